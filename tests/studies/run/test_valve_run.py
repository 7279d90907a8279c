"""A bench run from Python holds what its command writes, and draws on the axes that it is given."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.commands.cli import app
from apesim.studies.run import valve_run
from apesim.studies.run.valve_run import run_valve
from apesim.studies.terminal.console import main_of, plain


@pytest.mark.parametrize(
    "options",
    [
        {"supply": "0.49 MPa gauge", "temperature": "300 K"},
        {"pulse": "25 ms", "repeat": "20 Hz"},
        {"pulse": "20 ms", "until": "30 ms"},
    ],
)
def test_the_result_is_what_the_command_writes(capsys, monkeypatch, options):
    words = [word for name, text in options.items() for word in (f"--{name}", text)]
    monkeypatch.setattr("sys.argv", ["apesim", "valve", "run", "--json", *words])
    assert main_of(app) == 0
    written, held = json.loads(capsys.readouterr().out), plain(run_valve(Machine(), **options).to_dict())
    assert list(held) == list(written)
    assert {**held, "wall_time_s": 0} == {**written, "wall_time_s": 0}


def test_texts_and_floats_in_si_are_the_same():
    machine = Machine()
    text = run_valve(machine, supply="0.49 MPa gauge", temperature="300 K", pulse="25 ms", repeat="20 Hz")
    pressure = machine.ambient.pressure + 0.49e6
    si = run_valve(machine, supply=pressure, temperature=300.0, pulse=25e-3, repeat=20.0)
    assert {**si.to_dict(), "wall_time_s": 0} == {**text.to_dict(), "wall_time_s": 0}
    assert text.conditions["repeated at"] == "20 Hz" and text["converged"] and "periodic after" in text.ending
    assert len(repr(text).splitlines()) < 12
    assert "converged" not in run_valve(machine, pulse=25e-3)


def test_the_supply_given_counts_for_the_control_air_too():
    machine = Machine().with_(supply_control_pressure="0.3 MPa gauge")
    assert (
        run_valve(machine, supply="0.8 MPa gauge")["opening_delay"]
        == (run_valve(Machine(), supply="0.8 MPa gauge")["opening_delay"])
    )


def test_it_is_drawn_on_the_axes_given():
    run = run_valve(Machine())
    _, axes = plt.subplots(1, 2)
    assert run.plot(axes[0]) is axes[0] and run.plot(axes[1], "pressures") is axes[1]
    assert np.allclose(axes[0].lines[0].get_ydata(), 1e3 * run.traces["lift"].values)
    assert len(axes[1].lines) == len(run.plot_pressures().lines) == 2
    with pytest.raises(InputError, match="there is no plot of heat; give one of lift, pressures"):
        run.plot(what="heat")
    plt.close("all")


def test_what_does_not_repeat_is_raised_with_its_result(monkeypatch):
    march = run_valve(Machine(), pulse="25 ms", repeat="20 Hz").march
    unsettled = march._replace(orbit=march.orbit._replace(converged=False, cycles=7))
    monkeypatch.setattr(valve_run, "run_bench", lambda *_: unsettled)
    with pytest.raises(apesim.NotConverged, match="a pulse of 25 ms: not periodic after 7 cycles; ") as caught:
        run_valve(Machine(), pulse="25 ms", repeat="20 Hz")
    assert caught.value.result["opening_delay"] == march.opening.delay
