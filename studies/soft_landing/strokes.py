"""Soft landing, the next step that the paper names (doi 10.1631/jzus.A0820373): how far braking re-switches go."""

from math import nan
from typing import NamedTuple

import numpy as np

from apesim.march.adaptive import LOG_HEAD, ZERO_CROSSING
from apesim.studies.operating_conditions import with_supply
from apesim.studies.soft_landing.braking import (
    APART,
    SWITCHED,
    front_of,
    search,
    sturdiest,
    widest_soft,
)
from apesim.studies.soft_landing.landing import BOTH, ONLY_A, ONLY_B, SOLENOIDS, STROKES, Landing, Task, apart_of, land
from apesim.valve.motion import MET_CLOSED, MET_OPEN, SPEED_EXTREMUM

PRESSURES = "0.4:1.6:0.6 MPa gauge"
SPACING = 1.0 / (2.0 * 120.0)
"""Between two edges of a solenoid that follows 120 Hz, the paper's [s]."""
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
    """See `apesim.studies.soft_landing.braking.BRAKE`."""
    landings: tuple
    """A `Landing` for each pressure factor and temperature offset, row by row."""
    added: np.ndarray
    """Time added to the unbraked stroke of the same condition [s], in the same order."""

    @property
    def solenoids(self):
        """Those it switches, one of `apesim.studies.soft_landing.landing.SOLENOIDS`."""
        return SOLENOIDS[int(self.row[SWITCHED])]


class Result(NamedTuple):
    """What was found for a stroke at one pressure."""

    task: Task
    unbraked: Landing
    lowest: float
    """Lowest speed of the unbraked piston between its peak and contact [m/s]: the most that the fluctuation alone could
    give, if the stop stood there."""
    brakes: np.ndarray
    """Brakes of all solenoids tried, see `apesim.studies.soft_landing.braking.search`."""
    choices: dict
    """`Choice` or None by limit and kind."""

    @property
    def gauge(self):
        """Gauge pressure of the control air [Pa]."""
        return self.task.machine.supply.control().pressure - self.task.machine.ambient.pressure

    @property
    def best(self):
        """The softest brake within the spacing; without one, the softest of any spacing; else None."""
        return next((c for limit in LIMITS if (c := self.choices[limit, "softest"])), None)

    @property
    def braked(self):
        """The task with the solenoids of its best brake, and the edges of that; none if there is no brake."""
        best = self.best
        return (self.task._replace(solenoids=best.solenoids), tuple(best.row[:2])) if best else (self.task, ())


def lowest_speed(log, command, contact):
    """Lowest speed after the peak of a stroke, up to its contact [m/s].

    Parameters
    ----------
    log : (l, 3 + n) float array
        Of a bench run, see `apesim.march.adaptive.march`.
    command, contact : float
        [s]

    Returns
    -------
    float
    """
    told = np.isin(log[:, 1], (MET_CLOSED, MET_OPEN, ZERO_CROSSING + SPEED_EXTREMUM))
    speeds = np.abs(log[told & (log[:, 0] >= command) & (log[:, 0] <= contact), LOG_HEAD + 1])
    return float(speeds[speeds.argmax() :].min()) if len(speeds) else nan


def conditions_of(task):
    """A task at every pressure factor and temperature offset, row by row, each with its unbraked landing."""
    pressure, temperature = task.machine.supply.control()
    ambient = task.machine.ambient.pressure
    tasks = [
        task._replace(machine=with_supply(task.machine, ambient + factor * (pressure - ambient), temperature + offset))
        for factor in FACTORS
        for offset in OFFSETS
    ]
    return [(other, land(other)) for other in tasks]


def choose(task, unbraked, brakes, conditions, spacing, cost):
    """The softest and the sturdiest brake for a spacing and a cost; a dict of `Choice` or None by kind."""
    softest = front_of(brakes, spacing, cost)[-1:]
    if not len(softest):
        return dict.fromkeys(KINDS)
    found = []
    for number in np.unique(brakes[:, SWITCHED]).astype(int):
        brake, worst = sturdiest(_of(number, conditions), brakes[brakes[:, SWITCHED] == number], spacing, cost)
        found += [(worst, brake, number)] if brake else []
    _, brake, number = min(found, default=(None, None, None))
    return {
        "softest": _choice(task, unbraked, softest[0, :2], int(softest[0, SWITCHED]), conditions),
        "sturdy": _choice(task, unbraked, brake, number, conditions) if brake else None,
    }


def _of(number, conditions):
    """Conditions whose brake switches the solenoids of that number."""
    return [(task._replace(solenoids=SOLENOIDS[number]), unbraked) for task, unbraked in conditions]


def _choice(task, unbraked, brake, number, conditions):
    [(task, _)], conditions = _of(number, [(task, unbraked)]), _of(number, conditions)
    landings = tuple(land(other, brake) for other, _ in conditions)
    added = np.array([found.contact - base.contact for found, (_, base) in zip(landings, conditions, strict=True)])
    landing = land(task, brake)
    apart = apart_of(task, brake)
    return Choice(np.array([*brake, landing.contact - unbraked.contact, landing.speed, apart, number]), landings, added)


def soften(task, spacing, cost, solenoids=SOLENOIDS):
    """Find the brakes of a stroke.

    Parameters
    ----------
    task : Task
    spacing : float
        Between two edges of a solenoid, at least [s].
    cost : float
        Added time allowed [s].
    solenoids : sequence of str
        Tried to brake with, of `apesim.studies.soft_landing.landing.SOLENOIDS`.

    Returns
    -------
    Result
        Without brakes where the unbraked stroke is not completed.
    """
    unbraked = land(task)
    if not unbraked.stays:
        return Result(
            task, unbraked, nan, np.empty((0, 6)), {(limit, kind): None for limit in LIMITS for kind in KINDS}
        )
    plain = task.run(sample=task.dwell)
    lowest = lowest_speed(plain.log, task.command, task.command + unbraked.contact)
    brakes = np.concatenate([search(task._replace(solenoids=s), unbraked, spacing, cost) for s in solenoids])
    conditions = conditions_of(task)
    choices = {
        (limit, kind): choice
        for limit, apart in zip(LIMITS, (spacing, 0.0), strict=True)
        for kind, choice in choose(task, unbraked, brakes, conditions, apart, cost).items()
    }
    return Result(task, unbraked, lowest, brakes, choices)


def soft_landings(machine, pressures, temperature, dwell, spacing=SPACING, cost=1e-3, report=None, solenoids=SOLENOIDS):
    """Brakes of both strokes over pressure.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    pressures : sequence of float
        [Pa abs]
    temperature : float
        [K]
    dwell : float
        From each command edge to the next [s].
    spacing : float
        Between two edges of a solenoid, at least [s].
    cost : float
        Added time allowed for a stroke, command edge to contact [s].
    report : function, optional
        Called with the numbers of strokes done and in all.
    solenoids : sequence of str
        See `soften`.

    Returns
    -------
    list of Result
        Opening and closing for each pressure; the closing follows an opening with its best brake.
    """
    results = []
    for pressure in pressures:
        supplied = with_supply(machine, pressure, temperature)
        before = Task(supplied, dwell, STROKES[0]).before
        for stroke in STROKES:
            result = soften(Task(supplied, dwell, stroke, before=before), spacing, cost, solenoids)
            results.append(result)
            task, brake = result.braked
            before = task.edges(brake)
            if report:
                report(len(results), 2 * len(pressures))
    return results


def faults_of(results, spacing, cost, solenoids=SOLENOIDS):
    """One line for each stroke that is not completed, or that no brake within the spacing softens at that cost.

    Returns
    -------
    list of str
    """
    told = {BOTH: "both solenoids at once", ONLY_A: "solenoid A alone", ONLY_B: "solenoid B alone"}
    which = "" if len(solenoids) == len(SOLENOIDS) else " of " + " or ".join(told[name] for name in solenoids)
    lines = []
    for result in results:
        where = f"{result.gauge / 1e6:.3g} MPa gauge, {result.task.stroke}"
        if not result.unbraked.stays:
            lines.append(f"{where}: not completed even without a brake; try more pressure or a longer pulse")
        elif not result.choices["within_spacing", "softest"]:
            tried = f"with edges {1e3 * spacing:.3g} ms apart lowers the seating speed at a cost of {1e3 * cost:.3g} ms"
            lines.append(f"{where}: out of reach: no brake{which} {tried}{_what_would(result, cost)}")
    return lines


def _what_would(result, cost):
    wide = widest_soft(result.brakes, result.unbraked, cost)
    return f"; {1e3 * wide[0, APART]:.2f} ms apart, one halves it" if len(wide) else ""
