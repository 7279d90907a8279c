"""Operating points, run one by one: each is what it is alone, whatever is run beside it."""

from collections.abc import Sequence
from math import nan
from typing import Any

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.drivetrain.point import run_point
from apesim.engine.drivetrain.preparing import machines_of
from apesim.engine.indicators import INDICATORS
from apesim.engine.warnings import EngineWarning
from apesim.march.adaptive import Status
from apesim.studies.sweep.plan import CORRECTED, Point, rpm
from apesim.studies.timing import corrected

ANGLE_STEP = 0.5 * DEGREE
"""Crank angle between two rows of a trace [rad]."""
ROWS = round(TURN / ANGLE_STEP)
"""Number of rows of a trace without its last row, which is one turn after the first."""
LIFT, TORQUE = TRACE.index("lift [m]"), TRACE.index("torque [N m]")
"""Columns of a trace."""
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
    Indicators and trace are NaN where the point failed or its timing is out of reach. Of several cylinders the trace is
    that of the first, its torque that of all; what each does stands under ``cylinders``, and the lifts of the others
    under ``other_lifts``, without `traces` none.
    """
    results = [_result(point) for point in points]
    return results if traces else [(scalars | {"other_lifts": []}, None) for scalars, _ in results]


def _result(point: Point) -> tuple[dict[str, Any], np.ndarray | None]:
    """Scalars and trace of one operating point."""
    machine, speed, reason = point.machine, point.speed, NOT_ASKED
    scalars: dict[str, Any] = dict.fromkeys((*INDICATORS, "energise_deg", "release_deg"), nan)
    scalars |= dict.fromkeys(("warnings", *WARNING_FLAGS.values()), NOT_JUDGED) | {"cylinders": [], "other_lifts": []}
    scalars |= {"speed_rpm": rpm(speed), "status": NOT_MARCHED}
    if point.timing == CORRECTED:
        timing = corrected(machine, speed)
        machine, reason = timing.machine, int(timing.reason)
    trace = np.full((ROWS + 1, len(TRACE)), nan)
    if reason > 0:
        return scalars | {"timing_reason": reason}, trace
    done = run_point(machine, speed, ANGLE_STEP, point.trace_start)
    if done.run.status == Status.DONE:
        scalars |= dict(done.values) | {flag: int(warning in done.warnings) for warning, flag in WARNING_FLAGS.items()}
        scalars["warnings"] = len(done.warnings)
        scalars["cylinders"] = [
            {**own, "energise_deg": each.command.energise / DEGREE, "release_deg": each.command.release / DEGREE}
            for own, each in zip(done.cylinders, machines_of(machine), strict=True)
        ]
        trace, *others = done.traces
        if others:
            scalars["other_lifts"] = [each[:, LIFT] for each in others]
            trace = trace.copy()
            trace[:, TORQUE] = np.sum([each[:, TORQUE] for each in done.traces], axis=0)
    if machine.engine.intake == EPV:
        scalars |= {f"{name}_deg": getattr(machine.command, name) / DEGREE for name in ("energise", "release")}
    return scalars | {"status": done.run.status, "timing_reason": reason}, trace
