"""What a study says of a machine, put back into a single run, is met: for a machine that is the default in no section.

The machine's control air has a pressure of its own, its valve is small and its ambient is another one. Only the model
of air is the default's, as another one is compiled anew.
"""

import re

import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.quantities.settings import differences

SPEED = "1200 rpm"
VALUES = {
    "ambient.pressure": "95 kPa abs",
    "ambient.temperature": "300 K",
    "supply.pressure": "8 bar gauge",
    "supply.temperature": "299 K",
    "supply.control_pressure": "6 bar gauge",
    "valve.stroke": "6 mm",
    "valve.moving_mass": "0.05 kg",
    "valve.piston_area": "490.9 mm^2",
    "valve.clearance_volume": "4 cm^3",
    "valve.spring_rate": "1500 N/m",
    "valve.viscous_friction": "60 N s/m",
    "valve.solenoid.effective_area": "7 mm^2",
    "valve.solenoid.dead_time": "1 ms",
    "valve.solenoid.ramp_time": "1.2 ms",
    "groove.effective_area": "110 mm^2",
    "groove.lap": "0.7 mm",
    "engine.bore": "80 mm",
    "engine.stroke": "82 mm",
    "engine.rod_length": "140 mm",
    "engine.pin_offset": "1 mm",
    "engine.compression_ratio": "15",
    "engine.cam.lift": "6 mm",
    "engine.exhaust.effective_area": "450 mm^2",
    "engine.exhaust.opens": "160 deg",
    "engine.receiver.volume": "0.8 L",
    "engine.friction.constant": "0.3 bar",
    "command.energise": "-25 deg",
    "command.release": "50 deg",
    "command.open_target": "-3 deg",
    "command.close_target": "74 deg",
}
MACHINE = Machine().with_(**VALUES)
RUN_VALUES = ("valve_open_deg", "valve_close_deg", "peak_lift", "brake_torque")


def run_with(speed=SPEED, **values):
    """Run the engine with some other values, an incomplete periodic state being a failure."""
    return apesim.run_engine(MACHINE.with_(**values), speed=speed)


def commands_of(traces, place, prefix=""):
    """Command angles that a study says of a point, as keys of the machine."""
    return {
        f"command.{edge}": f"{traces[f'{prefix}{edge}_deg'].values.ravel()[place]:.12g} deg"
        for edge in ("energise", "release")
    }


def said_of(traces, place, prefix=""):
    """Results of a point by the names of a run."""
    return {
        name: float(traces[f"{prefix}{name}"].values.ravel()[place])
        for name in RUN_VALUES
        if f"{prefix}{name}" in traces
    }


def test_the_machine_is_the_default_in_no_section_but_air_and_what_no_engine_reads():
    changed = {key.split(".")[0] for key, _ in differences(MACHINE)}
    beyond_steady = {"shaft", "load", "cylinder", "stage_2", "inter_receiver"}
    assert set(Machine._fields) - changed == {"air", "rig", "effects", "known_to"} | beyond_steady


@pytest.mark.parametrize(
    ("grid", "key"),
    [
        ({"pressure": "8 bar gauge, 9 bar gauge"}, "supply_pressure"),
        ({"control_pressure": "5 bar gauge, 6 bar gauge"}, "supply_control_pressure"),
    ],
    ids=["supply", "control air"],
)
def test_corrected_commands_open_and_close_the_valve_at_its_targets(grid, key):
    found = apesim.correct_timing(MACHINE, speed=SPEED, temperature="299 K", **grid)
    assert found.failed == ()
    (name,) = grid
    for place, pressure in enumerate(re.findall(r"\d bar gauge", grid[name])):
        run = run_with(**{key: pressure}, **commands_of(found.traces, place))
        said = said_of(found.traces, place)
        assert {name: run[name] for name in said} == pytest.approx(said, rel=1e-6)
        assert run["valve_open_deg"] == pytest.approx(-3.0, abs=0.06)
        assert run["valve_close_deg"] == pytest.approx(74.0, abs=0.06)
        before = float(found.traces["fixed_brake_torque"].values.ravel()[place])
        assert run_with(**{key: pressure})["brake_torque"] == pytest.approx(before, rel=1e-6)


@pytest.mark.parametrize("grid", [{"pressure": "8 bar gauge"}, {"control_pressure": "6 bar gauge"}], ids=str)
def test_a_limit_has_one_answer_for_one_point_and_is_met_there(grid):
    found = apesim.find_engine_limit(MACHINE, temperature="299 K", duration="77 deg", **grid)
    assert found["runs"] == 1 and found["limit_rpm"] == found["min_limit_rpm"]
    run = run_with(f"{found['limit_rpm']:.9g} rpm", **commands_of(found.traces, 0))
    assert run["valve_open_deg"] == pytest.approx(-3.0, abs=0.56)
    assert run["valve_close_deg"] == pytest.approx(74.0, abs=0.56)
    assert run["full_open_deg"] is not None and run["closed_deg"] is not None


def test_every_row_of_a_sweep_is_that_of_a_run():
    table = apesim.sweep(MACHINE, SPEED, intake=["epv", "cam", "ideal"], timing="both").to_pandas()
    assert list(table["timing"]) == ["fixed", "corrected", "fixed", "fixed"]
    for _, row in table.iterrows():
        commands = {f"command.{edge}": f"{row[f'{edge}_deg']:.12g} deg" for edge in ("energise", "release")}
        run = run_with(engine_intake=row["intake"], **commands if row["intake"] == "epv" else {})
        said = {name: row[name] for name in RUN_VALUES}
        assert {name: run[name] for name in said} == pytest.approx(said, rel=1e-6)


def test_optimal_commands_give_what_is_said_of_them():
    found = apesim.optimise_commands(MACHINE, goal="torque", speed=SPEED)
    prefix = "most_torque_"
    run = run_with(**commands_of(found.traces, 0, prefix))
    assert run["brake_torque"] == pytest.approx(said_of(found.traces, 0, prefix)["brake_torque"], rel=1e-6)


def test_the_real_valve_of_an_assessment_is_that_of_a_run():
    found = apesim.assess_valve(MACHINE, speed=SPEED).to_xarray()
    real = found.isel(speed_rpm=0).sel(valve="real")
    assert float(real["brake_torque"]) == pytest.approx(run_with()["brake_torque"], rel=1e-9)


@pytest.mark.parametrize("machine", [MACHINE, MACHINE.with_(supply_control_pressure="")], ids=["stated", "supply's"])
def test_strokes_of_the_valves_studies_are_those_of_a_run(machine):
    run = apesim.run_valve(machine, supply="5 bar gauge", temperature="299 K")
    mapped = apesim.map_valve(machine, pressure="5 bar gauge", temperature="299 K")
    for stroke in ("opening", "closing"):
        for name in ("delay", "seating_speed"):
            said = mapped.traces[f"{stroke}_{name}"].values[0]
            assert run[f"{stroke}_{name}"] == pytest.approx(said, rel=1e-12)


@pytest.mark.slow
def test_a_stroke_without_a_brake_lands_as_in_a_run():
    run = apesim.run_valve(MACHINE)
    landing = apesim.find_soft_landing(MACHINE, pressure="6 bar gauge", solenoids="b").strokes[0]
    assert landing.unbraked.speed == pytest.approx(run["opening_seating_speed"], rel=1e-9)


def test_a_valves_limit_is_complete_in_a_run_and_has_one_answer_at_the_machines_own_control_air():
    duty = "0.35"
    found = apesim.find_valve_limit(MACHINE, pressure="6 bar gauge", temperature="299 K", duty=duty)
    rate = float(found.traces["limit_hz"].values[0])
    run = apesim.run_valve(MACHINE, pulse=f"{350.0 / rate:.9g} ms", repeat=f"{rate:.12g} Hz")
    assert run["period_cycles"] == 1 and run["opening_stroke_time"] > 0.0 and run["closing_stroke_time"] > 0.0


@pytest.mark.parametrize("study", [apesim.correct_timing, apesim.find_engine_limit], ids=lambda study: study.__name__)
def test_a_grid_over_both_pressures_is_refused_by_name(study):
    with pytest.raises(apesim.InputError, match="pressure: varies beside control_pressure"):
        study(MACHINE, pressure="7 bar gauge, 8 bar gauge", control_pressure="5 bar gauge")
