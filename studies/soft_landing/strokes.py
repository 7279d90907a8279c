"""Soft landing, the next step that the paper names (doi 10.1631/jzus.A0820373): how far braking re-switches go."""

from collections.abc import Callable, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.march.adaptive import LOG_HEAD, ZERO_CROSSING
from apesim.studies.operating_conditions import with_control_air
from apesim.studies.soft_landing.braking import (
    APART,
    SWITCHED,
    front_of,
    search,
    sturdiest,
    widest_soft,
)
from apesim.studies.soft_landing.landing import (
    BOTH,
    ONLY_A,
    ONLY_B,
    SOLENOIDS,
    STROKES,
    Edges,
    Landing,
    Task,
    apart_of,
    land,
)
from apesim.valve.motion import MET_CLOSED, MET_OPEN, SPEED_EXTREMUM

PRESSURES = "0.4:1.6:0.6 MPa gauge"
SPACING = 1.0 / (2.0 * 120.0)
"""Shortest time between two edges of a solenoid that follows 120 Hz, the paper's [s]."""
FACTORS = (0.95, 1.0, 1.05)
"""Factors on the gauge pressure for which a brake is tried."""
OFFSETS = (-10.0, 0.0, 10.0)
"""Offsets of the temperature for which a brake is tried [K]."""
LIMITS = ("within_spacing", "any_spacing")
"""Whether the edges keep the solenoids' least time."""
KINDS = ("softest", "sturdy")
"""The lowest seating speed as it should be; the lowest at the worst of the conditions."""


class Choice(NamedTuple):
    """A brake, and what becomes of it under other conditions."""

    row: np.ndarray
    """Brake with the columns from `apesim.studies.soft_landing.braking.BRAKE` on, (6,)."""
    landings: tuple[Landing, ...]
    """A `Landing` for each pressure factor and temperature offset, row by row."""
    added: np.ndarray
    """Time added to the unbraked stroke of the same condition [s], in the same order."""

    @property
    def solenoids(self) -> str:
        """Solenoids that the brake switches, one of `apesim.studies.soft_landing.landing.SOLENOIDS`."""
        return SOLENOIDS[int(self.row[SWITCHED])]


class Result(NamedTuple):
    """Brakes of a stroke at one pressure."""

    task: Task
    """Stroke without a brake."""
    unbraked: Landing
    """Landing without a brake."""
    lowest: float
    """Lowest speed of the unbraked piston between its peak and contact [m/s]: the most that the fluctuation alone could
    give, if the stop stood there."""
    brakes: np.ndarray
    """Brakes of all solenoids tried, see `apesim.studies.soft_landing.braking.search`."""
    choices: dict[tuple[str, str], Choice | None]
    """Chosen brakes by limit and kind; None where there is none."""

    @property
    def gauge(self) -> float:
        """Gauge pressure of the control air [Pa]."""
        return self.task.machine.supply.control().pressure - self.task.machine.ambient.pressure

    @property
    def best(self) -> Choice | None:
        """Softest brake within the spacing; without one, the softest of any spacing; else None."""
        return next((c for limit in LIMITS if (c := self.choices[limit, "softest"])), None)

    @property
    def braked(self) -> tuple[Task, tuple[float, ...]]:
        """Task with the solenoids of its best brake, and the edges of that; none if there is no brake."""
        best = self.best
        return (self.task._replace(solenoids=best.solenoids), tuple(best.row[:2])) if best else (self.task, ())


def _lowest_speed(log: np.ndarray, command: float, contact: float) -> float:
    """Find the lowest speed after the peak of a stroke, up to its contact [m/s], in the log of a bench run."""
    is_event = np.isin(log[:, 1], (MET_CLOSED, MET_OPEN, ZERO_CROSSING + SPEED_EXTREMUM))
    speeds = np.abs(log[is_event & (log[:, 0] >= command) & (log[:, 0] <= contact), LOG_HEAD + 1])
    return float(speeds[speeds.argmax() :].min()) if len(speeds) else nan


def conditions_of(task: Task) -> list[tuple[Task, Landing]]:
    """Set a task to every pressure factor and temperature offset, and land it there without a brake.

    Parameters
    ----------
    task : Task
        Stroke at its own pressure and temperature.

    Returns
    -------
    list of (Task, Landing)
        Tasks row by row, a row for each of `FACTORS`, a column for each of `OFFSETS`; each with its unbraked landing.

    Examples
    --------
    >>> conditions = conditions_of(Task(Machine(), 50e-3, "closing"))
    >>> [round(1e3 * landing.contact, 1) for _, landing in conditions[::4]]  # [ms]
    [11.7, 11.5, 11.3]
    """
    pressure, temperature = task.machine.supply.control()
    ambient = task.machine.ambient.pressure
    tasks = [
        task._replace(
            machine=with_control_air(task.machine, ambient + factor * (pressure - ambient), temperature + offset)
        )
        for factor in FACTORS
        for offset in OFFSETS
    ]
    return [(other, land(other)) for other in tasks]


def _choose(
    task: Task,
    unbraked: Landing,
    brakes: np.ndarray,
    conditions: Sequence[tuple[Task, Landing]],
    spacing: float,
    cost: float,
) -> dict[str, Choice | None]:
    """Choose the softest and the sturdiest brake for a spacing and a cost [s], by kind; None where there is none."""
    softest = front_of(brakes, spacing, cost)[-1:]
    if not len(softest):
        return dict.fromkeys(KINDS)
    candidates: list[tuple[float, tuple[float, float], int]] = []
    for number in np.unique(brakes[:, SWITCHED]).astype(int):
        brake, worst = sturdiest(_of(number, conditions), brakes[brakes[:, SWITCHED] == number], spacing, cost)
        candidates += [(worst, brake, int(number))] if brake else []
    sturdy = min(candidates, default=None)
    return {
        "softest": _choice(task, unbraked, softest[0, :2], int(softest[0, SWITCHED]), conditions),
        "sturdy": _choice(task, unbraked, sturdy[1], sturdy[2], conditions) if sturdy else None,
    }


def _of(number: int, conditions: Sequence[tuple[Task, Landing]]) -> list[tuple[Task, Landing]]:
    """Conditions whose brake switches the solenoids of that number."""
    return [(task._replace(solenoids=SOLENOIDS[number]), unbraked) for task, unbraked in conditions]


def _choice(
    task: Task,
    unbraked: Landing,
    brake: Edges,
    number: int,
    conditions: Sequence[tuple[Task, Landing]],
) -> Choice:
    """Run a brake of numbered solenoids as it should be and under all conditions."""
    [(task, _)], conditions = _of(number, [(task, unbraked)]), _of(number, conditions)
    landings = tuple(land(other, brake) for other, _ in conditions)
    added = np.array([braked.contact - base.contact for braked, (_, base) in zip(landings, conditions, strict=True)])
    landing = land(task, brake)
    apart = apart_of(task, brake)
    return Choice(np.array([*brake, landing.contact - unbraked.contact, landing.speed, apart, number]), landings, added)


def _soften(task: Task, spacing: float, cost: float, solenoids: Sequence[str] = SOLENOIDS) -> Result:
    """Find the brakes of a stroke; there are none where the unbraked stroke is not completed."""
    unbraked = land(task)
    if not unbraked.stays:
        return Result(
            task, unbraked, nan, np.empty((0, 6)), {(limit, kind): None for limit in LIMITS for kind in KINDS}
        )
    plain = task.run(sample=task.dwell)
    lowest = _lowest_speed(plain.log, task.command, task.command + unbraked.contact)
    brakes = np.concatenate([search(task._replace(solenoids=s), unbraked, spacing, cost) for s in solenoids])
    conditions = conditions_of(task)
    choices = {
        (limit, kind): choice
        for limit, apart in zip(LIMITS, (spacing, 0.0), strict=True)
        for kind, choice in _choose(task, unbraked, brakes, conditions, apart, cost).items()
    }
    return Result(task, unbraked, lowest, brakes, choices)


def soft_landings(
    machine: Machine,
    pressures: Sequence[float],
    temperature: float,
    dwell: float,
    spacing: float = SPACING,
    cost: float = 1e-3,
    report: Callable[[int, int], Any] | None = None,
    solenoids: Sequence[str] = SOLENOIDS,
) -> list[Result]:
    """Find brakes of both strokes over pressure.

    Parameters
    ----------
    machine : Machine
        Machine with the valve.
    pressures : sequence of float
        Pressures of the control air [Pa abs].
    temperature : float
        Temperature of the control air [K].
    dwell : float
        Time from each command edge to the next [s].
    spacing : float
        Shortest time between two edges of a solenoid [s].
    cost : float
        Longest time that a brake may add to a stroke, command edge to contact [s].
    report : function, optional
        Called with the number of strokes that are done and the number of all.
    solenoids : sequence of str
        Ways to brake that are tried, of `apesim.studies.soft_landing.landing.SOLENOIDS`.

    Returns
    -------
    list of Result
        Opening and closing for each pressure; the closing follows an opening with its best brake.

    Examples
    --------
    >>> results = soft_landings(Machine(), [0.12e6], 287.0, dwell=50e-3)  # too little pressure to move the piston
    >>> [(result.task.stroke, result.unbraked.stays, result.best) for result in results]
    [('opening', False, None), ('closing', False, None)]
    """
    results = []
    for pressure in pressures:
        supplied = with_control_air(machine, pressure, temperature)
        before = Task(supplied, dwell, STROKES[0]).before
        for stroke in STROKES:
            result = _soften(Task(supplied, dwell, stroke, before=before), spacing, cost, solenoids)
            results.append(result)
            task, brake = result.braked
            before = task.edges(brake)
            if report:
                report(len(results), 2 * len(pressures))
    return results


def faults_of(
    results: Sequence[Result], spacing: float, cost: float, solenoids: Sequence[str] = SOLENOIDS
) -> list[str]:
    """Write one line for each stroke that is not completed, or that no brake within the spacing softens at that cost.

    Parameters
    ----------
    results : sequence of Result
        Strokes at each pressure.
    spacing : float
        Shortest time between two edges of a solenoid [s].
    cost : float
        Longest added time that is allowed [s].
    solenoids : sequence of str
        Ways to brake that were tried.

    Returns
    -------
    list of str
        Each line names pressure and stroke, and says what is the matter.

    Examples
    --------
    >>> results = soft_landings(Machine(), [0.12e6], 287.0, dwell=50e-3)
    >>> faults_of(results, SPACING, 1e-3)[0]
    '0.0187 MPa gauge, opening: not completed even without a brake; try more pressure or a longer pulse'
    """
    names = {BOTH: "both solenoids at once", ONLY_A: "solenoid A alone", ONLY_B: "solenoid B alone"}
    which = "" if len(solenoids) == len(SOLENOIDS) else " of " + " or ".join(names[name] for name in solenoids)
    lines = []
    for result in results:
        where = f"{result.gauge / 1e6:.3g} MPa gauge, {result.task.stroke}"
        if not result.unbraked.stays:
            lines.append(f"{where}: not completed even without a brake; try more pressure or a longer pulse")
        elif not result.choices["within_spacing", "softest"]:
            tried = f"with edges {1e3 * spacing:.3g} ms apart lowers the seating speed at a cost of {1e3 * cost:.3g} ms"
            lines.append(f"{where}: out of reach: no brake{which} {tried}{_what_would(result, cost)}")
    return lines


def _what_would(result: Result, cost: float) -> str:
    """Say which spacing would do, in words."""
    wide = widest_soft(result.brakes, result.unbraked, cost)
    return f"; {1e3 * wide[0, APART]:.2f} ms apart, one halves it" if len(wide) else ""
