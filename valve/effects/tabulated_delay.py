"""Opening of the solenoids over time that has no name, as tables."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from apesim.cubic_table import table
from apesim.effect import Effect
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


PLACES = 0, 25, 50, 75, 100
"""Share of the opening at the values of the tables of each solenoid [%]."""
PRESSURES = 0, 400, 800, 1200
"""Control pressure above ambient at the values of the table of both solenoids [kPa]."""
SIZE = Quantity("ms", -2, 2, "solenoid valves of 120 Hz")
"""Declaration of a value: the time by which an opening is later."""
APART = 1e-6
"""Shortest time between two points of an opening curve [s]; chosen, so that the curve always rises."""

TabulatedDelay = table("TabulatedDelay", __name__, a=(PLACES, SIZE), b=(PLACES, SIZE), pressure=(PRESSURES, SIZE))
TabulatedDelay.__doc__ = "How much later each solenoid has come how far; and how much later both, over the pressure."


def bent(curve: np.ndarray, times: Sequence[float], all_times: float) -> np.ndarray:
    """Return a curve of an edge whose points come later, by a table over the share of the way.

    `curve` (j, 2) is as in `apesim.valve.solenoid.SolenoidCurves`; `times` are delays at the shares `PLACES`, linear in
    between, and `all_times` is the delay at any share [s]. The curve returned, (k, 2), rises, and does not reach to
    before the edge.
    """
    nodes = np.array(PLACES) / 100.0
    between = np.column_stack((np.interp(nodes[1:-1], curve[:, 1], curve[:, 0]), nodes[1:-1]))
    points = np.unique(np.concatenate((curve, between)), axis=0)
    later = points[:, 0] + np.interp(points[:, 1], nodes, times) + all_times
    room = APART * np.arange(len(later))
    return np.column_stack((np.maximum.accumulate(np.maximum(later, 0.0) - room) + room, points[:, 1]))


def adjust(
    effect: tuple[float, ...], actuator: "Actuator", tables: "ActuatorTables"
) -> tuple["Actuator", "ActuatorTables"]:
    """Delay both edges of both solenoids by tables, ``t(x) = t(x) + delay(x) + delay(p_c)``. Chosen.

    Parameters
    ----------
    effect : TabulatedDelay
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
    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> _, later = adjust(TabulatedDelay(a_at_0=0.5e-3), actuator, tables)
    >>> round(float(later.curves_a.release[0, 0] - tables.curves_a.release[0, 0]) * 1e3, 6)
    0.5
    """
    above = (actuator.control_pressure - actuator.ambient.pressure) / 1e3
    both = float(np.interp(above, PRESSURES, effect[10:]))
    return actuator, tables._replace(
        curves_a=tables.curves_a.changed(lambda curve: bent(curve, effect[:5], both)),
        curves_b=tables.curves_b.changed(lambda curve: bent(curve, effect[5:10], both)),
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
