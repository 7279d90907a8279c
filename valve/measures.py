"""Delay time, full stroke time, seating speed and fluctuation of a stroke (Fig. 7); how far the piston travels."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from apesim.march.adaptive import LOG_HEAD, ZERO_CROSSING
from apesim.valve.motion import CORNER, LEFT, MET_CLOSED, MET_OPEN, NEAR_OPEN, ONE_PERCENT, SPEED_EXTREMUM, TURNED
from apesim.valve.piston import HELD_CLOSED, HELD_OPEN

NEVER = float("nan")


class Travel(IntEnum):
    """Which of its stops the piston meets in a run, or in a cycle that repeats."""

    COMPLETE = 0
    STAYS_CLOSED = 1
    OPENS_PARTLY = 2
    STAYS_OPEN = 3
    CLOSES_PARTLY = 4
    BETWEEN_STOPS = 5

    @property
    def opens_fully(self):
        """Whether the piston is on its open stop at any time."""
        return self in (Travel.COMPLETE, Travel.STAYS_OPEN, Travel.CLOSES_PARTLY)


class Stroke(NamedTuple):
    """Measures of an opening or a closing; NaN where the motion did not come to it.

    A stroke that starts from less than full lift has no delay time and no full stroke time, but a seating speed.
    """

    delay: float = NEVER
    """t_d: command edge to 1 % of the stroke [s]."""
    stroke_time: float = NEVER
    """t_f: from there to the first contact with the far stop [s]."""
    seating_speed: float = NEVER
    """v_e: speed just before that contact [m/s]."""
    fluctuation: float = NEVER
    """(peak speed - lowest later speed before contact)/peak."""
    reverses: bool = False
    """Whether the motion turns back before contact."""
    contact: float = NEVER
    """Time of the first contact [s]."""


def stroke_of(log, command, until, began, met):
    """Measures of the stroke that follows a command edge.

    Parameters
    ----------
    log : (l, 3 + n) float array
        Of a march, see `apesim.march.adaptive.march`; columns 3 and 4 are position and speed.
    command, until : float
        The edge, and where the search ends [s].
    began : tuple of int
        Code and sign of the zero crossing at 1 % of the stroke.
    met : int
        Event code of the far stop.

    Returns
    -------
    Stroke
    """
    time, code, sign, speed = log[:, 0], log[:, 1], log[:, 2], log[:, LOG_HEAD + 1]
    after = (time >= command) & (time <= until)
    starts = time[after & (code == began[0]) & (sign == began[1])]
    start = float(starts[0]) if len(starts) else NEVER
    contacts = np.flatnonzero(after & (code == met))
    if not len(contacts):
        return Stroke(delay=start - command)
    contact = float(time[contacts[0]])
    seating = float(speed[contacts[0]])
    towards = after & (time < contact) & (code == ZERO_CROSSING + SPEED_EXTREMUM) & (speed * seating > 0.0)
    speeds = np.append(np.abs(speed[towards]), abs(seating))
    peak = int(np.argmax(speeds))
    turned = bool(np.any((time > start) & (time < contact) & (code == TURNED)))
    lowest = 0.0 if turned else speeds[peak:].min()
    return Stroke(
        start - command,
        contact - start,
        abs(seating),
        float((speeds[peak] - lowest) / speeds[peak]),
        turned,
        contact,
    )


def opening_stroke(log, command, until):
    """Measures of an opening; see `stroke_of`."""
    return stroke_of(log, command, until, (ZERO_CROSSING + ONE_PERCENT, 1.0), MET_OPEN)


def closing_stroke(log, command, until):
    """Measures of a closing; see `stroke_of`."""
    return stroke_of(log, command, until, (ZERO_CROSSING + NEAR_OPEN, -1.0), MET_CLOSED)


def lap_times(log, stroke, lap):
    """When the lift first rises through the lap, and when it then falls through it.

    Parameters
    ----------
    log : (l, 3 + n) float array
        See `stroke_of`; of two periods where the motion repeats, so that an opening late in one has its closing.
    stroke, lap : float
        [m]

    Returns
    -------
    opened, shut : float
        [s]; NaN: never.
    """
    time, code, speed = log[:, 0], log[:, 1], log[:, LOG_HEAD + 1]
    lift = np.minimum(stroke - log[:, LOG_HEAD], stroke)
    at_lap = ((code == CORNER) | (code == MET_CLOSED)) & (np.abs(lift - lap) < 1e-6 * stroke)
    opened = time[at_lap & (speed < 0.0)]
    opened = float(opened[0]) if len(opened) else NEVER
    shut = time[at_lap & (speed > 0.0) & (time > opened)]
    return opened, float(shut[0]) if len(shut) else NEVER


def travel_of(log, phase, opening, closing):
    """Which of its stops a piston meets.

    Parameters
    ----------
    log : (l, 3 + n) float array
        Of the run, or of one cycle of a periodic state, see `apesim.march.adaptive.march`.
    phase : int
        Of the piston at its start, see `apesim.valve.piston`.
    opening, closing : Stroke

    Returns
    -------
    Travel
    """
    if not np.any(log[:, 1] == LEFT):
        if phase == HELD_CLOSED:
            return Travel.STAYS_CLOSED
        if phase == HELD_OPEN:
            return Travel.STAYS_OPEN
    opens, closes = not np.isnan(opening.contact), not np.isnan(closing.contact)
    if opens:
        return Travel.COMPLETE if closes else Travel.CLOSES_PARTLY
    return Travel.OPENS_PARTLY if closes else Travel.BETWEEN_STOPS
