"""Corrected commands over speed, pressure and temperature, what they win back, and what the shortcut costs."""

import json
from collections.abc import Callable, Sequence
from itertools import product
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import NO_YES, column, run_axis, run_text, values_of
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.command import Command
from apesim.engine.drivetrain.point import point_of, run_point
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.march.adaptive import Status
from apesim.quantities.settings import dumps
from apesim.studies.archives.pressure_axes import PRESSURE_AXES, find_pressure_axis
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.run.operating_conditions import SPEED, Supplies
from apesim.studies.timing.law import Law, laws_of
from apesim.studies.timing.open_loop import Delays, open_loop_delays
from apesim.studies.timing.solve import Reason, Timing, alone, corrected, look, start_after, wrapped
from apesim.studies.timing.table import Axes, InterpolationError, centres, interpolation_error

SECONDS_A_POINT = 0.12
"""Estimated computing time of a point [s]."""
MAX_CHECKS, SEED = 60, 20090
"""Centres of cells that are solved to measure the error of interpolation; seed of their choice."""
CRITERION = (
    "both angles within 0.05 deg of their targets, in a periodic state that repeats every cycle, the lift through the "
    "lap once a cycle"
)
REASONS = ", ".join(f"{int(reason)} {reason.words}" for reason in Reason)
COLUMNS = {
    "speed_rpm": ("r/min", "speed, revolutions a minute"),
    "supply_pressure": ("Pa abs", "pressure of the supply"),
    "control_pressure": ("Pa abs", "pressure of control air from the regulator"),
    "supply_temperature": ("K", "temperature of the supply"),
    "reachable": ("1", CRITERION),
    "reason": ("1", "why not"),
    "advance_deg": ("deg", "target of the opening less command angle of the energising"),
    "release_advance_deg": ("deg", "target of the closing less command angle of the release"),
    "energise_deg": ("deg", "command angle of the energising"),
    "release_deg": ("deg", "command angle of the release"),
    "pulse_s": ("s", "time for which the solenoids are energised"),
    "valve_open_deg": ("deg", "crank angle at which the lift rises through the lap"),
    "valve_close_deg": ("deg", "crank angle at which the lift falls through the lap"),
    "peak_lift_m": ("m", "highest lift"),
    "full_lift": ("1", "whether the piston meets its open stop"),
    "brake_torque_Nm": ("N m", "mean brake torque"),
    "specific_air_kg_per_kWh": ("kg/kWh", "all air over brake work"),
    "fixed_valve_open_deg": ("deg", "opening with the machine's own commands"),
    "fixed_valve_close_deg": ("deg", "closing with the machine's own commands"),
    "fixed_brake_torque_Nm": ("N m", "brake torque with the machine's own commands"),
    "fixed_specific_air_kg_per_kWh": ("kg/kWh", "all air over brake work with the machine's own commands"),
    "shortcut_energise_deg": ("deg", "command angle from the delay of the bench, from rest"),
    "shortcut_release_deg": ("deg", "command angle from the delay of the bench, from rest"),
    "shortcut_open_error_deg": ("deg", "true less target opening with the commands from the bench"),
    "shortcut_close_error_deg": ("deg", "true less target closing with the commands from the bench"),
    "marches": ("1", "periodic states computed to find the commands"),
}
"""Name of each result: its unit and what it is."""
ERROR_KEYS = (
    "points",
    "centres",
    "seed",
    "advance_most",
    "advance_rms",
    "release_advance_most",
    "release_advance_rms",
)
"""Keys of the error of interpolation in the provenance of an archive."""
MEANINGS = {"reachable": NO_YES, "full_lift": NO_YES, "reason": REASONS}


class Series(NamedTuple):
    """Points at one pressure and temperature, by rising speed; each starts from what the ones before it needed."""

    machine: Machine
    """Machine with the supply of the points."""
    speeds: tuple[float, ...]
    """Speeds of the points, increasing [rad/s]."""
    places: tuple[int, ...]
    """Place of the result of each speed: in the grid, or among the centres of cells."""
    alone: bool
    """Whether the commands are all that is wanted, as at the centres of cells."""


class TimingMap(NamedTuple):
    """Corrected commands over speed, pressure and temperature: tables, laws and all results."""

    archive: Archive
    """All results, a run for each point; see `COLUMNS`."""
    command: Command
    """Command of the machine, with the targets."""
    axes: Axes
    """Speeds, pressures and temperatures of the points."""
    advance: np.ndarray
    """Target of the opening less command angle of the energising, (i, j, k) [rad]; NaN out of reach."""
    release_advance: np.ndarray
    """Target of the closing less command angle of the release, (i, j, k) [rad]; NaN out of reach."""
    laws: dict[str, list[Law]]
    """Laws of the temperature, under ``advance`` and ``release_advance``."""
    error: InterpolationError
    """Measured error of both tables between their points."""

    @property
    def pressure_axis(self) -> str:
        """Pressure that the tables stand over: "supply_pressure" or "control_pressure"."""
        return find_pressure_axis(self.archive)

    @property
    def full_lift(self) -> np.ndarray:
        """Whether the piston meets its open stop, (i, j, k); the targets can be in reach without it."""
        return self.archive.variables["full_lift"].values.reshape(self.axes.shape) == 1


def _compute(series: Series) -> list[dict[str, float]]:
    """Solve the commands of a series of points, and find what they win back.

    The results of each speed have their names in `COLUMNS`, without speed, pressure and temperature; they are the
    commands only where the series wants these alone.
    """
    delays = open_loop_delays(series.machine)
    before: list[tuple[float, Timing]] = []
    rows: list[dict[str, float]] = []
    for speed in series.speeds:
        timing = corrected(series.machine, speed, start_after(series.machine, speed, before))
        if timing.reachable:
            before.append((speed, timing))
        row = _commands(timing, speed)
        if not series.alone:
            row |= _won_back(series.machine, timing, speed) | _shortcut(series.machine, delays, speed)
        rows.append(row)
    return rows


def _commands(timing: Timing, speed: float) -> dict[str, float]:
    """Commands of a point, and whether its targets are in reach."""
    command, reachable = timing.machine.command, timing.reachable
    return {
        "reachable": int(reachable),
        "reason": int(timing.reason),
        "advance_deg": timing.advance / DEGREE,
        "release_advance_deg": timing.release_advance / DEGREE,
        "energise_deg": command.energise / DEGREE if reachable else nan,
        "release_deg": command.release / DEGREE if reachable else nan,
        "pulse_s": (command.release - command.energise) / speed if reachable else nan,
        "marches": timing.marches,
    }


def _won_back(machine: Machine, timing: Timing, speed: float) -> dict[str, float]:
    """Results with the corrected and with the machine's own commands."""
    plain = run_point(machine, speed)
    own = plain.values if plain.run.status == Status.DONE and plain.run.orbit.converged else {}
    new = point_of(timing.machine, timing.run).values if timing.run else {}
    row = {f"fixed_{name}": own.get(name, nan) for name in ("valve_open_deg", "valve_close_deg")}
    row |= {name: new.get(name, nan) for name in ("valve_open_deg", "valve_close_deg", "peak_lift_m")}
    row["full_lift"] = int(not np.isnan(new.get("full_open_deg", nan)))
    for name in ("brake_torque_Nm", "specific_air_kg_per_kWh"):
        row |= {name: new.get(name, nan), f"fixed_{name}": own.get(name, nan)}
    return row


def _shortcut(machine: Machine, delays: Delays, speed: float) -> dict[str, float]:
    """Commands that stand the bench's delays before their targets, and by how much the valve then misses these."""
    command = machine.command
    energise, release = command.open_target - speed * delays.opening, command.close_target - speed * delays.closing
    row = {"shortcut_energise_deg": energise / DEGREE, "shortcut_release_deg": release / DEGREE}
    errors = [nan, nan]
    if 0.0 < release - energise < TURN:
        misses = look(alone(machine), speed, energise, release - energise).misses
        if np.isfinite(misses).all():
            errors = [misses[0] / DEGREE, wrapped(misses.sum()) / DEGREE]
    return row | {"shortcut_open_error_deg": errors[0], "shortcut_close_error_deg": errors[1]}


def _series(supplies: Supplies, axes: Axes, chosen: Sequence[Sequence[float]]) -> list[Series]:
    """Group the points of the grid, and the chosen centres of cells, into series of one pressure and temperature."""
    i, j, k = axes.shape
    series = [
        Series(supplies.machine_at(*air), tuple(axes.speeds), tuple(number + j * k * s for s in range(i)), False)
        for number, air in enumerate(product(axes.pressures, axes.temperatures))
    ]
    groups: dict[tuple[float, ...], list[tuple[float, int]]] = {}
    for place, (speed, *supply) in enumerate(chosen):
        groups.setdefault(tuple(supply), []).append((speed, place))
    for air, members in groups.items():
        speeds, places = zip(*sorted(members), strict=True)
        series.append(Series(supplies.machine_at(*air), speeds, places, True))
    return series


def map_timing(
    supplies: Supplies,
    speeds: Sequence[float],
    jobs: int | None = None,
    max_checks: int = MAX_CHECKS,
    command: str = "",
    report: Callable[[int, int], Any] | None = None,
) -> TimingMap:
    """Map corrected commands over a grid, what they win back, and how well a table of them interpolates.

    Supplies (of a machine with an electro-pneumatic intake) and `speeds` [rad/s] come in any order; those that occur
    twice count once. Run ``(i len(pressures) + j) len(temperatures) + k`` of the archive is speed i, pressure j,
    temperature k. `jobs` None: as many processes as the work is worth; `max_checks` is the most centres of cells that
    are solved to measure the error of interpolation; `report` gets the numbers of points done and of all.

    >>> supplies = Supplies([1.1e6], [280.0, 300.0], Machine())
    >>> timing_map = map_timing(supplies, [94.0], jobs=1)
    >>> (timing_map.advance / DEGREE).round(1).tolist()  # colder air makes the valve slower
    [[[36.3, 35.7]]]
    >>> timing_map.error.centres
    1
    """
    asked, machine = (speeds, supplies.pressures, supplies.temperatures), supplies.base
    axes = Axes(*(np.unique(np.asarray(axis, dtype=float)) for axis in asked))
    chosen, number = centres(axes, max_checks, SEED)
    size = int(np.prod(axes.shape))

    # Results come in any order. Where a worker process dies, an empty row counts as failed, and a NaN centre as none.
    rows: list[dict[str, float]] = [{}] * size
    checks = [(nan, nan)] * len(chosen)
    done, total = 0, size + len(chosen)
    jobs = workers_for(SECONDS_A_POINT * total, jobs)
    for series, results in run_tasks(_compute, _series(supplies, axes, chosen), jobs):
        for place, row in zip(series.places, results or (), strict=bool(results)):
            if series.alone:
                checks[place] = row["advance_deg"] * DEGREE, row["release_advance_deg"] * DEGREE
            else:
                rows[place] = row
        done += len(series.places)
        if report:
            report(done, total)

    # Tables and laws are made from the columns of the archive, so that they are the same when it is read again.
    variables = _variables(supplies, axes, rows)
    advance, release_advance = (
        variables[name].values.reshape(axes.shape) * DEGREE for name in ("advance_deg", "release_advance_deg")
    )
    laws = {"advance": laws_of(axes, advance), "release_advance": laws_of(axes, release_advance)}

    # No table was made from the centres of cells, so that what was solved there measures how well tables interpolate.
    solved = [(point, *angles) for point, angles in zip(chosen, checks, strict=True)]
    error = interpolation_error(axes, advance, release_advance, solved, number, SEED)

    # The measured error goes with the archive, in which the centres themselves are not.
    provenance = {
        "kind": "engine timing",
        "command": command,
        "kernels": sources_hash(),
        "criterion": CRITERION,
        "interpolation_error_rad": json.dumps(dict(zip(ERROR_KEYS, error, strict=True))),
    }
    archive = Archive(dumps(machine), provenance, variables)
    return TimingMap(archive, machine.command, axes, advance, release_advance, laws, error)


def _variables(supplies: Supplies, axes: Axes, rows: Sequence[dict[str, float]]) -> dict[str, Variable]:
    """Make the variables of the archive from the rows of the grid; a row whose worker died is one that failed."""
    speeds, pressures, temperatures = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    machines = [supplies.machine_at(*air) for air in zip(pressures, temperatures, strict=True)]
    places = {
        "speed_rpm": np.array([float(f"{speed / TURN * 60.0:.12g}") for speed in speeds]),
        "supply_pressure": np.array([machine.supply.pressure for machine in machines]),
        "control_pressure": np.array([machine.supply.control().pressure for machine in machines]),
        "supply_temperature": temperatures,
    }
    coordinates = places.keys() - PRESSURE_AXES | {supplies.axis}
    lost = {"reachable": 0, "reason": int(Reason.FAILED), "full_lift": 0, "marches": 0}
    variables = {"run": run_axis(len(rows))}
    for name, (unit, description) in COLUMNS.items():
        values = places[name] if name in places else np.array([row.get(name, lost.get(name, nan)) for row in rows])
        values = values.astype(np.int64 if name == "marches" else float)
        variables[name] = column(values, unit, description, MEANINGS.get(name, ""), coordinate=name in coordinates)
    return variables


def timing_map_of(archive: Archive, command: Command) -> TimingMap:
    """Make the map of corrected commands of an archive that was written from one, with the command of its machine.

    The speeds are those of the archive, which have 12 digits. Raises ValueError where the runs are no grid.

    >>> timing_map = map_timing(Supplies([1.1e6], [280.0, 300.0], Machine()), [94.0], jobs=1)
    >>> again = timing_map_of(timing_map.archive, timing_map.command)
    >>> bool(np.array_equal(again.advance, timing_map.advance)), again.error == timing_map.error
    (True, True)
    """
    v = values_of(archive)
    speeds = [SPEED.read(f"{float(speed)!r} rpm") for speed in np.unique(v["speed_rpm"])]
    pressures = np.unique(v[find_pressure_axis(archive)])
    axes = Axes(np.array(speeds), pressures, np.unique(v["supply_temperature"]))
    advance, release_advance = (v[name].reshape(axes.shape) * DEGREE for name in ("advance_deg", "release_advance_deg"))
    laws = {"advance": laws_of(axes, advance), "release_advance": laws_of(axes, release_advance)}
    known = json.loads(archive.provenance["interpolation_error_rad"])
    error = InterpolationError(*(known[key] for key in ERROR_KEYS))
    return TimingMap(archive, command, axes, advance, release_advance, laws, error)


def faults_of_timing(archive: Archive) -> list[str]:
    """Write one line for each point whose targets are out of reach: which, why, and what to change."""
    v = values_of(archive)
    return [
        f"{run_text(archive, int(run))}: {Reason(v['reason'][run]).remedy}"
        for run in np.flatnonzero(v["reachable"] == 0)
    ]
