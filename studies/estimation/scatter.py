"""Scatter between runs: supply, friction and dead time are a little other ones in each run, and no record says it.

Repeats of a run tell it: what the model leaves of one less what it leaves of another holds no error that both have.
What scatters is then noise that all samples of a run have in common, and is whitened like other noise.
"""

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import TYPE_CHECKING, Any, NamedTuple
from zlib import crc32

import numpy as np
from scipy.optimize import minimize
from scipy.stats import chi2, norm, t

from apesim.studies.estimation.starts import starts_at
from apesim.studies.measured import FIT, GATE, Measured, MeasuredRun

if TYPE_CHECKING:
    from apesim.studies.estimation.model import Model
    from apesim.studies.estimation.residuals import WhitenedResiduals

Identity = tuple[str, str, int]
"""Name and file of a run, with a checksum of what was measured."""
SCATTERING = "supply.pressure", "supply.temperature", "valve.viscous_friction", "valve.solenoid.dead_time"
"""What may scatter: the supply by its regulator and its store, friction by grease and seals, dead time by the coil."""
MIN_FALL = 10.0
"""Fall of twice the negative log likelihood from which repeats show a scatter: four sizes that are not there give 9.5
in one case of twenty."""
ODD_CHANCE = 1e-4
"""Chance of scatter and noise alone below which a repeat is the odd one out, and tells nothing of the scatter."""
COVER = 0.975
"""Quantile at which an uncertain size is as wide as Student's t says."""
REACH = 2.0
"""Standard deviations to both sides over which the effect of a scatter is taken."""
LARGEST = 100.0
"""Largest size that is tried, in prior standard deviations."""


class Spread(NamedTuple):
    """How the whitened samples of one run vary by scatter."""

    directions: np.ndarray
    """Orthonormal columns, (n, k)."""
    shares: np.ndarray
    """Share by which what lies along each of them is shortened, (k,)."""


class Contrast(NamedTuple):
    """What two parts of a set of repeats differ by, along the directions in which scatter moves it."""

    files: tuple[str, ...]
    """Files that it is made of."""
    values: np.ndarray
    """Independent and of variance one by noise alone, (k,)."""
    slopes: np.ndarray
    """Change of the values by each size, (k, p)."""


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

    def whiten(self, run: Identity, rows: np.ndarray) -> np.ndarray:
        """Whiten what is common to the samples of a run.

        Parameters
        ----------
        run : tuple
            See `identify`.
        rows : (n, k) float array
            Samples of the run, white but for the scatter [standard deviations].

        Returns
        -------
        (n, k) float array
            The same where nothing is known of the run.

        Examples
        --------
        Both samples of a run go up and down together, by 3 standard deviations of their noise in all:

        >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", np.zeros(2), {"lift": np.zeros(2)})
        >>> scatter = Scatter(("supply.pressure",), (0.3,), 1, {identify(run): find_spread(np.full((2, 1), sqrt(4.0)))})
        >>> scatter.whiten(identify(run), np.array([[3.0, 1.0], [3.0, -1.0]])).round(3).tolist()
        [[1.0, 1.0], [1.0, -1.0]]
        """
        spread = self.spreads.get(run)
        if spread is None:
            return rows
        return rows - spread.directions @ (spread.shares[:, None] * (spread.directions.T @ rows))


def identify(run: MeasuredRun) -> Identity:
    """Identify a run among all of a set, repeats and parts of one file too.

    Parameters
    ----------
    run : apesim.studies.measured.MeasuredRun

    Returns
    -------
    tuple
        Name, file, and a checksum of what was measured.

    Examples
    --------
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", np.zeros(2), {"lift": np.zeros(2)})
    >>> identify(run) == identify(run._replace(channels={"lift": np.ones(2)}))
    False
    """
    values = b"".join(np.ascontiguousarray(each).tobytes() for each in (*run.channels.values(), *run.means.values()))
    return run.name, run.data, crc32(values)


def find_spread(columns: np.ndarray) -> Spread:
    """Find how the samples of a run vary, from what each scattering number does to them at its standard deviation.

    White noise and scatter have the covariance ``I + G G'``, whose inverse root shortens each left singular vector of
    G by ``1 - 1 / sqrt(1 + s^2)``.

    Parameters
    ----------
    columns : (n, k) float array
        G, whitened [standard deviations of noise].

    Returns
    -------
    Spread

    Examples
    --------
    >>> find_spread(np.array([[0.0], [sqrt(3.0)]])).shares.round(6).tolist()
    [0.5]
    """
    directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return Spread(directions, 1.0 - 1.0 / np.sqrt(1.0 + sizes**2))


def find_scatter(model: "Model", measured: Measured) -> Scatter | None:
    """Find what scatters between the repeats of runs.

    Its sizes are the most probable ones, see `find_variances`, and larger where few repeats tell them: as wide as
    Student's t at `COVER`. A repeat that differs by more than scatter explains is left out: it is a fault of its file.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
        The calibrated machine, its residuals without scatter.
    measured : apesim.studies.measured.Measured

    Returns
    -------
    Scatter or None
        None where there are no repeats, or where they differ by no more than noise.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example, read_example
    >>> find_scatter(explain_example().calibrated, read_example()) is None  # no run is repeated
    True
    """
    keys = [p.key for p in model.residuals.parameters]
    places = [keys.index(key) for key in SCATTERING if key in keys]
    runs = measured.of(FIT) + measured.of(GATE)
    if not places or len({(run.name, run.role) for run in runs}) == len(runs):
        return None
    residuals, errors = _march(model, runs)
    columns, _ = residuals.jacobian(model.fitted.x, errors, model.fitted.steps, only=places)
    rows = residuals.run_slices()
    contrasts = list_contrasts(runs, [errors[own] for own in rows], [columns[own] for own in rows])
    model.residuals.counter.add(residuals.simulations)
    variances, kept = find_variances(contrasts)
    if not variances.any():
        return None
    sizes = np.sqrt(variances) * t.ppf(COVER, kept) / norm.ppf(COVER)
    spreads = find_spreads(model, measured.runs, dict(zip(places, sizes.tolist(), strict=True)))
    return Scatter(tuple(keys[place] for place in places), tuple(sizes.tolist()), kept, spreads)


def find_spreads(model: "Model", runs: Sequence[MeasuredRun], sizes: Mapping[int, float]) -> dict[Identity, Spread]:
    """Find how the samples of each run vary, from differences over `REACH` standard deviations to both sides.

    A number that is off by z standard deviations moves the samples by ``G z + H z^2``, and z^2 has the root mean square
    ``sqrt(3)``: the curvature H is a direction of its own.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    runs : sequence of apesim.studies.measured.MeasuredRun
    sizes : mapping of int to float
        Standard deviation of each scattering number, in those of the priors, by its place among the parameters.

    Returns
    -------
    dict of Spread
        By run, see `identify`.

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The simulation of a run does not come to its end.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example, read_example
    >>> (friction, *_) = find_spreads(explain_example().calibrated, read_example().runs[:1], {0: 0.3}).values()
    >>> friction.directions.shape, bool(friction.shares[0] > 0.9)
    ((160, 2), True)
    """
    residuals, errors = _march(model, runs)
    columns = []
    for place, size in sizes.items():
        if not size:
            continue
        step = np.zeros(len(model.fitted.x))
        step[place] = REACH * size
        above, below = (
            residuals.at(np.clip(model.fitted.x + way * step, residuals.low, residuals.high)) for way in (1.0, -1.0)
        )
        columns.append((above - below) / (2.0 * REACH))
        columns.append(sqrt(3.0) * (above + below - 2.0 * errors) / (2.0 * REACH**2))
    model.residuals.counter.add(residuals.simulations)
    whole = np.column_stack(columns)
    return {identify(run): find_spread(whole[own]) for run, own in zip(runs, residuals.run_slices(), strict=True)}


def _march(model: "Model", runs: Sequence[MeasuredRun]) -> "tuple[WhitenedResiduals, np.ndarray]":
    """Residuals of runs as a function of a model's parameters, with their values at its fit."""
    own = model.residuals
    residuals = own.with_runs(runs, starts_at(own.machine, runs, own.parameters, model.fitted.x))
    return residuals, residuals.at(model.fitted.x)


def list_contrasts(
    runs: Sequence[MeasuredRun], errors: Sequence[np.ndarray], columns: Sequence[np.ndarray]
) -> list[Contrast]:
    """List what repeats of runs differ by: Helmert's contrasts, along the directions in which scatter moves them.

    Parameters
    ----------
    runs : sequence of apesim.studies.measured.MeasuredRun
    errors : sequence of (n,) float array
        Whitened residuals of each run.
    columns : sequence of (n, p) float array
        What each scattering number does to them.

    Returns
    -------
    list of Contrast

    Examples
    --------
    >>> runs = [MeasuredRun("p", f"{i}.csv", 0.5e6, 287.0, 50e-3, "fit", np.zeros(2), {}) for i in range(2)]
    >>> (contrast,) = list_contrasts(runs, [np.array([3.0, 0.0]), np.array([1.0, 0.0])], [np.array([[2.0], [0.0]])] * 2)
    >>> contrast.files, abs(contrast.values.round(3)).tolist(), abs(contrast.slopes.round(3)).tolist()
    (('0.csv', '1.csv'), [1.414], [[2.0]])
    """
    groups: dict[Any, list[int]] = {}
    for number, run in enumerate(runs):
        groups.setdefault((run.name, run.role, len(errors[number])), []).append(number)
    found = []
    for numbers in groups.values():
        basis, slopes = np.linalg.qr(np.mean([columns[number] for number in numbers], axis=0))
        along = [basis.T @ errors[number] for number in numbers]
        for k in range(1, len(numbers)):
            values = (np.sum(along[:k], axis=0) - k * along[k]) / sqrt(k * (k + 1.0))
            found.append(Contrast(tuple(runs[number].data for number in numbers[: k + 1]), values, slopes))
    return found


def find_variances(contrasts: Sequence[Contrast]) -> tuple[np.ndarray, int]:
    """Find how much each number scatters: the most probable sizes.

    Beforehand a size is half a normal number of one prior standard deviation: what is uncertain in all runs bounds what
    differs between them, where the repeats do not say which of two numbers scatters.

    Parameters
    ----------
    contrasts : sequence of Contrast

    Returns
    -------
    variances : (p,) float array
        In prior standard deviations squared; zeros where the contrasts are no more than noise.
    kept : int
        Number of contrasts that tell it: without those that scatter does not explain.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> slopes, wide = np.diag([9.0, 0.0]), np.array([3.0, 1.0])  # 3.0^2 = 1 + (9.0 x 0.314)^2
    >>> drawn = [Contrast(("a", "b"), wide * rng.normal(size=2), slopes) for _ in range(99)]
    >>> variances, kept = find_variances(drawn)
    >>> round(float(np.sqrt(variances[0])), 1), kept
    (0.3, 99)
    """
    if not contrasts:
        return np.zeros(0), 0
    kept = list(contrasts)
    variances = _fit(kept)
    while len(kept) > 1:
        fits = [_fit([other for other in kept if other is not each]) for each in kept]
        chances = [_chance(each, own, len(kept) - 1) for each, own in zip(kept, fits, strict=True)]
        odd = int(np.argmin(chances))
        if chances[odd] * len(kept) > ODD_CHANCE:
            break
        variances = fits[odd]
        del kept[odd]
    fall = sum(_price(each, np.zeros(len(variances))) - _price(each, variances) for each in kept)
    return variances if fall > MIN_FALL else np.zeros(len(variances)), len(kept)


def _fit(contrasts: Sequence[Contrast]) -> np.ndarray:
    """The most probable variances, if a size is half a normal number beforehand, of one prior standard deviation."""
    number = contrasts[0].slopes.shape[1]

    def price(sizes: np.ndarray) -> float:
        return float(sizes @ sizes) + sum(_price(each, sizes**2) for each in contrasts)

    ends = [minimize(price, np.full(number, start), bounds=[(0.0, LARGEST)] * number) for start in (0.1, 1.0)]
    return min(ends, key=lambda end: end.fun).x ** 2


def _price(contrast: Contrast, variances: np.ndarray) -> float:
    """Twice the negative log likelihood of a contrast, but for a constant."""
    covariance = np.eye(len(contrast.values)) + (contrast.slopes * variances) @ contrast.slopes.T
    return float(np.linalg.slogdet(covariance)[1] + contrast.values @ np.linalg.solve(covariance, contrast.values))


def _chance(contrast: Contrast, variances: np.ndarray, known_from: int) -> float:
    """Chance of a contrast as unlikely, where so many others tell the scatter."""
    wide = variances * (t.ppf(COVER, known_from) / norm.ppf(COVER)) ** 2
    covariance = np.eye(len(contrast.values)) + (contrast.slopes * wide) @ contrast.slopes.T
    return float(chi2.sf(contrast.values @ np.linalg.solve(covariance, contrast.values), len(contrast.values)))
