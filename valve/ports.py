"""Full geometry of the groove: an annular groove in the piston that passes over round ports in the cylinder's wall.

The geometry is chosen; its areas are those of segments of a circle.
"""

from math import atan2, inf, pi, sqrt
from typing import Annotated, NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.quantities import Quantity

HALVINGS = 200
"""Halvings of an interval at most; more than the digits of a float, so that the last interval is one float wide."""


class Ports(NamedTuple):
    """Round ports and what passes over them (groove.geometry = "ports"); lap is where the groove meets the ports."""

    number: Annotated[float, Quantity("", 1, 100, "chosen; of the ports round the piston", whole=True)] = 4.0
    diameter: Annotated[float, Quantity("mm", 0.1, 100, "chosen: open at full lift behind a lap of 1 mm")] = 8.0e-3
    groove_width: Annotated[
        float, Quantity("mm", 0.1, 200, "chosen; a narrower groove than port never opens it whole")
    ] = 8.0e-3
    passage_area: Annotated[
        float, Quantity("mm^2", 0.1, inf, 'chosen; narrowest section beside the ports, caps their area; "inf": no cap')
    ] = 200.0e-6
    discharge_coefficient: Annotated[
        float, Quantity("", 0.01, 1, "chosen: sharp-edged ports; effective area over it")
    ] = 0.75


@kernel
def segment_area(height: float, diameter: float) -> float:
    """Return the area of a circle's segment.

    ``2 r^2 atan2(sqrt(h), sqrt(d - h)) - (r - h) sqrt(h (d - h))``, with radius r, diameter d and height h: a circle's
    segment [1]_, its angle by the tangent of the quarter angle, which stays exact at both ends.

    Parameters
    ----------
    height : float
        Height of the segment, clipped to 0...diameter [m].
    diameter : float
        Diameter of the circle [m].

    Returns
    -------
    float
        Area [m2].

    References
    ----------
    .. [1] E. W. Weisstein, "Circular Segment", MathWorld, https://mathworld.wolfram.com/CircularSegment.html.

    Examples
    --------
    Half of a circle and the whole, pi/8 and pi/4:

    >>> round(segment_area(0.5, 1.0), 4), round(segment_area(1.0, 1.0), 4)
    (0.3927, 0.7854)
    """
    r = 0.5 * diameter
    h = min(max(height, 0.0), diameter)
    return 2.0 * r * r * atan2(sqrt(h), sqrt(diameter - h)) - (r - h) * sqrt(h * (diameter - h))


@kernel
def ports_area(ports: Ports, travel: float) -> float:
    """Return the effective area [m2] of the ports under the groove, without the cap of the passage.

    A port is open between the groove's two edges: ``C n (segment(travel) - segment(travel - width))``. `travel` is how
    far the groove's leading edge is beyond the ports' near side, lift less lap [m].

    Four ports of 8 mm, half covered, times 0.75: 0.75 * 4 * pi/8 * 64 mm2

    >>> round(ports_area(Ports(), 4e-3) * 1e6, 2)
    75.4
    """
    under = segment_area(travel, ports.diameter) - segment_area(travel - ports.groove_width, ports.diameter)
    return ports.discharge_coefficient * ports.number * under


def ports_table(ports: Ports, lap: float, stroke: float) -> np.ndarray:
    """Return the lifts at which the law of the ports' area changes, and the areas there: (j, 2) [m], [m2].

    The first row is at the lap. Where two rows have one area it is that in between; else it is that of `ports_area`.
    `lap` is the lift at which the groove meets the ports [m], `stroke` the full lift [m].
    """
    cap = ports.discharge_coefficient * ports.passage_area
    width, diameter = ports.groove_width, ports.diameter
    widest = 0.5 * (width + diameter)
    corners = {0.0, min(width, diameter), widest, max(width, diameter), width + diameter, stroke - lap}
    if ports_area(ports, widest) > cap:
        corners |= {_travel_at(ports, cap, 0.0, widest), _travel_at(ports, cap, width + diameter, widest)}
    travels = np.array(sorted(travel for travel in corners if 0.0 <= travel <= stroke - lap))
    lifts, first = np.unique(lap + travels, return_index=True)
    travels = travels[first]
    areas = np.array([min(ports_area(ports, travel), cap) for travel in travels])
    areas[np.isclose(areas, cap, rtol=1e-12, atol=0.0)] = cap
    whole = ports.discharge_coefficient * ports.number * 0.25 * pi * diameter**2
    areas[np.isclose(areas, whole, rtol=1e-12, atol=0.0)] = whole
    return np.column_stack((lifts, areas))


def _travel_at(ports: Ports, area: float, low: float, high: float) -> float:
    """Travel between low (area below) and high (above) at which the ports have an area [m]."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (low, middle) if ports_area(ports, middle) > area else (middle, high)
    return high
