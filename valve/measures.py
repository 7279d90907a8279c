"""Measures of a stroke: delay time, full stroke time, seating speed and fluctuation; how far the piston travels.

The first three are those of the EPV paper (doi 10.1631/jzus.A0820373), Fig. 7.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from apesim.march.adaptive import ZERO_CROSSING
from apesim.valve.ledger import logged_motion
from apesim.valve.motion import CORNER, LEFT, MET_CLOSED, MET_OPEN, NEAR_OPEN, ONE_PERCENT, SPEED_EXTREMUM, TURNED
from apesim.valve.piston import HELD_CLOSED, HELD_OPEN

NEVER = float("nan")
"""Measure of a motion that did not come to it."""


class Travel(IntEnum):
    """Which of its stops the piston meets in a run, or in a cycle that repeats."""

    COMPLETE = 0
    STAYS_CLOSED = 1
    OPENS_PARTLY = 2
    STAYS_OPEN = 3
    CLOSES_PARTLY = 4
    BETWEEN_STOPS = 5

    @property
    def opens_fully(self) -> bool:
        """Whether the piston is on its open stop at any time."""
        return self in (Travel.COMPLETE, Travel.STAYS_OPEN, Travel.CLOSES_PARTLY)


class Stroke(NamedTuple):
    """Measures of an opening or a closing; NaN where the motion did not come to it.

    A stroke that starts from less than full lift has no delay time and no full stroke time, but a seating speed.

    Delay time, full stroke time and seating speed are those of Fig. 7 of the EPV paper (doi 10.1631/jzus.A0820373); the
    fluctuation puts its Fig. 9 into a number, and is ours.
    """

    delay: float = NEVER
    """Delay time t_d, from the command edge to 1 % of the stroke [s]."""
    stroke_time: float = NEVER
    """Full stroke time t_f, from 1 % of the stroke to the first contact with the far stop [s]."""
    seating_speed: float = NEVER
    """Seating speed v_e, just before the first contact [m/s]."""
    fluctuation: float = NEVER
    """Peak speed less the lowest later speed before contact, over the peak speed."""
    reverses: bool = False
    """Whether the motion turns back before contact."""
    contact: float = NEVER
    """Time of the first contact with the far stop [s]."""


def stroke_of(log: np.ndarray, command: float, until: float, began: tuple[int | float, float], met: int) -> Stroke:
    """Measure the stroke that follows a command edge.

    Delay time, full stroke time and seating speed are those of Fig. 7 of the EPV paper [1]_, with the start of a motion
    at `apesim.valve.motion.DETECTED`.

    Parameters
    ----------
    log : (l, 3 + n) float array
        Log of a march, see `apesim.march.adaptive.march`; columns 3 and 4 are position [m] and speed [m/s].
    command, until : float
        Command edge, and where the search ends [s].
    began : tuple of int
        Code and sign of the zero crossing at 1 % of the stroke.
    met : int
        Event code of the far stop.

    Returns
    -------
    Stroke
        Measures; NaN where the motion did not come to it.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Fig. 7.

    Examples
    --------
    The lift passes 1 % at 5 ms, and the piston meets the open stop at 11 ms:

    >>> log = np.array([[5e-3, ZERO_CROSSING + ONE_PERCENT, 1.0, 8.91e-3, -0.1], [11e-3, MET_OPEN, 0.0, 0.0, -2.0]])
    >>> stroke = stroke_of(log, 0.0, 1.0, (ZERO_CROSSING + ONE_PERCENT, 1.0), MET_OPEN)
    >>> round(stroke.delay * 1e3, 6), round(stroke.stroke_time * 1e3, 6), stroke.seating_speed
    (5.0, 6.0, 2.0)
    """
    (time, code, sign), (_, speed) = log[:, :3].T, logged_motion(log)
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


def opening_stroke(log: np.ndarray, command: float, until: float) -> Stroke:
    """Measure an opening.

    The measures are those of Fig. 7 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    log : (l, 3 + n) float array
        Log of a march, see `stroke_of`.
    command, until : float
        Edge that energises, and where the search ends [s].

    Returns
    -------
    Stroke
        Measures; NaN where the motion did not come to it.

    Examples
    --------
    >>> log = np.array([[5e-3, ZERO_CROSSING + ONE_PERCENT, 1.0, 8.91e-3, -0.1], [11e-3, MET_OPEN, 0.0, 0.0, -2.0]])
    >>> round(opening_stroke(log, 1e-3, 1.0).delay * 1e3, 6)
    4.0
    """
    return stroke_of(log, command, until, (ZERO_CROSSING + ONE_PERCENT, 1.0), MET_OPEN)


def closing_stroke(log: np.ndarray, command: float, until: float) -> Stroke:
    """Measure a closing.

    The measures are those of Fig. 7 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    log : (l, 3 + n) float array
        Log of a march, see `stroke_of`.
    command, until : float
        Edge that releases, and where the search ends [s].

    Returns
    -------
    Stroke
        Measures; NaN where the motion did not come to it.

    Examples
    --------
    >>> log = np.array([[5e-3, ZERO_CROSSING + NEAR_OPEN, -1.0, 0.09e-3, 0.1], [11e-3, MET_CLOSED, 0.0, 9e-3, 2.5]])
    >>> closing_stroke(log, 1e-3, 1.0).seating_speed
    2.5
    """
    return stroke_of(log, command, until, (ZERO_CROSSING + NEAR_OPEN, -1.0), MET_CLOSED)


def lap_times(log: np.ndarray, stroke: float, lap: float) -> tuple[float, float]:
    """Return the times [s] at which the lift first rises through the lap, and then falls through it; NaN: never.

    `log` (l, 3 + n) is that of a march, see `stroke_of`; of two periods where the motion repeats, so that an opening
    late in one has its closing. `stroke` and `lap` in [m].

    With 9 mm of stroke and a lap of 1 mm the piston passes the lap at L = 8 mm:

    >>> log = np.array([[5e-3, CORNER, 0.0, 8e-3, -1.0], [30e-3, CORNER, 0.0, 8e-3, 1.5]])
    >>> lap_times(log, 9e-3, 1e-3)
    (0.005, 0.03)
    """
    time, code, (position, speed) = log[:, 0], log[:, 1], logged_motion(log)
    lift = np.minimum(stroke - position, stroke)
    at_lap = ((code == CORNER) | (code == MET_CLOSED)) & (np.abs(lift - lap) < 1e-6 * stroke)
    opened = time[at_lap & (speed < 0.0)]
    opened = float(opened[0]) if len(opened) else NEVER
    shut = time[at_lap & (speed > 0.0) & (time > opened)]
    return opened, float(shut[0]) if len(shut) else NEVER


def travel_of(log: np.ndarray, phase: float, opening: Stroke, closing: Stroke) -> Travel:
    """Return which of its stops a piston meets, by the log (l, 3 + n) of a run or of one cycle of a periodic state.

    `phase` is that of the piston at the start, see `apesim.valve.piston`.

    >>> travel_of(np.empty((0, 5)), HELD_CLOSED, Stroke(), Stroke()).name
    'STAYS_CLOSED'
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
