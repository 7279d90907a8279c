"""Effects of the piston: friction, drag, further forces, cushions, springs and mass."""

from math import exp

import numpy as np
import pytest

from apesim.march.adaptive import LOG_HEAD
from apesim.valve.actuator import state_of
from apesim.valve.bench import bench_of, run_bench
from apesim.valve.effects.coulomb_friction import CoulombFriction
from apesim.valve.effects.end_cushion import EndCushion
from apesim.valve.effects.intake_flow_force import IntakeFlowForce
from apesim.valve.effects.moving_mass_error import MovingMassError
from apesim.valve.effects.quadratic_drag import QuadraticDrag
from apesim.valve.effects.seal_friction import SealFriction
from apesim.valve.effects.side_force import SideForce
from apesim.valve.effects.spring_rate_error import SpringRateError
from apesim.valve.effects.stribeck_friction import StribeckFriction
from apesim.valve.motion import LEFT
from apesim.valve.piston import HELD_CLOSED, HELD_OPEN, TO_CLOSED, TO_OPEN
from tests.valve.effects.test_valve_effects import INTAKE, PULSE, machine_with, rates_at, run_with
from tests.valve.test_bench import LIFT
from tests.valve.test_motion import marched

MASS = 0.1145
"""[kg]"""

# --- Coulomb friction ---


def test_friction_delays_the_start_and_slows_the_flight():
    strokes = [run_with(coulomb_friction=CoulombFriction(force)).opening for force in (0.0, 2.0, 4.0)]
    delays, contacts, speeds = ([getattr(s, name) for s in strokes] for name in ("delay", "contact", "seating_speed"))
    assert delays == sorted(delays)
    assert contacts == sorted(contacts)
    assert speeds == sorted(speeds, reverse=True)
    assert len(set(delays)) == 3


def force_at_start(effects):
    """Force to open at the instant at which the piston leaves its stop [N]."""
    log, *_ = marched(machine_with(**effects), PULSE, 8e-3, tolerance=1e-10)
    (row,) = log[log[:, 1] == LEFT]
    p, _ = bench_of(machine_with(**effects), [0.0, PULSE])
    state = state_of(p.actuator, row[LOG_HEAD:], p.supply)
    return (state.chamber_b.pressure - state.chamber_a.pressure) * 1134.1e-6 + 1828.0 * 9e-3


@pytest.mark.parametrize(("force", "breakaway", "holds"), [(3.0, 0.0, 3.0), (3.0, 2.0, 3.0), (3.0, 8.0, 8.0)])
def test_the_piston_starts_where_the_force_exceeds_the_larger_of_friction_and_breakaway(force, breakaway, holds):
    # The force rises by 1e5 N/s or so, its time is located to 1e-12 s; pressures of 1e6 Pa are held to 1e-10.
    assert force_at_start({"coulomb_friction": CoulombFriction(force, breakaway)}) == pytest.approx(holds, abs=1e-5)
    assert force_at_start({}) == pytest.approx(0.0, abs=1e-5)


def without_acceleration(rates):
    """Rates of the valve, the acceleration of its piston left out."""
    return rates._replace(states=rates.states._replace(speed=0.0))


@pytest.mark.parametrize(("phase", "sign"), [(TO_CLOSED, -1.0), (TO_OPEN, 1.0), (HELD_OPEN, 0.0), (HELD_CLOSED, 0.0)])
def test_friction_decelerates_by_force_over_mass(phase, sign):
    _, _, with_it = rates_at(phase, machine_with(coulomb_friction=CoulombFriction(3.0, 9.0)))
    _, _, without = rates_at(phase, machine_with())
    # Accelerations of some 1e4 m/s2, rounded at 1e-16 of them.
    assert with_it.states.speed - without.states.speed == pytest.approx(sign * 3.0 / 0.1145, abs=1e-10)
    assert without_acceleration(with_it) == without_acceleration(without)


def force_of(phase, position=4e-3, speed=1.2, intake_pressure=None, **effects):
    """What effects add to the force on a moving piston [N]."""
    at = {"position": position, "speed": speed, "intake_pressure": intake_pressure}
    _, _, with_it = rates_at(phase, machine_with(**effects), **at)
    _, _, without = rates_at(phase, machine_with(), **at)
    assert without_acceleration(with_it) == without_acceleration(without)
    return (with_it.states.speed - without.states.speed) * MASS


# --- friction that fades with speed, and that grows with pressure ---


@pytest.mark.parametrize(("speed", "share"), [(0.05, exp(-1.0)), (0.1, exp(-4.0)), (0.025, exp(-0.25)), (1.2, 0.0)])
@pytest.mark.parametrize("phase", [TO_CLOSED, TO_OPEN])
def test_stribeck_friction_fades_with_the_square_of_the_speed(phase, speed, share):
    found = force_of(phase, speed=speed, stribeck_friction=StribeckFriction(5.0, 0.05))
    assert found == pytest.approx(-phase * 5.0 * share, abs=1e-10)


def test_stribeck_friction_holds_at_rest_on_top_of_what_holds_already():
    effects = {"stribeck_friction": StribeckFriction(5.0)}
    assert force_at_start(effects) == pytest.approx(5.0, abs=1e-5)
    assert force_at_start(effects | {"coulomb_friction": CoulombFriction(3.0)}) == pytest.approx(8.0, abs=1e-5)


def test_seal_friction_is_proportional_to_both_pressures_over_ambient():
    """At 4 mm: p_A = 1.101325 MPa x 21588.9/15918.4, p_B = 0.101325 MPa x 11382/17052.5, 1e-5 N/Pa."""
    above_a = 1.101325e6 * 21588.9 / 15918.4 - 101325.0
    below_b = 101325.0 - 101325.0 * 11382.0 / 17052.5
    for phase in (TO_CLOSED, TO_OPEN):
        found = force_of(phase, seal_friction=SealFriction(1e-5))
        assert found == pytest.approx(-phase * 1e-5 * (above_a + below_b), rel=1e-7)


def test_seal_friction_holds_the_piston_by_the_pressures_at_its_start():
    effects = {"seal_friction": SealFriction(1e-5)}
    log, *_ = marched(machine_with(**effects), PULSE, 8e-3, tolerance=1e-10)
    (row,) = log[log[:, 1] == LEFT]
    p, _ = bench_of(machine_with(**effects), [0.0, PULSE])
    state = state_of(p.actuator, row[LOG_HEAD:], p.supply)
    holds = 1e-5 * (abs(state.chamber_a.pressure - 101325.0) + abs(state.chamber_b.pressure - 101325.0))
    assert holds > 1.0
    assert force_at_start(effects) == pytest.approx(holds, abs=1e-5)


@pytest.mark.parametrize("name", ["stribeck_friction", "seal_friction"])
def test_friction_of_any_kind_delays_the_start_and_the_contact(name):
    effect = {"stribeck_friction": StribeckFriction(6.0, 0.2), "seal_friction": SealFriction(5e-5)}[name]
    plain, rubbed = run_with().opening, run_with(**{name: effect}).opening
    assert rubbed.delay > plain.delay
    assert rubbed.contact > plain.contact


# --- drag, constant force, flow force ---


@pytest.mark.parametrize("phase", [TO_CLOSED, TO_OPEN])
def test_quadratic_drag_by_hand(phase):
    """30 N s2/m2 x (1.2 m/s)2 = 43.2 N against the motion."""
    assert force_of(phase, quadratic_drag=QuadraticDrag(30.0)) == pytest.approx(-phase * 43.2, abs=1e-10)


def test_drag_lowers_the_seating_speeds_of_both_strokes():
    plain, dragged = run_with(), run_with(quadratic_drag=QuadraticDrag(40.0))
    assert dragged.opening.seating_speed < plain.opening.seating_speed
    assert dragged.closing.seating_speed < plain.closing.seating_speed


@pytest.mark.parametrize("phase", [TO_CLOSED, TO_OPEN])
def test_a_side_force_points_to_closed_whichever_way_the_piston_moves(phase):
    assert force_of(phase, side_force=SideForce(8.0)) == pytest.approx(8.0, abs=1e-10)


def test_a_side_force_delays_the_opening_and_hastens_the_closing():
    plain, pushed = run_with(), run_with(side_force=SideForce(12.0))
    assert pushed.opening.delay > plain.opening.delay
    assert pushed.closing.delay < plain.closing.delay


def test_the_intake_pushes_to_closed_by_its_pressure_above_ambient():
    """100 mm2 x (0.6 - 0.101325) MPa = 49.8675 N."""
    effect = {"intake_flow_force": IntakeFlowForce(100e-6)}
    assert force_of(TO_OPEN, intake_pressure=0.6e6, **effect) == pytest.approx(49.8675, abs=1e-10)
    assert force_of(TO_OPEN, **effect) == 0.0


def test_intake_pressure_delays_the_opening_by_its_force_alone():
    machine = machine_with(intake_flow_force=IntakeFlowForce(20e-6))
    off, on = (run_bench(machine, PULSE, intake_pressure=pressure) for pressure in (None, INTAKE))
    assert on.opening.delay > off.opening.delay
    assert off.opening == run_with().opening


# --- cushions ---


@pytest.mark.parametrize(
    ("phase", "position", "force"),
    [
        pytest.param(TO_OPEN, 0.2e-3, 100.0 * 0.6 * 1.2, id="0.2 of 0.5 mm before the open stop"),
        pytest.param(TO_CLOSED, 8.9e-3, -100.0 * 0.8 * 1.2, id="0.1 of 0.5 mm before the closed stop"),
        pytest.param(TO_CLOSED, 0.2e-3, 0.0, id="away from the open stop"),
        pytest.param(TO_OPEN, 8.9e-3, 0.0, id="away from the closed stop"),
        pytest.param(TO_OPEN, 0.6e-3, 0.0, id="not yet there"),
    ],
)
def test_a_cushion_brakes_towards_the_stop_ahead(phase, position, force):
    found = force_of(phase, position=position, end_cushion=EndCushion(100.0, 0.5e-3))
    assert found == pytest.approx(force, abs=1e-9)


def test_a_cushion_takes_seating_speed_and_nothing_before_it():
    plain, cushioned = run_with(), run_with(end_cushion=EndCushion(200.0, 1e-3))
    assert cushioned.opening.seating_speed < plain.opening.seating_speed
    assert cushioned.closing.seating_speed < plain.closing.seating_speed
    before = plain.trace[:, LIFT] < 7.9e-3
    first = np.argmin(before)
    assert cushioned.trace[:first, LIFT] == pytest.approx(plain.trace[:first, LIFT], abs=1e-9)


# --- springs and mass ---


@pytest.mark.parametrize("share", [-0.3, 0.3])
def test_stiffer_springs_by_hand(share):
    """K (9 mm - 2 x 4 mm) = 1.828 N."""
    assert force_of(TO_OPEN, spring_rate_error=SpringRateError(share)) == pytest.approx(share * 1.828, abs=1e-10)


def test_stiffer_springs_start_sooner():
    """At the closed stop the springs push to open."""
    delays = [run_with(spring_rate_error=SpringRateError(share)).opening.delay for share in (0.3, 0.0, -0.3)]
    assert delays[0] < delays[1] < delays[2]


def test_a_heavier_piston_is_slower_by_its_mass():
    _, _, heavy = rates_at(TO_OPEN, machine_with(moving_mass_error=MovingMassError(0.1)))
    _, _, plain = rates_at(TO_OPEN, machine_with())
    assert heavy.states.speed == pytest.approx(plain.states.speed / 1.1, rel=1e-12)
    contacts = [run_with(moving_mass_error=MovingMassError(share)).opening.contact for share in (-0.15, 0.0, 0.15)]
    assert contacts[0] < contacts[1] < contacts[2]
