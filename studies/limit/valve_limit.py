"""The highest rate at which the valve still completes every stroke."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle, product
from math import nan
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from apesim.archive import Archive
from apesim.archive.columns import column, run_text, values_of
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.march.adaptive import LOG_HEAD, LOG_ROWS, NO_CARRY, Status, march
from apesim.march.periodic import MAX_CYCLES, Orbit, periodic_orbit
from apesim.quantities.arguments import Given
from apesim.quantities.settings import dumps
from apesim.results import Scalar
from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.drawing.axes import in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, computed, public
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.limit.design_rule import WITHIN, rule_columns
from apesim.studies.limit.points import Point, lowest_run, own_run, point_column, with_own
from apesim.studies.limit.summary import summary_json
from apesim.studies.limit.valve_map import PRESSURES, grid_conditions, plot_over_pressure, supply_columns
from apesim.studies.run.operating_conditions import DUTY, JOBS, PRESSURE, TEMPERATURE, with_control_air
from apesim.valve.actuator import STATES
from apesim.valve.bench import TRACE, accuracy_of, bench_of, closed_at_start
from apesim.valve.groove import area_table, lap_of
from apesim.valve.measures import closing_stroke, lap_times, opening_stroke

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CRITERION = (
    "in its periodic state the piston meets the open stop and the closed stop in every cycle, "
    "and every cycle repeats the one before"
)
POINT_KEYS = {
    "supply_pressure_Pa": "supply_pressure",
    "supply_temperature_K": "supply_temperature",
    **{name: name for name in ("duty", "limit_hz", "limit_rpm", "lap_to_lap_s", "window_deg", "rule_window_deg")},
}
"""Keys of a point in JSON, where no unit stands beside a number, and its columns in the archive."""
LOWEST, HIGHEST, RESOLUTION = 1.0, 1000.0, 0.01
"""Rates between which the limit is looked for, and how closely [Hz]."""
STEP_UP = 1.25
"""Ratio of a rate of the scan to the one before."""
SETTLING = 30
"""Cycles that a valve is given to settle before a stroke that falls short counts, and then twice as many, and so on;
chosen: from the state of a lower rate complete strokes repeat after some 25 cycles, from rest after some 50."""
WATCHED = 10
"""Cycles that are watched then; chosen: a valve that wanders between its stops falls short in every other cycle."""
SECONDS_A_POINT = 0.25
"""Estimated computing time of a limit [s]."""
NAMES = {"limit_hz": "highest working rate", "limit_rpm": "engine speed at it, one event a revolution"}
"""What figures call the limits."""
LIMIT_TEMPERATURES = "250 K, 287 K, 322 K"
DUTIES = "0.3, 0.5"
FOUND, NONE, DIED = range(3)
OUTCOMES = f"{FOUND} found, {NONE} not even the lowest rate is complete, {DIED} its worker process died"


class Limit(NamedTuple):
    """Working limit of the valve: the highest rate at which every stroke is complete."""

    limit: float
    """Highest rate found to be complete [Hz]; NaN: none is."""
    complete_again: float
    """A rate above the limit at which strokes are complete again [Hz]; NaN: none was met in the scan."""
    marches: int
    """Periodic states computed."""
    open_time: float = nan
    """Time for which the lift is above the lap at the limit [s]."""


class Strokes(NamedTuple):
    """Strokes of a valve that is driven at a rate."""

    are_complete: bool
    """Whether every stroke is complete, and every cycle repeats the one before."""
    state: tuple[np.ndarray, np.ndarray]
    """State and modes at the end, from which a rate near by may start."""
    log: np.ndarray
    """Log of two periods of the periodic state, see `apesim.march.adaptive.march`; empty where none was met."""


class _Drive:
    """Valve on its bench that is driven at a rate [Hz] with a duty, from a state or from rest."""

    def __init__(self, machine: Machine, rate: float, duty: float, state: tuple[np.ndarray, np.ndarray] | None) -> None:
        self.period, self.duty = 1.0 / rate, duty
        self.p, self.tables = bench_of(machine, (0.0, duty * self.period), self.period)
        self.breakpoints = self.tables.breakpoints(0.0, self.period)
        self.accuracy = accuracy_of(self.p)
        self.state = state or closed_at_start(self.p)

    def settle(self, max_cycles: int) -> Orbit:
        """March towards the periodic state, over so many cycles at most."""
        orbit = periodic_orbit(self.p, self.tables, *self.state, self.breakpoints, self.accuracy, max_cycles=max_cycles)
        self.state = orbit.y, orbit.mode
        return orbit

    def log_cycle(self) -> np.ndarray:
        """March a cycle, and return its log."""
        (y, mode), log = (part.copy() for part in self.state), np.empty((LOG_ROWS, LOG_HEAD + STATES))
        y[len(self.accuracy.scale) :] = 0.0  # the ledger is that of the cycle
        no_trace = np.empty(0), np.empty((0, len(TRACE))), NO_CARRY
        outcome = march(self.p, self.tables, 0.0, y, mode, self.breakpoints, self.accuracy, log, *no_trace)
        self.state = y, mode
        return log[: outcome.logged] if outcome.status == Status.DONE else log[:0]

    def in_turn(self, cycle: np.ndarray, after: np.ndarray) -> np.ndarray:
        """Log of a cycle and of the one after it, in one."""
        later = after.copy()
        later[:, 0] += self.period
        return np.concatenate((cycle, later))

    def completes(self, log: np.ndarray) -> bool:
        """Whether both strokes of the first of two cycles in a log are complete.

        Contacts later than a period after their command belong to another cycle's stroke.
        """
        release = self.duty * self.period
        opening, closing = opening_stroke(log, 0.0, 2.0 * self.period), closing_stroke(log, release, 2.0 * self.period)
        return opening.contact <= self.period and closing.contact <= release + self.period


def drive_valve(
    machine: Machine, rate: float, duty: float, start: tuple[np.ndarray, np.ndarray] | None = None
) -> Strokes:
    """Drive the valve on its bench at a rate until its strokes are seen to be complete for ever, or not to be.

    Complete strokes forget what went before: the piston stands at each stop in each cycle, and the state repeats after
    some ten cycles. Strokes that fall short do not, and the piston may wander between its stops for ever, so no search
    goes on for a period once a stroke falls short in cycles that had time to settle. `rate` is strokes to open a second
    [Hz], `duty` the share of the period for which the solenoids are energised; the bench begins with the state and
    modes `start`, None: at rest.
    """
    drive = _Drive(machine, rate, duty, start)
    settling, cycles, no_log = SETTLING, 0, np.empty((0, LOG_HEAD + STATES))
    while cycles < MAX_CYCLES:
        orbit = drive.settle(min(settling, MAX_CYCLES - cycles))
        if orbit.status != Status.DONE:
            return Strokes(False, drive.state, no_log)
        if orbit.converged:
            cycle = drive.log_cycle()
            log = drive.in_turn(cycle, cycle)
            drive.state = orbit.y, orbit.mode
            return Strokes(orbit.period == 1 and drive.completes(log), drive.state, log)
        # A stroke that falls short now answers the question; else there is more to settle.
        before = drive.log_cycle()
        for _ in range(WATCHED):
            before, last = drive.log_cycle(), before
            if not drive.completes(drive.in_turn(last, before)):
                return Strokes(False, drive.state, no_log)
        cycles += orbit.cycles + 1 + WATCHED
        settling *= 2
    return Strokes(False, drive.state, no_log)


def is_complete(machine: Machine, rate: float, duty: float) -> bool:
    """Judge whether every stroke of the valve is complete at a rate, in its periodic state on the bench.

    False, too, where the march failed or the cycles do not repeat one by one. `rate` is strokes to open a second [Hz],
    `duty` the share of the period for which the solenoids are energised.
    """
    return drive_valve(machine, rate, duty).are_complete


def working_limit(machine: Machine, duty: float = 0.5, resolution: float = RESOLUTION) -> Limit:
    """Find the highest rate to which the valve can be brought from below with complete strokes.

    The rate [Hz] rises in steps of a quarter; where the limit lies between two rates it is bisected (Press et al. 2007,
    "Numerical Recipes", 3rd ed., section 9.1), and then approached in steps of `resolution` [Hz], so that a rate that
    is not complete is at most that far away. Each rate starts from the periodic state of the highest complete one
    below. `duty` is the share of the period for which the solenoids are energised; the result also holds the time for
    which the lift is above the lap at the limit [s].
    """
    rates = LOWEST * STEP_UP ** np.arange(int(np.log(HIGHEST / LOWEST) / np.log(STEP_UP)) + 1)
    marches, good, bad, again = 0, nan, nan, nan
    best: Strokes | None = None
    for rate in rates:
        marches += 1
        # The rate rises slowly, as it would on a bench; above the limit there is nothing to start from.
        strokes = drive_valve(machine, rate, duty, best.state if best and np.isnan(bad) else None)
        if strokes.are_complete and np.isnan(bad):
            good, best = rate, strokes
        elif strokes.are_complete:
            again = rate
            break
        elif np.isnan(bad):
            bad = rate
        elif rate > 2.0 * bad:
            break
    if best is None or np.isnan(bad):
        return Limit(good, again, marches)
    while bad - good > resolution:
        middle = 0.5 * (good + bad)
        marches += 1
        strokes = drive_valve(machine, middle, duty, best.state)
        if strokes.are_complete:
            good, best = middle, strokes
        else:
            bad = middle
    # Near its limit a valve that jumps to a rate may miss complete strokes that it keeps as the rate creeps up.
    step = resolution
    while True:
        marches += 1
        strokes = drive_valve(machine, good + step, duty, best.state)
        if strokes.are_complete:
            good, best, step = good + step, strokes, 2.0 * step
        elif step > resolution:
            step *= 0.5
        else:
            break
    lap = lap_of(area_table(machine.groove, machine.valve.stroke))
    opened, shut = lap_times(best.log, machine.valve.stroke, lap)
    return Limit(good, again, marches, shut - opened)


def _limit_at(point: tuple[int, Machine, float]) -> Limit:
    """Working limit at a point of a grid: number of the run, machine, duty."""
    return working_limit(*point[1:])


def limit_map(
    machine: Machine,
    pressures: Sequence[float],
    temperatures: Sequence[float],
    duties: Sequence[float],
    command: str = "",
    report: Callable[[int, int], Any] | None = None,
    jobs: int | None = None,
) -> Archive:
    """Map working limits of the valve over pressure, temperature and duty, and at the machine's own.

    A run for each point; the machine's own comes last where the grid does not hold it, its duty the share of a turn
    that lies between its command angles. `pressures` [Pa abs] and `temperatures` [K] are of the control air, `duties`
    shares of the period for which the solenoids are energised. `command` is the command line, which the archive keeps;
    `report` is called with the number of points that are done and the number of all; `jobs` are processes, None: as
    many as the work is worth, and do not change the results.
    """
    own = *machine.supply.control(), (machine.command.release - machine.command.energise) / TURN
    grid, kinds = with_own(list(product(pressures, temperatures, duties)), own)
    points = [(run, with_control_air(machine, p, t), duty) for run, (p, t, duty) in enumerate(grid)]

    # Results come in any order; a point whose worker process died keeps NaN, and is known by its outcome.
    limits = [Limit(nan, nan, 0)] * len(grid)
    outcomes = np.full(len(grid), DIED, dtype=np.int8)
    tasks = run_tasks(_limit_at, points, workers_for(SECONDS_A_POINT * len(grid), jobs))
    for done, ((run, *_), result) in enumerate(tasks):
        if result is not None:
            limits[run], outcomes[run] = result, NONE if np.isnan(result.limit) else FOUND
        if report:
            report(done + 1, len(grid))

    # What the limits mean for an engine: the shortest window between its targets, to which the design rule is fitted.
    limit, opened = np.array([(each.limit, each.open_time) for each in limits]).T
    windows = TURN * limit * opened - 2.0 * WITHIN
    supplies = [(p, t) for p, t, _ in grid]

    # The archive: conditions, limits, and what the design rule makes of them.
    variables = {
        **supply_columns(grid),
        "point": point_column(kinds),
        "duty": column(
            [d for _, _, d in grid], "1", "share of the period for which the solenoids are energised", coordinate=True
        ),
        "limit_hz": column(limit, "Hz", f"highest working rate: {CRITERION}"),
        "limit_rpm": column(60.0 * limit, "r/min", "the same as engine speed, revolutions a minute: one event each"),
        "complete_again_hz": column(
            [each.complete_again for each in limits], "Hz", "a rate above the limit that is complete again"
        ),
        "lap_to_lap_s": column(opened, "s", "time for which the lift is above the lap at the limit"),
        "window_deg": column(
            windows / DEGREE, "deg", "shortest window of an engine, each end met within 0.5 deg, at the limit"
        ),
        **rule_columns(supplies, windows, TURN * limit, outcomes == FOUND),
        "outcome": column(outcomes, "1", "what the search came to", OUTCOMES),
    }
    provenance = {
        "kind": "valve limit",
        "command": command,
        "kernels": sources_hash(),
        "criterion": CRITERION,
        "resolution_hz": str(RESOLUTION),
    }
    return Archive(dumps(machine), provenance, variables)


def faults_of_limits(archive: Archive) -> list[str]:
    """Write one line for each point of `limit_map` without a working limit: the point and why, or what to do."""
    reasons = {
        NONE: f"not even {LOWEST:g} Hz is complete: the supply cannot move the piston",
        DIED: "its worker process died; try --jobs 1",
    }
    return [
        f"{run_text(archive, run)}: {reasons[outcome]}"
        for run, outcome in enumerate(archive.variables["outcome"].values)
        if outcome != FOUND
    ]


@dataclass(frozen=True, eq=False, repr=False)
class ValveLimit(ArchiveResult):
    """Highest working rates of the valve over pressure, temperature and duty, and at the machine's own.

    ``limit_hz`` and ``limit_rpm`` are those of the machine's own control air and commands.
    """

    title: ClassVar[str] = "highest working rate of the valve"

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each point without a limit."""
        return faults_of_limits(archive)

    @classmethod
    def _summary_of(cls, archive: Archive) -> Mapping[str, Scalar]:
        """Limits at the machine's own point, and the lowest of the grid."""
        v, own, lowest = values_of(archive), own_run(values_of(archive)), lowest_run(values_of(archive))
        found = {
            "limit_hz": Scalar(float(v["limit_hz"][own]), "Hz", "at the machine's own control air and duty"),
            "limit_rpm": Scalar(
                float(v["limit_rpm"][own]), "r/min", "the same as engine speed, one event a revolution"
            ),
        }
        if lowest is not None:
            found["min_limit_hz"] = Scalar(float(v["limit_hz"][lowest]), "Hz", "lowest of the grid")
        return found

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Grid and criterion."""
        return grid_conditions(archive)

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim valve limit --json``.

        Returns
        -------
        dict
            Summary, criterion and the limit of each point under ``points``; NaN where JSON says null.

        Examples
        --------
        >>> import apesim
        >>> here = {"pressure": "1 MPa gauge", "temperature": "287 K"}
        >>> limits = apesim.find_valve_limit(apesim.Machine(), duty=0.5, **here).to_dict()
        >>> len(limits["points"]), float(limits["limit_at"]["supply_temperature_K"])
        (2, 287.0)
        """
        v = values_of(self.archive)
        points = [{key: v[name][run] for key, name in POINT_KEYS.items()} for run in range(len(v["run"]))]
        return summary_json(v, "duty") | {"criterion": CRITERION, "points": points, "faults": list(self.failed)}

    @property
    def criterion(self) -> str:
        """What a rate has to meet, in words."""
        return CRITERION

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str = "limit_hz") -> "Axes":
        """Draw limits over pressure, a line for each temperature and duty, and the machine's own point.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : str
            Name of a trace, e.g. "limit_rpm".

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Examples
        --------
        >>> from apesim.studies.archives.archive_result import variables_of
        >>> limits = column([55.0, 74.0], "Hz", "highest working rate")
        >>> columns = supply_columns([(0.5e6, 287.0), (1.1e6, 287.0)]) | {"limit_hz": limits}
        >>> columns |= {"duty": column([0.5, 0.2], "1", "duty"), "point": point_column([Point.GRID, Point.OWN])}
        >>> archive = Archive("", {}, columns)
        >>> axes = ValveLimit({}, variables_of(archive), archive=archive).plot()
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('control pressure [MPa gauge]', 'highest working rate [Hz]')
        """
        from apesim.studies.drawing.style import STYLES, Look, looks_of
        from apesim.studies.limit.lines import OWN_POINT

        temperatures, duties, points = (self.traces[n].values for n in ("supply_temperature", "duty", "point"))
        is_own = points == Point.OWN
        of_duties, kelvins = np.unique(duties[~is_own]), np.unique(temperatures[~is_own])
        groups: dict[str, tuple[np.ndarray, Look]] = {}
        for duty, of_duty in zip(of_duties, looks_of(len(of_duties)), strict=True):
            for kelvin, style in zip(kelvins, cycle(STYLES)):
                chosen = np.flatnonzero((temperatures == kelvin) & (duties == duty) & ~is_own)
                groups[f"{kelvin:g} K, duty {duty:g}"] = chosen, of_duty | {"ls": style}
        for run in np.flatnonzero(is_own):
            label = f"the machine's own: {temperatures[run]:g} K, duty {duties[run]:.3g}"
            groups[label] = np.array([run]), OWN_POINT
        return plot_over_pressure(self, what, ax, groups, NAMES.get(what, ""))


@public
def find_valve_limit(
    machine: Machine,
    *,
    pressure: Given | Iterable[Given] = PRESSURES,
    temperature: Given | Iterable[Given] = LIMIT_TEMPERATURES,
    duty: Given | Iterable[Given] = DUTIES,
    out: str | PathLike[str] | None = None,
    jobs: int | None = 1,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> ValveLimit:
    """Find the highest rate at which every stroke of the valve is complete, in periodic operation.

    Parameters
    ----------
    machine : Machine
    pressure : str, float or sequence of them
        Pressures of the control air, e.g. "0.1:1.9:0.2 MPa gauge", or [Pa abs].
    temperature : str, float or sequence of them
        Temperatures of the control air, e.g. "250 K, 287 K", or [K].
    duty : str, float or sequence of them
        Shares of the period for which the solenoids are energised.
    out : path, optional
        The archive to write.
    jobs : int or None
        Processes; None: as many as the work is worth. A script that asks for more than one does so below
        ``if __name__ == "__main__":``, as each process imports it.
    overwrite : bool
        Replace an archive that is there.
    progress : bool or function
        True: a bar on standard error; a function is called with the numbers of points done and in all.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    ValveLimit
        ``failed`` names the points without a limit.

    Raises
    ------
    InputError
        The machine or an argument is out of range.
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> found = apesim.find_valve_limit(apesim.Machine(), pressure="1 MPa gauge", temperature="287 K", duty=0.5)
    >>> found["runs"], f"{found['min_limit_hz']:.1f} Hz"
    (2, '73.9 Hz')
    """
    call = call_text(find_valve_limit, locals()) if call is None else call
    arguments, machine = arguments_of("find_valve_limit", machine)
    pressures = arguments.range("pressure", pressure, PRESSURE)
    temperatures = arguments.range("temperature", temperature, TEMPERATURE)
    duties = arguments.range("duty", duty, DUTY)
    arguments.quantity("jobs", jobs, JOBS)
    arguments.refuse()

    def compute(**options: Any) -> Archive:
        return limit_map(machine, pressures, temperatures, duties, command=call, jobs=jobs, **options)

    first = is_complete, machine, 10.0, duties[0]
    with show_progress(progress, "limit") as report:
        archive, wall_time = computed(compute, first, out, overwrite=overwrite, report=report)
    return ValveLimit.of(archive, wall_time)
