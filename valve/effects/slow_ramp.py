"""Solenoids that take longer, or shorter, from closed to open."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect
from apesim.quantities import Quantity

MIN_RAMP = 1e-6
"""[s]"""


class SlowRamp(NamedTuple):
    """A longer ramp of both solenoids from the same dead time on."""

    time: Annotated[float, Quantity("ms", -1.5, 1.5, "as long as the chosen ramp itself")] = 0.0


def adjust(effect, actuator, tables):
    """Stretch the opening curves about their first rows; a ramp keeps at least 0.001 ms.

    Parameters
    ----------
    effect : SlowRamp
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """

    def slower(curve):
        start, ramp = curve[0, 0], curve[-1, 0] - curve[0, 0]
        lengthened = max(ramp + effect.time, MIN_RAMP)
        return np.column_stack((start + (curve[:, 0] - start) * (lengthened / ramp), curve[:, 1]))

    return actuator, tables._replace(curve_a=slower(tables.curve_a), curve_b=slower(tables.curve_b))


EFFECT = Effect(
    "slow_ramp",
    SlowRamp,
    equation="ramp = ramp of the machine + time",
    source="solenoid valves: plunger and pilot fill at a rate of their own",
    seen_in="curvature of the chamber pressures at the switch; almost wholly eaten by delay and effective area",
    isolated_by="discharge test of a solenoid alone, pressure sampled at 20 kHz or more",
    adjust=adjust,
)
