"""Scatter between runs: supply, friction and dead time are a little other ones in each run, and no record says it.

Repeats of a run tell it: what the model leaves of one less what it leaves of another holds no error that both have.
What scatters is then noise that all samples of a run have in common, and is whitened like other noise.
"""

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import TYPE_CHECKING, NamedTuple
from zlib import crc32

import numpy as np

from apesim.studies.estimation.scatter_sizes import find_sizes, list_contrasts
from apesim.studies.measured import FIT, GATE, Measured, MeasuredRun

if TYPE_CHECKING:
    from apesim.studies.estimation.model import Model
    from apesim.studies.estimation.residuals import WhitenedResiduals

Identity = tuple[str, str, int]
"""Name and file of a run, with a checksum of what was measured."""
SCATTERING = "supply.pressure", "supply.temperature", "valve.viscous_friction", "valve.solenoid.dead_time"
"""What may scatter: the supply by its regulator and its store, friction by grease and seals, dead time by the coil."""
APART = 0.5
"""Prior standard deviations to both sides over which is found how repeats may differ."""
REACH = 2.0
"""Standard deviations to both sides over which the effect of a scatter is taken."""


class Spread(NamedTuple):
    """How the whitened samples of one run vary by scatter."""

    directions: np.ndarray
    """Orthonormal columns, (n, k)."""
    shares: np.ndarray
    """Share by which what lies along each of them is shortened, (k,)."""


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


def find_scatter(model: "Model", runs: "WhitenedResiduals", others: "WhitenedResiduals") -> Scatter | None:
    """Find what scatters between the repeats of runs.

    Its sizes are those of `find_sizes`: larger where few repeats tell them. A repeat that differs by more than scatter
    explains is left out there: it is a fault of its file.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
        The calibrated machine.
    runs : apesim.studies.estimation.residuals.WhitenedResiduals
        Residuals of the runs that tell the scatter as a function of the model's parameters, without scatter.
    others : apesim.studies.estimation.residuals.WhitenedResiduals
        Those of further runs that scatter as much.

    Returns
    -------
    Scatter or None
        None where there are no repeats, or where they differ by no more than noise.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example, read_example
    >>> model, measured = explain_example().calibrated, read_example()
    >>> runs, others = (model.residuals.with_runs(measured.of(role)) for role in ("fit", "check"))
    >>> find_scatter(model, runs, others) is None  # no run is repeated
    True
    """
    places, x = find_scattering(runs), model.fitted.x
    if not places:
        return None
    errors = runs.at(x)
    columns, _ = runs.jacobian(x, errors, model.fitted.steps, only=places)
    rows = runs.run_slices()
    sizes, kept = find_sizes(list_contrasts(runs.runs, [errors[own] for own in rows], [columns[own] for own in rows]))
    if not sizes.any():
        return None
    by_place = dict(zip(places, sizes.tolist(), strict=True))
    spreads = {key: one for each in (runs, others) if each.runs for key, one in find_spreads(each, x, by_place).items()}
    return Scatter(tuple(runs.parameters[place].key for place in places), tuple(sizes.tolist()), kept, spreads)


def find_scattering(residuals: "WhitenedResiduals") -> list[int]:
    """Find the places of what may scatter among the parameters of residuals.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals

    Returns
    -------
    list of int

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> residuals = explain_example().calibrated.residuals
    >>> residuals.parameters[find_scattering(residuals)[0]].key
    'supply.pressure'
    """
    keys = [p.key for p in residuals.parameters]
    return [keys.index(key) for key in SCATTERING if key in keys]


def find_changes(residuals: "WhitenedResiduals", x: np.ndarray, predicted: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Find how the samples of runs change with what may scatter, by `APART` to both sides.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    x : (p,) float array
        Their parameters.
    predicted : sequence of (n,) float array
        Prediction of each block at x [SI].

    Returns
    -------
    list of (n, k) float array
        Of each block, not whitened [SI]; [] where nothing may scatter.

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The simulation of a run does not come to its end.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> model = explain_example().calibrated
    >>> residuals, x = model.residuals, model.fitted.x
    >>> [columns.shape for columns in find_changes(residuals, x, residuals.predicted(x))][:1]  # four, to both sides
    [(160, 8)]
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
    """Tell whether runs to fit, or gate runs, are repeated.

    Parameters
    ----------
    measured : apesim.studies.measured.Measured

    Returns
    -------
    bool

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import read_example
    >>> is_repeated(read_example())
    False
    """
    runs = measured.of(FIT) + measured.of(GATE)
    return len({(run.name, run.role) for run in runs}) < len(runs)


def find_spreads(residuals: "WhitenedResiduals", x: np.ndarray, sizes: Mapping[int, float]) -> dict[Identity, Spread]:
    """Find how the samples of each run vary, from differences over `REACH` standard deviations to both sides.

    A number that is off by z standard deviations moves the samples by ``G z + H z^2``, and z^2 has the root mean square
    ``sqrt(3)``: the curvature H is a direction of its own.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    x : (p,) float array
        Their parameters.
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
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> model = explain_example().calibrated
    >>> (friction, *_) = find_spreads(model.residuals, model.fitted.x, {0: 0.3}).values()
    >>> friction.directions.shape, bool(friction.shares[0] > 0.9)
    ((160, 2), True)
    """
    errors, columns = residuals.at(x), []
    for place, size in sizes.items():
        if not size:
            continue
        step = np.zeros(len(x))
        step[place] = REACH * size
        above, below = (residuals.at(np.clip(x + way * step, residuals.low, residuals.high)) for way in (1.0, -1.0))
        columns.append((above - below) / (2.0 * REACH))
        columns.append(sqrt(3.0) * (above + below - 2.0 * errors) / (2.0 * REACH**2))
    whole, rows = np.column_stack(columns), residuals.run_slices()
    return {identify(run): find_spread(whole[own]) for run, own in zip(residuals.runs, rows, strict=True)}
