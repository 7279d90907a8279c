"""Scatter between runs: supply, friction and dead time are a little other ones in each run, and no record says it.

The user states it, or repeats of a run tell it: what the model leaves of one less what it leaves of another holds no
error that both have.
What scatters is then noise that all samples of a run have in common, and is whitened like other noise.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from zlib import crc32

import numpy as np

from apesim.engine.machine import Machine
from apesim.engine.stated_uncertainties import KNOWN_TO, find_odd_share
from apesim.quantities import Fault, InputError
from apesim.studies.estimation.engine_starts import starts_at
from apesim.studies.estimation.parameters import INSTRUMENTS, Parameter, value_of
from apesim.studies.estimation.scatter_sizes import find_lone, find_relief, find_sizes, list_contrasts
from apesim.studies.measured import FIT, GATE, Measured, MeasuredRun
from apesim.studies.measured.scatter import SCATTER, SCATTERING
from apesim.studies.measured.sensors import FILE

if TYPE_CHECKING:
    from apesim.studies.estimation.model import Model
    from apesim.studies.estimation.residuals import WhitenedResiduals

NO_SIZES: Mapping[str, float] = {}
Identity = tuple[str, str, int]
"""Name and file of a run, with a checksum of what was measured."""
APART = 0.5
"""Prior standard deviations to both sides over which is found how repeats may differ."""
REACH = 0.5
"""Standard deviations to both sides over which the effect of a scatter is taken."""
ROUNDS = 2
"""Steps towards where its scatter has moved a run."""


class Spread(NamedTuple):
    """How the whitened samples of one run vary by scatter."""

    directions: np.ndarray
    """Orthonormal columns, (n, k)."""
    shares: np.ndarray
    """Share by which what lies along each of them is shortened, (k,)."""
    moves: np.ndarray
    """How far the scattering numbers of the run have been moved, (m,) [prior standard deviations]."""
    taken: np.ndarray
    """What that does to the samples, whitened, as far as it is straight, (n,) [standard deviations]."""

    @property
    def parts(self) -> np.ndarray:
        """Share of the variance along each direction that is scatter, the rest being noise, (k,)."""
        return 1.0 - (1.0 - self.shares) ** 2

    def find_relief(self, errors: np.ndarray) -> float:
        """Find by how much a run is more likely than if its scatter were normal, see `scatter_sizes.find_relief`.

        `errors`, (n,), are its white samples [standard deviations]; the result is the fall of twice the negative log
        likelihood.

        >>> spread = find_spread(np.full((2, 1), 9.0))
        >>> round(spread.find_relief(np.full(2, 5.0)))  # both far off together
        34
        >>> spread.find_relief(np.array([5.0, -5.0])) < 1.0  # noise has no heavy tails
        True
        """
        return find_relief(self.directions.T @ errors, self.parts)


class Scatter(NamedTuple):
    """What scatters between runs, and what it does to each of them."""

    keys: tuple[str, ...]
    """Keys of what scatters."""
    sizes: tuple[float, ...]
    """Standard deviations, in those of the priors."""
    contrasts: int
    """Number of independent differences of repeats that tell it."""
    spreads: dict[Identity, Spread]
    """How the samples of each run vary; runs by their name, their file and a checksum, see `identify`."""
    odd: tuple[tuple[str, ...], ...] = ()
    """Files of the differences of repeats that the others do not explain, of each the one that differs last."""
    stated: tuple[str, ...] = ()
    """Keys whose sizes the user states."""
    lone: tuple[str, ...] = ()
    """Files of the only set of repeats that tells of a scatter, see `find_lone`."""

    def scale_slopes(self, parameters: Sequence[Parameter], slopes: np.ndarray) -> np.ndarray:
        """Find what each of the m scattering numbers does to data, (n, m), at its standard deviation.

        `slopes`, (n, p), are the sensitivities of the data to `parameters`.

        >>> pressure = Parameter("supply.pressure", 0.01, -5.0, 5.0, relative=True, prior=True)
        >>> Scatter(("supply.pressure",), (0.3,), 1, {}).scale_slopes([pressure], np.full((2, 1), 10.0)).tolist()
        [[3.0], [3.0]]
        """
        keys = [parameter.key for parameter in parameters]
        return slopes[:, [keys.index(key) for key in self.keys]] * np.array(self.sizes)

    def whiten(self, run: Identity, rows: np.ndarray) -> np.ndarray:
        """Whiten what is common to the samples of a run.

        `run` is as `identify` gives it; `rows`, (n, k), are white but for the scatter [standard deviations], and stay
        as they are where nothing is known of the run.

        Both samples of a run go up and down together, by 3 standard deviations of their noise in all:

        >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", np.zeros(2), {"lift": np.zeros(2)})
        >>> scatter = Scatter(("supply.pressure",), (0.3,), 1, {identify(run): find_spread(np.full((2, 1), 2.0))})
        >>> scatter.whiten(identify(run), np.array([[3.0, 1.0], [3.0, -1.0]])).round(3).tolist()
        [[1.0, 1.0], [1.0, -1.0]]
        """
        spread = self.spreads.get(run)
        return rows if spread is None else shorten(spread, rows)

    def find_move(self, run: Identity, samples: int) -> tuple[np.ndarray, np.ndarray]:
        """Find how far its own scatter has moved a run that has so many samples; `run` is as `identify` gives it.

        Gives the moves of the numbers that scatter, (m,) [prior standard deviations], and what they do to the whitened
        samples as far as it is straight, (samples,) [standard deviations]; zeros where nothing is known of the run.
        """
        spread = self.spreads.get(run)
        return (spread.moves, spread.taken) if spread else (np.zeros(len(self.keys)), np.zeros(samples))

    def colour(self, run: Identity, rows: np.ndarray) -> np.ndarray:
        """Take the whitening of what is common to the samples of a run back, see `whiten`.

        `run` is as `identify` gives it; `rows`, (n, k), are white samples, the result has the scatter in it [standard
        deviations of their noise].
        """
        spread = self.spreads.get(run)
        if spread is None:
            return rows
        longer = spread.shares / (1.0 - spread.shares)
        return rows + spread.directions @ (longer[:, None] * (spread.directions.T @ rows))


def identify(run: MeasuredRun) -> Identity:
    """Identify a run among all of a set, repeats and parts of one file too: name, file, checksum of its samples."""
    values = b"".join(np.ascontiguousarray(each).tobytes() for each in (*run.channels.values(), *run.means.values()))
    return run.name, run.data, crc32(values)


def find_spread(columns: np.ndarray) -> Spread:
    """Find how a run's samples vary, from what each scattering number does to them at its standard deviation.

    `columns` are G, (n, k), whitened [standard deviations of noise], about a run that has not been moved. White noise
    and scatter have the covariance ``I + G G'``, whose inverse root shortens each left singular vector of G by ``1 - 1
    / sqrt(1 + s^2)``.
    """
    directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    shares = 1.0 - 1.0 / np.sqrt(1.0 + sizes**2)
    return Spread(directions, shares, np.zeros(columns.shape[1]), np.zeros(len(columns)))


def shorten(spread: Spread, rows: np.ndarray) -> np.ndarray:
    """Shorten what lies along the directions of a scatter.

    `rows`, (n, k), are in standard deviations of noise, the result in those of noise and scatter.

    >>> shorten(find_spread(np.array([[0.0], [3.0**0.5]])), np.array([[1.0], [1.0]])).round(3).tolist()
    [[1.0], [0.5]]
    """
    return rows - spread.directions @ (spread.shares[:, None] * (spread.directions.T @ rows))


def find_stated_sizes(machine: Machine, measured: Measured, parameters: Sequence[Parameter]) -> dict[str, float]:
    """Find the sizes of the scatter that the user states, in prior standard deviations by key.

    `parameters` are the nuisances of the data. Raises InputError where a number is stated that counts as exact, or of
    which no share can be taken.

    >>> from apesim.quantities.uncertainties import Uncertainty
    >>> from apesim.studies.estimation.priors import nuisances_of
    >>> stated = {"supply.pressure": Uncertainty(0.003, True), "valve.solenoid.dead_time": Uncertainty(0.02, True)}
    >>> measured = Measured("", {}, (), "valve", scatter=stated)
    >>> sizes = find_stated_sizes(Machine(), measured, nuisances_of(Machine(), measured))
    >>> {key: round(size, 3) for key, size in sizes.items()}  # the dead time is 1.5 ms, and known to 0.1 ms
    {'supply.pressure': 0.3, 'valve.solenoid.dead_time': 0.3}
    """
    by_key = {parameter.key: parameter for parameter in parameters}
    sizes, faults = {}, []
    for key, uncertainty in measured.scatter.items():
        place = str(Path(measured.folder, FILE)), f"{SCATTER}.{key}"
        if fault := find_odd_share(machine, key, uncertainty):
            faults.append(Fault(*place, *fault))
        elif key not in by_key:
            faults.append(Fault(*place, f"counts as exact by [{KNOWN_TO}]", "leave one of both out"))
        else:
            own = 1.0 if key in INSTRUMENTS else value_of(machine, key)
            prior = by_key[key].scale * (own if by_key[key].relative else 1.0)
            sizes[key] = uncertainty.deviation * (own if uncertainty.is_share else 1.0) / prior
    if faults:
        raise InputError(faults)
    return sizes


def find_stated_scatter(
    residuals: "WhitenedResiduals", slopes: np.ndarray, sizes: Mapping[str, float]
) -> Scatter | None:
    """Find how runs vary by a scatter that is stated, about where the machine has them; None: none is stated.

    `residuals` are without scatter, `slopes` their sensitivities, (n + p, p), and `sizes` as `find_stated_sizes` gives
    them.
    """
    if not any(sizes.values()):
        return None
    scatter = Scatter(tuple(sizes), tuple(sizes.values()), 0, {}, stated=tuple(sizes))
    whole = scatter.scale_slopes(residuals.parameters, slopes)
    rows = zip(map(identify, residuals.runs), residuals.run_slices(), strict=True)
    return scatter._replace(spreads={run: find_spread(whole[own]) for run, own in rows})


def find_scatter(
    model: "Model",
    runs: "WhitenedResiduals",
    others: "WhitenedResiduals",
    known: Scatter | None = None,
    stated: Mapping[str, float] = NO_SIZES,
) -> Scatter | None:
    """Find what scatters between runs: what the user states, and what repeats tell of the rest.

    `runs` are the residuals without scatter of those that tell it, `others` of further runs that scatter as much. Sizes
    are those of `find_sizes`, larger where few repeats tell them, or those of `known`, told by more repeats; `stated`
    ones are in prior standard deviations. A repeat that differs by more than the others explain is left out, see
    `warn_of_odd_repeats`. None: nothing is stated, and there are no repeats or they differ by no more than noise.
    """
    places, x = find_scattering(runs), model.fitted.x
    if not places:
        return None
    if known is None:
        errors = runs.at(x)
        columns, _ = runs.jacobian(x, errors, model.fitted.steps, only=places)
        rows = runs.run_slices()
        contrasts = list_contrasts(runs.runs, [errors[own] for own in rows], [columns[own] for own in rows])
        keys = tuple(runs.parameters[place].key for place in places)
        sizes, kept = find_sizes(contrasts, np.array([stated.get(key, np.nan) for key in keys]))
        if not sizes.any():
            return None
        odd = tuple(contrast.files for contrast in contrasts if not any(contrast is each for each in kept))
        known = Scatter(keys, tuple(sizes.tolist()), len(kept), {}, odd, tuple(stated), find_lone(kept))
    names = {run.data for run in runs.runs}
    odd = tuple(files for files in known.odd if names.issuperset(files))
    known = known._replace(odd=odd, lone=known.lone if names.issuperset(known.lone) else ())
    spreads = {key: one for each in (runs, others) if each.runs for key, one in find_spreads(each, x, known).items()}
    return known._replace(spreads=spreads)


def warn_of_odd_repeats(scatter: Scatter | None) -> list[str]:
    """Warnings of repeats that differ by more than the others scatter, or alone of all; none without a scatter.

    >>> warn_of_odd_repeats(Scatter(("supply.pressure",), (0.3,), 4, {}, (("a.csv", "b.csv"),)))
    ['b.csv differs from a.csv by more than the scatter of the other repeats explains: one of them may be wrong']
    >>> warn_of_odd_repeats(None)
    []
    """
    warnings = [
        f"{files[-1]} differs from {' and '.join(files[:-1])} by more than the scatter of the other repeats explains: "
        "one of them may be wrong"
        for files in (scatter.odd if scatter else ())
    ]
    if scatter and scatter.lone:
        files = " and ".join(scatter.lone)
        warnings.append(
            f"{files} differ by far more than noise, the other repeats by no more than that: it is taken for scatter "
            "between runs, but one of them may be wrong"
        )
    return warnings


def list_odd_repeats(scatter: Scatter | None) -> list[str]:
    """List the files that differ from their repeats by more than the others scatter; none without a scatter.

    Each entry is a file, or all of which one is odd, with "or" between them, where no third one tells which.

    >>> a_third_tells, two_alone = ("a.csv", "b.csv", "c.csv"), ("a.csv", "b.csv")
    >>> scatter = Scatter(("supply.pressure",), (0.3,), 4, {})
    >>> [list_odd_repeats(scatter._replace(odd=odd)) for odd in ((a_third_tells,), (two_alone,))]
    [['c.csv'], ['a.csv or b.csv']]
    >>> list_odd_repeats(scatter._replace(odd=(two_alone, a_third_tells)))
    ['a.csv or b.csv or c.csv']
    >>> list_odd_repeats(None)
    []
    """
    odd = scatter.odd if scatter else ()
    found = []
    for files in odd:
        if any(set(files) < set(others) for others in odd):
            continue
        agreed = len(files) > 2 and not any(set(others) < set(files) for others in odd)
        found.append(files[-1] if agreed else " or ".join(files))
    return found


def find_scatter_at(model: "Model", others: Sequence[MeasuredRun]) -> Scatter:
    """Find what a scatter does to each run of another machine, by the sizes that are known.

    `model` is a machine with effects whose residuals know a scatter, `others` are further runs that scatter as much.
    What is missing in a machine changes how supply, friction and dead time move its samples: directions that are taken
    without it leave a part of the scatter, which looks like faults of single files. Raises EndedEarly where a
    simulation does not come to its end.
    """
    scatter, x = model.residuals.scatter, model.fitted.x
    assert scatter is not None
    runs = model.residuals.with_scatter(None)
    spreads = find_spreads(runs, x, scatter)
    if others:
        starts = starts_at(runs.machine, others, runs.parameters, x)
        spreads |= find_spreads(runs.with_runs(others, starts), x, scatter)
    return scatter._replace(spreads=spreads)


def find_scattering(residuals: "WhitenedResiduals") -> list[int]:
    """Find the places of what may scatter among the parameters of residuals."""
    keys = [p.key for p in residuals.parameters]
    return [keys.index(key) for key in SCATTERING if key in keys]


def find_changes(residuals: "WhitenedResiduals", x: np.ndarray, predicted: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Find how the samples of runs change with what may scatter, by `APART` to both sides.

    x (p,) are the parameters of the residuals, `predicted` the prediction of each block there, (n,) [SI]. Gives each
    block's changes, (n, k), not whitened [SI]; [] where nothing may scatter. Raises EndedEarly where a simulation does
    not come to its end.
    """
    found = []
    for place in find_scattering(residuals):
        for way in (APART, -APART):
            moved = x.copy()
            moved[place] += way
            after = residuals.predicted(np.clip(moved, residuals.low, residuals.high))
            found.append([values - old for values, old in zip(after, predicted, strict=True)])
    return [np.column_stack(columns) for columns in zip(*found, strict=True)]


def is_repeated(measured: Measured) -> bool:
    """Tell whether runs to fit, or gate runs, are repeated."""
    runs = measured.of(FIT) + measured.of(GATE)
    return len({(run.name, run.role) for run in runs}) < len(runs)


def find_spreads(residuals: "WhitenedResiduals", x: np.ndarray, scatter: Scatter) -> dict[Identity, Spread]:
    """Find how the samples of each run vary, about where its own scatter has most probably moved it.

    `residuals` are without scatter, x (p,) their parameters; of `scatter` its sizes count alone. A run whose numbers
    are off by z standard deviations shows ``e(z)``, which is not straight: a dead time that is long by four of them
    moves an impact by more samples than the noise hides. So z is sought that has least ``|e(z)|^2 + |z|^2``, by
    `ROUNDS` steps of Gauss and Newton, and ``e(z) + G (z' - z)`` taken for what other z' show (Lindstrom and Bates
    1990, doi 10.2307/2532087). The result is by run, see `identify`. Raises EndedEarly where a simulation does not come
    to its end.
    """
    sizes, keys = np.array(scatter.sizes), [p.key for p in residuals.parameters]
    rows = dict(zip(map(identify, residuals.runs), residuals.run_slices(), strict=True))
    pulls = {run: np.zeros(len(sizes)) for run in rows}
    for number in range(ROUNDS + 1):
        still = {run: _stand(own.stop - own.start, sizes * pulls[run]) for run, own in rows.items()}
        moved = residuals.with_scatter(scatter._replace(spreads=still))
        errors, columns = moved.at(x), []
        for key, size in zip(scatter.keys, scatter.sizes, strict=True):
            step = np.zeros(len(x))
            step[keys.index(key)] = REACH * size
            above, below = (moved.at(x + way * step) for way in (1.0, -1.0))
            columns.append((above - below) / (2.0 * REACH))
        whole = np.column_stack(columns)
        if number == ROUNDS:
            break
        for run, own in rows.items():
            slopes = whole[own]
            left = errors[own] - slopes @ pulls[run]
            pulls[run] = -np.linalg.solve(np.eye(len(sizes)) + slopes.T @ slopes, slopes.T @ left)
    found = {}
    for run, own in rows.items():
        spread = find_spread(whole[own])
        taken = (whole[own] @ pulls[run])[:, None]
        found[run] = spread._replace(moves=sizes * pulls[run], taken=shorten(spread, taken)[:, 0])
    return found


def _stand(samples: int, moves: np.ndarray) -> Spread:
    """A run that has been moved, and of which nothing is whitened."""
    return Spread(np.zeros((samples, 0)), np.zeros(0), moves, np.zeros(samples))
