"""Groove in the piston, through which the engine breathes.

The line from the lap to full lift is chosen; a measured table or the geometry of `apesim.valve.ports` replaces it.
"""

from collections.abc import Iterator
from math import inf
from typing import Annotated, NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.quantities import NO_CURVE, Choice, Curve, Quantity
from apesim.valve.ports import Ports, ports_table

LINE, PORTS = 0, 1
"""Geometries of the groove."""


class Groove(NamedTuple):
    """The groove that lets the intake air pass as the piston lifts."""

    effective_area: Annotated[float, Quantity("mm^2", 0.1, 5000, "chosen; at full lift")] = 150.0e-6
    lap: Annotated[float, Quantity("mm", 0, 40, "chosen; lift at which the groove begins to open")] = 1.0e-3
    area_curve: Annotated[
        np.ndarray,
        Curve(("lift [mm]", "effective_area [mm^2]"), "measured; not given: as the geometry has it"),
    ] = NO_CURVE
    geometry: Annotated[
        int, Choice(("line", "ports"), "chosen; line: linear from the lap to full lift, ports: as groove.ports has it")
    ] = LINE
    ports: Ports = Ports()

    @property
    def has_ports(self) -> bool:
        """Whether the effective area is that of the ports."""
        return self.geometry == PORTS and not len(self.area_curve)

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the area curve, beyond the ranges of its single values: key, wrong, right."""
        curve = self.area_curve
        if len(curve) and (curve[0, 0] < 0.0 or curve[0, 1] != 0.0 or curve[:, 1].min() < 0.0):
            yield "area_curve", "does not start closed", "area 0 in the first row (lift >= 0), nowhere below 0"

    def overruled(self) -> Iterator[tuple[str, str]]:
        """Find keys, or sections, that are not used because of others, and what is used in their place."""
        if len(self.area_curve):
            yield from ((key, ".area_curve is given") for key in ("effective_area", "lap", "geometry", "ports"))
        elif self.has_ports:
            yield "effective_area", '.geometry is "ports"'
        else:
            yield "ports", '.geometry is "line"'


def area_table(groove: Groove, stroke: float) -> np.ndarray:
    """Return the effective area [m2] of the groove over lift [m], as knots (j, 2), for a full lift [m].

    It is linear in between (with ports: see `apesim.valve.ports.ports_table`), zero before the first knot, and constant
    after the last.
    """
    if len(groove.area_curve):
        return np.ascontiguousarray(groove.area_curve)
    if groove.has_ports:
        return ports_table(groove.ports, groove.lap, stroke)
    return np.array([[groove.lap, 0.0], [stroke, groove.effective_area]])


def lap_of(table: np.ndarray) -> float:
    """Return the lift [m] at which a table (j, 2) of lift and area, see `area_table`, begins to open."""
    opens = int(np.argmax(table[:, 1] > 0.0))
    return float(table[max(opens - 1, 0), 0])


@kernel
def piece_of(table: np.ndarray, lift: float) -> int:
    """Return the number of the piece of the table (j, 2), see `area_table`, that a lift [m] lies in.

    It is 0 before the first knot, and j after the last.
    """
    piece = 0
    while piece < table.shape[0] and lift > table[piece, 0]:
        piece += 1
    return piece


@kernel
def piece_line(table: np.ndarray, piece: int) -> tuple[float, float, float, float]:
    """Return the effective area on a piece of the table (j, 2), see `piece_of`, as a line over lift.

    Gives its area at lift 0 [m2], its slope [m], and the ends of the piece [m], infinite at the outer ones.

    150 mm2 over 8 mm of lift, from a lap of 1 mm on:

    >>> area, slope, low, high = piece_line(np.array([[1e-3, 0.0], [9e-3, 150e-6]]), 1)
    >>> [round(float(x), 5) for x in (area * 1e6, slope * 1e3, low, high)]
    [-18.75, 18.75, 0.001, 0.009]
    """
    last = table.shape[0]
    if piece == 0:
        return 0.0, 0.0, -inf, table[0, 0]
    if piece == last:
        return table[last - 1, 1], 0.0, table[last - 1, 0], inf
    low, high = table[piece - 1, 0], table[piece, 0]
    slope = (table[piece, 1] - table[piece - 1, 1]) / (high - low)
    return table[piece - 1, 1] - slope * low, slope, low, high
