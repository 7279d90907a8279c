"""Lifts over crank angle that stand for a real one: at constant speed, and as it is."""

import numpy as np

from apesim.march import LOG_HEAD
from engine.breathing import TURN
from engine.cycle import TRACE
from valve.groove import area_table, lap_of

LIFT = TRACE.index("lift [m]")
PEAK = 1e-6
"""Share by which lifts at the peak may differ: a contact is located within 1e-12 s."""


def constant_speed_lift(machine, run, opens, closes):
    """Trapezoid that crosses the lap, and reaches and leaves the peak lift, where the real lift does.

    A triangle where the real lift turns back before its open stop. Below the lap, where the groove is shut, its sides
    go on to zero lift.

    Parameters
    ----------
    machine : engine.machine.Machine
    run : engine.steady.SteadyRun
        Periodic.
    opens, closes : float
        Angles at which the real lift crosses the lap [rad].

    Returns
    -------
    (n, 2) float array
        Crank angle [rad] and lift [m].
    """
    lap = lap_of(area_table(machine.groove, machine.valve.stroke))
    angle = run.p.start + run.p.speed * run.log[:, 0]
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


def lift_curve_of(machine, run):
    """The real lift over a turn that begins where it is lowest, located events included.

    Parameters
    ----------
    machine : engine.machine.Machine
    run : engine.steady.SteadyRun
        Periodic.

    Returns
    -------
    (n, 2) float array
        Crank angle [rad] and lift [m]; that of the first and the last row is taken as zero.
    """
    located = run.p.start + run.p.speed * run.log[:, 0]
    angles = np.concatenate((run.angles[:-1], located))
    lifts = np.concatenate((run.trace[:-1, LIFT], machine.valve.stroke - run.log[:, LOG_HEAD]))
    angles, first = np.unique((angles - run.p.start) % TURN, return_index=True)
    lifts = np.clip(lifts[first], 0.0, machine.valve.stroke)
    lowest = int(np.argmin(lifts))
    angles = np.concatenate((angles[lowest:], angles[: lowest + 1] + TURN)) + run.p.start
    lifts = np.concatenate((lifts[lowest:], lifts[: lowest + 1]))
    lifts[[0, -1]] = 0.0
    return np.column_stack((angles, lifts))
