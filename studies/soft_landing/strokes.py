"""Soft landing, the next step that the paper names (doi 10.1631/jzus.A0820373): how far braking re-switches go."""

from math import nan
from typing import NamedTuple

import numpy as np

from apesim.march import LOG_HEAD, WATCH
from studies.soft_landing.braking import (
    APART,
    STROKES,
    Landing,
    Task,
    apart_of,
    front_of,
    land,
    search,
    sturdiest,
    widest_soft,
)
from studies.valve_map import with_supply
from valve.bench import run_bench
from valve.motion import MET_CLOSED, MET_OPEN, SPEED_EXTREMUM

PRESSURES = "0.4:1.6:0.6 MPa gauge"
SPACING = 1.0 / (2.0 * 120.0)
"""Between two edges of a solenoid that follows 120 Hz, the paper's [s]."""
FACTORS = (0.95, 1.0, 1.05)
"""Of the gauge pressure, for which a brake is tried."""
OFFSETS = (-10.0, 0.0, 10.0)
"""Of the temperature, likewise [K]."""
LIMITS = ("within_spacing", "any_spacing")
"""Whether the edges keep the solenoids' least time."""
KINDS = ("softest", "sturdy")
"""The lowest seating speed as it should be; the lowest at the worst of the conditions."""


class Choice(NamedTuple):
    """A brake, and what becomes of it under other conditions."""

    row: np.ndarray
    """See `studies.soft_landing.braking.BRAKE`."""
    landings: tuple
    """A `Landing` for each pressure factor and temperature offset, row by row."""
    added: np.ndarray
    """Time added to the unbraked stroke of the same condition [s], in the same order."""


class Result(NamedTuple):
    """What was found for a stroke at one pressure."""

    task: Task
    unbraked: Landing
    lowest: float
    """Lowest speed of the unbraked piston between its peak and contact [m/s]: the most that the fluctuation alone could
    give, if the stop stood there."""
    brakes: np.ndarray
    """See `studies.soft_landing.braking.search`."""
    choices: dict
    """`Choice` or None by limit and kind."""

    @property
    def gauge(self):
        """Gauge pressure of the control air [Pa]."""
        return self.task.machine.supply.control()[0] - self.task.machine.ambient.pressure

    @property
    def best(self):
        """The softest brake within the spacing; without one, the softest of any spacing; else None."""
        return next((c for limit in LIMITS if (c := self.choices[limit, "softest"])), None)


def lowest_speed(log, command, contact):
    """Lowest speed after the peak of a stroke, up to its contact [m/s].

    Parameters
    ----------
    log : (l, 3 + n) float array
        Of a bench run, see `apesim.march.march`.
    command, contact : float
        [s]

    Returns
    -------
    float
    """
    told = np.isin(log[:, 1], (MET_CLOSED, MET_OPEN, WATCH + SPEED_EXTREMUM))
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
    sturdy = sturdiest(conditions, brakes, spacing, cost) if len(softest) else None
    return {
        "softest": _choice(task, unbraked, softest[0, :2], conditions) if len(softest) else None,
        "sturdy": _choice(task, unbraked, sturdy, conditions) if sturdy else None,
    }


def _choice(task, unbraked, brake, conditions):
    landings = tuple(land(other, brake) for other, _ in conditions)
    added = np.array([found.contact - base.contact for found, (_, base) in zip(landings, conditions, strict=True)])
    landing = land(task, brake)
    apart = apart_of(task, brake)
    return Choice(np.array([*brake, landing.contact - unbraked.contact, landing.speed, apart]), landings, added)


def soften(task, spacing, cost):
    """Find the brakes of a stroke.

    Parameters
    ----------
    task : Task
    spacing : float
        Between two edges of a solenoid, at least [s].
    cost : float
        Added time allowed [s].

    Returns
    -------
    Result
        Without brakes where the unbraked stroke is not completed.
    """
    unbraked = land(task)
    if not unbraked.stays:
        return Result(
            task, unbraked, nan, np.empty((0, 5)), {(limit, kind): None for limit in LIMITS for kind in KINDS}
        )
    plain = run_bench(task.machine, task.dwell, sample=task.dwell, brakes=task.before)
    lowest = lowest_speed(plain.log, task.command, task.command + unbraked.contact)
    brakes = search(task, unbraked, spacing, cost)
    conditions = conditions_of(task)
    choices = {
        (limit, kind): choice
        for limit, apart in zip(LIMITS, (spacing, 0.0), strict=True)
        for kind, choice in choose(task, unbraked, brakes, conditions, apart, cost).items()
    }
    return Result(task, unbraked, lowest, brakes, choices)


def soft_landings(machine, pressures, temperature, dwell, spacing=SPACING, cost=1e-3, report=None):
    """Brakes of both strokes over pressure.

    Parameters
    ----------
    machine : engine.machine.Machine
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

    Returns
    -------
    list of Result
        Opening and closing for each pressure; the closing follows an opening with its best brake.
    """
    results = []
    for pressure in pressures:
        supplied = with_supply(machine, pressure, temperature)
        before = ()
        for stroke in STROKES:
            result = soften(Task(supplied, dwell, stroke, before), spacing, cost)
            results.append(result)
            before = tuple(result.best.row[:2]) if result.best else ()
            if report:
                report(len(results), 2 * len(pressures))
    return results


def faults_of(results, spacing, cost):
    """One line for each stroke that is not completed, or that no brake within the spacing softens at that cost.

    Returns
    -------
    list of str
    """
    lines = []
    for result in results:
        where = f"{result.gauge / 1e6:.3g} MPa gauge, {result.task.stroke}"
        if not result.unbraked.stays:
            lines.append(f"{where}: not completed even without a brake; try more pressure or a longer pulse")
        elif not result.choices["within_spacing", "softest"]:
            tried = f"with edges {1e3 * spacing:.3g} ms apart lowers the seating speed at a cost of {1e3 * cost:.3g} ms"
            lines.append(f"{where}: out of reach: no brake {tried}{_what_would(result, cost)}")
    return lines


def _what_would(result, cost):
    wide = widest_soft(result.brakes, result.unbraked, cost)
    return f"; {1e3 * wide[0, APART]:.2f} ms apart, one halves it" if len(wide) else ""
