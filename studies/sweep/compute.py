"""Operating points, run one by one: each is what it is alone, whatever is run beside it."""

from math import nan

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.rates import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.indicators import INDICATORS, indicators
from apesim.engine.steady import run_steady
from apesim.engine.warnings import EngineWarning, judge_point
from apesim.march.adaptive import Status
from apesim.studies.sweep.plan import CORRECTED, rpm
from apesim.studies.timing import corrected

ANGLE_STEP = 0.5 * DEGREE
ROWS = round(TURN / ANGLE_STEP)
"""Rows of a trace, without the last, which is a turn after the first."""
NOT_MARCHED, NOT_ASKED = -1, -1
"""Status of a point that is out of reach; reason of one whose timing was not to be corrected."""
WARNING_FLAGS = {warning: f"warning_{warning.name.lower()}" for warning in EngineWarning}
"""Name of the flag of each warning, as in files."""
NOT_JUDGED = -1
"""Flag of a point that has no results."""


def compute(points):
    """Run operating points.

    Parameters
    ----------
    points : sequence of apesim.studies.sweep.plan.Point

    Returns
    -------
    list of tuple
        For each point its scalars by name and its trace, (721, 11).
    """
    return [_result(point) for point in points]


def _result(point):
    machine, speed, reason = point.machine, point.speed, NOT_ASKED
    scalars = dict.fromkeys((*INDICATORS, "energise_deg", "release_deg"), nan)
    scalars |= dict.fromkeys(("warnings", *WARNING_FLAGS.values()), NOT_JUDGED)
    scalars |= {"speed_rpm": rpm(speed), "status": NOT_MARCHED}
    if point.timing == CORRECTED:
        timing = corrected(machine, speed)
        machine, reason = timing.machine, int(timing.reason)
    trace = np.full((ROWS + 1, len(TRACE)), nan)
    if reason > 0:
        return scalars | {"timing_reason": reason}, trace
    place, trace_start = _rows_before(machine.command.energise - point.trace_start)
    run = run_steady(machine, speed, angle_step=ANGLE_STEP, trace_start=trace_start)
    if run.status == Status.DONE:
        values = indicators(machine, run)
        told = judge_point(machine, run, values)
        scalars |= values | {flag: int(warning in told) for warning, flag in WARNING_FLAGS.items()}
        scalars["warnings"] = len(told)
        trace = _from_first_angle(run.trace, place)
    if machine.engine.intake == EPV:
        scalars |= {f"{name}_deg": getattr(machine.command, name) / DEGREE for name in ("energise", "release")}
    return scalars | {"status": run.status, "timing_reason": reason}, trace


def _rows_before(angle):
    """For a cycle that starts an angle after the traces do: the row of its first sample, and where in it that is.

    Returns
    -------
    int
        Of a trace.
    float
        From the start of the cycle [rad].
    """
    place = int(np.ceil(angle / ANGLE_STEP - 1e-9))
    return place % ROWS, max(0.0, place * ANGLE_STEP - angle)


def _from_first_angle(trace, place):
    """A cycle's trace, its first row at `place`: what comes after the end of the traces is moved to their start."""
    if place == 0:
        return trace
    turned = np.roll(trace[:ROWS], place, axis=0)
    return np.concatenate((turned, turned[:1]))
