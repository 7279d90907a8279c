"""An operating point in its periodic state: of one cylinder at constant speed, of several, or of a free shaft."""

from collections.abc import Mapping, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.drivetrain.indicators import OWN_INDICATORS, SHAFT_INDICATORS, shaft_indicators
from apesim.engine.drivetrain.steady import Revolution, cylinder_runs, run_revolution
from apesim.engine.indicators import INDICATORS, indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun, is_of_one_cylinder, run_steady
from apesim.engine.warnings import EngineWarning, judge_cylinders, judge_point
from apesim.march.adaptive import Status


class PointRun(NamedTuple):
    """Operating point that was marched to its periodic state."""

    run: SteadyRun | Revolution
    """Cycle of one cylinder at constant speed, or revolution of a shaft."""
    values: Mapping[str, Any]
    """Indicators by their names, those of a shaft with `SHAFT_INDICATORS`; NaN where the march ended early."""
    cylinders: Sequence[Mapping[str, float]]
    """`OWN_INDICATORS` of each cylinder; none where the march ended early."""
    runs: Sequence[SteadyRun]
    """Cycle of each cylinder; none where the march of a shaft ended early."""
    traces: Sequence[np.ndarray]
    """Trace of each of them over a turn, columns as in `apesim.engine.cycle.cylinder_laws.TRACE`, (t, 11)."""
    warnings: Mapping[EngineWarning, str]
    """What a user should know; nothing where the march ended early."""


def run_point(
    machine: Machine,
    speed: float,
    angle_step: float = 0.5 * DEGREE,
    trace_start: float | None = None,
    is_free: bool = False,
) -> PointRun:
    """March an operating point to its periodic state at a speed [rad/s], find its indicators and judge it.

    The rows of the traces are `angle_step` [rad] apart over a turn, from the energising on, or from `trace_start` [rad]
    on; of several cylinders over the angle of the shaft. `is_free`: the shaft is free, and begins at the speed.
    """
    if is_free or not is_of_one_cylinder(machine):
        return point_of(
            machine, run_revolution(machine, speed, is_free, angle_step=angle_step, trace_start=trace_start)
        )

    # A cycle begins at the energising: its rows are turned to begin at another angle.
    before = 0.0 if trace_start is None else machine.command.energise - trace_start
    rows, place = round(TURN / angle_step), int(np.ceil(before / angle_step - 1e-9))
    run = run_steady(machine, speed, angle_step=angle_step, trace_start=max(0.0, place * angle_step - before))
    point = point_of(machine, run)
    if run.status != Status.DONE or place % rows == 0:
        return point
    turned = np.roll(run.trace[:rows], place % rows, axis=0)
    return point._replace(traces=[np.concatenate((turned, turned[:1]))])


def point_of(machine: Machine, run: SteadyRun | Revolution) -> PointRun:
    """Find the indicators of an operating point that was marched, and judge it; its traces are those of the run."""
    done = run.status == Status.DONE
    if isinstance(run, SteadyRun):
        values = indicators(machine, run) if done else dict.fromkeys(INDICATORS, nan)
        own = [{name: values[name] for name in OWN_INDICATORS}] if done else []
        return PointRun(run, values, own, [run], [run.trace], judge_point(machine, run, values) if done else {})
    if not done:
        return PointRun(run, dict.fromkeys((*INDICATORS, *SHAFT_INDICATORS), nan), [], [], [], {})
    runs = cylinder_runs(run)
    totals, cylinders = shaft_indicators(run, runs)
    warnings = judge_cylinders(run.machines, runs, totals)
    return PointRun(run, totals, cylinders, runs, [each.trace for each in runs], warnings)
