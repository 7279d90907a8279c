"""A groove whose effective area differs from the machine file's."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.valve.groove import lap_of
from apesim.valve.ports import ports_area

PIECES = 32


class GrooveAreaError(NamedTuple):
    """An error of the effective area, the same at any lift, and one that is largest at half of the open travel."""

    share: Annotated[float, Quantity("", -0.4, 0.4, "discharge coefficients: 0.6 to 0.9")] = 0.0
    taper: Annotated[float, Quantity("", -0.4, 0.4, "at half of the open travel; chamfers, round ports")] = 0.0


def in_pieces(cycle, table, pieces):
    """A groove's table with further rows, so that its areas can be changed over the lift.

    Parameters
    ----------
    cycle : apesim.engine.cycle.state.Cycle
    table : (j, 2) float array
        Lift [m] and effective area [m2].
    pieces : int
        Between the lap and the stroke; of a groove with ports `PIECES`.

    Returns
    -------
    apesim.engine.cycle.state.Cycle
        Its groove that of the table.
    (k, 2) float array
    """
    between = np.linspace(lap_of(table), cycle.actuator.valve.stroke, (PIECES if cycle.has_ports else pieces) + 1)
    lifts = np.union1d(table[:, 0], between)
    if not cycle.has_ports:
        return cycle, np.column_stack((lifts, np.interp(lifts, *table.T)))
    ports = cycle.ports
    cap = ports.discharge_coefficient * ports.passage_area
    areas = [min(ports_area(ports, lift - cycle.lap), cap) for lift in lifts]
    return cycle._replace(has_ports=0), np.column_stack((lifts, areas))


def larger(effect, table, stroke):
    """A groove's table with its areas times (1 + share)(1 + taper 4 s (1 - s)).

    Parameters
    ----------
    effect : GrooveAreaError
    table : (j, 2) float array
        Lift [m] and effective area [m2].
    stroke : float
        [m]

    Returns
    -------
    (j, 2) float array
    """
    lap = lap_of(table)
    s = np.clip((table[:, 0] - lap) / (stroke - lap), 0.0, 1.0)
    return np.column_stack(
        (table[:, 0], table[:, 1] * (1.0 + effect.share) * (1.0 + effect.taper * 4.0 * s * (1.0 - s)))
    )


def adjust(effect, cycle, tables):
    """Change the groove's table; with a taper, a table of ports becomes one of 32 pieces.

    Parameters
    ----------
    effect : GrooveAreaError
    cycle : apesim.engine.cycle.state.Cycle
    tables : apesim.engine.cycle.state.CycleTables

    Returns
    -------
    apesim.engine.cycle.state.Cycle, apesim.engine.cycle.state.CycleTables
    """
    table, stroke, ports = tables.valve.groove, cycle.actuator.valve.stroke, cycle.ports
    if effect.taper:
        cycle, table = in_pieces(cycle, table, 2)
    ports = ports._replace(discharge_coefficient=(1.0 + effect.share) * ports.discharge_coefficient)
    cycle = cycle._replace(ports=ports, full_area=(1.0 + effect.share) * cycle.full_area)
    return cycle, tables._replace(valve=tables.valve._replace(groove=larger(effect, table, stroke)))


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
