"""Free parameters of a machine, and the measured runs as a function of them."""

from collections.abc import Callable, Iterable, Sequence
from math import isnan, nan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities import Quantity
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.estimation.residuals import Counter, EndedEarly, WhitenedResiduals
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import run_of, with_value

if TYPE_CHECKING:
    from apesim.studies.identify.fit import Identified

FITTED = "lift", "pressure_a", "pressure_b"
"""Sensors that are fitted."""
MAX_SIMULATIONS = 600
"""Simulations of each run for each free parameter, after which a fit by least squares ends as it stands."""
CHANGE = 0.5
"""Standard deviations that a finite difference aims at: with more, an optimum of few parameters is found less
closely than a hundredth of its interval, as the sum of squares bends where a contact passes a sample."""
AWRY = 10.0
"""Times the largest measured value, that a simulation counts to be off by where it ends early."""


class Free(NamedTuple):
    """A free parameter, SI."""

    key: str
    declaration: Quantity
    low: float
    high: float
    start: float
    scale: float
    local: bool
    """Whether starts stay within a factor of two of the machine's value; else they lie all over the range."""


SUPPLY = {"supply.pressure": "supply", "supply.temperature": "temperature"}
"""What a measured run says of its supply, by key of the machine."""


def holds_in(identified: "Identified", key: str, run: MeasuredRun) -> bool:
    """Whether the value that was found for a key of the machine holds in a run.

    A supply that was fitted holds only in runs that state the nominal supply of the fitted runs, or none.

    >>> from types import SimpleNamespace
    >>> identified = SimpleNamespace(nominal={"supply.pressure": 5e5})
    >>> runs = [SimpleNamespace(supply=pressure) for pressure in (5e5, 6e5)]
    >>> [holds_in(identified, "supply.pressure", run) for run in runs], holds_in(identified, "valve.stroke", runs[0])
    ([True, False], True)
    """
    nominal = identified.nominal.get(key)
    return nominal is None or isnan(own := getattr(run, SUPPLY[key])) or own == nominal


def machine_for(identified: "Identified", run: MeasuredRun) -> Machine:
    """Give the fitted machine with the supply of a run; a fitted supply stays where it holds, see `holds_in`."""
    machine = run_of(identified.machine, run)
    for key in identified.nominal:
        if holds_in(identified, key, run):
            machine = with_value(machine, key, identified.parameters[key])
    return machine


class ReportingCounter(Counter):
    """Number of simulations, reported as they are counted.

    ``report(done, None)`` is called after each simulation, as their number is not known before.
    """

    def __init__(self, report: Callable[[int, None], object] | None = None) -> None:
        super().__init__()
        self._report = report

    def add(self, number: int) -> None:
        """Count more simulations, and report them."""
        super().add(number)
        if self._report:
            self._report(self.number, None)


def free_residuals(
    machine: Machine, runs: Iterable[MeasuredRun], free: Iterable[Free], counter: Counter | None = None
) -> WhitenedResiduals:
    """Make the residuals of the sensors that are fitted, as a function of free parameters.

    Runs without any such sensor are left out; the scaled parameter x of each is its value over its scale.
    """
    kept = []
    for run in runs:
        channels = {sensor: run.channels[sensor] for sensor in FITTED if sensor in run.channels}
        if channels:
            kept.append(run._replace(channels=channels, means={}))
    parameters = [Parameter(f.key, f.scale, f.low / f.scale, f.high / f.scale) for f in free]
    return WhitenedResiduals(machine, kept, parameters, counter=counter, change=CHANGE)


def find_differences(residuals: WhitenedResiduals, x: np.ndarray) -> list[np.ndarray]:
    """Find the simulation less the measurement [SI] of each block (n,); large where a simulation ends early.

    `x` (p,) holds the scaled parameters.

    A lift at rest that was measured 1 and 2 micrometres too high:

    >>> lift = np.array([1e-6, 2e-6])
    >>> run = MeasuredRun("p040", "p040.csv", 5e5, 287.0, 50e-3, "fit", np.array([0.0, 1e-3]), {"lift": lift})
    >>> [difference] = find_differences(free_residuals(Machine(), [run], []), np.zeros(0))
    >>> difference.tolist()
    [-1e-06, -2e-06]
    """
    try:
        predicted = residuals.predicted(x)
    except EndedEarly:
        return [np.full(len(block.values), AWRY * np.abs(block.values).max()) for block in residuals.blocks]
    return [values - block.values for values, block in zip(predicted, residuals.blocks, strict=True)]


def find_objective(residuals: WhitenedResiduals, differences: Sequence[np.ndarray]) -> float:
    """Find [EPV, Eq. 11] over all fitted samples of lift [m]; NaN without any lift.

    `differences` are those of `find_differences`.

    >>> run = MeasuredRun("p040", "p040.csv", 5e5, 287.0, 50e-3, "fit", np.array([0.0, 1e-3]), {"lift": np.zeros(2)})
    >>> find_objective(free_residuals(Machine(), [run], []), [np.array([3e-6, 4e-6])])
    5e-06
    """
    pairs = zip(differences, residuals.blocks, strict=True)
    errors = np.concatenate([[], *(values for values, block in pairs if block.sensor == "lift")])
    return float(np.sqrt(np.sum(errors**2)) / (len(errors) - 1)) if len(errors) else nan


def machine_at(machine: Machine, free: Iterable[Free], x: np.ndarray) -> Machine:
    """Give the machine with free parameters at x (p,), their values over their scales, within their bounds."""
    for parameter, number in zip(free, x, strict=True):
        value = float(np.clip(number * parameter.scale, parameter.low, parameter.high))
        machine = with_value(machine, parameter.key, value)
    return machine
