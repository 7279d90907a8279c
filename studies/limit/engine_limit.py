"""The highest speed at which the valve opens and closes the engine's intake at its targets, with complete strokes."""

from enum import IntEnum
from math import isnan, nan
from typing import NamedTuple

import numpy as np

from apesim.archive import Archive
from apesim.archive.columns import column, run_axis
from apesim.engine.angles import DEGREE, TURN
from apesim.kernel import sources_hash
from apesim.march.periodic import PERIODIC_TOLERANCE
from apesim.quantities.settings import dumps
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.limit.design_rule import RPM, WITHIN, rule_columns
from apesim.studies.limit.points import Point, point_column, with_own
from apesim.studies.operating_conditions import with_supply
from apesim.studies.timing.solve import SKETCH, Reason, Timing, corrected, start_after

CRITERION = (
    "command angles exist with which the valve opens and closes within 0.5 deg of its targets, the piston meets the "
    "open stop and the closed stop in every cycle, and every cycle repeats the one before"
)
LOWEST, HIGHEST, RESOLUTION, SKETCH_RESOLUTION = 300.0 * RPM, 12000.0 * RPM, 1.0 * RPM, 8.0 * RPM
"""Speeds between which the limit is looked for, and how closely [rad/s]."""
STEP_UP = 1.25
BEYOND = 2.0
"""How many times as fast as the first speed that fails the scan looks for speeds that do not."""
SECONDS_A_LIMIT = 1.0


class Failure(IntEnum):
    """Which part of the criterion is not met."""

    NONE = 0
    TIMING = 1
    FULL_LIFT = 2
    FULL_CLOSURE = 3
    REPETITION = 4

    @property
    def remedy(self):
        """What fails, and what to change."""
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
    """The limit of an engine's intake."""

    limit: float
    """Highest speed that meets the criterion, from the lowest upwards [rad/s]; NaN: the lowest does not."""
    fails: Failure
    """What fails first above it; NONE: nothing up to the highest."""
    works_again: float
    """A speed above the limit that meets the criterion again [rad/s]; NaN: none was met in the scan."""
    timing: Timing | None
    """The commands at the limit."""
    marches: int
    """Periodic states computed."""


def failure_of(timing):
    """Which part of the criterion commands do not meet; the first in the order of `Failure`."""
    if timing.reason == Reason.NOT_PERIODIC:
        return Failure.REPETITION
    if not timing.reachable:
        return Failure.TIMING
    if isnan(timing.angles["full_open_deg"]):
        return Failure.FULL_LIFT
    return Failure.FULL_CLOSURE if isnan(timing.angles["closed_deg"]) else Failure.NONE


def parted(machine, angle):
    """A machine whose targets are moved apart by an angle each [rad]."""
    command = machine.command
    moved = command._replace(open_target=command.open_target - angle, close_target=command.close_target + angle)
    return machine._replace(command=moved)


def judged(machine, speed, before=(), periodic_tolerance=PERIODIC_TOLERANCE):
    """Whether any commands meet the criterion at a speed.

    What the targets themselves do not allow, those at the ends of the tolerance may: the valve is open for the longest
    time, which full lift needs, if it opens 0.5 deg early and closes 0.5 deg late; full closure needs the reverse.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    speed : float
        [rad/s]
    before : sequence of tuple
        See `apesim.studies.timing.solve.start_after`.
    periodic_tolerance : float
        See `apesim.studies.timing.solve.corrected`.

    Returns
    -------
    Failure
        At the targets themselves, where no commands meet the criterion.
    Timing
        That meets it; or the one for the targets themselves.
    marches : int
    """
    timing = corrected(machine, speed, start_after(machine, speed, before), periodic_tolerance)
    failure, marches = failure_of(timing), timing.marches
    others = {
        Failure.TIMING: (WITHIN, -WITHIN),
        Failure.FULL_LIFT: (WITHIN,),
        Failure.FULL_CLOSURE: (-WITHIN,),
    }.get(failure, ())
    for angle in others:
        other = parted(machine, angle)
        start = start_after(other, speed, [(speed, timing)] if timing.reachable else before)
        nearby = corrected(other, speed, start, periodic_tolerance)
        marches += nearby.marches
        if failure_of(nearby) == Failure.NONE:
            return Failure.NONE, nearby, marches
    return failure, timing, marches


class Judge:
    """What was found at some speeds, by periodic states of one kind.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    periodic_tolerance : float
        See `apesim.studies.timing.solve.corrected`.
    before : sequence of tuple
        To start from, see `apesim.studies.timing.solve.start_after`.
    """

    def __init__(self, machine, periodic_tolerance, before=()):
        self.machine, self.periodic_tolerance, self.before = machine, periodic_tolerance, list(before)
        self.found = {}
        self.marches = 0

    def failure(self, speed):
        """See `judged`; computed once."""
        if speed not in self.found:
            failure, timing, marches = judged(self.machine, speed, self.before, self.periodic_tolerance)
            self.found[speed] = failure, timing._replace(run=None)
            self.marches += marches
            if timing.reachable:
                self.before.append((speed, timing))
        return self.found[speed][0]


def engine_limit(machine, resolution=RESOLUTION):
    """Highest speed that meets the criterion: scanned upwards in steps of a quarter, then bisected.

    Sketches of the periodic state lead near it, full ones decide; where those say otherwise than the sketches, they
    scan anew.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
        With an electro-pneumatic intake and its targets.
    resolution : float
        [rad/s]

    Returns
    -------
    EngineLimit
    """
    sketch = Judge(machine, SKETCH)
    good, bad, again = _scanned(sketch)
    good, bad = _bisected(sketch, good, bad, SKETCH_RESOLUTION)
    full = Judge(machine, PERIODIC_TOLERANCE, sketch.before)
    expected = [(speed, speed != bad) for speed in (good, bad, again) if not isnan(speed)]
    if any((full.failure(speed) == Failure.NONE) != meets for speed, meets in expected):
        good, bad, again = _scanned(full)
    good, bad = _bisected(full, good, bad, resolution)
    fails = Failure.NONE if isnan(bad) else full.failure(bad)
    timing = None if isnan(good) else full.found[good][1]
    return EngineLimit(good, fails, again, timing, sketch.marches + full.marches)


def _scanned(judge):
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


def _bisected(judge, good, bad, resolution):
    """A speed that meets the criterion and one that fails, no further apart than the resolution."""
    while bad - good > resolution:
        middle = 0.5 * (good + bad)
        if judge.failure(middle) == Failure.NONE:
            good = middle
        else:
            bad = middle
    return good, bad


def lasting(machine, duration):
    """A machine whose closing target stands a duration after its opening target [rad]."""
    command = machine.command
    return machine._replace(command=command._replace(close_target=command.open_target + duration))


def map_engine_limit(machine, pressures, temperatures, durations, jobs=None, command="", report=None):
    """Limits over pressure, temperature and duration of the target window, and at the machine's own.

    Parameters
    ----------
    machine : Machine
    pressures : sequence of float
        Of the supply [Pa abs].
    temperatures : sequence of float
        Of the supply [K].
    durations : sequence of float
        From opening to closing [rad].
    jobs : int, optional
        Processes; as many as the work is worth if left out.
    command : str
        The command line, for the archive.
    report : function, optional
        Called with the numbers of limits done and in all.

    Returns
    -------
    Archive
        The machine's own point comes last where the grid does not hold it.
    """
    supply, command_angles = machine.supply, machine.command
    grid = [(p, t, d, p) for p in pressures for t in temperatures for d in durations]
    own = supply.pressure, supply.temperature, command_angles.close_target - command_angles.open_target
    grid, kinds = with_own(grid, (*own, supply.control()[0]))
    machines = [
        machine if kind == Point.OWN else lasting(with_supply(machine, p, t), d)
        for kind, (p, t, d, _) in zip(kinds, grid, strict=True)
    ]
    limits = [EngineLimit(nan, Failure.TIMING, nan, None, 0)] * len(grid)
    jobs = workers_for(SECONDS_A_LIMIT * len(grid), jobs)
    for done, ((number, _), found) in enumerate(run_tasks(_limit_of, list(enumerate(machines)), jobs)):
        limits[number] = found or limits[number]
        if report:
            report(done + 1, len(grid))
    provenance = {
        "command": command,
        "kernels": sources_hash(),
        "criterion": CRITERION,
        "resolution_rpm": f"{RESOLUTION / RPM:g}",
        "lowest_rpm": f"{LOWEST / RPM:g}",
        "highest_rpm": f"{HIGHEST / RPM:g}",
    }
    return Archive(dumps(machine), provenance, _variables(grid, kinds, limits))


def _limit_of(item):
    return engine_limit(item[1])


def _variables(grid, kinds, limits):
    def at_limit(value, unit, description):
        values = [value(found.timing) if found.timing else nan for found in limits]
        return column(np.array(values, dtype=float), unit, description)

    pressures, temperatures, durations, controls = np.array(grid).T
    speeds = np.array([found.limit for found in limits])
    fails = np.array([found.fails for found in limits])
    supplies = list(zip(pressures, temperatures, controls, strict=True))
    opened = [
        found.timing.machine.command.close_target - found.timing.machine.command.open_target if found.timing else nan
        for found in limits
    ]
    return {
        "run": run_axis(len(grid)),
        "point": point_column(kinds),
        "supply_pressure": column(pressures, "Pa abs", "pressure of the supply", coordinate=True),
        "supply_temperature": column(temperatures, "K", "temperature of the supply", coordinate=True),
        "control_pressure": column(controls, "Pa abs", "pressure of control air from the regulator"),
        "duration_deg": column(
            durations / DEGREE, "deg", "window: from the target opening to the target closing", coordinate=True
        ),
        "limit_rpm": column(speeds / RPM, "r/min", f"highest speed, revolutions a minute: {CRITERION}"),
        "limit_hz": column(speeds / TURN, "Hz", "the same as a working rate, one event a revolution"),
        "fails": column(fails, "1", "what fails first above the limit", FAILURES),
        "works_again_rpm": column(
            [found.works_again / RPM for found in limits],
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
        "marches": column([found.marches for found in limits], "1", "periodic states computed"),
    }
