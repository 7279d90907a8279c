"""Mechanical friction of the engine."""

from math import pi
from typing import Annotated, NamedTuple

from apesim.quantities import Quantity


class Friction(NamedTuple):
    """Chen and Flynn's friction mean effective pressure."""

    constant: Annotated[float, Quantity("bar", 0, 10, "Chen and Flynn, SAE 650733; constants vary")] = 0.4e5
    peak_pressure: Annotated[float, Quantity("", 0, 0.1, "Chen and Flynn; times the peak cylinder pressure")] = 0.005
    piston_speed: Annotated[float, Quantity("bar s/m", 0, 2, "Chen and Flynn; times the mean piston speed")] = 0.08e5
    piston_speed_squared: Annotated[float, Quantity("bar s^2/m^2", 0, 0.1, "Chen and Flynn")] = 0.0008e5


def friction_mean_effective_pressure(friction, peak_pressure, piston_speed):
    """Chen-Flynn: fmep = A + B p_max + C S_p + D S_p^2 (SAE 650733).

    Parameters
    ----------
    friction : Friction
    peak_pressure : float
        Highest cylinder pressure of the cycle [Pa abs].
    piston_speed : float
        Mean piston speed [m/s].

    Returns
    -------
    float
        [Pa]
    """
    return (
        friction.constant
        + friction.peak_pressure * peak_pressure
        + friction.piston_speed * piston_speed
        + friction.piston_speed_squared * piston_speed**2
    )


def mean_piston_speed(stroke, speed):
    """Two strokes a turn [m/s]; speed in rad/s."""
    return stroke * speed / pi
