"""Operating points, run one by one: each is what it is alone, whatever is run beside it."""

from collections.abc import Sequence
from math import nan
from typing import Any

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.indicators import INDICATORS, indicators
from apesim.engine.steady import run_steady
from apesim.engine.warnings import EngineWarning, judge_point
from apesim.march.adaptive import Status
from apesim.studies.sweep.plan import CORRECTED, Point, rpm
from apesim.studies.timing import corrected

ANGLE_STEP = 0.5 * DEGREE
"""Crank angle between two rows of a trace [rad]."""
ROWS = round(TURN / ANGLE_STEP)
"""Number of rows of a trace without its last row, which is one turn after the first."""
NOT_MARCHED, NOT_ASKED = -1, -1
"""Code of the status of a point whose timing is out of reach; code of the reason where no timing was corrected."""
WARNING_FLAGS = {warning: f"warning_{warning.name.lower()}" for warning in EngineWarning}
"""Name of the flag of each warning, as in files."""
NOT_JUDGED = -1
"""Value of the flags of warnings, and of their number, for a point without results."""


def compute(points: Sequence[Point], traces: bool = True) -> list[tuple[dict[str, Any], np.ndarray | None]]:
    """Run operating points, one after the other, each to its periodic state; return their scalars and traces.

    A trace is (721, 11): a row every half degree of crank angle over one turn, columns as in
    `apesim.engine.cycle.cylinder_laws.TRACE`; without `traces`, nearly all of the memory of the results, it is None.
    Indicators and trace are NaN where the point failed or its timing is out of reach.
    """
    results = [_result(point) for point in points]
    return [(scalars, trace if traces else None) for scalars, trace in results]


def _result(point: Point) -> tuple[dict[str, Any], np.ndarray]:
    """Scalars and trace of one operating point."""
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
        warnings = judge_point(machine, run, values)
        scalars |= values | {flag: int(warning in warnings) for warning, flag in WARNING_FLAGS.items()}
        scalars["warnings"] = len(warnings)
        trace = _from_first_angle(run.trace, place)
    if machine.engine.intake == EPV:
        scalars |= {f"{name}_deg": getattr(machine.command, name) / DEGREE for name in ("energise", "release")}
    return scalars | {"status": run.status, "timing_reason": reason}, trace


def _rows_before(angle: float) -> tuple[int, float]:
    """Find the row of the traces at which the samples of a cycle begin, `angle` [rad] after the first row.

    Also return the crank angle of that sample from the start of the cycle [rad], in 0...`ANGLE_STEP`.
    """
    place = int(np.ceil(angle / ANGLE_STEP - 1e-9))
    return place % ROWS, max(0.0, place * ANGLE_STEP - angle)


def _from_first_angle(trace: np.ndarray, place: int) -> np.ndarray:
    """Turn the trace of a cycle so that its first row becomes row `place`; rows beyond the end move to the start."""
    if place == 0:
        return trace
    turned = np.roll(trace[:ROWS], place, axis=0)
    return np.concatenate((turned, turned[:1]))
