"""The highest speed at which the valve opens and closes the engine's intake at its targets, with complete strokes."""

from collections.abc import Callable, Sequence
from enum import IntEnum
from itertools import product
from math import isnan, nan
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import column, run_axis
from apesim.engine.angles import DEGREE, RPM, TURN
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.march.periodic import PERIODIC_TOLERANCE
from apesim.quantities.settings import dumps
from apesim.studies.archives.pressure_axes import PRESSURE_AXES
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.limit.design_rule import WITHIN, rule_columns
from apesim.studies.limit.points import Point, point_column, with_own
from apesim.studies.run.operating_conditions import Supplies
from apesim.studies.timing.solve import SKETCH, Reason, Timing, corrected, start_after

CRITERION = (
    "command angles exist with which the valve opens and closes within 0.5 deg of its targets, the piston meets the "
    "open stop and the closed stop in every cycle, and every cycle repeats the one before"
)
LOWEST, HIGHEST, RESOLUTION, SKETCH_RESOLUTION = 300.0 * RPM, 12000.0 * RPM, 1.0 * RPM, 8.0 * RPM
"""Speeds between which the limit is looked for, and how closely [rad/s]."""
STEP_UP = 1.25
"""Ratio of a speed of the scan to the one before."""
BEYOND = 2.0
"""How many times as fast as the first speed that fails the scan looks for speeds that do not."""
SECONDS_A_LIMIT = 1.0
"""Estimated computing time of a limit [s]."""


class Failure(IntEnum):
    """Part of the criterion that is not met, or `NONE`."""

    NONE = 0
    TIMING = 1
    FULL_LIFT = 2
    FULL_CLOSURE = 3
    REPETITION = 4

    @property
    def remedy(self) -> str:
        """What fails, and what to change, in words."""
        return REMEDIES[self]


REMEDIES = {
    Failure.NONE: "nothing fails",
    Failure.TIMING: "no commands open and close the valve at its targets; part the targets or raise the pressure",
    Failure.FULL_LIFT: "the valve must turn back before it meets its open stop; part the targets or raise the pressure",
    Failure.FULL_CLOSURE: "the valve must open again before it meets its closed stop; bring the targets together",
    Failure.REPETITION: "the cycles do not repeat one by one; lower the pressure or damp the valve",
}
FAILURES = ", ".join(f"{int(failure)} {failure.name.lower().replace('_', ' ')}" for failure in Failure)


class EngineLimit(NamedTuple):
    """Limit of an engine's intake: the highest speed at which the intended timing is met."""

    limit: float
    """Highest speed that meets the criterion, from the lowest upwards [rad/s]; NaN: the lowest does not."""
    fails: Failure
    """What fails first above the limit; NONE: nothing up to the highest speed."""
    works_again: float
    """A speed above the limit that meets the criterion again [rad/s]; NaN: none was met in the scan."""
    timing: Timing | None
    """Commands at the limit; None where there is no limit."""
    marches: int
    """Number of periodic states that were computed."""


def failure_of(timing: Timing) -> Failure:
    """Judge which part of the criterion a timing, corrected commands or the reason why there are none, does not meet.

    REPETITION where the cycles do not repeat; else the first of TIMING, FULL_LIFT and FULL_CLOSURE that is not met;
    NONE where all are.
    """
    if timing.reason == Reason.NOT_PERIODIC:
        return Failure.REPETITION
    if not timing.reachable:
        return Failure.TIMING
    if isnan(timing.angles["full_open_deg"]):
        return Failure.FULL_LIFT
    return Failure.FULL_CLOSURE if isnan(timing.angles["closed_deg"]) else Failure.NONE


def _with_targets_apart(machine: Machine, angle: float) -> Machine:
    """Move the targets of a machine apart.

    The opening comes earlier and the closing later by the angle [rad]; a negative one brings them together.
    """
    command = machine.command
    moved = command._replace(open_target=command.open_target - angle, close_target=command.close_target + angle)
    return machine._replace(command=moved)


def judged(
    machine: Machine,
    speed: float,
    before: Sequence[tuple[float, Timing]] = (),
    periodic_tolerance: float = PERIODIC_TOLERANCE,
) -> tuple[Failure, Timing, int]:
    """Judge whether any commands meet the criterion at a speed [rad/s].

    Where the targets themselves cannot be met, angles at the ends of the tolerance may be: the valve is open for the
    longest time, which full lift needs, if it opens 0.5 deg early and closes 0.5 deg late; full closure needs the
    reverse. Returned are NONE and the timing that meets the criterion, else what fails at the targets themselves and
    the timing for these; and the number of periodic states that were computed. `machine` has an electro-pneumatic
    intake and its targets, `before` holds other speeds [rad/s] with their timings, see
    `apesim.studies.timing.solve.start_after`, and `periodic_tolerance` is the change over a cycle that counts as
    periodic.
    """
    timing = corrected(machine, speed, start_after(machine, speed, before), periodic_tolerance)
    failure, marches = failure_of(timing), timing.marches
    others = {
        Failure.TIMING: (WITHIN, -WITHIN),
        Failure.FULL_LIFT: (WITHIN,),
        Failure.FULL_CLOSURE: (-WITHIN,),
    }.get(failure, ())
    for angle in others:
        other = _with_targets_apart(machine, angle)
        start = start_after(other, speed, [(speed, timing)] if timing.reachable else before)
        nearby = corrected(other, speed, start, periodic_tolerance)
        marches += nearby.marches
        if failure_of(nearby) == Failure.NONE:
            return Failure.NONE, nearby, marches
    return failure, timing, marches


class _Judge:
    """Judge of speeds: it keeps its judgement on each, by sketches of periodic states or by full ones.

    `machine` has an electro-pneumatic intake and its targets, `before` holds speeds [rad/s] with their timings to start
    from, see `apesim.studies.timing.solve.start_after`, and `periodic_tolerance` is the change over a cycle that counts
    as periodic.
    """

    def __init__(
        self, machine: Machine, periodic_tolerance: float, before: Sequence[tuple[float, Timing]] = ()
    ) -> None:
        self.machine, self.periodic_tolerance, self.before = machine, periodic_tolerance, list(before)
        self.judgements: dict[float, tuple[Failure, Timing]] = {}
        self.marches = 0

    def failure(self, speed: float) -> Failure:
        """Judge which part of the criterion a speed [rad/s] does not meet, see `judged`; each is computed once."""
        if speed not in self.judgements:
            failure, timing, marches = judged(self.machine, speed, self.before, self.periodic_tolerance)
            self.judgements[speed] = failure, timing._replace(run=None)
            self.marches += marches
            if timing.reachable:
                self.before.append((speed, timing))
        return self.judgements[speed][0]


def engine_limit(machine: Machine, resolution: float = RESOLUTION) -> EngineLimit:
    """Find the highest speed that meets the criterion: scan upwards in steps of a quarter, then bisect.

    Sketches of the periodic state lead near the limit, full periodic states decide; where these contradict the
    sketches, the scan is repeated with full ones. `machine` has an electro-pneumatic intake and its targets; the limit
    is bisected (Press et al. 2007, "Numerical Recipes", 3rd ed., section 9.1) until a speed that fails is at most
    `resolution` [rad/s] away.
    """
    sketch = _Judge(machine, SKETCH)
    good, bad, again = _scanned(sketch)
    good, bad = _bisected(sketch, good, bad, SKETCH_RESOLUTION)
    full = _Judge(machine, PERIODIC_TOLERANCE, sketch.before)
    expected = [(speed, speed != bad) for speed in (good, bad, again) if not isnan(speed)]
    if any((full.failure(speed) == Failure.NONE) != meets for speed, meets in expected):
        good, bad, again = _scanned(full)
    good, bad = _bisected(full, good, bad, resolution)
    fails = Failure.NONE if isnan(bad) else full.failure(bad)
    timing = None if isnan(good) else full.judgements[good][1]
    return EngineLimit(good, fails, again, timing, sketch.marches + full.marches)


def _scanned(judge: _Judge) -> tuple[float, float, float]:
    """The last speed before the first that fails, that one, and one above it that does not; NaN where there is none."""
    good = bad = nan
    for speed in LOWEST * STEP_UP ** np.arange(int(np.log(HIGHEST / LOWEST) / np.log(STEP_UP)) + 1):
        if speed > BEYOND * bad:
            break
        meets = judge.failure(speed) == Failure.NONE
        if meets and not isnan(bad):
            return good, bad, speed
        if meets:
            good = speed
        elif isnan(bad):
            bad = speed
    return good, bad, nan


def _bisected(judge: _Judge, good: float, bad: float, resolution: float) -> tuple[float, float]:
    """A speed that meets the criterion and one that fails, no further apart than the resolution."""
    while bad - good > resolution:
        middle = 0.5 * (good + bad)
        if judge.failure(middle) == Failure.NONE:
            good = middle
        else:
            bad = middle
    return good, bad


def lasting(machine: Machine, duration: float) -> Machine:
    """Set the closing target of a machine a duration after its opening target, both crank angles [rad]."""
    command = machine.command
    return machine._replace(command=command._replace(close_target=command.open_target + duration))


def map_engine_limit(
    machine: Machine,
    supplies: Supplies,
    durations: Sequence[float],
    jobs: int | None = None,
    command: str = "",
    report: Callable[[int, int], Any] | None = None,
) -> Archive:
    """Map limits of the engine over pressure, temperature and duration of the window, and at the machine's own.

    A run for each point; the machine's own point comes last where the grid does not hold it. `machine` has an
    electro-pneumatic intake, `supplies` are of that machine, `durations` are crank angles from the target opening to
    the target closing [rad]. `jobs` are processes, None: as many as the work is worth; `command` is the command line,
    which the archive keeps; `report` is called with the number of limits that are done and the number of all.
    """
    asked = product(supplies.pressures, supplies.temperatures, durations)
    machines = [lasting(supplies.machine_at(pressure, temperature), window) for pressure, temperature, window in asked]
    grid, kinds = with_own([_point_of(each) for each in machines], _point_of(machine))
    machines += [machine] * (len(grid) - len(machines))
    limits = [EngineLimit(nan, Failure.TIMING, nan, None, 0)] * len(grid)
    jobs = workers_for(SECONDS_A_LIMIT * len(grid), jobs)
    for done, ((number, _), limit) in enumerate(run_tasks(_limit_of, list(enumerate(machines)), jobs)):
        limits[number] = limit or limits[number]
        if report:
            report(done + 1, len(grid))
    provenance = {
        "kind": "engine limit",
        "command": command,
        "kernels": sources_hash(),
        "criterion": CRITERION,
        "resolution_rpm": f"{RESOLUTION / RPM:g}",
        "lowest_rpm": f"{LOWEST / RPM:g}",
        "highest_rpm": f"{HIGHEST / RPM:g}",
    }
    return Archive(dumps(machine), provenance, limit_columns(grid, kinds, limits, supplies.axis))


def _point_of(machine: Machine) -> tuple[float, float, float, float]:
    """Conditions of a limit: supply pressure [Pa abs], temperature [K], window [rad], control pressure [Pa abs]."""
    supply, command = machine.supply, machine.command
    return supply.pressure, supply.temperature, command.close_target - command.open_target, supply.control().pressure


def _limit_of(task: tuple[int, Machine]) -> EngineLimit:
    """Limit of the machine of a numbered task."""
    return engine_limit(task[1])


def limit_columns(
    grid: Sequence[tuple[float, ...]],
    kinds: Sequence[Point],
    limits: Sequence[EngineLimit],
    pressure_axis: str = PRESSURE_AXES[0],
) -> dict[str, Variable]:
    """Make the columns of the archive of a map of limits: conditions, limits, design rule and command angles.

    A point of `grid` is the pressure of the supply [Pa abs], its temperature [K], the duration from the target opening
    to the target closing [rad] and the pressure of the control air [Pa abs]. `pressure_axis` is the pressure that is an
    axis of the grid, one of `apesim.studies.archives.pressure_axes.PRESSURE_AXES`. Commands are NaN where a limit has
    none.
    """

    def at_limit(value: Callable[[Timing], float], unit: str, description: str) -> Variable:
        values = [value(limit.timing) if limit.timing else nan for limit in limits]
        return column(np.array(values, dtype=float), unit, description)

    # Only the pressure that the grid was laid over is a coordinate; the other one is a column like any other.
    pressures, temperatures, durations, controls = np.array(grid).T
    over_supply, over_control = (pressure_axis == name for name in PRESSURE_AXES)
    speeds = np.array([limit.limit for limit in limits])
    fails = np.array([limit.fails for limit in limits])
    supplies = list(zip(pressures, temperatures, controls, strict=True))

    # The window that was met at the limit: each end of it may stand 0.5 deg off what was asked for, see `judged`.
    opened = [
        limit.timing.machine.command.close_target - limit.timing.machine.command.open_target if limit.timing else nan
        for limit in limits
    ]

    # Conditions come first, then the limits, what the design rule makes of them, and the commands at the limit.
    return {
        "run": run_axis(len(grid)),
        "point": point_column(kinds),
        "supply_pressure": column(pressures, "Pa abs", "pressure of the supply", coordinate=over_supply),
        "supply_temperature": column(temperatures, "K", "temperature of the supply", coordinate=True),
        "control_pressure": column(
            controls, "Pa abs", "pressure of control air from the regulator", coordinate=over_control
        ),
        "duration_deg": column(
            durations / DEGREE, "deg", "window: from the target opening to the target closing", coordinate=True
        ),
        "limit_rpm": column(speeds / RPM, "r/min", f"highest speed, revolutions a minute: {CRITERION}"),
        "limit_hz": column(speeds / TURN, "Hz", "the same as a working rate, one event a revolution"),
        "fails": column(fails, "1", "what fails first above the limit", FAILURES),
        "works_again_rpm": column(
            [limit.works_again / RPM for limit in limits],
            "r/min",
            "higher speed that meets it again, revolutions a minute",
        ),
        "lap_to_lap_s": column(opened / speeds, "s", "time for which the lift is above the lap at the limit"),
        **rule_columns(supplies, durations, speeds, fails == Failure.FULL_LIFT),
        "energise_deg": at_limit(
            lambda timing: timing.machine.command.energise / DEGREE, "deg", "command angle at the limit"
        ),
        "release_deg": at_limit(
            lambda timing: timing.machine.command.release / DEGREE, "deg", "command angle at the limit"
        ),
        "peak_lift_m": at_limit(lambda timing: timing.angles["peak_lift_m"], "m", "highest lift at the limit"),
        "marches": column([limit.marches for limit in limits], "1", "periodic states computed"),
    }
