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
        """Find what is wrong with the area curve, beyond the ranges of its single values.

        Yields
        ------
        key, wrong, right : str
            Key of the machine file, what is wrong with it, and what would be right.

        Examples
        --------
        >>> [wrong for _, wrong, _ in Groove(area_curve=np.array([[0.0, 1e-6], [9e-3, 1e-4]])).faults()]
        ['does not start closed']
        """
        curve = self.area_curve
        if len(curve) and (curve[0, 0] < 0.0 or curve[0, 1] != 0.0 or curve[:, 1].min() < 0.0):
            yield "area_curve", "does not start closed", "area 0 in the first row (lift >= 0), nowhere below 0"

    def overruled(self) -> Iterator[tuple[str, str]]:
        """Find keys that are not used because of others.

        Yields
        ------
        key, reason : str
            Key or section, and what is used in its place.

        Examples
        --------
        >>> list(Groove().overruled())
        [('ports', 'groove.geometry is "line"')]
        """
        if len(self.area_curve):
            yield from ((key, "groove.area_curve is given") for key in ("effective_area", "lap", "geometry", "ports"))
        elif self.has_ports:
            yield "effective_area", 'groove.geometry is "ports"'
        else:
            yield "ports", 'groove.geometry is "line"'


def area_table(groove: Groove, stroke: float) -> np.ndarray:
    """Return the effective area of the groove over lift, as knots.

    Parameters
    ----------
    groove : Groove
        Parameters of the groove.
    stroke : float
        Full lift [m].

    Returns
    -------
    (j, 2) float array
        Lift [m] and effective area [m2]; linear in between (with ports: see `apesim.valve.ports.ports_table`), zero
        before the first knot, constant after the last.

    Examples
    --------
    >>> area_table(Groove(effective_area=150e-6, lap=1e-3), 9e-3).tolist()
    [[0.001, 0.0], [0.009, 0.00015]]
    """
    if len(groove.area_curve):
        return np.ascontiguousarray(groove.area_curve)
    if groove.has_ports:
        return ports_table(groove.ports, groove.lap, stroke)
    return np.array([[groove.lap, 0.0], [stroke, groove.effective_area]])


def lap_of(table: np.ndarray) -> float:
    """Return the lift at which a table begins to open.

    Parameters
    ----------
    table : (j, 2) float array
        Lift [m] and effective area [m2], see `area_table`.

    Returns
    -------
    float
        Lap [m].

    Examples
    --------
    >>> lap_of(np.array([[1e-3, 0.0], [9e-3, 150e-6]]))
    0.001
    """
    opens = int(np.argmax(table[:, 1] > 0.0))
    return float(table[max(opens - 1, 0), 0])


@kernel
def piece_of(table: np.ndarray, lift: float) -> int:
    """Return the number of the piece of the table that a lift lies in.

    Parameters
    ----------
    table : (j, 2) float array
        Lift [m] and effective area [m2], see `area_table`.
    lift : float
        Lift [m].

    Returns
    -------
    int
        0 before the first knot, j after the last.

    Examples
    --------
    >>> table = np.array([[1e-3, 0.0], [9e-3, 150e-6]])
    >>> [piece_of(table, lift) for lift in (0.5e-3, 5e-3, 10e-3)]
    [0, 1, 2]
    """
    piece = 0
    while piece < table.shape[0] and lift > table[piece, 0]:
        piece += 1
    return piece


@kernel
def piece_line(table: np.ndarray, piece: int) -> tuple[float, float, float, float]:
    """Return the effective area on a piece of the table, as a line over lift.

    Parameters
    ----------
    table : (j, 2) float array
        Lift [m] and effective area [m2], see `area_table`.
    piece : int
        Number of the piece, see `piece_of`.

    Returns
    -------
    area : float
        Area of the line at lift 0 [m2].
    slope : float
        Slope of the line [m].
    low, high : float
        Ends of the piece [m]; infinite at the outer ones.

    Examples
    --------
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
