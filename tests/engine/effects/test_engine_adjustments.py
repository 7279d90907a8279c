"""Effects that change the engine's parameters: clearance, exhaust, groove, friction."""

import numpy as np
import pytest

from apesim.engine.angles import DEGREE
from apesim.engine.cycle.operating_point import cycle_of
from apesim.engine.effects.clearance_error import ClearanceError
from apesim.engine.effects.exhaust_back_pressure import ExhaustBackPressure
from apesim.engine.effects.exhaust_restriction import ExhaustRestriction
from apesim.engine.effects.exhaust_timing import ExhaustTiming
from apesim.engine.effects.friction_torque import FrictionTorque
from apesim.engine.effects.groove_area_error import GrooveAreaError
from apesim.engine.indicators import indicators
from apesim.engine.kinematics import cylinder_volume
from apesim.valve.groove import PORTS
from apesim.valve.ports import ports_area
from tests.machines import RPM, machine, settled

SPEED = 1000.0 * RPM
SWEPT = 0.25 * np.pi * 0.085**2 * 0.088


def having(values=None, **effects):
    a_machine = machine(**(values or {}))
    return a_machine._replace(effects=a_machine.effects._replace(**effects))


def told(a_machine, rpm=800.0):
    run = settled(a_machine, rpm)
    return indicators(a_machine, run), run


# --- clearance ---


def test_clearance_grows_by_its_share_and_the_swept_volume_does_not():
    p, _, _ = cycle_of(having(clearance_error=ClearanceError(0.08)), SPEED)
    top, bottom = (cylinder_volume(p.crank, angle)[0] for angle in (0.0, np.pi))
    assert top == pytest.approx(1.08 * SWEPT / 17.0, rel=1e-12)
    assert bottom - top == pytest.approx(SWEPT, rel=1e-12)


@pytest.mark.compiled
def test_a_larger_clearance_lowers_the_compression():
    """With the intake's opening put off beyond TDC, the compression's end is that of the closed cylinder."""
    late = {"energise": 20.0, "release": 90.0}
    pressures = []
    for share in (-0.08, 0.0, 0.08):
        _, run = told(having(late, clearance_error=ClearanceError(share)))
        pressures.append(np.interp(2.0 * np.pi, run.angles, run.trace[:, 0]))
    assert pressures[0] > pressures[1] > pressures[2]


# --- exhaust ---


@pytest.mark.parametrize("angle", [8.0, -8.0])
def test_exhaust_timing_moves_the_valve_and_its_corners(angle):
    plain, turned = (cycle_of(a, SPEED) for a in (having(), having(exhaust_timing=ExhaustTiming(angle * DEGREE))))
    assert turned[0].engine.exhaust.opens == pytest.approx((165.0 + angle) * DEGREE, rel=1e-12)
    assert turned[0].engine.exhaust.closes == pytest.approx((340.0 + angle) * DEGREE, rel=1e-12)
    corners = np.array([165.0, 190.0, 315.0, 340.0])

    def in_degrees(cycle):
        return cycle[2] * SPEED / DEGREE - 5.0

    for cycle, by in ((plain, 0.0), (turned, angle)):
        for corner in corners:
            assert np.abs(in_degrees(cycle) - (corner + by)).min() < 1e-9


def test_effects_of_the_exhaust_act_on_both_valves():
    two = {"engine.exhaust_2.effective_area": "200 mm^2", "engine.exhaust_2.opens": "190 deg"}
    effects = {"exhaust_restriction": ExhaustRestriction(0.4), "exhaust_timing": ExhaustTiming(3.0 * DEGREE)}
    plain = having().with_(**two)
    p, _, _ = cycle_of(plain._replace(effects=plain.effects._replace(**effects)), SPEED)
    areas, opens, closes, _ = np.transpose(p.exhausts)
    assert areas == pytest.approx([300e-6, 120e-6], rel=1e-12)
    assert opens == pytest.approx([168.0 * DEGREE, 193.0 * DEGREE], rel=1e-12)
    assert closes == pytest.approx(343.0 * DEGREE, rel=1e-12)


@pytest.mark.compiled
def test_a_late_exhaust_holds_the_pressure_longer_and_compresses_less():
    pressure = {}
    for angle in (-8.0, 0.0, 8.0):
        _, run = told(having(exhaust_timing=ExhaustTiming(angle * DEGREE)))
        degrees = np.degrees(run.angles)
        pressure[angle] = [np.interp(at, degrees, run.trace[:, 0]) for at in (180.0, 350.0)]
    assert pressure[-8.0][0] < pressure[0.0][0] < pressure[8.0][0]
    assert pressure[-8.0][1] > pressure[0.0][1] > pressure[8.0][1]


@pytest.mark.compiled
def test_a_restricted_exhaust_has_less_area_and_holds_the_pressure():
    p, _, _ = cycle_of(having(exhaust_restriction=ExhaustRestriction(0.4)), SPEED)
    assert p.engine.exhaust.effective_area == pytest.approx(300e-6, rel=1e-12)
    (free, free_run), (held, held_run) = (
        told(having(exhaust_restriction=ExhaustRestriction(share)), 1600.0) for share in (0.0, 0.4)
    )
    late_in_the_stroke = np.argmax(free_run.angles > 200.0 * DEGREE)
    assert held_run.trace[late_in_the_stroke, 0] > free_run.trace[late_in_the_stroke, 0]
    assert held["indicated_torque_Nm"] < free["indicated_torque_Nm"]


@pytest.mark.compiled
def test_back_pressure_is_where_the_cylinder_empties_to():
    """Slowly turned, the cylinder stands at the pressure behind the exhaust valve while that is wide open."""
    p, _, _ = cycle_of(having(exhaust_back_pressure=ExhaustBackPressure(20e3)), SPEED)
    assert p.exhaust_pressure == 101325.0 + 20e3
    (free, free_run), (held, held_run) = (
        told(having(exhaust_back_pressure=ExhaustBackPressure(pressure)), 300.0) for pressure in (0.0, 20e3)
    )
    at = np.searchsorted(free_run.angles, 260.0 * DEGREE)
    assert free_run.trace[at, 0] == pytest.approx(101325.0, rel=5e-3)
    assert held_run.trace[at, 0] == pytest.approx(121325.0, rel=5e-3)
    assert held["indicated_torque_Nm"] < free["indicated_torque_Nm"]


@pytest.mark.compiled
def test_back_pressure_costs_its_own_mean_effective_pressure():
    """Slowly turned, it stands against the piston in the exhaust stroke; what compression takes, expansion gives."""
    free, held = (
        told(having(exhaust_back_pressure=ExhaustBackPressure(pressure)), 300.0)[0] for pressure in (0.0, 20e3)
    )
    assert free["imep_Pa"] - held["imep_Pa"] == pytest.approx(20e3, rel=0.01)


# --- groove ---


def test_groove_area_and_its_taper_by_hand():
    """150 mm2 at 9 mm, lap 1 mm: 75 mm2 at 5 mm; +20 %, and +40 % at half of the travel."""
    p, tables, _ = cycle_of(having(groove_area_error=GrooveAreaError(0.2, 0.4)), SPEED)
    expected = np.array([[1e-3, 0.0], [5e-3, 126e-6], [9e-3, 180e-6]])
    assert tables.valve.groove == pytest.approx(expected, rel=1e-12)
    assert p.full_area == pytest.approx(180e-6, rel=1e-12)
    _, tables, _ = cycle_of(having(groove_area_error=GrooveAreaError(-0.4)), SPEED)
    assert tables.valve.groove == pytest.approx(np.array([[1e-3, 0.0], [9e-3, 90e-6]]), rel=1e-12)


def test_share_of_ports_is_that_of_their_discharge_coefficient():
    p, tables, _ = cycle_of(having({"groove__geometry": PORTS}, groove_area_error=GrooveAreaError(0.2)), SPEED)
    plain, plain_tables, _ = cycle_of(having({"groove__geometry": PORTS}), SPEED)
    assert p.has_ports == 1
    assert ports_area(p.ports, 3e-3) == pytest.approx(1.2 * ports_area(plain.ports, 3e-3), rel=1e-12)
    assert tables.valve.groove[:, 1] == pytest.approx(1.2 * plain_tables.valve.groove[:, 1], rel=1e-12)


def test_a_taper_of_ports_is_a_table_of_the_area_at_each_lift():
    p, tables, _ = cycle_of(having({"groove__geometry": PORTS}, groove_area_error=GrooveAreaError(0.0, 0.4)), SPEED)
    plain, _, _ = cycle_of(having({"groove__geometry": PORTS}), SPEED)
    assert p.has_ports == 0
    lift = np.array([1e-3, 3e-3, 5e-3, 9e-3])
    s = (lift - 1e-3) / 8e-3
    areas = np.array([min(ports_area(plain.ports, x - 1e-3), 0.75 * 200e-6) for x in lift])
    assert np.interp(lift, *tables.valve.groove.T) == pytest.approx(areas * (1.0 + 1.6 * s * (1.0 - s)), rel=1e-9)


@pytest.mark.parametrize("parameter", ["share", "taper"])
@pytest.mark.compiled
def test_a_larger_groove_lets_in_more_air(parameter):
    air = [
        told(having(groove_area_error=GrooveAreaError(**{parameter: value})))[0]["engine_air_kg_per_cycle"]
        for value in (-0.4, 0.0, 0.4)
    ]
    assert air[0] < air[1] < air[2]


# --- friction ---


@pytest.mark.compiled
def test_friction_takes_brake_torque_and_nothing_else():
    """20 kPa x 499.36 cm3 / 2 pi = 1.58951 N m."""
    plain, rubbed = (told(having(friction_torque=FrictionTorque(fmep)))[0] for fmep in (0.0, 20e3))
    assert plain["brake_torque_Nm"] - rubbed["brake_torque_Nm"] == pytest.approx(1.58951, rel=1e-4)
    assert rubbed["indicated_torque_Nm"] == plain["indicated_torque_Nm"]
    assert rubbed["engine_air_kg_per_cycle"] == plain["engine_air_kg_per_cycle"]
