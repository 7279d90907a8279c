"""Records of a cylinder with friction hidden in them: what the workflow names, and that nothing is named in vain."""

import math

import numpy as np
import pytest

import apesim
from apesim.valve.effects import coulomb_friction
from tests.truth.simulator.cylinder import Cylinder, Record, balance, move, write_folder

BORE = "25.7 mm"
"""Bore as the machine file has it: the true one is 20 µm wider."""
RECORDS = (
    Record(1, "fit"),
    Record(3, "fit"),
    Record(5, "fit"),
    Record(2, "fit", 5.0),
    Record(4, "gate"),
    Record(7, "check"),
)
"""One record five times as fast, so that what depends on the speed is distinguishable."""


def explain(folder, cylinder, seed):
    write_folder(folder, cylinder, RECORDS, seed=seed)
    return apesim.explain(apesim.Machine().with_(rig_bore=BORE), folder)


def assert_closed(found):
    """The gap on the record that nothing was fitted to falls to that of the noise alone."""
    assert found.held_out["before"] > 5.0
    assert found.held_out["after"] < 1.1 * found.held_out["noise_floor"]


def assert_effects(found, expected):
    assert {effect["key"] for effect in found.effects} == set(expected)
    for effect in found.effects:
        low, high = effect["interval_95"]
        true = expected[effect["key"]]
        assert effect["value"] == pytest.approx(true, rel=0.02)
        assert low - 0.5 * (high - low) < true < high + 0.5 * (high - low)  # twice as wide: three intervals in one test


def test_the_drive_moves_as_its_velocity_says():
    cylinder, times = Cylinder(), np.arange(0.0, 20.0, 1e-3)
    stroke, velocity = move(cylinder, 3e5, times)
    assert np.gradient(stroke, times) == pytest.approx(velocity, abs=1e-4)
    assert (stroke.min(), stroke.max()) == pytest.approx((0.0, cylinder.travel), abs=1e-6)


def test_the_force_is_that_of_a_balance_by_hand():
    cylinder = Cylinder(bore=0.02, coulomb=3.0, seal=1e-5, viscous=100.0, tare=0.5, gain=1.1)
    area = math.pi * 1e-4
    pushed, pulled = balance(cylinder, np.full(2, 2e5), np.array([0.01, -0.01]))
    assert pushed == pytest.approx(1.1 * (area * 2e5 + 1.0 + 5.0) + 0.5)
    assert pulled == pytest.approx(1.1 * (area * 2e5 - 1.0 - 5.0) + 0.5)


def test_where_nothing_is_hidden_nothing_is_named(tmp_path):
    found = explain(tmp_path, Cylinder(), seed=11)
    assert found.verdict == "NO_GAP"
    assert found.effects == []


@pytest.mark.slow
def test_coulomb_friction_is_named_with_its_value(tmp_path):
    found = explain(tmp_path, Cylinder(coulomb=5.0), seed=12)
    assert found.verdict == "NAMED"
    assert_effects(found, {"effects.coulomb_friction.force": 5.0})
    assert found.next_test["text"].endswith("coulomb friction: " + coulomb_friction.EFFECT.search.isolated_on_rig + ".")
    assert_closed(found)


@pytest.mark.slow
def test_coulomb_and_seal_friction_are_named_together(tmp_path):
    found = explain(tmp_path, Cylinder(coulomb=4.0, seal=6e-6), seed=13)
    assert found.verdict == "TWO_EFFECTS"
    assert_effects(found, {"effects.coulomb_friction.force": 4.0, "effects.seal_friction.coefficient": 6e-6})
    assert_closed(found)


@pytest.mark.slow
def test_at_one_speed_coulomb_friction_is_named_as_one_of_a_class(tmp_path):
    """Stribeck friction with a speed far above that of the drive is the same force."""
    records = [record for record in RECORDS if record.faster == 1.0]
    write_folder(tmp_path, Cylinder(coulomb=5.0), records, seed=14)
    found = apesim.explain(apesim.Machine().with_(rig_bore=BORE), tmp_path)
    assert found.verdict == "NAMED_CLASS"
    assert {"coulomb_friction", "stribeck_friction"} == set(found.to_dict()["class"])
