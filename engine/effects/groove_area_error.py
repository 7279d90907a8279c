"""Effective area of the groove that differs from the machine file's."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.valve.groove import lap_of
from apesim.valve.ports import ports_area

if TYPE_CHECKING:
    from apesim.engine.cycle.state import Cycle, CycleTables

PIECES = 32
"""Pieces of a table in place of ports, from the lap to the stroke; chosen: their areas bend smoothly over the lift."""


class GrooveAreaError(NamedTuple):
    """Errors of the effective area: one alike at all lifts, and one that is largest at half of the open travel."""

    share: Annotated[float, Quantity("", -0.4, 0.4, "discharge coefficients: 0.6 to 0.9")] = 0.0
    taper: Annotated[float, Quantity("", -0.4, 0.4, "at half of the open travel; chamfers, round ports")] = 0.0


def split_table(cycle: "Cycle", table: np.ndarray, pieces: int) -> tuple["Cycle", np.ndarray]:
    """Give a groove's table of areas further rows, so that its areas can be changed over the lift.

    `table` (j, 2) has lift [m] and effective area [m2]; the new one has the same area at every lift, in `pieces`
    between the lap and the stroke; a groove with ports gets `PIECES`. The machine that is returned has the area of the
    table, not that of ports.

    >>> from apesim.engine.cycle.operating_point import cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), speed=100.0)
    >>> _, table = split_table(cycle, tables.valve.groove, 2)
    >>> (table[-3:] * 1e3).round(6).tolist()
    [[1.0, 0.0], [5.0, 0.075], [9.0, 0.15]]
    """
    between = np.linspace(lap_of(table), cycle.actuator.valve.stroke, (PIECES if cycle.has_ports else pieces) + 1)
    lifts = np.union1d(table[:, 0], between)
    if not cycle.has_ports:
        return cycle, np.column_stack((lifts, np.interp(lifts, *table.T)))
    ports = cycle.ports
    cap = ports.discharge_coefficient * ports.passage_area
    areas = [min(ports_area(ports, lift - cycle.lap), cap) for lift in lifts]
    return cycle._replace(has_ports=0), np.column_stack((lifts, areas))


def scale_areas(effect: GrooveAreaError, table: np.ndarray, stroke: float) -> np.ndarray:
    """Scale the areas of a groove's table, ``S' = S (1 + share) (1 + taper 4 s (1 - s))``.

    The share s of the open travel is ``(L - lap)/(stroke - lap)`` at the lift L, from 0 to 1.

    The flow coefficient of an engine's valve depends on its lift [1]_; the parabola is chosen.

    Parameters
    ----------
    effect : GrooveAreaError
        Share and taper.
    table : (j, 2) float array
        Lift [m] and effective area [m2].
    stroke : float
        Stroke of the valve [m].

    Returns
    -------
    (j, 2) float array
        Lift [m] and effective area with the error [m2].

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, section 6.3.

    Examples
    --------
    A taper of 0.1 adds a tenth of the area at half of the open travel, and nothing at its end:

    >>> table = np.array([[0.0, 0.0], [1.0, 0.0], [5.0, 75.0], [9.0, 150.0]])
    >>> scale_areas(GrooveAreaError(taper=0.1), table, 9.0)[:, 1].round(6).tolist()
    [0.0, 0.0, 82.5, 150.0]
    """
    lap = lap_of(table)
    s = np.clip((table[:, 0] - lap) / (stroke - lap), 0.0, 1.0)
    return np.column_stack(
        (table[:, 0], table[:, 1] * (1.0 + effect.share) * (1.0 + effect.taper * 4.0 * s * (1.0 - s)))
    )


def adjust(effect: GrooveAreaError, cycle: "Cycle", tables: "CycleTables") -> tuple["Cycle", "CycleTables"]:
    """Change the effective area of the groove; with a taper, the area of ports becomes a table of `PIECES`."""
    table, stroke, ports = tables.valve.groove, cycle.actuator.valve.stroke, cycle.ports
    if effect.taper:
        cycle, table = split_table(cycle, table, 2)
    ports = ports._replace(discharge_coefficient=(1.0 + effect.share) * ports.discharge_coefficient)
    cycle = cycle._replace(ports=ports, full_area=(1.0 + effect.share) * cycle.full_area)
    return cycle, tables._replace(valve=tables.valve._replace(groove=scale_areas(effect, table, stroke)))


EFFECT = Effect(
    "groove_area_error",
    GrooveAreaError,
    equation="S(s) = (1 + share) (1 + taper 4 s (1 - s)) S(s), s = (lift - lap)/(stroke - lap)",
    source="flow coefficients of ports over lift: Heywood, Internal Combustion Engine Fundamentals",
    seen_in="pressure rise after opening; confused with the lap",
    isolated_by="steady flow through the groove at several lifts",
    strengths=("share", "taper"),
    adjust=adjust,
)
