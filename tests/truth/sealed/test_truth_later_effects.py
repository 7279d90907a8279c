"""A late release and a back pressure behind the exhaust, hidden in data of the simulator, and found again."""

from functools import partial

import numpy as np
import pytest

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.studies.gap.design.isolability import find_isolability
from apesim.studies.gap.workflow import explain
from tests.truth.sealed.challenge import Case, write
from tests.truth.sealed.library import ENGINE, VALVE
from tests.truth.sealed.nuisances import drawn, nuisances_for
from tests.truth.sealed.observation import Laboratory
from tests.truth.sealed.setting import AMBIENT, RPM, WHITE, Noise, Point, Setting
from tests.truth.simulator.effects import EFFECTS

NOISE = Noise(1.0, WHITE, 0.0, 0.0, True)
EXHAUST = (
    *("exhaust_back_pressure", "exhaust_restriction", "exhaust_timing"),
    *("clearance_error", "blow_by", "friction_torque"),
)
"""Effects that come nearest to a back pressure; with all of the library it takes minutes."""


def valve_setting(pulses):
    """Lift and chamber pressures of three runs to fit and one to check, with pulses [ms]."""
    gauge, roles = (0.2, 0.4, 0.6, 0.5), ("fit", "fit", "fit", "check")
    points = tuple(
        Point(role, 1e6 * supply + AMBIENT, 287.0, 1e-3 * pulse)
        for supply, role, pulse in zip(gauge, roles, pulses, strict=True)
    )
    return Setting(VALVE, "chambers", points, NOISE, 501, 0.0)


def engine_setting():
    """Cylinder pressure, torque and air flow of three runs to fit and one to check."""
    runs = ("fit", 0.6, 600.0), ("fit", 0.8, 1000.0), ("fit", 1.0, 800.0), ("check", 0.9, 900.0)
    points = tuple(Point(role, 1e6 * supply + AMBIENT, 287.0, speed=speed * RPM) for role, supply, speed in runs)
    return Setting(ENGINE, "cylinder", points, NOISE, 360, 0.0)


ALIKE = valve_setting([45.0] * 4)
NEAR = valve_setting([30.0, 45.0, 70.0, 50.0])
"""The cosine of a constant delay and one that grows with the pulse is 0.95, above the limit of a class."""
APART = valve_setting([20.0, 40.0, 80.0, 50.0])
"""That cosine is 0.88."""


def write_rig(folder, setting, **effects):
    """Data of a rig whose numbers are a little off, with effects hidden; the folder of the data."""
    rng = np.random.default_rng(1)
    answer = {"seed": 1, "nuisances": drawn(nuisances_for(setting.bench, setting.channels), rng)}
    hidden = tuple(partial(EFFECTS[name], **parameters) for name, parameters in effects.items())
    write(Case(answer, hidden, Laboratory(setting), rng), folder)
    return folder / "case"


def explained(folder, without=()):
    return explain(Machine.load(folder / "machine.toml"), folder, without=without).to_dict()


def assert_named(found, name, hidden):
    """The effect is named, and the interval of its strength holds what was hidden, in the unit of the machine file."""
    assert found["verdict"] == "NAMED"
    (effect,) = found["effects"]
    low, high = effect["interval_95"]
    assert effect["name"] == name
    assert low < hidden < high
    assert high - low < 0.2 * hidden


@pytest.mark.slow
def test_a_late_release_is_named(tmp_path):
    assert_named(explained(write_rig(tmp_path, NEAR, release_delay={"time": 0.8e-3})), "release_delay", 0.8)


@pytest.mark.parametrize(
    "without",
    [
        [effect.name for effect in ALL_EFFECTS if effect.name not in EXHAUST],
        pytest.param([], marks=pytest.mark.slow),
    ],
    ids=["few", "all"],
)
@pytest.mark.slow
def test_a_back_pressure_is_named(without, tmp_path):
    folder = write_rig(tmp_path, engine_setting(), exhaust_back_pressure={"pressure": 20e3})
    assert_named(explained(folder, without), "exhaust_back_pressure", 20.0)


RECORDER = '''"""An error of the recorder's time."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import moved


class Error(NamedTuple):
    size: Annotated[float, Quantity("{unit}", -1, 1, "chosen")] = 0.0


def sensor(effect, reading):
    return moved(reading, lambda times: {times})


EFFECT = Effect(
    "{name}", Error, "x({times})", "chosen", seen_in="time", isolated_by="-", sensor=sensor, layer="valve"
)
'''


@pytest.fixture
def recorder(tmp_path):
    """The default machine with two errors of the recorder beside the library: its clock, and its zero of time."""
    paths = []
    for name, unit, times in (("clock", "", "times / (1.0 + effect.size)"), ("trigger", "ms", "times - effect.size")):
        paths.append(tmp_path / f"recorder_{name}.py")
        paths[-1].write_text(RECORDER.format(name=f"recorder_{name}", unit=unit, times=times))
    return Machine().with_effects(*paths)


@pytest.mark.parametrize(
    ("setting", "is_alike"), [(ALIKE, True), (NEAR, True), (APART, False)], ids=["alike", "near", "apart"]
)
def test_a_late_release_and_a_fast_clock_are_one_class_where_pulses_are_much_alike(
    setting, is_alike, recorder, tmp_path
):
    rows = {row["effect"]: row for row in find_isolability(recorder, write_rig(tmp_path, setting)).effects}
    release = rows["release_delay"]
    assert release["limit"] < 0.1  # ms
    assert ("recorder_clock" in release["class"]) == is_alike
    assert bool(release["helped_by"]) == is_alike
    assert "recorder_trigger" not in release["class"]  # it moves the opening, too
