"""Balance of the shaft: torques of gas, friction and load, rest and breakaway."""

from math import pi
from typing import NamedTuple

import numpy as np

from apesim.engine.cycle.state import Cycle, cylinder_state
from apesim.engine.cylinder import indicated_power
from apesim.engine.drivetrain.state import (
    ACCELERATION,
    DIRECTION,
    FRICTION_PRESSURE,
    HELD_SINCE,
    LOAD,
    SPEED,
    Drivetrain,
    block_of,
    cylinder_of,
    cylinders_of,
    own_modes,
    shaft_modes,
    shaft_states,
    surroundings_of,
)
from apesim.engine.friction import friction_mean_effective_pressure, mean_piston_speed
from apesim.engine.kinematics import swept_volume
from apesim.engine.shaft import HOIST, brake_torque, breakaway_share
from apesim.kernel import kernel

MIN_TORQUE = 1e-9
"""Torque that moves no shaft [N m]; chosen above the rounding of gas at ambient pressure, for one without friction."""


class Resistance(NamedTuple):
    """Torques that friction and load put against the gas, at a speed."""

    friction: float
    """Friction, against the motion or holding against it [N m]."""
    brake: float
    """Load of a brake, likewise [N m]."""
    hoist: float
    """Load of a hoist, against the direction of rotation whatever the motion [N m]."""


@kernel
def gas_torque(p: Drivetrain, c: Cycle, y: np.ndarray, mode: np.ndarray, i: int) -> float:
    """Torque of the gas in a cylinder `c`, number `i`, above ambient pressure on the shaft [N m]."""
    cylinder, slope = cylinder_state(c, surroundings_of(p, c, y, mode, i), block_of(y, i))
    return indicated_power(cylinder.air.pressure, c.actuator.ambient.pressure, slope, 1.0)


@kernel
def friction_torque(c: Cycle, pressure: float, speed: float) -> float:
    """Friction of a cylinder at a speed, without breakaway.

    ``T = fmep V_s/(2 pi)``, with Chen and Flynn's mean effective pressure [1]_ at the pressure and the mean piston
    speed of the moment, and the swept volume V_s.

    Parameters
    ----------
    c : apesim.engine.cycle.state.Cycle
        Cylinder.
    pressure : float
        Highest pressure between its last two passages of angle 0 [Pa abs].
    speed : float
        Speed of the shaft without sign [rad/s].

    Returns
    -------
    float
        Torque [N m].

    References
    ----------
    .. [1] S. K. Chen and P. F. Flynn, "Development of a single cylinder compression ignition research engine",
       SAE 650733, 1965, doi 10.4271/650733.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), 100.0)
    >>> round(friction_torque(cycle, 1e6, 100.0), 4)
    5.4072
    """
    engine = c.engine
    fmep = friction_mean_effective_pressure(engine.friction, pressure, mean_piston_speed(engine.stroke, speed))
    return fmep * swept_volume(engine) / (2.0 * pi)


@kernel
def resistance_at(p: Drivetrain, y: np.ndarray, mode: np.ndarray, speed: float) -> Resistance:
    """Find the torques of friction and load at a speed without sign [rad/s]."""
    friction = 0.0
    for i in range(cylinders_of(p)):
        friction += friction_torque(cylinder_of(p, y, mode, i), own_modes(mode, i)[FRICTION_PRESSURE], speed)
    constant = mode[shaft_modes(p) + LOAD]
    friction *= breakaway_share(p.shaft, speed)
    if p.load.kind == HOIST:
        return Resistance(friction, 0.0, constant)
    return Resistance(friction, brake_torque(p.load, constant, p.load_table, speed), 0.0)


@kernel
def driving_torque(p: Drivetrain, y: np.ndarray, mode: np.ndarray) -> float:
    """Torque of the gas in all cylinders, less that of a hoist [N m]."""
    torque = 0.0
    for i in range(cylinders_of(p)):
        torque += gas_torque(p, cylinder_of(p, y, mode, i), y, mode, i)
    return torque - mode[shaft_modes(p) + LOAD] if p.load.kind == HOIST else torque


@kernel
def breaks_away(p: Drivetrain, y: np.ndarray, mode: np.ndarray) -> float:
    """Return how far what drives a shaft at rest exceeds what can hold it [N m]; above zero it moves."""
    holds = resistance_at(p, y, mode, 0.0)
    return abs(driving_torque(p, y, mode)) - holds.friction - holds.brake - MIN_TORQUE


@kernel
def come_to_rest(p: Drivetrain, t: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Let a shaft whose speed is zero go on, turn back, or be held; changes its speed in `y`, and `mode`."""
    first = shaft_modes(p)
    if p.is_imposed:
        mode[first + DIRECTION] = np.sign(mode[first + ACCELERATION])
        return
    y[shaft_states(p) + SPEED] = 0.0
    if breaks_away(p, y, mode) > 0.0:
        mode[first + DIRECTION] = np.sign(driving_torque(p, y, mode))
    else:
        mode[first + DIRECTION], mode[first + HELD_SINCE] = 0.0, t
