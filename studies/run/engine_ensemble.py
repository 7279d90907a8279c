"""Operating points of many machines at once, as arrays."""

import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from os import cpu_count
from typing import Any, ClassVar

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.indicators import COUNTS, FLAGS, INDICATORS
from apesim.engine.machine import Machine
from apesim.quantities import Arguments, Fault, InputError
from apesim.quantities.arguments import WithUnit
from apesim.results import Result, Trace, name_of, scalars_of
from apesim.studies.execution.calls import arguments_of, public
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.run.compiling import compile_point
from apesim.studies.run.engine_run import compute_point
from apesim.studies.run.operating_conditions import JOBS, SPEED

NUMBERS = {
    "runs": ("1", "machines that were run"),
    "converged_runs": ("1", "machines that came to a periodic state"),
    "wall_time_s": ("s", "computing time of the call"),
}
"""Numbers of an ensemble: unit and what they are."""
Computed = tuple[dict[str, Any], list[str]]
"""Indicators of an operating point, and what a user should know of it."""


@dataclass(frozen=True, eq=False, repr=False)
class Ensemble(Result):
    """Operating points of many machines: each number of an engine run is an array with its unit, in ``traces``.

    ``traces["converged"]`` tells which machines came to a periodic state. The numbers of one that did not are those of
    its last cycle, and NaN where its march ended early.

    Attributes
    ----------
    run_warnings : tuple of tuple of str
        Warnings of each machine, in their order; `warnings` has all of them, each with the index of its machine.
    """

    title: ClassVar[str] = "operating points of many machines"
    headline: ClassVar[tuple[str, ...]] = ("runs", "converged_runs", "wall_time")

    run_warnings: tuple[tuple[str, ...], ...] = field(default=(), kw_only=True)


@public
def run_many(
    machines: Iterable[Machine],
    speed: WithUnit | Iterable[WithUnit],
    *,
    jobs: int | None = 1,
    progress: Progress = False,
) -> Ensemble:
    """March an operating point of each of many machines to its periodic state, all in one call.

    Each number is what `apesim.run_engine` gives for that machine alone, to the bit. No trace over the crank angle is
    kept, and no text of a machine is written, so that the call costs little more than the marches.

    Parameters
    ----------
    machines : iterable of Machine
        Machines to run, which differ in any keys.
    speed : str, (array, str) or sequence of them
        Speed of the crankshaft with its unit: one for all machines, "1000 rpm", or one for each of them, in their
        order, e.g. ``(array, "rpm")``.
    jobs : int or None
        Threads; None: as many as there are processors. The same bits come out of any number.
    progress : bool or function
        True: a bar on standard error; a function is called with the numbers of points done and in all.

    Returns
    -------
    Ensemble
        Numbers of each machine, as arrays.

    Raises
    ------
    InputError
        A machine, a speed or another argument is out of range, or there are not as many speeds as machines.

    Examples
    --------
    >>> import apesim
    >>> machines = [apesim.Machine().with_(engine_bore=(bore, "mm")) for bore in (80, 85)]
    >>> many = apesim.run_many(machines, speed="1000 rpm")
    >>> many.traces["brake_torque"]
    <Trace [N m] over 2 run, 29.32 to 29.378>
    >>> many.traces["converged"].values.tolist(), many["converged_runs"]
    ([True, True], 2)
    """
    machines = list(machines)
    arguments = Arguments("run_many")
    machines = _checked(arguments, machines)
    speeds = arguments.range("speed", speed, SPEED)
    if speeds and machines and len(speeds) not in (1, len(machines)):
        wrong = f"has {len(speeds)} values for {len(machines)} machines"
        arguments.fault("speed", wrong, "give one for all machines, or one for each of them")
    count = arguments.quantity("jobs", jobs, JOBS)
    arguments.refuse()
    for machine in machines:
        compile_point(machine)
    start = time.perf_counter()
    with show_progress(progress, "run many") as report:
        points = list(zip(machines, speeds * (len(machines) // len(speeds)), strict=True))
        computed = _compute_all(points, int(count or cpu_count() or 1), report)
    return _ensemble(speeds, computed, time.perf_counter() - start)


def _checked(arguments: Arguments, machines: Sequence[Machine]) -> list[Machine]:
    """Machines as kernels need them; the faults of each are noted, with its index before the key."""
    if not machines:
        arguments.fault("machines", "holds no machine", "give at least one Machine")
    checked = []
    for number, machine in enumerate(machines):
        try:
            checked.append(arguments_of("run_many", machine)[1])
        except InputError as error:
            for fault in error.faults:
                key = f"machines[{number}].{fault.key}"
                arguments.faults.append(Fault(fault.file, key, fault.wrong, fault.right))
    return checked


def _compute_all(
    points: Sequence[tuple[Machine, float]], jobs: int, report: Callable[[int, int], object]
) -> list[Computed]:
    """Indicators and warnings of each point, computed in threads: the marches leave the interpreter to others."""
    computed: list[Computed | None] = [None] * len(points)
    left, telling, done = iter(range(len(points))), threading.Lock(), 0

    def work() -> None:
        nonlocal done
        for number in left:  # which the threads share: each takes the next point
            values, warnings = compute_point(*points[number])
            computed[number] = values, warnings
            with telling:
                done += 1
                report(done, len(points))

    running = [call_in_thread(work) for _ in range(min(jobs, len(points)))]
    try:
        for each in running:
            each.result()
    finally:
        for _ in left:  # what is left after an interrupt or an error is not begun
            pass
    return [each for each in computed if each is not None]


def _ensemble(speeds: Sequence[float], computed: Sequence[Computed], wall_time: float) -> Ensemble:
    """Result of all points, a trace for each indicator."""
    traces = {"run": Trace(("run",), np.arange(len(computed)), "1", "index of the machine")}
    for key, (unit, long_name) in INDICATORS.items():
        values = np.array([values[key] for values, _ in computed], dtype=float)
        if key in FLAGS:
            values = values == 1.0
        elif key in COUNTS:
            values = np.nan_to_num(values).astype(int)
        traces[name_of(key, unit)] = Trace(("run",), values, unit, long_name)
    converged = traces["converged"].values
    numbers = {"runs": len(computed), "converged_runs": int(converged.sum()), "wall_time_s": wall_time}
    ends = dict.fromkeys(f"{speed / TURN * 60.0:.6g}" for speed in (min(speeds), max(speeds)))
    run_warnings = tuple(tuple(warnings) for _, warnings in computed)
    return Ensemble(
        scalars_of(numbers, NUMBERS),
        traces,
        {"speed": f"{' to '.join(ends)} r/min"},
        [f"run {number}: {text}" for number, texts in enumerate(run_warnings) for text in texts],
        converged=bool(converged.all()),
        run_warnings=run_warnings,
    )
