"""Measured runs against their simulation, in standard deviations of the noise, as a function of parameters."""

from collections.abc import Callable, Iterable
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.effects import library_of
from apesim.march.adaptive import TOLERANCE
from apesim.studies.estimation.noise.process import noise_for, whitened
from apesim.studies.estimation.parameters import put
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import predict, run_of, start_of

STEP = 0.01
"""Step of the first finite difference, in units of x."""
CHANGE = 1.5
"""Standard deviations that a finite difference aims at: with more, contacts that pass from one sample to the next bend
the data, with less the march's own error is seen."""
STEPS = 1e-4, 0.1
"""Smallest and largest finite difference, in units of x."""


KEPT = 2
"""Points at which marches are remembered."""


class Block(NamedTuple):
    """One channel of one measured run; a mean over the cycle is a block of one sample."""

    number: int
    """Number of the run, from 0."""
    run: MeasuredRun
    sensor: str
    """Name of the channel or of the mean."""
    times: np.ndarray
    """Times since the solenoids were energised, (n,) [s]; 0 for a mean."""
    values: np.ndarray
    """Measured values, (n,) [SI]."""
    interval: float
    """Median interval between two samples [s]; 0 for a mean."""


class EndedEarly(ArithmeticError):
    """A simulation that did not come to its end."""


def unless_ended(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function, and return None where a simulation in it does not come to its end.

    Parameters
    ----------
    function : callable
    *arguments : object
        What it is called with.

    Returns
    -------
    object or None
        What the function returns; None where it raises `EndedEarly`.
    """
    try:
        return function(*arguments)
    except EndedEarly:
        return None


def volumes_of(machine):
    """Names of the effects that add volumes, and with them states."""
    effects = machine.effects
    volumes = [effect for effect in library_of(effects) if effect.volume]
    return tuple(effect.name for effect in volumes if effect.is_on(getattr(effects, effect.name)))


def blocks_of(runs: Iterable[MeasuredRun]) -> list[Block]:
    """The blocks of measured runs: one for each channel, and one of a single sample for each mean.

    Parameters
    ----------
    runs : iterable of apesim.studies.measured.MeasuredRun

    Returns
    -------
    list of Block
        Run after run, the channels of a run before its means.
    """
    found: list[Block] = []
    for number, run in enumerate(runs):
        for sensor, values in run.channels.items():
            interval = float(np.round(np.median(np.diff(run.times)), 9))
            found.append(Block(number, run, sensor, run.times, values, interval))
        for sensor, value in run.means.items():
            found.append(Block(number, run, sensor, np.zeros(1), np.array([value]), 0.0))
    return found


class WhitenedResiduals:
    """Residuals of measured runs as a function of parameters of a machine, whitened, with the pulls of the priors.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    runs : sequence of apesim.studies.measured.MeasuredRun
    parameters : sequence of Parameter
    noise : dict
        See `apesim.studies.estimation.noise.estimation.noise_of`.
    """

    def __init__(self, machine, runs, parameters, noise=None):
        self.machine, self.runs, self.parameters = machine, list(runs), list(parameters)
        self.blocks = blocks_of(runs)
        self.noise = noise
        self.low = np.array([p.low for p in self.parameters])
        self.high = np.array([p.high for p in self.parameters])
        self.known = np.array([p.prior for p in self.parameters], dtype=bool)
        self.starts = {}
        """Periodic states from which those of little different machines are near, by number of an engine's run, and
        by the volumes that are among its states."""
        self.marched = np.array([p.is_marched for p in self.parameters], dtype=bool)
        self._memory = {}
        self.steps = np.full(len(self.parameters), STEP)
        self.simulations = 0

    def __getstate__(self):
        """For another process, where what was marched is of no use."""
        return self.__dict__ | {"_memory": {}}

    def with_parameters(self, parameters):
        """Return these runs with other parameters; parameters that stay keep their steps."""
        other = WhitenedResiduals(self.machine, self.runs, parameters, self.noise)
        other.go_on_from(self)
        return other

    def with_noise(self, noise):
        """Return these residuals with another noise; what was marched and the steps stay."""
        other = WhitenedResiduals(self.machine, self.runs, self.parameters, noise)
        other.go_on_from(self)
        other._memory, other.simulations = dict(self._memory), self.simulations
        return other

    def go_on_from(self, other):
        """Start from the periodic states of another, with its steps of the parameters that are the same."""
        self.starts = dict(other.starts)
        known = dict(zip((p.key for p in other.parameters), other.steps, strict=True))
        self.steps = np.array([known.get(p.key, STEP) for p in self.parameters])

    def with_runs(self, runs):
        """Return these parameters on other runs."""
        return WhitenedResiduals(self.machine, runs, self.parameters, self.noise)

    def by_block(self, whole):
        """What stands of each block in an array over all of them: residuals, without or with the pulls behind them.

        Returns
        -------
        list of (n,) float array
        """
        return [whole[rows] for rows in self.block_slices()]

    def block_slices(self):
        """Place of each block in such an array, a slice each."""
        ends = accumulate((len(block.values) for block in self.blocks), initial=0)
        return [slice(*pair) for pair in pairwise(ends)]

    def _predictions(self, x, tolerance=TOLERANCE):
        marched = np.asarray(x, dtype=float)[self.marched].tobytes()
        for number, run in enumerate(self.runs):
            self.simulations += 1
            nominal = run_of(self.machine, run)
            memory = self._remembered(number, marched, tolerance)
            machine = put(nominal, self.parameters, x)
            start = number, volumes_of(machine)
            if start not in self.starts:
                self.starts[start] = start_of(machine, run)
            prediction = predict(machine, run, None, self.starts[start], tolerance, memory)
            if prediction.failed:
                raise EndedEarly(f"{run.name}: the simulation does not come to its end")
            self.starts[start] = prediction.start or self.starts[start]
            yield run, prediction

    def start_at(self, x):
        """Find the periodic states anew at a point, for all that begins near it."""
        self.starts.clear()
        self.at(x)

    def _remembered(self, *key):
        """What was marched at a point, for the parameters that only the sensors know."""
        memory = self._memory.pop(key, {})
        self._memory[key] = memory
        while len(self._memory) > KEPT * len(self.runs):
            del self._memory[next(iter(self._memory))]
        return memory

    def predicted(self, x, tolerance=TOLERANCE):
        """What the sensors would show of each block without noise.

        Parameters
        ----------
        x : (p,) float array
        tolerance : float
            Tolerance of the march.

        Returns
        -------
        list of (n,) float array
            One for each block [SI].

        Raises
        ------
        EndedEarly
            A simulation does not come to its end.
        """
        found = []
        for run, prediction in self._predictions(x, tolerance):
            found += [prediction.channels[sensor] for sensor in run.channels]
            found += [np.array([prediction.means[sensor]]) for sensor in run.means]
        return found

    def marks(self, x):
        """Instants that divide the stroke or cycle of each run, see `apesim.studies.measured.prediction`."""
        return [prediction.marks for _, prediction in self._predictions(x)]

    def whiten(self, arrays):
        """Blocks one below the other, the noise made white; shape (n,) or (n, k)."""
        return np.concatenate(
            [
                whitened(noise_for(self.noise, block), a.reshape(len(a), -1), block.times)
                for block, a in zip(self.blocks, arrays, strict=True)
            ]
        )

    def at(self, x: np.ndarray) -> np.ndarray:
        """Residuals: prediction less measurement, whitened, and behind them the pull of each prior.

        Parameters
        ----------
        x : (p,) float array

        Returns
        -------
        (n + p,) float array
            [standard deviations]

        Raises
        ------
        EndedEarly
            A simulation does not come to its end.
        """
        left = [v - b.values for b, v in zip(self.blocks, self.predicted(x), strict=True)]
        return np.append(self.whiten(left)[:, 0], self.pulls(x))

    def pulls(self, x: np.ndarray) -> np.ndarray:
        """Pull of each parameter's prior: x where it has one, else 0.

        Parameters
        ----------
        x : (p,) float array

        Returns
        -------
        (p,) float array
            [standard deviations]
        """
        return np.where(self.known, x, 0.0)

    def column(self, x, j, step, errors=None):
        """Sensitivity of the residuals to one parameter, by a difference of a given step."""
        moved = np.array(x)
        moved[j] += step
        return (self.at(moved) - (self.at(x) if errors is None else errors)) / step

    def jacobian(self, x, errors, only=None):
        """Sensitivities of the residuals to the parameters, by one-sided differences.

        The step of each parameter is then adapted, so that the next difference changes the data by `CHANGE`.

        Parameters
        ----------
        x : (p,) float array
        errors : (n + p,) float array
            Residuals at x, see `at`.
        only : sequence of int, optional
            Places of the parameters; without it, all.

        Returns
        -------
        (n + p, p) or (n + p, len(only)) float array

        Raises
        ------
        EndedEarly
            A simulation does not come to its end on either side of x.
        """
        columns = []
        for j in range(len(x)) if only is None else only:
            step = self.steps[j] if x[j] + self.steps[j] <= self.high[j] else -self.steps[j]
            try:
                column = self.column(x, j, step, errors)
            except EndedEarly:
                column = self.column(x, j, -step, errors)
            self.steps[j] = np.clip(CHANGE / max(np.linalg.norm(column), 1e-9), *STEPS)
            columns.append(column)
        return np.column_stack(columns)
