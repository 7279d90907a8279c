"""What the text says of the piston's motion over pressure (Figs. 9 to 11), and what counts as that."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from apesim.studies.paper.claims.stroke import fluctuates_more, gets_slower, turns_back


class Statement(NamedTuple):
    """What the text says of the motion over pressure.

    The statements are those of the EPV paper (doi 10.1631/jzus.A0820373) on its Figs. 9 to 11.
    """

    key: str
    """Name in tables and in ``claims.json``."""
    name: str
    """Name in a few words, as a figure's title."""
    text: str
    """The paper's words."""
    criterion: str
    """What counts as that."""
    holds: Callable[[dict[str, np.ndarray]], np.ndarray]
    """Whether it holds, shape (m,) over temperature, by the opening strokes' measures: a dict of (n, m) arrays, over
    pressure and temperature."""


STATEMENTS = (
    Statement(
        "fluctuation",
        "rising fluctuation",
        "the piston velocity appears to fluctuate with the increase of air pressure (Fig. 9)",
        "the fluctuation rises at every step of pressure from its least on, to more than twice that at 0.1 MPa",
        lambda strokes: np.array([fluctuates_more(column) for column in strokes["fluctuation"].T]),
    ),
    Statement(
        "pressure_inversion",
        "pressure inversion",
        "until the air pressure behind the piston exceeds the pressure before the piston again (Fig. 9)",
        "at 1.9 MPa the pressure behind the piston falls below that ahead of it",
        lambda strokes: strokes["least_difference"][-1] < 0.0,
    ),
    Statement(
        "rebound",
        "rebound",
        "the piston would decrease and even rebound (Fig. 9)",
        "the piston turns back before contact at some pressure",
        lambda strokes: np.any(strokes["reverses"] > 0.0, axis=0),
    ),
    Statement(
        "stroke_time",
        "$t_f$ not monotonic",
        "This fluctuation also causes t_f and v_e not to increase with the increasing of p_in, but has the maps like "
        "Fig. 10 and Fig. 11",
        "the full stroke time neither only rises nor only falls with pressure",
        lambda strokes: turns_back(strokes["stroke_time"]),
    ),
    Statement(
        "seating_speed",
        "$v_e$ not monotonic",
        "the same sentence",
        "the seating speed neither only rises nor only falls with pressure",
        lambda strokes: turns_back(strokes["seating_speed"]),
    ),
    Statement(
        "response",
        "no faster response",
        "increasing pressure of compressed air solely would not make the EPV response faster (conclusion)",
        "at some step of pressure the time from command to contact does not fall",
        lambda strokes: gets_slower(strokes["delay"] + strokes["stroke_time"]),
    ),
)
