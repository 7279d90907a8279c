"""How large the gap is on runs that nothing was fitted to: the size that names an effect, or refuses it.

The parameters may move within their uncertainty: what counts is the least of ``|e(x + d)|^2 + d' C^-1 d`` over shifts d
of the parameters, with the covariance C that the fitted runs give them. Noise is averaged out over windows, so that a
gap far below the noise of a sample is seen.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.estimation.starts import starts_at
from apesim.studies.gap.decide.operating_points import is_at, points_of
from apesim.studies.gap.search.model_selection import Choice
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, SURE
from apesim.studies.gap.work import Work
from apesim.studies.measured import GATE, Measured, MeasuredRun

WINDOWS = 50
"""Number of windows of each channel of each run."""


class HeldOut(NamedTuple):
    """The gap that the calibrated machine and a model with effects leave on runs that neither was fitted to.

    Examples
    --------
    >>> judged = HeldOut(samples=100, before=3.0, after=1.2, removed=800.0, left=50.0, chance=10.0)
    >>> round(judged.left_surely, 3), round(judged.share, 3), round(judged.size, 3)
    (33.6, 0.96, 0.58)
    """

    samples: int
    """Number of samples."""
    before: float
    """Root mean square of the residuals of the calibrated machine, over the noise."""
    after: float
    """Root mean square of the residuals of the model with its effects, over the noise."""
    removed: float
    """Energy of the gap that the effects take away: by how much they lower the sum of squares [standard deviations
    squared]."""
    left: float
    """Energy of the gap that is still there: the sum of squares of the means over windows, less what noise gives them
    [standard deviations squared]."""
    chance: float
    """Standard deviation of `left` by noise alone."""
    noise_floor: float = 1.0
    """Root mean square of what varies within windows of what the model with its effects leaves, over the noise."""
    misfit: float = 0.0
    """Sum of squares of what the model with its effects leaves, the parameters' uncertainty taken off."""

    @property
    def settled_before(self) -> float:
        """Size `before`, the parameters' uncertainty taken off."""
        return float(np.sqrt((self.misfit + self.removed) / self.samples))

    @property
    def settled_after(self) -> float:
        """Size `after`, the parameters' uncertainty taken off."""
        return float(np.sqrt(self.misfit / self.samples))

    @property
    def left_surely(self) -> float:
        """Energy that is still there, as far as it stands out of noise: ``left - SURE chance``, 0 at least."""
        return max(0.0, self.left - SURE * self.chance)

    @property
    def share(self) -> float:
        """Share of the gap's energy that is gone, ``removed / (removed + left_surely)``; 0 if nothing was removed."""
        return self.removed / (self.removed + self.left_surely) if self.removed > 0.0 else 0.0

    @property
    def size(self) -> float:
        """Root mean square of the gap that is still there, over the noise."""
        return float(np.sqrt(self.left_surely / self.samples))

    @property
    def size_before(self) -> float:
        """Root mean square of the gap without the effects."""
        return float(np.sqrt(max(0.0, self.removed + self.left) / self.samples))


class LeftOver(NamedTuple):
    """The residuals of a model on runs that it was not fitted to."""

    plain: np.ndarray
    """Whitened residuals with the parameters as fitted, (n,) [standard deviations]."""
    misfit: float
    """Least sum of squares with the parameters moved, and the price of that: ``|e(x + d)|^2 + d' C^-1 d``."""
    windowed: np.ndarray
    """Means over windows with the parameters moved, (m,) [standard deviations of a mean]."""
    scatter: float
    """Sum of squares of `plain` about its means over windows."""
    simulations: int
    """Number of simulations that it took."""


def left_over(model: Model, runs: Sequence[MeasuredRun], noise: dict[str, Any]) -> LeftOver:
    """The residuals of a model on runs that it was not fitted to, with its parameters moved within their uncertainty.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    runs : sequence of apesim.studies.measured.MeasuredRun
    noise : dict
        Noise by sensor, see `apesim.studies.estimation.noise.estimation.noise_of`.

    Returns
    -------
    LeftOver

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The simulation of a run does not come to its end with the parameters as fitted.
    """
    residuals = Anchored(model, runs, noise)
    errors = residuals.at(model.fitted.x)
    settled = descend(residuals, model.fitted.x, *residuals.jacobian(model.fitted.x, errors, model.fitted.steps))
    n = len(errors) - len(model.fitted.x)
    windowed, _ = _windows(residuals.by_block(settled.residuals))
    _, scatter = _windows(residuals.by_block(errors))
    return LeftOver(errors[:n], settled.cost, windowed, scatter, residuals.simulations)


def _windows(channels: Iterable[np.ndarray]) -> tuple[np.ndarray, float]:
    """Sums over windows of channels, over the root of their length, (m,) array; and the squares about their means."""
    parts = [part for own in channels for part in np.array_split(own, min(WINDOWS, len(own)))]
    sums = np.array([part.sum() / np.sqrt(len(part)) for part in parts])
    return sums, float(sum(np.sum(part**2) for part in parts) - sums @ sums)


class Anchored(WhitenedResiduals):
    """Residuals of runs that a model was not fitted to, its fit standing for the priors of all its parameters.

    The pulls behind the residuals are ``R (x - x_fit)`` with ``R'R = J'J`` of the fit, so that their squares add up to
    the price of a shift d of the parameters, ``d' C^-1 d``.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    runs : sequence of apesim.studies.measured.MeasuredRun
    noise : dict
        Noise by sensor, see `apesim.studies.estimation.noise.estimation.noise_of`.
    """

    def __init__(self, model: Model, runs: Sequence[MeasuredRun], noise: dict[str, Any]) -> None:
        machine, parameters = model.residuals.machine, model.residuals.parameters
        starts = starts_at(machine, runs, parameters, model.fitted.x)
        super().__init__(machine, runs, parameters, noise, starts=starts)
        self.anchor, self.root = model.fitted.x, np.linalg.qr(model.fitted.jacobian, mode="r")

    def pulls(self, x: np.ndarray) -> np.ndarray:
        """Pulls towards the fit, ``R (x - x_fit)``.

        Parameters
        ----------
        x : (p,) float array

        Returns
        -------
        (p,) float array
            [standard deviations]
        """
        return self.root @ (x - self.anchor)


def all_left_over(
    base: Model, models: Iterable[Model], runs: Sequence[MeasuredRun], noise: dict[str, Any], work: Work
) -> list[LeftOver]:
    """The residuals of several models on runs that they were not fitted to, see `left_over`.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    models : iterable of apesim.studies.estimation.model.Model
    runs : sequence of apesim.studies.measured.MeasuredRun
    noise : dict
        Noise by sensor, see `apesim.studies.estimation.noise.estimation.noise_of`.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of LeftOver
        One for each model, in their order.
    """
    found = work.each("judging", left_over, [(model, runs, noise) for model in models])
    work.simulations.add(sum(left.simulations for left in found))
    return found


def held_out(base: Model, model: Model, runs: Sequence[MeasuredRun], noise: dict[str, Any], work: Work) -> HeldOut:
    """Judge a model with effects, against the calibrated machine, by runs that neither was fitted to.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    model : apesim.studies.estimation.model.Model
        The model with effects.
    runs : sequence of apesim.studies.measured.MeasuredRun
    noise : dict
        Noise by sensor, see `apesim.studies.estimation.noise.estimation.noise_of`.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    HeldOut
    """
    return compared([all_left_over(base, (base, model), runs, noise, work)])


def compared(pairs: Sequence[Sequence[LeftOver]]) -> HeldOut:
    """Compare the residuals of the calibrated machine with those of a model with effects.

    With the means w over m windows of the model with effects, the energy that it leaves and its standard deviation by
    noise alone are ``left = sum(w^2) - m`` and ``chance = sqrt(2 m + 4 max(left, 0))``.

    Parameters
    ----------
    pairs : sequence of (LeftOver, LeftOver)
        For each set of runs that of the calibrated machine and that of the model with effects.

    Returns
    -------
    HeldOut
        The sum over all sets of runs.

    Examples
    --------
    >>> before = LeftOver(np.array([3.0, 3.0]), 18.0, np.array([3.0, 3.0]), 0.0, 1)
    >>> after = LeftOver(np.array([1.0, -1.0]), 2.0, np.array([1.0, -1.0]), 0.0, 1)
    >>> judged = compared([(before, after)])
    >>> judged.before, judged.after, judged.removed, judged.left, judged.chance
    (3.0, 1.0, 16.0, 0.0, 2.0)
    """
    samples = sum(len(base.plain) for base, _ in pairs)
    before = sum(float(base.plain @ base.plain) for base, _ in pairs)
    after = sum(float(model.plain @ model.plain) for _, model in pairs)
    removed = sum(base.misfit - model.misfit for base, model in pairs)
    windows = sum(len(model.windowed) for _, model in pairs)
    left = sum(float(model.windowed @ model.windowed) for _, model in pairs) - windows
    chance = float(np.sqrt(2.0 * windows + 4.0 * max(left, 0.0)))
    floor = float(np.sqrt(sum(model.scatter for _, model in pairs) / max(1, samples - windows)))
    misfit = sum(model.misfit for _, model in pairs)
    before, after = (float(np.sqrt(squares / samples)) for squares in (before, after))
    return HeldOut(samples, before, after, removed, left, chance, floor, misfit)


def leave_one_out(base: Model, model: Model, work: Work) -> HeldOut | None:
    """Judge two models by each operating point in turn, both fitted anew to all the others.

    It is cross-validation [1]_ over operating points.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    model : apesim.studies.estimation.model.Model
        The model with effects.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    HeldOut or None
        The sum over all operating points; None: there is one point alone.

    References
    ----------
    .. [1] M. Stone, "Cross-validatory choice and assessment of statistical predictions", J. R. Statist. Soc. B 36,
       1974, pp. 111-147, doi 10.1111/j.2517-6161.1974.tb00994.x.
    """
    points = points_of(base.residuals.runs)
    if len(points) < 2:
        return None
    pairs = work.each("judging", _without, [(base, model, point) for point in points])
    work.simulations.add(sum(left.simulations for pair in pairs for left in pair))
    return compared(pairs)


def _without(base: Model, model: Model, point: MeasuredRun) -> list[LeftOver]:
    """The residuals of two models at an operating point, both fitted anew without it."""
    runs, noise, pair = base.residuals.runs, base.residuals.noise, []
    kept = [run for run in runs if not is_at(run, point)]
    out = [run for run in runs if is_at(run, point)]
    starts = starts_at(base.residuals.machine, kept, base.residuals.parameters, base.fitted.x)
    for one in (base, model):
        residuals = one.residuals.with_runs(kept, starts)
        fitted = descend(residuals, one.fitted.x, steps=one.fitted.steps)
        left = left_over(Model(one.candidates, residuals, fitted), out, noise)
        pair.append(left._replace(simulations=left.simulations + residuals.simulations))
    return pair


def judge_held_out(
    calibrated: Model, choices: list[Choice], measured: Measured, work: Work
) -> tuple[list[Choice], HeldOut | None]:
    """Judge the best explanation by the gate runs, or by operating points left out one at a time.

    Where there are gate runs, what each explanation leaves of them counts beside its cost.

    Parameters
    ----------
    calibrated : apesim.studies.estimation.model.Model
        The calibrated machine.
    choices : list of apesim.studies.gap.search.model_selection.Choice
        The best first.
    measured : apesim.studies.measured.Measured
    work : apesim.studies.gap.work.Work

    Returns
    -------
    choices : list of apesim.studies.gap.search.model_selection.Choice
        The best first.
    judged : HeldOut or None
        None: there is nothing to hold out.
    """
    runs, noise = measured.of(GATE), calibrated.residuals.noise
    if not choices or choices[0].cost >= calibrated.cost:
        return choices, None
    if not runs:
        return choices, leave_one_out(calibrated, choices[0].model, work)
    single = next((choice for choice in choices if len(choice.names) == 1), None)
    near = [c for c in choices if c is single or c.cost - choices[0].cost < 4.0 * AMBIGUOUS_COST]
    before, *after = all_left_over(calibrated, [calibrated, *(c.model for c in near)], runs, noise, work)
    left = {c.names: own for c, own in zip(near, after, strict=True)}
    near = [Choice(c.model, c.cost + left[c.names].misfit - before.misfit) for c in near]
    choices = sorted(near, key=lambda choice: choice.cost)
    return choices, compared([(before, left[choices[0].names])])
