"""Corners of a cylinder: own angles at which something switches, passed either way, and the edges of its command.

Between two corners the cylinder is in an interval of its own angle; leaving it at either end is an event. So is leaving
the interval in which its solenoids are energised, or that in which they are not.
"""

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.cam import within_turn
from apesim.engine.cycle.state import CycleTables
from apesim.engine.drivetrain.state import (
    COMMAND_HIGH,
    COMMAND_LOW,
    COMMANDED,
    CORNER,
    CORNER_HIGH,
    CORNER_LOW,
    EDGE_COUNT,
    EDGE_NUMBER,
    ENERGISE,
    FIRST_EDGE,
    MARGIN,
    NEXT_TIME,
    RELEASE,
    Drivetrain,
)
from apesim.kernel import kernel
from apesim.valve.edges import EDGES, len_of_ramps


@kernel
def find_corner(corners: np.ndarray, angle: float, mode: np.ndarray) -> None:
    """Write the interval between corners (c,) [rad] in which an own angle [rad] lies into `mode` (OWN_MODES,)."""
    since = within_turn(angle)
    i = corners.shape[0] - 1
    while corners[i] > since:
        i -= 1
    mode[CORNER] = i
    _write_interval(corners, angle - since, mode)


@kernel
def _write_interval(corners: np.ndarray, turn: float, mode: np.ndarray) -> None:
    """Write the ends of the interval behind the corner passed last, in the turn that begins at an angle [rad]."""
    i = int(mode[CORNER])
    last = corners.shape[0] - 1
    mode[CORNER_LOW] = turn + corners[i]
    mode[CORNER_HIGH] = turn + (corners[i + 1] if i < last else corners[0] + TURN)


@kernel
def pass_corner(corners: np.ndarray, is_forward: bool, mode: np.ndarray) -> int:
    """Go over to the interval behind the corner that is passed, in `mode` (OWN_MODES,); return the corner's number."""
    i, last = int(mode[CORNER]), corners.shape[0] - 1
    turn = mode[CORNER_LOW] - corners[i]
    if is_forward:
        passed = i + 1 if i < last else 0
        mode[CORNER] = passed
        _write_interval(corners, turn if i < last else turn + TURN, mode)
        return passed
    mode[CORNER] = i - 1 if i > 0 else last
    _write_interval(corners, turn if i > 0 else turn - TURN, mode)
    return i


@kernel
def leaves(angle: float, low: float, high: float) -> float:
    """Return how far an angle has left an interval, beyond a margin [rad]; above zero it has."""
    return max(angle - high, low - angle) - MARGIN


@kernel
def find_command(angle: float, mode: np.ndarray) -> bool:
    """Find whether the solenoids are to be energised at an own angle [rad], and the interval in which that stays so.

    The interval is written into `mode` (OWN_MODES,), whose command angles hold.
    """
    duration = within_turn(mode[RELEASE] - mode[ENERGISE])
    since = within_turn(angle - mode[ENERGISE])
    is_on = since < duration
    low = angle - since if is_on else angle - since + duration
    mode[COMMAND_LOW], mode[COMMAND_HIGH] = low, low + (duration if is_on else TURN - duration)
    return is_on


@kernel
def pass_command(is_forward: bool, mode: np.ndarray) -> None:
    """Go over to the interval of the command behind the end that is passed, in `mode` (OWN_MODES,)."""
    duration = TURN - (mode[COMMAND_HIGH] - mode[COMMAND_LOW])
    if is_forward:
        low = mode[COMMAND_HIGH]
        mode[COMMAND_LOW], mode[COMMAND_HIGH] = low, low + duration
    else:
        high = mode[COMMAND_LOW]
        mode[COMMAND_LOW], mode[COMMAND_HIGH] = high - duration, high


@kernel
def shift_turn(turn: float, mode: np.ndarray) -> None:
    """Move the intervals by a turn [rad], as the shaft's angle begins anew; changes `mode` (OWN_MODES,)."""
    mode[CORNER_LOW] += turn
    mode[CORNER_HIGH] += turn
    mode[COMMAND_LOW] += turn
    mode[COMMAND_HIGH] += turn


@kernel
def issue_edge(p: Drivetrain, tables: CycleTables, i: int, t: float, mode: np.ndarray) -> None:
    """Issue an edge of the command of cylinder `i` at a time [s]: remember it in `mode` (OWN_MODES,).

    Edges energise and release in turn. A pair whose ramps have ended is forgotten.
    """
    last = len_of_ramps(tables.valve)
    count = int(mode[EDGE_COUNT])
    is_full = count >= EDGES - 1
    while count >= 2 and (mode[FIRST_EDGE + 1] + last < t or is_full):
        for j in range(count - 2):
            mode[FIRST_EDGE + j] = mode[FIRST_EDGE + j + 2]
        count -= 2
        is_full = False
    deviation = 0.0
    if p.deviations.shape[1] > 0:
        deviation = p.deviations[i, int(mode[EDGE_NUMBER]) % p.deviations.shape[1]]
    mode[FIRST_EDGE + count] = t + deviation
    mode[EDGE_COUNT] = count + 1
    mode[EDGE_NUMBER] += 1.0
    mode[COMMANDED] = 1.0 - mode[COMMANDED]
    mode[NEXT_TIME] = -np.inf  # to be found anew
