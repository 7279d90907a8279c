"""An engine run from Python holds what its command writes, and draws on the axes that it is given."""

import csv
import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

import apesim
from apesim.engine.drivetrain import point
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.commands.cli import app
from apesim.studies.run.engine_run import PLOTS, run_engine
from apesim.studies.terminal.console import main_of, plain


@pytest.fixture(scope="module")
def run():
    return run_engine(Machine(), speed="1000 rpm")


def test_the_result_is_what_the_command_writes(run, capsys, tmp_path, monkeypatch):
    path = tmp_path / "traces.csv"
    arguments = ["engine", "run", "--speed", "1000 rpm", "--json", "--csv", str(path)]
    monkeypatch.setattr("sys.argv", ["apesim", *arguments])
    assert main_of(app) == 0
    written = json.loads(capsys.readouterr().out)
    held = plain(run.to_dict())
    assert list(held) == list(written)
    assert {key: value for key, value in held.items() if key != "wall_time_s"} == {
        key: value for key, value in written.items() if key != "wall_time_s"
    }
    for key, value in written.items():
        if isinstance(value, float) and key != "wall_time_s":
            assert run[key] == value
    with path.open() as file:
        headers, *rows = csv.reader(file)
    columns = dict(zip(headers, np.array(rows, dtype=float).T, strict=True))
    assert np.array_equal(columns["crank_angle [deg]"], run.traces["crank_angle_deg"])
    for header, column in columns.items():
        name, _, unit = header.rstrip("]").partition(" [")
        trace = run.traces[name if name != "crank_angle" else "crank_angle_deg"]
        assert trace.unit == unit and np.array_equal(trace.values, column)


def test_a_speed_is_a_text_or_a_number_with_its_unit(run):
    again = run_engine(Machine(), (1000, "rpm"))
    assert again["brake_torque"] == run["brake_torque"] == run["brake_torque_Nm"]
    assert run.conditions == {"intake": "epv", "speed": "1000 r/min", "supply": "1 MPa gauge, 287 K"}


def test_its_text_is_short_and_says_how_it_ended(run):
    text = repr(run)
    assert len(text.splitlines()) < 12 and "array" not in text
    assert f"periodic after {run['cycles']} cycles (period: 1 cycle)" in text
    assert f"{run['brake_torque']:.5g} N m" in text


def test_it_is_drawn_on_the_axes_given(run):
    _, axes = plt.subplots(1, 3)
    for ax, what in zip(axes, PLOTS, strict=True):
        assert run.plot(ax, what) is ax and len(ax.lines) == 1 and "[" in ax.get_xlabel()
    assert np.allclose(axes[1].lines[0].get_ydata(), 1e3 * run.traces["lift"].values)
    assert run.plot() is not axes[0]
    for again, ax in ((run.plot_lift(), axes[1]), (run.plot_indicator_diagram(), axes[2])):
        assert np.array_equal(again.lines[0].get_xydata(), ax.lines[0].get_xydata())
    with pytest.raises(InputError, match=r"what: there is no plot of lifts; did you mean lift\?"):
        run.plot(what="lifts")
    plt.close("all")


def test_xarray_and_pandas_hold_numbers_and_traces(run):
    pytest.importorskip("xarray")
    pytest.importorskip("pandas")
    data, table = run.to_xarray(), run.to_pandas()
    assert data["brake_torque"].item() == run["brake_torque"] and data["brake_torque"].attrs["units"] == "N m"
    assert data["cylinder_pressure"].attrs["reference"] == "absolute"
    assert np.array_equal(table["lift"], run.traces["lift"]) and table.attrs["units"]["lift"] == "m"


def test_what_does_not_converge_is_raised_with_its_result_and_the_command_ends_with_3(run, capsys, monkeypatch):
    def unsettled(machine, speed, **options):
        march = run.march
        return march._replace(orbit=march.orbit._replace(converged=False, cycles=7))

    monkeypatch.setattr(point, "run_steady", unsettled)
    with pytest.raises(apesim.NotConverged, match="epv at 1000 r/min: not periodic after 7 cycles; ") as caught:
        run_engine(Machine(), "1000 rpm")
    result = caught.value.result
    assert result["brake_torque"] == run["brake_torque"] and result.converged is False
    assert "not periodic after 7 cycles" in repr(result)
    monkeypatch.setattr("sys.argv", ["apesim", "engine", "run", "--speed", "1000 rpm", "--json"])
    assert main_of(app) == 3
    said = capsys.readouterr()
    assert json.loads(said.out)["converged"] is False and "not periodic after 7 cycles" in said.err


def test_nothing_is_printed(capsys):
    run_engine(Machine().with_(engine_intake="ideal"), "1000 rpm")
    assert capsys.readouterr() == ("", "")


def test_the_table_calls_cold_temperatures_an_adiabatic_limit(apesim):
    code, out, _ = apesim("engine", "run", "--speed", "1000 rpm")
    cold = [line for line in out.splitlines() if "temperature" in line]
    assert code == 0 and len(cold) == 2
    assert all("adiabatic limit" in line for line in cold)


def test_the_text_of_the_machine_is_that_of_the_run_whatever_is_done_to_its_arrays_after_it():
    curve = np.array([[0.0, 0.0], [1e-3, 0.5], [2e-3, 1.0]])
    machine = Machine().with_(valve_solenoid_opening_curve=curve)
    array = machine.valve.solenoid.opening_curve
    before = machine.to_toml()
    run = run_engine(machine, "1000 rpm")
    array[1, 1] = 0.4
    assert machine.to_toml() != before == run.machine
