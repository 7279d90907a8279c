"""Shaft and load: inertia, breakaway friction, and what the engine drives, where its speed is free.

A steady run at an imposed speed does not depend on them.
"""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

import numpy as np

from apesim.engine.angles import TURN
from apesim.kernel import kernel
from apesim.linear_table import read_table
from apesim.quantities import NO_CURVE, Choice, Curve, Quantity

BRAKE, HOIST = 0, 1
LOADS = ("brake", "hoist")
"""Kinds of load, as a machine file names them: one that acts against the motion, one that pulls one way."""


class Shaft(NamedTuple):
    """Shaft, of matter only where its speed is free: inertia, and friction on breaking away from rest."""

    inertia: Annotated[
        float, Quantity("kg m^2", 1e-6, 1e5, "chosen; constant, of all that turns, the load's reduced to it")
    ] = 0.1
    breakaway_factor: Annotated[
        float, Quantity("", 1, 10, "chosen; friction at rest over that without breakaway, 1: alike")
    ] = 2.0
    breakaway_speed: Annotated[
        float, Quantity("rpm", 0.1, 3000, "chosen; from here on friction is without breakaway")
    ] = TURN  # 60 r/min, one turn a second


class Load(NamedTuple):
    """Load on the shaft, of matter only where its speed is free; by default there is none."""

    kind: Annotated[
        int,
        Choice(LOADS, "chosen; brake: against the motion, hoist: the constant torque whichever way the shaft turns"),
    ] = BRAKE
    constant: Annotated[float, Quantity("N m", -1e6, 1e6, "chosen: none; of a brake at least 0")] = 0.0
    proportional: Annotated[float, Quantity("N m s", 0, 1e6, "chosen: none; per rad/s")] = 0.0
    quadratic: Annotated[float, Quantity("N m s^2", 0, 1e6, "chosen: none; per (rad/s)^2")] = 0.0
    table: Annotated[
        np.ndarray,
        Curve(
            ("speed [rpm]", "torque [N m]"),
            "measured, linear in between and constant beyond, besides the three above; not given: none",
        ),
    ] = NO_CURVE

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the load, beyond the ranges of its single keys: key, wrong, right."""
        if self.kind == HOIST:
            given = {"proportional": self.proportional, "quadratic": self.quadratic, "table": len(self.table)}
            wrong, right = "is given for a hoist, which has a constant torque alone", 'leave it out, or kind = "brake"'
            yield from ((key, wrong, right) for key, value in given.items() if value)
            return
        if self.constant < 0.0:
            yield "constant", f"{self.constant:g} N m would drive the shaft", 'at least 0 N m, or kind = "hoist"'
        if len(self.table) and self.table.min() < 0.0:
            yield "table", "has a speed or a torque below 0", "at least 0 in both columns: it acts against the motion"


@kernel
def breakaway_share(shaft: Shaft, speed: float) -> float:
    """Friction at a speed over that without breakaway.

    ``1 + (kappa - 1)(1 - (omega/omega_1)^2)^2`` below the speed omega_1, else 1, with the factor kappa at rest. This
    shape is chosen; value and slope are continuous.

    Parameters
    ----------
    shaft : Shaft
        Breakaway factor kappa and speed omega_1 [rad/s].
    speed : float
        Speed omega of the shaft, of either sign [rad/s].

    Returns
    -------
    float
        Share, 1 and above.

    Examples
    --------
    >>> [breakaway_share(Shaft(breakaway_factor=2.0, breakaway_speed=6.0), speed) for speed in (0.0, 3.0, -6.0)]
    [2.0, 1.5625, 1.0]
    """
    share = (speed / shaft.breakaway_speed) ** 2
    return 1.0 + (shaft.breakaway_factor - 1.0) * (1.0 - share) ** 2 if share < 1.0 else 1.0


@kernel
def brake_torque(load: Load, constant: float, table: np.ndarray, speed: float) -> float:
    """Torque of a brake at a speed, ``L = c_0 + c_1 omega + c_2 omega^2 + table(omega)``; it acts against the motion.

    The table is linear between its rows and constant beyond. The shape is chosen; c_2 alone is a fan.

    Parameters
    ----------
    load : Load
        Coefficients c_1 [N m s] and c_2 [N m s2].
    constant : float
        Constant part c_0, which may change with time [N m].
    table : (n, 2) float array
        Speed [rad/s] and torque [N m].
    speed : float
        Speed omega of the shaft without sign [rad/s].

    Returns
    -------
    float
        Torque [N m].

    Examples
    --------
    >>> load, table = Load(proportional=0.5, quadratic=0.1), np.array([[0.0, 4.0], [20.0, 8.0]])
    >>> [round(float(brake_torque(load, 1.0, table, speed)), 9) for speed in (0.0, 10.0, 30.0)]
    [5.0, 22.0, 114.0]
    """
    torque = constant + load.proportional * speed + load.quadratic * speed * speed
    return torque + read_table(table, speed) if table.shape[0] > 0 else torque
