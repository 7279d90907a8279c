"""Geometry that the user says to be known only so far is no effect that is missing.

The rig is simulated by tests/truth, with another stroke or dead volume than the machine file says.
"""

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import read_measured
from apesim.valve.effects import VALVE_EFFECTS
from tests.truth.simulator.valve import Bench, measured_lift

AMBIENT = 101325.0
TIMES = np.arange(-0.02, 0.07, 0.4e-3)
LIBRARY = ("coulomb_friction", "side_force", "dead_volume", "slow_ramp", "spring_rate_error")
WITHOUT = [effect.name for effect in VALVE_EFFECTS if effect.name not in LIBRARY]
SENSOR = '"sensor.lift.gain" = "0.1 %"'


RUNS = (0.16, "fit"), (0.40, "fit"), (0.60, "fit"), (0.49, "check")


def explained(folder, known_to, runs=RUNS, **rig):
    """Explanation of the lift of a rig, with what measured.toml says of its numbers."""
    rng = np.random.default_rng(11)
    lines = ['bench = "valve"', "[known_to]", *known_to]
    for pressure, role in runs:
        bench = Bench(supply_pressure=pressure * 1e6 + AMBIENT, **rig)
        lift = measured_lift(bench, 0.03, np.maximum(TIMES, 0.0), 2e-5, rng)
        name = f"p{100 * pressure:.0f}.csv"
        rows = (f"{1e3 * t:.6g},{1e3 * x:.6g}" for t, x in zip(TIMES, lift, strict=True))
        (folder / name).write_text("\n".join(["time [ms],lift [mm]", *rows]) + "\n")
        lines += ["[[run]]", f'data = "{name}"', f'supply = "{pressure} MPa gauge"', 'temperature = "287 K"']
        lines += ['pulse = "30 ms"', f'role = "{role}"']
    (folder / "measured.toml").write_text("\n".join(lines) + "\n")
    return explain(Machine(), read_measured(folder, AMBIENT), without=WITHOUT)


@pytest.mark.parametrize("stroke", [8.91e-3, 9.09e-3])
def test_a_stroke_off_by_what_it_is_known_to_is_no_finding(tmp_path, stroke):
    found = explained(tmp_path, [SENSOR, '"valve.stroke" = "1 %"'], stroke=stroke)
    assert found.verdict == "NO_GAP"
    pulls = dict(zip((p.key for p in found.calibrated.residuals.parameters), found.calibrated.fitted.x, strict=True))
    assert pulls["valve.stroke"] == pytest.approx((stroke / 9e-3 - 1.0) / 0.01, abs=0.2)
    told = {row["key"]: (row["known_to"], row["stated_in"]) for row in found.to_dict()["nuisances"]}
    assert told["valve.stroke"] == ("1 %", "measured.toml")
    assert told["effects.sensor_gain.lift"] == ("0.1 %", "measured.toml")
    assert told["valve.viscous_friction"] == ("10 %", "default")


def test_a_stroke_that_counts_as_exact_is_blamed_on_the_sensor(tmp_path):
    found = explained(tmp_path, [SENSOR], stroke=8.91e-3)
    assert (found.verdict, found.best.corrected) == ("CALIBRATION", ("effects.sensor_gain.lift",))


def test_a_dead_volume_is_named_only_where_the_clearance_volume_counts_as_exact(tmp_path):
    wide = {"clearance_volume": 1.15 * 11382e-9}
    found = explained(tmp_path, [], **wide)
    assert (found.verdict, found.best.names) == ("NAMED", ("dead_volume",))
    assert explained(tmp_path, ['"valve.clearance_volume" = "10 %"'], **wide).verdict == "NO_GAP"


def test_a_number_far_beyond_what_it_is_known_to_is_a_finding(tmp_path):
    found = explained(tmp_path, ['"sensor.lift.gain" = "0.05 %"', '"valve.stroke" = "0.1 %"'], stroke=8.91e-3)
    assert (found.verdict, found.best.corrected) == ("CALIBRATION", ("valve.stroke",))
    (row,) = found.to_dict()["effects"]
    assert row["key"] == "valve.stroke"
    assert row["interval_95"][0] < 8.91 < row["interval_95"][1]


@pytest.mark.slow
def test_an_effect_is_named_beside_a_number_far_beyond_what_it_is_known_to(tmp_path):
    stated = ['"sensor.lift.gain" = "0.05 %"', '"valve.stroke" = "0.1 %"']
    runs = *RUNS, (0.25, "fit"), (0.33, "fit")
    found = explained(tmp_path, stated, runs, stroke=8.91e-3, dry_friction=12.0, breakaway=12.0)
    data = found.to_dict()
    assert (found.verdict, data["effects"][0]["name"]) == ("NAMED", "coulomb_friction")
    low, high = data["effects"][0]["interval_95"]
    assert low < 12.0 < high
    (row,) = data["numbers"]
    assert row["key"] == "valve.stroke"
    assert row["interval_95"][0] < 8.91 < row["interval_95"][1]
    assert "Besides, a number is wrong: valve, stroke (8.9" in found.sentence
    found.write(tmp_path / "found")
    extended = Machine.load(tmp_path / "found" / "machine.toml")
    assert extended.valve.stroke == pytest.approx(8.91e-3, abs=0.01e-3)
    assert extended.effects.coulomb_friction.force == pytest.approx(12.0, abs=1.0)
    assert "valve stroke corrected" in (tmp_path / "found" / "report.html").read_text().replace(", ", " ")


@pytest.mark.slow
def test_a_number_that_is_known_goes_before_the_effect_that_says_the_same(tmp_path):
    found = explained(tmp_path, ['"valve.spring_rate" = "3 %"'], spring_rate=2400.0)
    assert (found.verdict, found.best.corrected) == ("CALIBRATION", ("valve.spring_rate",))
    found = explained(tmp_path, [], spring_rate=2400.0)  # exact, as far as is said
    assert (found.verdict, found.best.names) == ("NAMED", ("spring_rate_error",))
