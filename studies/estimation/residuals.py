"""Measured runs against their simulation, in standard deviations of the noise, as a function of parameters."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from copy import copy
from itertools import accumulate, pairwise
from typing import Any, NamedTuple, Self

import numpy as np

from apesim.engine.machine import Machine
from apesim.march.adaptive import TOLERANCE
from apesim.results import NotConverged
from apesim.studies.estimation.engine_starts import Starts, starts_at
from apesim.studies.estimation.heavy_tails import find_pull
from apesim.studies.estimation.noise.process import Noise, Whitening, noise_for
from apesim.studies.estimation.parameters import Parameter, put
from apesim.studies.estimation.scatter import Scatter, Spread, identify
from apesim.studies.measured import ENGINE, MeasuredRun
from apesim.studies.measured.prediction import Memory, Prediction, predict, run_of

STEP = 0.01
"""Step of the first finite difference, in units of x."""
CHANGE = 1.5
"""Standard deviations that a finite difference aims at: with more, contacts that pass from one sample to the next bend
the data, with less the march's own error is seen."""
STEPS = 1e-4, 0.1
"""Smallest and largest finite difference, in units of x."""
KEPT = 2
"""Points at which marches are remembered."""


ENDED_EARLY = "the simulation does not come to its end"
REMEDY = "simulate its conditions with run_valve or run_engine, which say why, and correct the machine or the run"


class Block(NamedTuple):
    """One channel of one measured run, without its empty cells; a mean over the cycle is a block of one sample."""

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

    @property
    def angles(self) -> np.ndarray:
        """Crank angles of the samples of an engine's trace, (n,) [rad]."""
        values = self.run.channels.get(self.sensor)
        return self.run.angles if values is None else self.run.angles[~np.isnan(values)]


class EndedEarly(NotConverged):
    """A simulation of a measured run that did not come to its end.

    `what` names the run, `wrong` says how it ended, `right` what may help; there is no `result`.
    """

    def __init__(self, what: str, wrong: str = ENDED_EARLY, right: str = REMEDY, result: None = None) -> None:
        super().__init__(what, wrong, right, result)


def unless_ended(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function, and return None where a simulation in it does not come to its end (`EndedEarly`).

    >>> def simulate(speed):
    ...     if speed > 100.0:
    ...         raise EndedEarly("no periodic state")
    ...     return speed
    >>> unless_ended(simulate, 50.0), unless_ended(simulate, 500.0)
    (50.0, None)
    """
    try:
        return function(*arguments)
    except EndedEarly:
        return None


def blocks_of(runs: Iterable[MeasuredRun]) -> list[Block]:
    """The blocks of measured runs: one for each channel, and one of a single sample for each mean.

    They come run after run, the channels of a run before its means.

    >>> times = np.arange(0.0, 0.1, 1e-3)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": 0.0 * times})
    >>> [(block.sensor, len(block.values), block.interval) for block in blocks_of([run])]
    [('lift', 100, 0.001)]
    """
    found: list[Block] = []
    for number, run in enumerate(runs):
        for sensor, values in run.channels.items():
            is_measured = ~np.isnan(values)
            is_slower = 0 < 2 * is_measured.sum() < len(values)  # sampled more slowly than its rows come
            times = run.times[is_measured] if is_slower else run.times
            interval = float(np.round(np.median(np.diff(times)), 9))
            found.append(Block(number, run, sensor, run.times[is_measured], values[is_measured], interval))
        for sensor, value in run.means.items():
            found.append(Block(number, run, sensor, np.zeros(1), np.array([value]), 0.0))
    return found


class Counter:
    """Number of simulations of one run each."""

    def __init__(self) -> None:
        self.number = 0

    def add(self, number: int) -> None:
        """Count more simulations."""
        self.number += number


def first_steps(number: int) -> np.ndarray:
    """Give the steps of the first finite differences of some parameters, (number,) in units of x."""
    return np.full(number, STEP)


class WhitenedResiduals:
    """Residuals of measured runs as a function of a machine's parameters, whitened, with the pulls of the priors.

    Nothing that it gives depends on what was asked of it before: simulations are remembered at `KEPT` points alone, and
    counted in `counter` (None: one of its own). `noise` is by sensor and sampling interval [s], see
    `apesim.studies.estimation.noise.estimation.noise_of`; without it there are predictions alone. `starts` are those of
    an engine's runs (None: of the machine as it is), `change` is the change of the data that a finite difference aims
    at [standard deviations], and `scatter` what the samples of a run have in common, another one in each run, whitened
    like other noise.
    """

    def __init__(
        self,
        machine: Machine,
        runs: Iterable[MeasuredRun],
        parameters: Iterable[Parameter],
        noise: dict[str, dict[float, Noise]] | None = None,
        *,
        starts: Starts | None = None,
        counter: Counter | None = None,
        change: float = CHANGE,
        scatter: Scatter | None = None,
    ) -> None:
        self.machine, self.runs, self.parameters = machine, list(runs), list(parameters)
        self.blocks = blocks_of(self.runs)
        self.noise = noise or {}
        self.low = np.array([p.low for p in self.parameters])
        self.high = np.array([p.high for p in self.parameters])
        self.known = np.array([p.prior for p in self.parameters], dtype=bool)
        self.starts = starts or starts_at(machine, self.runs)
        self.counter = counter or Counter()
        self.change, self.scatter = change, scatter
        # Runs are identified by what was measured: once, and not in each of thousands of evaluations.
        self._scattering = list(zip(map(identify, self.runs), self.run_slices(), strict=True)) if scatter else []
        self._moves, self._taken = self._list_moves()
        self._whitenings: list[Whitening] = []
        self._own = [[number for number, p in enumerate(self.parameters) if p.is_of(run)] for run in self.runs]
        self._marched = [[number for number in own if self.parameters[number].is_marched] for own in self._own]
        self._memory: dict[tuple[int, bytes, float], Memory] = {}

    def _list_moves(self) -> tuple[list[np.ndarray], np.ndarray]:
        """How far its own scatter has moved the parameters of each run, and what that does to its white samples."""
        if self.scatter is None:
            return [], np.zeros(())
        keys = [p.key for p in self.parameters]
        places = [keys.index(key) for key in self.scatter.keys]
        moves, taken = [], []
        for run, rows in self._scattering:
            own, parts = self.scatter.find_move(run, rows.stop - rows.start)
            moves.append(np.zeros(len(keys)))
            moves[-1][places] = own
            taken.append(parts)
        return moves, np.concatenate([np.zeros(0), *taken])

    def __getstate__(self) -> dict[str, Any]:
        """State for another process, where what was marched is of no use."""
        return self.__dict__ | {"_memory": {}}

    @property
    def simulations(self) -> int:
        """Number of simulations that its counter has counted."""
        return self.counter.number

    def with_parameters(self, parameters: Iterable[Parameter]) -> "WhitenedResiduals":
        """Take other parameters on the same runs, with the same starts and a new counter."""
        other = WhitenedResiduals(
            self.machine,
            self.runs,
            parameters,
            self.noise,
            starts=self.starts,
            change=self.change,
            scatter=self.scatter,
        )
        if [p for p in other.parameters if p.is_marched] == [p for p in self.parameters if p.is_marched]:
            other._memory = dict(self._memory)
        return other

    def with_noise(self, noise: dict[str, dict[float, Noise]]) -> Self:
        """Take another noise, by sensor and sampling interval [s], with the same runs, starts and counter."""
        other = self._derived(self.runs, noise, self.starts, self.counter, self.scatter)
        other._memory = dict(self._memory)
        return other

    def with_runs(self, runs: Iterable[MeasuredRun], starts: Starts | None = None) -> Self:
        """Take other runs for the same parameters, with a new counter; `starts` None: the machine's own."""
        return self._derived(runs, self.noise, starts, None, self.scatter)

    def restarted_at(self, x: np.ndarray) -> Self:
        """Fix the starts of an engine's runs anew, at parameters x (p,), for all that is simulated near them.

        The counter stays; on a valve's bench, which starts from rest, the residuals are the same to the bit.
        """
        starts = starts_at(self.machine, self.runs, self.parameters, x)
        return self._derived(self.runs, self.noise, starts, self.counter, self.scatter)

    def _derived(
        self,
        runs: Iterable[MeasuredRun],
        noise: dict[str, dict[float, Noise]],
        starts: Starts | None,
        counter: Counter | None,
        scatter: Scatter | None,
    ) -> Self:
        """Copy of these residuals, of the same class and with the same parameters."""
        other = copy(self)
        WhitenedResiduals.__init__(
            other,
            self.machine,
            runs,
            self.parameters,
            noise,
            starts=starts,
            counter=counter,
            change=self.change,
            scatter=scatter,
        )
        return other

    def with_scatter(self, scatter: Scatter | None) -> Self:
        """Take another scatter of the same runs, or None, with the same starts and counter."""
        other = self._derived(self.runs, self.noise, self.starts, self.counter, scatter)
        other._memory = dict(self._memory)
        return other

    def change_scatter(self, whitened: np.ndarray, scatter: Scatter) -> np.ndarray:
        """Whiten sensitivities by another scatter than the one of these residuals.

        `whitened`, (n, k) [standard deviations], has the rows of all blocks, whitened by the own scatter if there is
        one; the result has the same shape.
        """
        changed = []
        for run, rows in self._scattering or zip(map(identify, self.runs), self.run_slices(), strict=True):
            part = self.scatter.colour(run, whitened[rows]) if self.scatter else whitened[rows]
            changed.append(scatter.whiten(run, part))
        return np.concatenate(changed)

    def list_spreads(self) -> list[tuple[Spread, slice]]:
        """List how each run varies by scatter, with its rows; empty where nothing scatters."""
        spreads = self.scatter.spreads if self.scatter else {}
        return [(spreads[run], rows) for run, rows in self._scattering if run in spreads]

    def find_relief(self, errors: np.ndarray) -> float:
        """Find by how much all runs together are more likely than if their scatter were normal.

        `errors`, (n,), are whitened residuals without the pulls of the priors [standard deviations]; the result is the
        fall of twice the negative log likelihood, 0 where nothing scatters.
        """
        return sum((spread.find_relief(errors[rows]) for spread, rows in self.list_spreads()), 0.0)

    def by_block(self, whole: np.ndarray) -> list[np.ndarray]:
        """Split an array over all blocks, (n,) residuals or (n + p,) with the pulls behind, into each block's part."""
        return [whole[rows] for rows in self.block_slices()]

    def block_slices(self) -> list[slice]:
        """Find the place of each block in an array over all of them."""
        ends = accumulate((len(block.values) for block in self.blocks), initial=0)
        return [slice(*pair) for pair in pairwise(ends)]

    def run_slices(self) -> list[slice]:
        """Find the place of each run, with all its channels, in an array over all blocks."""
        lengths = [0] * len(self.runs)
        for block in self.blocks:
            lengths[block.number] += len(block.values)
        return [slice(*pair) for pair in pairwise(accumulate(lengths, initial=0))]

    def _predictions(self, x: np.ndarray, tolerance: float = TOLERANCE) -> Iterator[tuple[MeasuredRun, Prediction]]:
        """Runs and their predictions."""
        x = np.asarray(x, dtype=float)
        for number, run in enumerate(self.runs):
            self.counter.add(1)
            memory = self._remembered(number, self._key(number, x), tolerance)
            machine = self._machine(number, x)
            prediction = predict(machine, run, None, self.starts.near(number, machine), tolerance, memory)
            if prediction.failed:
                raise EndedEarly(run.name)
            yield run, prediction

    def _machine(self, number: int, x: np.ndarray) -> Machine:
        """Machine of a run."""
        own, x = self._own[number], self._moved(number, x)
        return put(run_of(self.machine, self.runs[number]), [self.parameters[j] for j in own], x[own])

    def _moved(self, number: int, x: np.ndarray) -> np.ndarray:
        """Parameters of a run, where its own scatter has moved them."""
        if not self._moves:
            return x
        return np.clip(x + self._moves[number], self.low, self.high)

    def _key(self, number: int, x: np.ndarray) -> bytes:
        """What the march of a run depends on."""
        return self._moved(number, x)[self._marched[number]].tobytes()

    def _around(self, x: np.ndarray) -> Self:
        """These residuals, an engine's runs marched from their periodic states at x: the way from there is short."""
        if all(run.bench != ENGINE for run in self.runs):
            return self
        known = [prediction.start for _, prediction in self._predictions(x)]
        other = copy(self)
        other.starts = self.starts.around([self._machine(number, x) for number in range(len(known))], known)
        # What is marched from other starts has other last digits, so each keeps its own, but for what both have at x.
        at_x = [(number, self._key(number, x), TOLERANCE) for number in range(len(self.runs))]
        other._memory = {key: self._memory[key] for key in at_x}
        return other

    def _remembered(self, number: int, marched: bytes, tolerance: float) -> Memory:
        """What was marched at a point, for the parameters that only the sensors know."""
        key = number, marched, tolerance
        memory = self._memory.pop(key, {})
        self._memory[key] = memory
        while len(self._memory) > KEPT * len(self.runs):
            del self._memory[next(iter(self._memory))]
        return memory

    def predicted(self, x: np.ndarray, tolerance: float = TOLERANCE) -> list[np.ndarray]:
        """Predict what the sensors would show of each block without noise, (m,) each [SI], at parameters x (p,).

        `tolerance` is that of the march. Raises EndedEarly where a simulation does not come to its end.
        """
        found = []
        for run, prediction in self._predictions(x, tolerance):
            found += [prediction.channels[sensor][~np.isnan(values)] for sensor, values in run.channels.items()]
            found += [np.array([prediction.means[sensor]]) for sensor in run.means]
        return found

    def marks(self, x: np.ndarray) -> list[dict[str, float]]:
        """Find the instants that divide the stroke or cycle of each run, at parameters x (p,).

        See `apesim.studies.measured.prediction.Prediction`. Raises EndedEarly where a simulation does not come to its
        end.
        """
        return [prediction.marks for _, prediction in self._predictions(x)]

    def whiten(self, arrays: Sequence[np.ndarray]) -> np.ndarray:
        """Whiten the noise of arrays, one for each block, and put them one below the other.

        They are (m,) or (m, k) [SI], the result (n, k) [standard deviations].
        """
        if not self._whitenings:
            self._whitenings = [Whitening(noise_for(self.noise, block), block.times) for block in self.blocks]
        whole = np.concatenate(
            [
                whitening.whiten(array.reshape(len(array), -1))
                for whitening, array in zip(self._whitenings, arrays, strict=True)
            ]
        )
        if self.scatter is None:
            return whole
        return np.concatenate([self.scatter.whiten(run, whole[rows]) for run, rows in self._scattering])

    def at(self, x: np.ndarray) -> np.ndarray:
        """Find the residuals: prediction less measurement, whitened, and behind them the pull of each prior.

        x is (p,), the residuals are (n + p,) [standard deviations]. Raises EndedEarly where a simulation does not come
        to its end.

        >>> from apesim.studies.estimation.noise.process import white
        >>> times = np.array([0.0, 1e-3])
        >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": np.array([6e-5, -3e-5])})
        >>> known = Parameter("valve.moving_mass", 0.01, -5.0, 5.0, 0.1, shifts=True, prior=True)
        >>> residuals = WhitenedResiduals(Machine(), [run], [known], {"lift": {1e-3: white(3e-5, "stated")}})
        >>> residuals.at(np.array([0.5])).round(2).tolist()  # two samples at rest, and the pull of the prior
        [-2.0, 1.0, 0.49]
        """
        differences = [v - b.values for b, v in zip(self.blocks, self.predicted(x), strict=True)]
        return np.append(self.whiten(differences)[:, 0] - self._taken, self.pulls(x))

    def pulls(self, x: np.ndarray) -> np.ndarray:
        """Find the pull of each parameter's prior, (p,) [standard deviations], see `find_pull`: 0 without one."""
        return np.where(self.known, find_pull(x), 0.0)

    def column(self, x: np.ndarray, j: int, step: float, residuals: np.ndarray | None = None) -> np.ndarray:
        """Find the sensitivity of the residuals, (n + p,), to parameter `j`, by a difference of a given step in x.

        `residuals` are those at x, (n + p,); None: they are found. Raises EndedEarly where a simulation does not come
        to its end.
        """
        moved = np.array(x)
        moved[j] += step
        return (self.at(moved) - (self.at(x) if residuals is None else residuals)) / step

    def jacobian(
        self,
        x: np.ndarray,
        residuals: np.ndarray,
        steps: np.ndarray | None = None,
        only: Sequence[int] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Find the sensitivities of the residuals to the parameters, by one-sided differences.

        `residuals` are those at x (p,), see `at`; `steps`, (p,) in units of x, are `STEP` if left out, and `only` are
        the places of the parameters to take (None: all). Gives the jacobian, (n + p, p or len(only)), and the steps
        with which the next differences change the data by ``change``; of parameters left out they stay. Raises
        EndedEarly where a simulation does not come to its end on either side of x.
        """
        steps = first_steps(len(x)) if steps is None else np.array(steps)
        columns, near = {}, self._around(x)
        places = list(range(len(x)) if only is None else only)
        # What the sensors alone know comes first, as long as the march at x is remembered.
        for j in sorted(places, key=lambda place: self.parameters[place].is_marched):
            step = steps[j] if x[j] + steps[j] <= self.high[j] else -steps[j]
            try:
                columns[j] = near.column(x, j, step, residuals)
            except EndedEarly:
                columns[j] = near.column(x, j, -step, residuals)
            steps[j] = np.clip(self.change / max(float(np.linalg.norm(columns[j])), 1e-9), *STEPS)
        return np.column_stack([columns[j] for j in places]), steps
