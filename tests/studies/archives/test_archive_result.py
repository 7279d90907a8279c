"""Sweeps, maps and limits from Python: the same archive as the command's, named, drawn, written and read back."""

import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest

import apesim
from apesim.archive import read
from apesim.engine.machine import Machine
from apesim.studies.commands.cli import app
from apesim.studies.terminal.console import main_of
from tests.folders import ROOT

GRID = {"pressure": "0.4:0.8:0.4 MPa gauge", "temperature": "280 K, 300 K"}


@pytest.fixture(scope="module")
def swept():
    varied = {"supply.pressure": "0.6:1.0:0.4 MPa gauge"}
    return apesim.sweep(Machine(), "600:900:300 rpm", intake=["cam", "ideal"], vary=varied)


@pytest.fixture(scope="module")
def mapped():
    return apesim.map_valve(Machine(), **GRID)


@pytest.fixture(scope="module")
def limited():
    return apesim.find_valve_limit(Machine(), pressure="0.8 MPa gauge", temperature="287 K", duty=0.5)


def same_values(one, other):
    assert list(one.variables) == list(other.variables)
    for name, variable in one.variables.items():
        assert np.array_equal(variable.values, other.variables[name].values, equal_nan=variable.kind == "float64"), name


@pytest.mark.slow
def test_a_command_writes_what_the_function_returns(monkeypatch, tmp_path, swept, mapped):
    monkeypatch.chdir(tmp_path)
    sweep = "engine sweep --intake cam,ideal --no-figures --out s.h5 --speed".split()
    for words in (
        [*sweep, "600:900:300 rpm", "--vary", "supply.pressure=0.6:1.0:0.4 MPa gauge"],
        ["valve", "map", *(word for name, text in GRID.items() for word in (f"--{name}", text)), "--out", "m.h5"],
    ):  # fmt: skip
        monkeypatch.setattr("sys.argv", ["apesim", *words])
        assert main_of(app) == 0
    same_values(read("s.h5"), swept.archive)
    same_values(read("m.h5"), mapped.archive)
    assert read("s.h5").provenance["plan_hash"] == swept.archive.provenance["plan_hash"]


def test_the_call_from_python_is_noted_without_folders(swept, tmp_path):
    call = "apesim.sweep(machine, speed='600:900:300 rpm', intake=['cam', 'ideal'], vary={'supply.pressure': "
    assert swept.archive.provenance["command"].startswith(call)
    out = tmp_path / "m.h5"
    made = apesim.map_valve(Machine(), pressure=[5e5], temperature=np.array([287.0]), out=out)
    noted = made.archive.provenance["command"]
    assert noted == "apesim.map_valve(machine, pressure=[500000.0], temperature=array([287.]), out='m.h5')"


def test_a_dataset_has_named_axes_units_and_names_without_si_units(swept):
    pytest.importorskip("xarray")
    data = swept.dataset
    torque = data["brake_torque"]
    assert torque.dims == ("actuation", "supply_pressure", "speed_rpm") and torque.attrs["units"] == "N m"
    one = torque.sel(actuation="cam", speed_rpm=900.0).isel(supply_pressure=1).item()
    assert one == swept.archive.variables["brake_torque_Nm"].values[3]
    assert data["lift"].dims[-1] == "crank_angle_deg" and "specific_air_kg_per_kWh" in data
    assert swept["max_brake_torque"] == torque.max().item()


def test_pandas_has_a_row_for_each_run(swept):
    pytest.importorskip("pandas")
    table = swept.to_pandas()
    assert len(table) == 8 and table.index.name == "run" and table.attrs["units"]["brake_torque"] == "N m"
    assert table["brake_torque"].max() == swept["max_brake_torque"]
    assert set(table["actuation"]) == {"cam", "ideal"} and "lift" not in table


def test_each_is_short_and_drawn_on_the_axes_given(swept, mapped, limited):
    _, axes = plt.subplots(1, 3)
    for ax, result, lines in zip(axes, (swept, mapped, limited), (4, 2, 2), strict=True):
        assert result.plot(ax) is ax and len(ax.lines) == lines and ax.get_legend()
        with pytest.raises(apesim.InputError, match=r"what: there is no plot of speed_rpn; (did|give)"):
            result.plot(what="speed_rpn")
        assert len(repr(result).splitlines()) < 12 and "array" not in repr(result)
        assert "<table>" in result._repr_html_()
    assert "speed 600 r/min, 900 r/min" in repr(swept) and f"{limited['limit_hz']:.5g} Hz" in repr(limited)
    assert limited["limit_rpm"] == 60.0 * limited["limit_hz"]
    plt.close("all")


@pytest.mark.slow
def test_drawing_leaves_the_backend_of_a_notebook_as_it_is():
    code = (
        "import matplotlib; matplotlib.use('svg'); import apesim.studies.sweep.figures; print(matplotlib.get_backend())"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "svg"


def test_what_is_written_is_read_back_as_the_same_result(swept, mapped, limited, tmp_path):
    for result in (swept, mapped, limited):
        path = tmp_path / f"{type(result).__name__}.h5"
        assert result.write(path) == path
        again = apesim.read_archive(path)
        assert type(again) is type(result) and again.conditions == result.conditions
        same_values(again.archive, result.archive)
        with pytest.raises(apesim.ArchiveError, match="exists already"):
            result.write(path)
        result.write(path, overwrite=True)


def test_any_other_archive_is_read_by_its_variables(tmp_path, mapped):
    from dataclasses import replace

    from apesim.archive import write

    path = tmp_path / "other.h5"
    variables = {name: mapped.archive.variables[name] for name in ("run", "control_air_kg")}
    write(replace(mapped.archive, provenance={}, variables=variables), path)
    other = apesim.read_archive(path)
    assert type(other).__name__ == "ArchiveResult" and len(other.traces["control_air"]) == 4
    with pytest.raises(apesim.ArchiveError):
        apesim.read_archive(tmp_path / "none.h5")


def test_failed_points_are_named_and_nothing_is_raised(tmp_path):
    found = apesim.map_valve(Machine(), pressure=[5e5], temperature=["287 K"], pulse="2 ms")
    assert found["failed_runs"] == 1 and "not completed" in found.failed[0] and found.converged is False
    short = Machine().with_(command_close_target="-4.5 deg")
    late = apesim.sweep(short, "2400 rpm", intake="epv", timing="corrected")
    assert "out of reach" in late.failed[0] and np.isnan(late.traces["brake_torque"][0])
    assert late.failed[0][:40] in repr(late)


def test_a_sweep_goes_on_and_says_when_it_was_finished(tmp_path):
    out = tmp_path / "s.h5"
    first = apesim.sweep(Machine(), "600 rpm", intake="ideal", out=out)
    assert out.exists() and not first.was_finished
    with pytest.raises(apesim.ArchiveError, match="exists already"):
        apesim.sweep(Machine(), "600 rpm", intake="ideal", out=out)
    assert apesim.sweep(Machine(), "600 rpm", intake="ideal", out=out, resume=True).was_finished


def test_progress_is_shown_on_demand_only(capsys):
    reports = []
    options = {"pressure": "0.8 MPa gauge", "temperature": "280 K, 300 K"}
    apesim.map_valve(Machine(), **options, progress=lambda *done: reports.append(done))
    assert reports == [(1, 2), (2, 2)] and capsys.readouterr() == ("", "")
    apesim.map_valve(Machine(), **options, progress=True)
    out, err = capsys.readouterr()
    assert out == "" and "2/2" in err


def test_varied_keys_in_si_and_in_text_make_the_same_machines():
    ambient = Machine().ambient.pressure
    text = apesim.sweep(Machine(), "600 rpm", intake="ideal", vary=["supply.pressure=0.6:1.0:0.4 MPa gauge"])
    si = apesim.sweep(Machine(), "600 rpm", intake="ideal", vary={"supply_pressure": [ambient + 0.6e6, 1.101325e6]})
    same_values(text.archive, si.archive)


def test_a_varied_number_makes_the_plan_of_its_text():
    text = apesim.sweep(Machine(), "600 rpm", intake="ideal", vary=["engine.bore=80 mm, 90 mm"])
    si = apesim.sweep(Machine(), "600 rpm", intake="ideal", vary={"engine_bore": [80e-3, 90e-3]})
    assert text.archive.provenance["plan_hash"] == si.archive.provenance["plan_hash"]
