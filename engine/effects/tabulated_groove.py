"""An effective area of the groove that has no name."""

import numpy as np

from apesim.effect import Effect
from apesim.engine.effects.groove_area_error import in_pieces
from apesim.nodes import table
from apesim.quantities import Quantity
from apesim.valve.groove import lap_of

PLACES = 0, 25, 50, 75, 100
"""Share of the travel from the lap on [%]."""

TabulatedGroove = table(
    "TabulatedGroove", __name__, share=(PLACES, Quantity("", -0.6, 0.6, "discharge coefficients: 0.6 to 0.9"))
)
TabulatedGroove.__doc__ = "Shares by which the groove's effective area is larger, over the lift."


def adjust(effect, cycle, tables):
    """Change the groove's table; a table of ports becomes one of pieces.

    Parameters
    ----------
    effect : TabulatedGroove
    cycle : apesim.engine.cycle.state.Cycle
    tables : apesim.engine.cycle.state.CycleTables

    Returns
    -------
    apesim.engine.cycle.state.Cycle, apesim.engine.cycle.state.CycleTables
    """
    cycle, table = in_pieces(cycle, tables.valve.groove, len(PLACES) - 1)
    lap = lap_of(table)
    place = 100.0 * (table[:, 0] - lap) / (cycle.actuator.valve.stroke - lap)
    table = np.column_stack((table[:, 0], table[:, 1] * (1.0 + np.interp(place, PLACES, effect))))
    cycle = cycle._replace(full_area=(1.0 + effect[-1]) * cycle.full_area)
    return cycle, tables._replace(valve=tables.valve._replace(groove=table))


EFFECT = Effect(
    "tabulated_groove",
    TabulatedGroove,
    equation="S(s) = (1 + share(s)) S(s), s = (lift - lap)/(stroke - lap), linear between nodes every quarter",
    source="no law: what area over the lift would close a gap",
    seen_in="pressure rise after opening",
    isolated_by="steady flow through the groove at several lifts",
    strengths=TabulatedGroove._fields,
    adjust=adjust,
    tabulated="area",
)
