"""Rig that moves the piston of a pneumatic cylinder by a drive, and measures the force on the drive.

One chamber is pressurised. Stroke and pressure are given; the force follows from the balance of the piston at every
instant by itself, as its inertia is neglected: 0.1 kg at 0.1 m/s2 are 0.01 N.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from apesim.air import GasState
from apesim.effect import Effect, add_laws, library_for
from apesim.quantities import Quantity
from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
from apesim.valve.effects import (
    VALVE_LIBRARY,
    coulomb_friction,
    quadratic_drag,
    seal_friction,
    sensor_gain,
    sensor_offset,
    side_force,
    stribeck_friction,
    tabulated_damping,
    tabulated_force,
)
from apesim.valve.piston import TO_CLOSED, TO_OPEN, dry_friction_force, smooth_force
from apesim.valve.supply import ValveSupply
from apesim.valve.terms import DRY, FORCE, TERMS

RIG_EFFECTS = (
    coulomb_friction.EFFECT,
    stribeck_friction.EFFECT,
    seal_friction.EFFECT,
    quadratic_drag.EFFECT,
    side_force.EFFECT,
    tabulated_force.EFFECT,
    tabulated_damping.EFFECT,
    sensor_gain.EFFECT,
    sensor_offset.EFFECT,
)
"""Effects of the valve that a piston moved by a drive can show: forces on the piston, and errors of the sensors."""


class Rig(NamedTuple):
    """Rig for a pneumatic cylinder that a drive moves; only data of the bench "cylinder" depend on it."""

    bore: Annotated[float, Quantity("mm", 1, 1000, "chosen: a round piston of the valve's area, 1134.1 mm^2")] = 38.0e-3
    viscous_friction: Annotated[
        float, Quantity("N s/m", 0, 10000, "chosen: none; it is fitted within a prior, see the bench")
    ] = 0.0

    @property
    def piston_area(self) -> float:
        """Area of the piston [m2]."""
        return float(0.25 * np.pi * self.bore**2)


def shows_on_rig(effect: Effect) -> bool:
    """Tell whether an effect of the valve can show where a drive moves the piston.

    One from outside counts as a force on the piston.

    >>> from apesim.valve.effects import leakage_a
    >>> shows_on_rig(seal_friction.EFFECT), shows_on_rig(leakage_a.EFFECT)
    (True, False)
    """
    return effect in RIG_EFFECTS or effect.is_from_outside


def drive_force(machine: Any, stroke: np.ndarray, pressure: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the force on the drive of a cylinder: that of the pressure, more or less the friction.

    ``F = A (p - p_0) + beta v + F_d sign(v) + F_s``, the balance of Eq. 1 of the EPV paper [1]_ without springs and
    inertia, with the dry friction of its Eq. 2.

    p is the pressure in the chamber, p_0 the ambient one, A the piston's area and v the velocity of the stroke,
    positive where the drive pushes the piston against the pressure. F_d and F_s are what the laws of the valve's
    effects add against the motion and along the axis. The chamber takes the place of chamber A, the other one is open.

    Parameters
    ----------
    machine : NamedTuple
        Machine with the section ``rig``, and those of its valve.
    stroke : (n,) float array
        Stroke, rising where the drive pushes the piston against the pressure [m].
    pressure : (n,) float array
        Pressure in the chamber [Pa abs].
    velocity : (n,) float array
        Velocity of the stroke; nowhere 0, as friction at rest is a reaction [m/s].

    Returns
    -------
    (n,) float array
        Force, positive where the pressure pushes the drive back [N].

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 1 and 2.

    Examples
    --------
    0.1 MPa above ambient on 518.7 mm2, with a friction of 5 N, pushed in and let out:

    >>> import apesim
    >>> machine = apesim.Machine().with_(rig_bore="25.7 mm", **{"effects.coulomb_friction.force": "5 N"})
    >>> stroke, pressure = np.array([10e-3, 10e-3]), np.full(2, machine.ambient.pressure + 1e5)
    >>> drive_force(machine, stroke, pressure, np.array([0.01, -0.01])).round(2).tolist()
    [56.87, 46.87]
    """
    actuator, _ = actuator_of(machine, [0.0], np.inf)
    effects = _effects_on(machine)
    span = float(np.ptp(stroke)) or machine.valve.stroke
    valve = actuator.valve._replace(
        stroke=span,
        piston_area=machine.rig.piston_area,
        spring_rate=0.0,
        viscous_friction=machine.rig.viscous_friction,
    )
    rest = state_of(actuator, closed_at_rest(actuator, actuator.ambient), ValveSupply(actuator.ambient, 0.0))
    rest = rest._replace(valve=valve, chamber_b=actuator.ambient)
    ambient, position = actuator.ambient, stroke.max() - stroke
    forces = np.empty(len(stroke))
    for number, speed in enumerate((-velocity).tolist()):
        place, air = float(position[number]), GasState(float(pressure[number]), ambient.temperature)
        force = smooth_force(valve, place, speed, air.pressure, ambient.pressure)
        if effects:
            balance = np.zeros(TERMS)
            add_laws(effects, rest._replace(position=place, speed=speed, chamber_a=air), balance)
            force += balance[FORCE] + dry_friction_force(TO_CLOSED if speed > 0.0 else TO_OPEN, balance[DRY])
        forces[number] = force
    return forces


def _effects_on(machine: Any) -> tuple[Any, ...]:
    """Parameters of the effects that are on and act on the piston."""
    library = library_for(machine.effects, VALVE_LIBRARY, "valve").effects
    values = [(effect, getattr(machine.effects, effect.name)) for effect in library if shows_on_rig(effect)]
    return tuple(value for effect, value in values if effect.is_marched and effect.is_on(value))
