"""An opening of the solenoids over time that has no name."""

import numpy as np

from apesim.cubic_table import table
from apesim.effect import Effect
from apesim.quantities import Quantity

PLACES = 0, 25, 50, 75, 100
"""How far a solenoid has followed its switch [%]."""
PRESSURES = 0, 400, 800, 1200
"""Of control air above ambient [kPa]."""
SIZE = Quantity("ms", -2, 2, "solenoid valves of 120 Hz")
APART = 1e-6
"""Least time between two points of an opening curve [s]."""

TabulatedDelay = table("TabulatedDelay", __name__, a=(PLACES, SIZE), b=(PLACES, SIZE), pressure=(PRESSURES, SIZE))
TabulatedDelay.__doc__ = "How much later each solenoid has come how far; and how much later both, over the pressure."


def bent(curve, times, all_times):
    """An opening curve whose points come later.

    Parameters
    ----------
    curve : (j, 2) float array
        See `apesim.valve.solenoid.opening_curve`.
    times : sequence of float
        At the openings `PLACES` [s].
    all_times : float
        At any opening [s].

    Returns
    -------
    (k, 2) float array
        Not to before the switch, and rising.
    """
    nodes = np.array(PLACES) / 100.0
    between = np.column_stack((np.interp(nodes[1:-1], curve[:, 1], curve[:, 0]), nodes[1:-1]))
    points = np.unique(np.concatenate((curve, between)), axis=0)
    later = points[:, 0] + np.interp(points[:, 1], nodes, times) + all_times
    room = APART * np.arange(len(later))
    return np.column_stack((np.maximum.accumulate(np.maximum(later, 0.0) - room) + room, points[:, 1]))


def adjust(effect, actuator, tables):
    """Bend both solenoids' opening curves.

    Parameters
    ----------
    effect : TabulatedDelay
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    above = (actuator.control_pressure - actuator.ambient.pressure) / 1e3
    both = float(np.interp(above, PRESSURES, effect[10:]))
    return actuator, tables._replace(
        curve_a=bent(tables.curve_a, effect[:5], both), curve_b=bent(tables.curve_b, effect[5:10], both)
    )


EFFECT = Effect(
    "tabulated_delay",
    TabulatedDelay,
    equation="t(x) = t(x) + delay(x) + delay(p_c), x the opening; linear between nodes",
    source="no law: what opening over time would close a gap",
    seen_in="start of pressure change and of motion",
    isolated_by="pressure behind a solenoid against the coil current, at several supply pressures",
    strengths=TabulatedDelay._fields,
    adjust=adjust,
    tabulated="delay",
)
