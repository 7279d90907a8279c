"""Tables in place of laws: their values at nodes and between, by hand, and against the laws that they contain."""

import numpy as np
import pytest

import apesim
from apesim.cubic_table import interpolate_clamped, interpolate_periodic
from apesim.effect import law
from apesim.engine.machine import Machine
from apesim.valve.actuator import closed_at_rest, state_of
from apesim.valve.bench import bench_of
from apesim.valve.effects.leakage_a import LeakageA
from apesim.valve.effects.ring_leakage import RingLeakage
from apesim.valve.effects.tabulated_area import TabulatedArea
from apesim.valve.effects.tabulated_damping import TabulatedDamping
from apesim.valve.effects.tabulated_delay import TabulatedDelay, bent
from apesim.valve.effects.tabulated_force import TabulatedForce
from apesim.valve.effects.tabulated_heat import TabulatedHeat
from apesim.valve.effects.tabulated_leak import TabulatedLeak
from apesim.valve.solenoid_flow import SUPPLY_A, SUPPLY_B, VENT_A, VENT_B
from apesim.valve.terms import BREAKAWAY, DRY, ENERGY_A, ENERGY_B, FLOW_SHARE, FORCE, TERMS
from tests.machines import changed
from tests.valve.effects.test_piston_effects import force_at_start
from tests.valve.effects.test_valve_effects import PULSE, machine_with, run_with
from tests.valve.test_bench import numbers


def added(effect, position=4e-3, speed=1.2):
    """What a table adds to the balances just after the energising, chamber A charged, B vented."""
    p, _ = bench_of(machine_with(), [0.0, PULSE])
    y = closed_at_rest(p.actuator, p.supply.control)
    y[0], y[1] = position, speed
    balance = np.zeros(TERMS)
    law(effect, state_of(p.actuator, y, p.supply), balance)
    return balance


def test_a_table_goes_through_its_nodes_as_a_cubic_and_stays_constant_beyond_them():
    """Half way: the mean, and an eighth of the fall of the slopes; these are 0 at both ends."""
    values = 4.0, 8.0, -2.0, 6.0
    places = -3.0, 0.0, 1.0, 2.0, 3.0, 7.0
    assert [interpolate_clamped(values, place) for place in places] == [4.0, 4.0, 8.0, -2.0, 6.0, 6.0]
    assert interpolate_clamped(values, 0.5) == 6.0 + (0.0 + 3.0) / 8.0
    assert interpolate_clamped(values, 1.5) == 3.0 + (-3.0 + 1.0) / 8.0
    assert interpolate_clamped(values, 2.5) == 2.0 + (-1.0 - 0.0) / 8.0


def test_round_the_nodes_the_last_is_followed_by_the_first():
    """Slopes -3 at the last node and 5 at the first."""
    values = 4.0, 8.0, -2.0
    assert [interpolate_periodic(values, place) for place in (0.0, 2.0, 3.0, 301.0)] == [4.0, -2.0, 4.0, 8.0]
    assert [interpolate_periodic(values, place) for place in (-0.5, 2.5)] == [1.0 + (-2.0 - 5.0) / 8.0] * 2


@pytest.mark.parametrize("place", [0.0, 1.0, 2.0, 3.0])
def test_a_table_has_no_corner(place):
    values, step = (4.0, 8.0, -2.0, 6.0), 1e-7
    for table in (interpolate_clamped, interpolate_periodic):
        left, right = ((table(values, place + d) - table(values, place)) / d for d in (-step, step))
        assert left == pytest.approx(right, abs=1e-5)


@pytest.mark.parametrize(("position", "push", "dry"), [(9e-3, 3.0, 5.0), (8.1e-3, 7.0, 1.0), (8.55e-3, 5.1875, 3.3125)])
def test_force_over_the_lift_by_hand(position, push, dry):
    """A node every 0.9 mm of lift; between the first two 5 + 1.5/8 and 3 + 2.5/8."""
    balance = added(TabulatedForce(3.0, 7.0, friction_at_0=5.0, friction_at_10=1.0), position)
    assert balance[[FORCE, DRY, BREAKAWAY]] == pytest.approx([push, dry, dry], abs=1e-12)
    assert np.count_nonzero(balance) == 3


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("speed", "own"), [(0.1, 2.0), (0.7, 4.0), (0.1 * (2.0**2.5 - 1.0), 3.3125), (5.0, 9.0)])
def test_friction_over_the_speed_by_hand(sign, speed, own):
    """Nodes at 0, 0.1, 0.3, 0.7, 1.5 and 3.1 m/s; between two of them 3.5 + (1 - 2.5)/8."""
    above_a = 1.101325 * 21588.9 / 15918.4 - 0.101325
    below_b = 0.101325 - 0.101325 * 11382.0 / 17052.5
    balance = added(TabulatedDamping(6.0, 2.0, 3.0, 4.0, 8.0, 9.0, 10.0), speed=sign * speed)
    seal = 10.0 * (above_a + below_b)
    assert balance[[DRY, BREAKAWAY]] == pytest.approx([own + seal, 6.0 + seal], rel=1e-6)


@pytest.mark.parametrize(
    ("effects", "holds"),
    [
        ({"tabulated_force": TabulatedForce(friction_at_0=4.0)}, 4.0),
        ({"tabulated_force": TabulatedForce(friction_at_0=-4.0)}, 0.0),
        ({"tabulated_force": TabulatedForce(force_at_0=2.5)}, 2.5),
        ({"tabulated_damping": TabulatedDamping(3.0)}, 3.0),
    ],
)
def test_friction_at_rest_holds_the_piston_and_one_below_zero_does_not(effects, holds):
    assert force_at_start(effects) == pytest.approx(holds, abs=1e-5)


def test_a_tenth_of_every_force_reversed_still_moves_the_piston_from_stop_to_stop():
    run = run_with(tabulated_force=TabulatedForce(*([4.0, -4.0] * 11)))
    assert run.status == 0
    assert np.isfinite([run.opening.contact, run.closing.contact]).all()


def test_heat_over_the_temperature_by_hand():
    """Chamber A is charged, B vented, both at 287 K before the stroke, 6.15 K below ambient."""
    effect = TabulatedHeat(a_at_minus_40=80.0, a_at_0=20.0, b_at_0=-40.0)
    balance = added(effect, 9e-3)
    place = 2.0 - 6.15 / 40.0
    assert balance[ENERGY_A] == pytest.approx(interpolate_clamped((0.0, 80.0, 20.0, 0.0, 0.0), place), rel=1e-9)
    assert balance[ENERGY_B] == pytest.approx(interpolate_clamped((0.0, 0.0, -40.0, 0.0, 0.0), place), rel=1e-9)


@pytest.mark.compiled
@pytest.mark.parametrize("heat", [-200.0, 200.0])
@pytest.mark.parametrize("area", [0.05e-6, 5e-6])
def test_no_heat_cools_air_to_0_kelvin_or_heats_it_without_end(heat, area):
    a_machine = changed(
        Machine(),
        {
            "valve.clearance_volume": 100e-9,
            "valve.solenoid.effective_area": area,
            **{f"effects.tabulated_heat.{name}": heat for name in TabulatedHeat._fields},
        },
    )
    run = apesim.run_valve(a_machine, pulse=0.3)
    assert run["energy_closure"] < 1e-6
    for name in ("pressure_a", "pressure_b"):
        assert run.traces[name].values.min() > 0.0


def same(one, other):
    assert numbers(run_with(**one)) == pytest.approx(numbers(run_with(**other)), rel=1e-6, abs=1e-9)


def test_even_tables_are_the_laws_that_they_contain():
    area = 0.2e-6
    same({"tabulated_leak": TabulatedLeak(area, area, area)}, {"leakage_a": LeakageA(area)})
    same({"tabulated_leak": TabulatedLeak(*6 * [0.0], area, area, area)}, {"ring_leakage": RingLeakage(area)})


def test_shares_of_the_area_over_the_pressure_ratio_by_hand():
    """At 4 mm of position chamber A has been compressed from 21588.9 mm3, B expanded from 11382 mm3."""
    filling, venting = (0.0, 0.1, 0.2, 0.4, -0.1), (0.3, -0.2, 0.1, 0.5, 0.2)
    shares = added(TabulatedArea(*filling, *venting))[FLOW_SHARE:]
    a, b = 1.101325 * 21588.9 / 15918.4, 0.101325 * 11382.0 / 17052.5
    for flow, values, low, high in (
        (SUPPLY_A, filling, 1.101325, a),
        (VENT_A, venting, 0.101325, a),
        (SUPPLY_B, filling, b, 1.101325),
        (VENT_B, venting, b, 0.101325),
    ):
        assert shares[flow] == pytest.approx(interpolate_clamped(values, 5.0 * low / high - 1.0), rel=1e-6)


CURVE = np.array([[1.5e-3, 0.0], [3.0e-3, 1.0]])


def test_a_table_of_delays_bends_the_opening_curve_at_its_nodes():
    found = bent(CURVE, (0.0, 1e-4, 2e-4, 1e-4, -3e-4), 5e-4)
    assert found[:, 1].tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert found[:, 0] == pytest.approx([2.0e-3, 2.475e-3, 2.95e-3, 3.225e-3, 3.2e-3 + 26e-6], abs=2.7e-5)
    assert np.all(np.diff(found[:, 0]) > 0.9e-6)
    assert bent(CURVE, (0.0,) * 5, -2e-3)[0, 0] == 0.0


def test_the_same_delay_everywhere_is_a_later_stroke():
    plain, late = run_with(), run_with(tabulated_delay=TabulatedDelay(*[4e-4] * 10))
    assert late.opening.delay - plain.opening.delay == pytest.approx(4e-4, rel=1e-6)
    assert late.closing.delay - plain.closing.delay == pytest.approx(4e-4, rel=1e-3)
    pressed = run_with(tabulated_delay=TabulatedDelay(pressure_at_800=4e-4, pressure_at_1200=8e-4))
    assert pressed.opening.delay - plain.opening.delay == pytest.approx(6e-4, rel=1e-6)
