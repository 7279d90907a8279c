"""The groove in the piston, through which the engine breathes."""

from math import inf
from typing import Annotated, NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.quantities import NO_CURVE, Choice, Curve, Quantity
from apesim.valve.ports import Ports, ports_table

LINE, PORTS = 0, 1


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
    def has_ports(self):
        """Whether its area is that of the ports."""
        return self.geometry == PORTS and not len(self.area_curve)

    def faults(self):
        """Faults that no single key shows."""
        curve = self.area_curve
        if len(curve) and (curve[0, 0] < 0.0 or curve[0, 1] != 0.0 or curve[:, 1].min() < 0.0):
            yield "area_curve", "does not start closed", "area 0 in the first row (lift >= 0), nowhere below 0"

    def overruled(self):
        """Keys that are not looked at, and by what."""
        if len(self.area_curve):
            yield from ((key, "groove.area_curve is given") for key in ("effective_area", "lap", "geometry", "ports"))
        elif self.has_ports:
            yield "effective_area", 'groove.geometry is "ports"'
        else:
            yield "ports", 'groove.geometry is "line"'


def area_table(groove, stroke):
    """Effective area over lift, as knots.

    Parameters
    ----------
    groove : Groove
    stroke : float
        Full lift [m].

    Returns
    -------
    (j, 2) float array
        Lift [m] and effective area [m2]; linear in between (with ports: see `apesim.valve.ports.ports_table`), zero
        before the first knot, constant after the last.
    """
    if len(groove.area_curve):
        return np.ascontiguousarray(groove.area_curve)
    if groove.has_ports:
        return ports_table(groove.ports, groove.lap, stroke)
    return np.array([[groove.lap, 0.0], [stroke, groove.effective_area]])


def lap_of(table):
    """Lift at which a table begins to open [m]."""
    opens = int(np.argmax(table[:, 1] > 0.0))
    return float(table[max(opens - 1, 0), 0])


@kernel
def piece_of(table, lift):
    """Number of the piece of the table that a lift lies in, 0 (before the first knot) to j (after the last)."""
    piece = 0
    while piece < table.shape[0] and lift > table[piece, 0]:
        piece += 1
    return piece


@kernel
def piece_line(table, piece):
    """Effective area on a piece of the table, as a line over lift.

    Returns
    -------
    area, slope : float
        At lift 0 [m2], and per lift [m].
    low, high : float
        Ends of the piece [m]; infinite at the outer ones.
    """
    last = table.shape[0]
    if piece == 0:
        return 0.0, 0.0, -inf, table[0, 0]
    if piece == last:
        return table[last - 1, 1], 0.0, table[last - 1, 0], inf
    low, high = table[piece - 1, 0], table[piece, 0]
    slope = (table[piece, 1] - table[piece - 1, 1]) / (high - low)
    return table[piece - 1, 1] - slope * low, slope, low, high
