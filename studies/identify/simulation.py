"""Measured runs through the simulator: what it predicts for them, and how far that is from what was measured."""

from math import isnan, nan
from typing import NamedTuple

import numpy as np

from apesim.quantities import Quantity
from apesim.studies.estimation.noise.first_order import FITTED, whiten
from apesim.studies.measured.prediction import predict, run_of, with_value

STEP = 1e-3
"""Step of a finite difference, as a share of a parameter's scale."""

MAX_SIMULATIONS = 600
"""Simulations of each run for each free parameter, after which a fit by least squares ends as it stands."""
KEPT = 16
"""Points whose simulations are kept, so that a fit that goes on from one does not repeat them."""


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


def carries(found, key, run):
    """Whether the value that was found for a key holds in a run.

    A supply that was fitted holds only in runs that state the nominal supply of the fitted runs, or none.

    Parameters
    ----------
    found : apesim.studies.identify.fit.Identified
    key : str
        Key of the machine.
    run : apesim.studies.measured.MeasuredRun

    Returns
    -------
    bool
    """
    nominal = found.nominal.get(key)
    return nominal is None or isnan(own := getattr(run, SUPPLY[key])) or own == nominal


def fitted_for(found, run):
    """The fitted machine with the supply of a run; a fitted supply stays where it holds in the run, see `carries`.

    Parameters
    ----------
    found : apesim.studies.identify.fit.Identified
    run : apesim.studies.measured.MeasuredRun

    Returns
    -------
    apesim.engine.machine.Machine
    """
    machine = run_of(found.machine, run)
    for key in found.nominal:
        if carries(found, key, run):
            machine = with_value(machine, key, found.parameters[key])
    return machine


class Problem:
    """Measured runs against their simulation, as a function of the scaled free parameters.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    runs : sequence of apesim.studies.measured.MeasuredRun
    free : sequence of Free
    report : callable, optional
        Told of the number of simulations after each.
    """

    def __init__(self, machine, runs, free, report=None):
        self.machine, self.runs, self.free, self.report = machine, runs, free, report
        self.evaluations, self.cut = 0, False
        self.scale = np.array([f.scale for f in free])
        self.bounds = np.array([[f.low, f.high] for f in free]).T / self.scale
        self.blocks = [(run, sensor) for run in runs for sensor in FITTED if sensor in run.channels]
        self.sensors = [sensor for _, sensor in self.blocks]
        self._kept = {}

    def machine_at(self, x, run=None):
        """The machine with the parameters, and with the supply of a run, if one is given."""
        machine = self.machine if run is None else run_of(self.machine, run)
        for free, value in zip(self.free, np.asarray(x) * self.scale, strict=True):
            machine = with_value(machine, free.key, float(np.clip(value, free.low, free.high)))
        return machine

    def residuals(self, x):
        """Simulation less measurement, an array for each of `blocks` [SI]; large where a simulation ends early."""
        at, found = np.asarray(x, dtype=float).tobytes(), []
        if at in self._kept:
            return self._kept[at]
        for run in self.runs:
            sensors = [sensor for sensor in FITTED if sensor in run.channels]
            values = predict(self.machine_at(x, run), run, sensors).channels
            self.evaluations += 1
            if self.report:
                self.report(self.evaluations, None)
            for sensor in sensors:
                measured = run.channels[sensor]
                error = values[sensor] - measured
                found.append(np.where(np.isnan(error), 10.0 * np.abs(measured).max(), error))
        self._kept[at] = found
        if len(self._kept) > KEPT:
            del self._kept[next(iter(self._kept))]
        return found

    @property
    def spent(self):
        """Whether there have been as many simulations as a fit may take."""
        return self.evaluations >= MAX_SIMULATIONS * len(self.runs) * len(self.free)

    def forget(self):
        """Simulate anew, even where it has been done."""
        self._kept.clear()

    def objective(self, x):
        """Eq. 11 over all fitted samples of lift [m]; NaN without any."""
        lift = [r for r, sensor in zip(self.residuals(x), self.sensors, strict=True) if sensor == "lift"]
        errors = np.concatenate([[], *lift])
        return float(np.sqrt(np.sum(errors**2)) / (len(errors) - 1)) if len(errors) else nan

    def whitened(self, x, noise):
        """All residuals in standard deviations, the colour of their noise taken off; shape (n,)."""
        blocks = zip(self.residuals(x), self.blocks, strict=True)
        return np.concatenate([whiten(r, run.times, *noise[sensor]) for r, (run, sensor) in blocks])

    def jacobian(self, x, noise, only=None):
        """Sensitivities of `whitened` by forward differences, shape (n, p) or (n, len(only))."""
        base = self.whitened(x, noise)
        columns = []
        for j in range(len(x)) if only is None else only:
            step = min(STEP, 0.25 * (self.bounds[1, j] - self.bounds[0, j]))
            step = step if x[j] + step <= self.bounds[1, j] else -step
            moved = np.array(x)
            moved[j] += step
            columns.append((self.whitened(moved, noise) - base) / step)
        return np.column_stack(columns)
