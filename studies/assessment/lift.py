"""Lifts over crank angle that stand for a real one: at constant speed, as it is, and on time."""

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun
from apesim.march.adaptive import LOG_HEAD
from apesim.valve.groove import area_table, lap_of

LIFT = TRACE.index("lift [m]")
PEAK = 1e-6
"""Share by which lifts at the peak may differ: a contact is located within 1e-12 s."""


def constant_speed_lift(machine: Machine, run: SteadyRun, opens: float, closes: float) -> np.ndarray:
    """Make the trapezoid that crosses the lap, and reaches and leaves the peak lift, where the real lift does.

    It has columns crank angle [rad] and lift [m], (n, 2); `opens` and `closes` are the crank angles [rad] at which the
    real lift crosses the lap. It is a triangle where the real lift turns back before its open stop; below the lap,
    where the groove is shut, its sides go on to zero lift.
    """
    lap = lap_of(area_table(machine.groove, machine.valve.stroke))
    angle = run.cycle.start + run.cycle.speed * run.log[:, 0]
    angle, lift = np.concatenate((angle, angle + TURN)), np.tile(machine.valve.stroke - run.log[:, LOG_HEAD], 2)
    opened = (opens < angle) & (angle < closes)
    peak = lift[opened].max()
    reaches, *_, leaves = np.repeat(angle[opened & (lift >= peak * (1.0 - PEAK))], 2)
    share, gap = lap / (peak - lap), 0.5 * (TURN - (closes - opens))
    before, after = min(share * (reaches - opens), gap), min(share * (closes - leaves), gap)
    rows = np.array(
        [(opens - before, 0.0), (opens, lap), (reaches, peak), (leaves, peak), (closes, lap), (closes + after, 0.0)]
    )
    return rows[np.append(np.diff(rows[:, 0]) > 0.0, True)]


def lift_curve_of(machine: Machine, run: SteadyRun) -> np.ndarray:
    """Extract the real lift over a turn that begins where it is lowest, located events included.

    Columns are crank angle [rad] and lift [m], (n, 2); the lift of the first and the last row is taken as zero.
    """
    located = run.cycle.start + run.cycle.speed * run.log[:, 0]
    angles = np.concatenate((run.angles[:-1], located))
    lifts = np.concatenate((run.trace[:-1, LIFT], machine.valve.stroke - run.log[:, LOG_HEAD]))
    angles, first = np.unique((angles - run.cycle.start) % TURN, return_index=True)
    lifts = np.clip(lifts[first], 0.0, machine.valve.stroke)
    lowest = int(np.argmin(lifts))
    angles = np.concatenate((angles[lowest:], angles[: lowest + 1] + TURN)) + run.cycle.start
    lifts = np.concatenate((lifts[lowest:], lifts[: lowest + 1]))
    lifts[[0, -1]] = 0.0
    return np.column_stack((angles, lifts))


def single_opening(curve: np.ndarray, opens: float, closes: float) -> np.ndarray:
    """Cut a periodic lift to the turn that holds one opening, where it is lowest after the closing.

    Curves have columns crank angle [rad] and lift [m]; the lift crosses the lap at `opens` and `closes` [rad], which
    may be whole turns away from the curve. The opening stands at its own angle.
    """
    turns = np.floor((opens - curve[0, 0]) / TURN) + np.arange(-1.0, 3.0)
    angle = np.concatenate([curve[:-1, 0] + TURN * turn for turn in turns])
    lift = np.tile(curve[:-1, 1], len(turns))
    shut = np.flatnonzero((angle > closes) & (angle < opens + TURN))
    end = angle[shut[np.argmin(lift[shut])]]
    retained = (angle > end - TURN - 1e-9) & (angle < end + 1e-9)
    return np.column_stack((angle[retained], lift[retained]))


def shift_flanks(curve: np.ndarray, true: tuple[float, float], intended: tuple[float, float]) -> np.ndarray:
    """Move each flank of a lift so that it crosses the lap where intended.

    Curves have columns crank angle [rad] and lift [m]; `true` and `intended` are angles of opening and closing [rad];
    the result lies within a turn, zero at both ends. The opening flank reaches until the lift leaves its peak for the
    last time; between the flanks the lift stays at its peak, and where they meet before, the lower of the two counts,
    and the peak is not reached.

    >>> curve = np.array([[0.0, 0.0], [1.0, 9e-3], [3.0, 9e-3], [4.0, 0.0], [6.0, 0.0]])
    >>> earlier = shift_flanks(curve, true=(0.5, 3.5), intended=(0.25, 3.0))
    >>> earlier.round(4).tolist()
    [[-0.25, 0.0], [0.75, 0.009], [2.5, 0.009], [2.75, 0.0067], [3.5, 0.0]]
    """
    angle, lift = curve.T
    opened = (angle > true[0]) & (angle < true[1])
    last = np.flatnonzero(opened & (lift >= lift[opened].max() * (1.0 - PEAK)))[-1]
    opening = angle[: last + 1] + (intended[0] - true[0]), lift[: last + 1]
    closing = angle[last:] + (intended[1] - true[1]), lift[last:]
    angles = np.union1d(opening[0], closing[0])
    above = np.interp(angles, *opening) - np.interp(angles, *closing)
    meets = np.flatnonzero(above[:-1] * above[1:] < 0.0)
    share = above[meets] / (above[meets] - above[meets + 1])
    angles = np.union1d(angles, angles[meets] + share * (angles[meets + 1] - angles[meets]))
    gap = 0.5 * (TURN - (intended[1] - intended[0]))
    angles = angles[(angles >= intended[0] - gap) & (angles <= intended[1] + gap)]
    lifts = np.minimum(np.interp(angles, *opening), np.interp(angles, *closing))
    lifts[[0, -1]] = 0.0
    return np.column_stack((angles, lifts))
