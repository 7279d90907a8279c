"""Measured runs against their simulation, in standard deviations of the noise, as a function of parameters."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from copy import copy
from itertools import accumulate, pairwise
from typing import Any, NamedTuple, Self

import numpy as np

from apesim.engine.machine import Machine
from apesim.march.adaptive import TOLERANCE
from apesim.results import NotConverged
from apesim.studies.estimation.heavy_tails import find_pull
from apesim.studies.estimation.noise.process import Noise, Whitening, noise_for
from apesim.studies.estimation.parameters import Parameter, put
from apesim.studies.estimation.scatter import Scatter, Spread, identify
from apesim.studies.estimation.starts import Starts, starts_at
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

    Parameters
    ----------
    what : str
        Run that was simulated.
    wrong : str
        How it ended.
    right : str
        What may help.
    result : None
        There is none.
    """

    def __init__(self, what: str, wrong: str = ENDED_EARLY, right: str = REMEDY, result: None = None) -> None:
        super().__init__(what, wrong, right, result)


def unless_ended(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function, and return None where a simulation in it does not come to its end.

    Parameters
    ----------
    function : callable
    *arguments : object
        Arguments that it is called with.

    Returns
    -------
    object or None
        Result of the function; None where it raises `EndedEarly`.

    Examples
    --------
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

    Parameters
    ----------
    runs : iterable of apesim.studies.measured.MeasuredRun

    Returns
    -------
    list of Block
        Run after run, the channels of a run before its means.

    Examples
    --------
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
    """Number of simulations of one run each.

    Examples
    --------
    >>> counter = Counter()
    >>> counter.add(3)
    >>> counter.number
    3
    """

    def __init__(self) -> None:
        self.number = 0

    def add(self, number: int) -> None:
        """Count more simulations.

        Parameters
        ----------
        number : int

        Examples
        --------
        >>> counter = Counter()
        >>> counter.add(2)
        >>> counter.number
        2
        """
        self.number += number


def first_steps(number: int) -> np.ndarray:
    """Give the steps of the first finite differences of some parameters.

    Parameters
    ----------
    number : int
        Number of parameters.

    Returns
    -------
    (number,) float array
        In units of x.

    Examples
    --------
    >>> first_steps(2).tolist()
    [0.01, 0.01]
    """
    return np.full(number, STEP)


class WhitenedResiduals:
    """Residuals of measured runs as a function of parameters of a machine, whitened, with the pulls of the priors.

    Nothing that it gives depends on what was asked of it before: simulations are remembered at `KEPT` points alone, and
    counted in the counter that was handed in.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    runs : sequence of apesim.studies.measured.MeasuredRun
    parameters : sequence of Parameter
    noise : dict, optional
        Noise by sensor and sampling interval, see `apesim.studies.estimation.noise.estimation.noise_of`; without it
        there are predictions alone.
    starts : apesim.studies.estimation.starts.Starts, optional
        Starts of an engine's runs; without them those of the machine as it is.
    counter : Counter, optional
        Counter of the simulations; without it one of its own.
    change : float
        Change of the data that a finite difference aims at [standard deviations].
    scatter : apesim.studies.estimation.scatter.Scatter, optional
        What the samples of a run have in common, and is another one in each run; it is whitened like other noise.
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
        """Take other parameters on the same runs, with the same starts and a new counter.

        Parameters
        ----------
        parameters : iterable of Parameter

        Returns
        -------
        WhitenedResiduals

        Examples
        --------
        >>> residuals = WhitenedResiduals(Machine(), [], [])
        >>> mass = Parameter("valve.moving_mass", 0.1, 0.1, 10.0)
        >>> [parameter.key for parameter in residuals.with_parameters([mass]).parameters]
        ['valve.moving_mass']
        """
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
        """Take another noise on the same runs, with the same starts and counter.

        Parameters
        ----------
        noise : dict
            Noise by sensor and sampling interval.

        Returns
        -------
        WhitenedResiduals

        Examples
        --------
        >>> from apesim.studies.estimation.noise.process import white
        >>> residuals = WhitenedResiduals(Machine(), [], []).with_noise({"lift": {5e-5: white(3e-5, "stated")}})
        >>> residuals.noise["lift"][5e-5].deviation
        3e-05
        """
        other = self._derived(self.runs, noise, self.starts, self.counter, self.scatter)
        other._memory = dict(self._memory)
        return other

    def with_runs(self, runs: Iterable[MeasuredRun], starts: Starts | None = None) -> Self:
        """Take other runs for the same parameters, with a new counter.

        Parameters
        ----------
        runs : iterable of apesim.studies.measured.MeasuredRun
        starts : apesim.studies.estimation.starts.Starts, optional
            Starts of these runs; without them those of the machine as it is.

        Returns
        -------
        WhitenedResiduals

        Examples
        --------
        >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", np.arange(0.0, 0.1, 1e-3), {})
        >>> [run.name for run in WhitenedResiduals(Machine(), [], []).with_runs([run]).runs]
        ['p040']
        """
        return self._derived(runs, self.noise, starts, None, self.scatter)

    def restarted_at(self, x: np.ndarray) -> Self:
        """Fix the starts of an engine's runs anew, at given parameters, for all that is simulated near them.

        Parameters
        ----------
        x : (p,) float array

        Returns
        -------
        WhitenedResiduals
            Residuals with the same counter; on a valve's bench, which starts from rest, they are the same to the bit.

        Examples
        --------
        >>> residuals = WhitenedResiduals(Machine(), [], [])
        >>> residuals.restarted_at(np.zeros(0)) is residuals
        False
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
        """Take another scatter of the same runs, with the same starts and counter.

        Parameters
        ----------
        scatter : apesim.studies.estimation.scatter.Scatter or None

        Returns
        -------
        WhitenedResiduals

        Examples
        --------
        >>> WhitenedResiduals(Machine(), [], []).with_scatter(None).scatter is None
        True
        """
        other = self._derived(self.runs, self.noise, self.starts, self.counter, scatter)
        other._memory = dict(self._memory)
        return other

    def change_scatter(self, whitened: np.ndarray, scatter: Scatter) -> np.ndarray:
        """Whiten sensitivities by another scatter than the one of these residuals.

        Parameters
        ----------
        whitened : (n, k) float array
            Rows of all blocks, whitened by the own scatter if there is one [standard deviations].
        scatter : apesim.studies.estimation.scatter.Scatter

        Returns
        -------
        (n, k) float array
            The same, whitened by the other one.

        Examples
        --------
        >>> from apesim.studies.gap.example_bench import explain_example
        >>> model = explain_example().best
        >>> rows = model.fitted.jacobian[: len(model.fitted.data_residuals)]
        >>> np.array_equal(model.residuals.change_scatter(rows, Scatter((), (), 0, {})), rows)
        True
        """
        changed = []
        for run, rows in self._scattering or zip(map(identify, self.runs), self.run_slices(), strict=True):
            part = self.scatter.colour(run, whitened[rows]) if self.scatter else whitened[rows]
            changed.append(scatter.whiten(run, part))
        return np.concatenate(changed)

    def list_spreads(self) -> list[tuple[Spread, slice]]:
        """List how each run varies by scatter, with its rows.

        Returns
        -------
        list of (apesim.studies.estimation.scatter.Spread, slice)
            Empty where nothing scatters.

        Examples
        --------
        >>> WhitenedResiduals(Machine(), [], []).list_spreads()
        []
        """
        spreads = self.scatter.spreads if self.scatter else {}
        return [(spreads[run], rows) for run, rows in self._scattering if run in spreads]

    def find_relief(self, errors: np.ndarray) -> float:
        """Find by how much all runs together are more likely than if their scatter were normal.

        Parameters
        ----------
        errors : (n,) float array
            Whitened residuals without the pulls of the priors [standard deviations].

        Returns
        -------
        float
            Fall of twice the negative log likelihood; 0 where nothing scatters.

        Examples
        --------
        >>> from apesim.studies.gap.example_bench import explain_example
        >>> model = explain_example().best
        >>> model.residuals.find_relief(model.fitted.data_residuals)  # no run is repeated
        0.0
        """
        return sum((spread.find_relief(errors[rows]) for spread, rows in self.list_spreads()), 0.0)

    def by_block(self, whole: np.ndarray) -> list[np.ndarray]:
        """Split an array over all blocks: residuals, without or with the pulls behind them.

        Parameters
        ----------
        whole : (n,) or (n + p,) float array

        Returns
        -------
        list of (m,) float array
            Part of each block.

        Examples
        --------
        >>> times = np.array([0.0, 1e-3, 2e-3])
        >>> runs = [MeasuredRun(name, "", 0.5e6, 287.0, 1e-3, "fit", times, {"lift": 0.0 * times}) for name in "ab"]
        >>> [part.tolist() for part in WhitenedResiduals(Machine(), runs, []).by_block(np.arange(6.0))]
        [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]
        """
        return [whole[rows] for rows in self.block_slices()]

    def block_slices(self) -> list[slice]:
        """Find the place of each block in an array over all of them.

        Returns
        -------
        list of slice

        Examples
        --------
        >>> times = np.array([0.0, 1e-3, 2e-3])
        >>> runs = [MeasuredRun(name, "", 0.5e6, 287.0, 1e-3, "fit", times, {"lift": 0.0 * times}) for name in "ab"]
        >>> [(rows.start, rows.stop) for rows in WhitenedResiduals(Machine(), runs, []).block_slices()]
        [(0, 3), (3, 6)]
        """
        ends = accumulate((len(block.values) for block in self.blocks), initial=0)
        return [slice(*pair) for pair in pairwise(ends)]

    def run_slices(self) -> list[slice]:
        """Find the place of each run in an array over all blocks.

        Returns
        -------
        list of slice

        Examples
        --------
        >>> channels = {"lift": np.zeros(2), "pressure_a": np.zeros(2)}
        >>> runs = [MeasuredRun(name, "", 0.5e6, 287.0, 1e-3, "fit", np.arange(2.0), channels) for name in "ab"]
        >>> [(rows.start, rows.stop) for rows in WhitenedResiduals(Machine(), runs, []).run_slices()]
        [(0, 4), (4, 8)]
        """
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
        """Predict what the sensors would show of each block without noise.

        Parameters
        ----------
        x : (p,) float array
        tolerance : float
            Tolerance of the march.

        Returns
        -------
        list of (m,) float array
            One for each block [SI].

        Raises
        ------
        EndedEarly
            A simulation does not come to its end.

        Examples
        --------
        >>> times = np.array([0.0, 1e-3])
        >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": np.array([1e-5, 0.0])})
        >>> residuals = WhitenedResiduals(Machine(), [run], [])
        >>> [values.tolist() for values in residuals.predicted(np.zeros(0))]  # at rest for the first millisecond
        [[0.0, 0.0]]
        """
        found = []
        for run, prediction in self._predictions(x, tolerance):
            found += [prediction.channels[sensor][~np.isnan(values)] for sensor, values in run.channels.items()]
            found += [np.array([prediction.means[sensor]]) for sensor in run.means]
        return found

    def marks(self, x: np.ndarray) -> list[dict[str, float]]:
        """Find the instants that divide the stroke or cycle of each run.

        Parameters
        ----------
        x : (p,) float array

        Returns
        -------
        list of dict
            One for each run, see `apesim.studies.measured.prediction.Prediction`.

        Raises
        ------
        EndedEarly
            A simulation does not come to its end.

        Examples
        --------
        >>> times = np.array([0.0, 1e-3])
        >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": 0.0 * times})
        >>> (marks,) = WhitenedResiduals(Machine(), [run], []).marks(np.zeros(0))
        >>> marks["release"]
        0.05
        """
        return [prediction.marks for _, prediction in self._predictions(x)]

    def whiten(self, arrays: Sequence[np.ndarray]) -> np.ndarray:
        """Whiten the noise of arrays, one for each block, and put them one below the other.

        Parameters
        ----------
        arrays : sequence of (m,) or (m, k) float array
            [SI]

        Returns
        -------
        (n, k) float array
            [standard deviations]

        Examples
        --------
        >>> from apesim.studies.estimation.noise.process import white
        >>> times = np.array([0.0, 1e-3])
        >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": 0.0 * times})
        >>> residuals = WhitenedResiduals(Machine(), [run], [], {"lift": {1e-3: white(3e-5, "stated")}})
        >>> residuals.whiten([np.array([3e-5, 6e-5])]).round(6).tolist()
        [[1.0], [2.0]]
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

        Examples
        --------
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
        """Find the pull of each parameter's prior, see `find_pull`: 0 where it has none.

        Parameters
        ----------
        x : (p,) float array

        Returns
        -------
        (p,) float array
            [standard deviations]

        Examples
        --------
        >>> known = Parameter("valve.moving_mass", 0.01, -5.0, 5.0, 0.1, shifts=True, prior=True)
        >>> free = Parameter("valve.viscous_friction", 100.0, 0.0, 10.0)
        >>> WhitenedResiduals(Machine(), [], [known, free]).pulls(np.array([0.5, 1.1])).round(2).tolist()
        [0.49, 0.0]
        """
        return np.where(self.known, find_pull(x), 0.0)

    def column(self, x: np.ndarray, j: int, step: float, residuals: np.ndarray | None = None) -> np.ndarray:
        """Find the sensitivity of the residuals to one parameter, by a difference of a given step.

        Parameters
        ----------
        x : (p,) float array
        j : int
            Place of the parameter.
        step : float
            Step in x.
        residuals : (n + p,) float array, optional
            Residuals at x; they are found where they are left out.

        Returns
        -------
        (n + p,) float array

        Raises
        ------
        EndedEarly
            A simulation does not come to its end.

        Examples
        --------
        >>> known = Parameter("valve.moving_mass", 0.01, -5.0, 5.0, 0.1, shifts=True, prior=True)
        >>> WhitenedResiduals(Machine(), [], [known]).column(np.array([0.5]), 0, 0.25)  # doctest: +SKIP
        array([1.])
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

        Parameters
        ----------
        x : (p,) float array
        residuals : (n + p,) float array
            Residuals at x, see `at`.
        steps : (p,) float array, optional
            Step of each difference, in units of x; `STEP` where they are left out.
        only : sequence of int, optional
            Places of the parameters; without it, all.

        Returns
        -------
        jacobian : (n + p, p) or (n + p, len(only)) float array
        steps : (p,) float array
            Steps with which the next differences change the data by ``change``; of parameters left out they stay.

        Raises
        ------
        EndedEarly
            A simulation does not come to its end on either side of x.

        Examples
        --------
        A gain of the lift that is known within 0.5 %, of a run at rest, which does not show it:

        >>> from apesim.studies.estimation.noise.process import white
        >>> times = np.array([0.0, 1e-3])
        >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": 0.0 * times})
        >>> gain = Parameter("effects.sensor_gain.lift", 0.005, -5.0, 5.0, shifts=True, prior=True)
        >>> residuals = WhitenedResiduals(Machine(), [run], [gain], {"lift": {1e-3: white(3e-5, "stated")}})
        >>> x = np.zeros(1)
        >>> jacobian, steps = residuals.jacobian(x, residuals.at(x))
        >>> jacobian.round(2).tolist(), steps.tolist()
        ([[0.0], [0.0], [1.0]], [0.1])
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
