"""Solenoids that take longer, or shorter, from closed to open."""

from operator import add
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Misstated, Search
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


MIN_RAMP = 1e-6
"""Shortest ramp that is left [s]; chosen, far below any step of the march."""


class SlowRamp(NamedTuple):
    """A longer ramp of both solenoids from the same dead time on."""

    time: Annotated[float, Quantity("ms", -3, 3, "twice as long as the chosen ramp itself")] = 0.0


def adjust(effect: SlowRamp, actuator: "Actuator", tables: "ActuatorTables") -> tuple["Actuator", "ActuatorTables"]:
    """Stretch the curves of both edges about their first rows, ``ramp = ramp + time``; a ramp keeps at least 0.001 ms.

    A ramp that only gets longer is chosen.

    Parameters
    ----------
    effect : SlowRamp
        Parameters of the effect.
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    tables : apesim.valve.actuator.ActuatorTables
        Arrays of the valve.

    Returns
    -------
    apesim.valve.actuator.Actuator
        Valve with the effect.
    apesim.valve.actuator.ActuatorTables
        Arrays with the effect.

    Examples
    --------
    The default ramp of 1.5 ms after a dead time of 1.5 ms takes 0.5 ms more:

    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> _, slower = adjust(SlowRamp(time=0.5e-3), actuator, tables)
    >>> (slower.curves_a.energising * [1e3, 1.0]).round(6).tolist()
    [[1.5, 0.0], [3.5, 1.0]]
    """

    def slower(curve: np.ndarray) -> np.ndarray:
        start, ramp = curve[0, 0], curve[-1, 0] - curve[0, 0]
        lengthened = max(ramp + effect.time, MIN_RAMP)
        return np.column_stack((start + (curve[:, 0] - start) * (lengthened / ramp), curve[:, 1]))

    a, b = (curves.changed(slower) for curves in (tables.curves_a, tables.curves_b))
    return actuator, tables._replace(curves_a=a, curves_b=b)


EFFECT = Effect(
    "slow_ramp",
    SlowRamp,
    equation="ramp = ramp of the machine + time",
    source="solenoid valves: plunger and pilot fill at a rate of their own",
    seen_in="curvature of the chamber pressures at the switch; mostly taken up by delay and effective area",
    isolated_by="discharge test of a solenoid alone, pressure sampled at 20 kHz or more",
    adjust=adjust,
    search=Search(
        misstated=(
            Misstated("valve.solenoid.ramp_time", add),
            Misstated("valve.solenoid.release_ramp_time", add),
        )
    ),
)
