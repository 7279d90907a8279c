"""Angles of the shaft at which something begins, ends or is passed, whichever way the crank turns.

The crank is in a sector, between one such angle and the next; sectors are numbered on from turn to turn, so that the
crank, with a little rounding, is never in two of them or in none. Angles in rad.
"""

from bisect import bisect_right
from typing import NamedTuple

from .crank import TURN, corners_of

APART = 1e-9
"""Angles nearer to one another than this are one [rad]."""


class Turn(NamedTuple):
    """One turn of the shaft."""

    angles: tuple
    """From 0 to 2 pi, ascending [rad]."""
    passed: tuple
    """Cylinders that pass their own 0 there, for each of the angles."""


def turn_of(engines, phases):
    """Angles of one turn, of all cylinders."""
    marked = []
    for number, (engine, phase) in enumerate(zip(engines, phases, strict=True)):
        own = [*corners_of(engine.exhaust), *intake_corners(engine)]
        marked += [(within(angle + phase), ()) for angle in own] + [(within(phase), (number,))]
    angles, passed = [], []
    for angle, cylinders in sorted(marked):
        if angles and angle - angles[-1] < APART:
            passed[-1] += cylinders
        else:
            angles.append(angle)
            passed.append(cylinders)
    return Turn(tuple(angles), tuple(passed))


def within(angle):
    """Angle within one turn, from 0 on; 0 where only rounding parts it from 2 pi."""
    angle %= TURN
    return 0.0 if TURN - angle < APART else angle


def intake_corners(engine):
    """Own angles at which a cylinder's intake is switched or not smooth."""
    if engine.intake == "cam":
        return corners_of(engine.cam, [lift / engine.cam_lift for lift in (engine.lap, engine.valve.stroke)])
    if engine.intake == "ideal":
        return [engine.open_target, engine.close_target]
    return [engine.energise, engine.release]


def begins(turn, sector):
    """Angle at which a sector begins."""
    turns, number = divmod(sector, len(turn.angles))
    return turn.angles[number] + turns * TURN


def middle(turn, sector):
    """Angle in the middle of a sector."""
    return 0.5 * (begins(turn, sector) + begins(turn, sector + 1))


def sector_of(turn, angle):
    """Number of the sector in which an angle lies, and the angle, which is brought onto a corner that is at hand."""
    turns = angle // TURN
    sector = int(turns) * len(turn.angles) + bisect_right(turn.angles, angle - turns * TURN) - 1
    for near in (sector, sector + 1):
        if abs(begins(turn, near) - angle) < APART:
            return near, begins(turn, near)
    return sector, angle


def passed_at(turn, sector):
    """Cylinders that pass their own 0 where a sector begins."""
    return turn.passed[sector % len(turn.angles)]


def is_energised(engine, own_angle):
    """Whether a cylinder's command is on at its own angle."""
    return (own_angle - engine.energise) % TURN < (engine.release - engine.energise) % TURN
