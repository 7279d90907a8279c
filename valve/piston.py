"""The piston: the forces on it (Eq. 1), its two stops, and what dry friction does at rest.

The coordinate L runs from 0 (fully open) to the stroke (closed); positive force and speed point to closed.
"""

from typing import Annotated, NamedTuple

from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.solenoid import Solenoid

HELD_CLOSED, TO_CLOSED, STUCK, TO_OPEN, HELD_OPEN = 2, 1, 0, -1, -2
"""Phases of the piston. The sign of a moving piston's phase is that of its speed."""
REST_SPEED = 1e-3
"""A rebound slower than this stays on the stop [m/s]."""


class Valve(NamedTuple):
    """The electro-pneumatic valve (EPV): a piston between two chambers."""

    stroke: Annotated[float, Quantity("mm", 0.5, 100, "paper, Table 1 (L_max)")] = 9.0e-3
    moving_mass: Annotated[float, Quantity("kg", 0.0001, 10, "paper, Table 1 (M)")] = 0.1145
    piston_area: Annotated[float, Quantity("mm^2", 1, 100000, "paper, Table 1 (A)")] = 1134.1e-6
    clearance_volume: Annotated[float, Quantity("mm^3", 10, 10000000, "paper, Table 1; each chamber")] = 11382e-9
    spring_rate: Annotated[float, Quantity("N/m", 0, 1000000, "paper, Table 1 (K), each spring")] = 1828.0
    viscous_friction: Annotated[float, Quantity("N s/m", 0, 10000, "paper, identified (beta)")] = 111.08
    solenoid: Solenoid = Solenoid()


@kernel
def is_moving(phase):
    """Whether a phase is one of motion."""
    return abs(phase) == TO_CLOSED


@kernel
def volume_a(valve, position):
    """Chamber A, which pushes to closed [m3]."""
    return valve.clearance_volume + valve.piston_area * position


@kernel
def volume_b(valve, position):
    """Chamber B, which pushes to open [m3]."""
    return valve.clearance_volume + valve.piston_area * (valve.stroke - position)


@kernel
def smooth_force(valve, position, speed, pressure_a, pressure_b):
    """Force of pressure, springs and viscous friction (Eq. 1 without F_f) [N].

    Parameters
    ----------
    valve : Valve
    position : float
        L [m].
    speed : float
        dL/dt [m/s].
    pressure_a, pressure_b : float
        [Pa abs]

    Returns
    -------
    float
        Positive to closed.
    """
    return (
        (pressure_a - pressure_b) * valve.piston_area
        + valve.spring_rate * (valve.stroke - 2.0 * position)
        - valve.viscous_friction * speed
    )


@kernel
def dry_friction_force(phase, dry):
    """Coulomb friction against the motion (Eq. 2) [N]; none in a phase of rest, where it is a reaction."""
    if phase == TO_CLOSED:
        return -dry
    if phase == TO_OPEN:
        return dry
    return 0.0


@kernel
def overcome(phase, force, breakaway):
    """By how much the force exceeds what holds the piston at rest [N]; it starts to move above zero."""
    if phase == HELD_CLOSED:
        return -force - breakaway
    if phase == HELD_OPEN:
        return force - breakaway
    return abs(force) - breakaway


@kernel
def start_moving(phase, force):
    """Phase of a piston that a force sets in motion; from a stop there is one way only."""
    if phase == HELD_CLOSED:
        return TO_OPEN
    if phase == HELD_OPEN:
        return TO_CLOSED
    return TO_CLOSED if force > 0.0 else TO_OPEN


@kernel
def land(stop, speed, restitution):
    """Speed and phase after contact with a stop.

    Parameters
    ----------
    stop : int
        HELD_CLOSED or HELD_OPEN.
    speed : float
        Just before contact [m/s].
    restitution : float
        Speed after over speed before, 0...1.

    Returns
    -------
    speed : float
    phase : int
    """
    rebound = -restitution * speed
    if abs(rebound) < REST_SPEED:
        return 0.0, stop
    return rebound, start_moving(stop, rebound)
