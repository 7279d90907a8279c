"""Effective area of the groove as a table over the lift, for errors that no law of the library explains."""

from typing import TYPE_CHECKING

import numpy as np

from apesim.cubic_table import table
from apesim.effect import Effect
from apesim.engine.effects.groove_area_error import split_table
from apesim.quantities import Quantity
from apesim.valve.groove import lap_of

if TYPE_CHECKING:
    from apesim.engine.cycle.state import Cycle, CycleTables

PLACES = 0, 25, 50, 75, 100
"""Shares of the travel from the lap to the stroke at the nodes [%]."""

TabulatedGroove = table(
    "TabulatedGroove", __name__, share=(PLACES, Quantity("", -0.6, 0.6, "discharge coefficients: 0.6 to 0.9"))
)
TabulatedGroove.__doc__ = "Shares by which the groove's effective area is larger, over the lift."


def adjust(effect: tuple[float, ...], cycle: "Cycle", tables: "CycleTables") -> tuple["Cycle", "CycleTables"]:
    """Change the effective area of the groove by a table, ``S' = (1 + share(s)) S`` at the share s of the open travel.

    The area of ports becomes a table of pieces.

    Tables over the lift in place of a law are chosen.

    Parameters
    ----------
    effect : TabulatedGroove
        Parameters of the effect.
    cycle : apesim.engine.cycle.state.Cycle
        Machine at a speed, as numbers for the kernels.
    tables : apesim.engine.cycle.state.CycleTables
        Arrays of the machine.

    Returns
    -------
    cycle : apesim.engine.cycle.state.Cycle
        Machine with the effect.
    tables : apesim.engine.cycle.state.CycleTables
        Arrays of the machine with the effect.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), speed=100.0)
    >>> wider, _ = adjust(TabulatedGroove(*[0.1] * len(PLACES)), cycle, tables)
    >>> round(wider.full_area / cycle.full_area, 9)
    1.1
    """
    cycle, table = split_table(cycle, tables.valve.groove, len(PLACES) - 1)
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
