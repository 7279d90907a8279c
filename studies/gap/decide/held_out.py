"""How large the gap is on runs that nothing was fitted to: the size that names an effect, or refuses it.

What is left is freed of what the parameters' uncertainty allows: the least of ``|e(x + d)|^2 + d C^-1 d`` over shifts
d of the parameters. Noise is averaged out over windows, so that a gap far below the noise of a sample is seen.
"""

from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import Problem
from apesim.studies.gap.decide.operating_points import is_at, points_of
from apesim.studies.gap.search.model_selection import Choice
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, SURE
from apesim.studies.gap.work import Work
from apesim.studies.measured import GATE, Measured

WINDOWS = 50
"""Number of windows of each channel of each run."""


class HeldOut(NamedTuple):
    """Two models on the same runs."""

    samples: int
    before: float
    """Root mean square of what the calibrated machine leaves, over the noise."""
    after: float
    """Size of what the model with its effects leaves."""
    removed: float
    """Energy of the gap that the effects took away [standard deviations squared]."""
    left: float
    """Energy that is still there."""
    chance: float
    """Standard deviation of `left` by noise alone."""
    noise_floor: float = 1.0
    """Root mean square of what varies within windows of what the model with its effects leaves, over the noise."""
    misfit: float = 0.0
    """Sum of squares of what the model with its effects leaves, the parameters' uncertainty taken off."""

    @property
    def settled_before(self):
        """Size `before`, the parameters' uncertainty taken off."""
        return float(np.sqrt((self.misfit + self.removed) / self.samples))

    @property
    def settled_after(self):
        """Size `after`, the parameters' uncertainty taken off."""
        return float(np.sqrt(self.misfit / self.samples))

    @property
    def left_surely(self):
        """Energy that is still there, as far as it stands out of noise."""
        return max(0.0, self.left - SURE * self.chance)

    @property
    def share(self):
        """Share of the gap's energy that is gone; 0 where nothing was removed."""
        return self.removed / (self.removed + self.left_surely) if self.removed > 0.0 else 0.0

    @property
    def size(self):
        """Root mean square of the gap that is still there, over the noise."""
        return float(np.sqrt(self.left_surely / self.samples))

    @property
    def size_before(self):
        """Root mean square of the gap without the effects."""
        return float(np.sqrt(max(0.0, self.removed + self.left) / self.samples))


class LeftOver(NamedTuple):
    """What a model leaves of runs."""

    plain: np.ndarray
    """[standard deviations], shape (n,)"""
    misfit: float
    """Sum of squares, the parameters' uncertainty taken off."""
    windowed: np.ndarray
    """Means over windows [standard deviations of a mean], shape (m,)."""
    scatter: float
    """Sum of squares of `plain` about its means over windows."""
    simulations: int
    """That it took."""


def left_over(model, runs, noise):
    """What a model leaves of runs that it was not fitted to.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    runs : sequence of apesim.studies.measured.MeasuredRun
    noise : dict
        See `apesim.studies.estimation.noise.estimation.noise_of`.

    Returns
    -------
    LeftOver
    """
    problem = Anchored(model, runs, noise)
    errors = problem.errors(model.fitted.x)
    settled = descend(problem, model.fitted.x, problem.jacobian(model.fitted.x, errors))
    n = len(errors) - len(model.fitted.x)
    windowed, _ = _windows(problem.parted(settled.errors))
    _, scatter = _windows(problem.parted(errors))
    return LeftOver(errors[:n], settled.cost, windowed, scatter, problem.simulations)


def _windows(channels):
    """Sums over windows of channels, over the root of their length, (m,) array; and the squares about their means."""
    parts = [part for own in channels for part in np.array_split(own, min(WINDOWS, len(own)))]
    sums = np.array([part.sum() / np.sqrt(len(part)) for part in parts])
    return sums, float(sum(np.sum(part**2) for part in parts) - sums @ sums)


class Anchored(Problem):
    """Runs that a model was not fitted to; its parameters are known as well as its own runs tell them.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    runs : sequence of apesim.studies.measured.MeasuredRun
    noise : dict
        See `apesim.studies.estimation.noise.estimation.noise_of`.
    """

    def __init__(self, model, runs, noise):
        super().__init__(model.problem.machine, runs, model.problem.parameters, noise)
        self.steps = model.problem.steps.copy()
        self.anchor, self.root = model.fitted.x, np.linalg.qr(model.fitted.jacobian, mode="r")

    def pulls(self, x):
        """Towards the fit."""
        return self.root @ (x - self.anchor)


def all_left_over(base, models, runs, noise, work):
    """What each of several models leaves of runs, see `left_over`; the calibrated machine counts the simulations.

    Returns
    -------
    list of LeftOver
    """
    found = work.each("judging", left_over, [(model, runs, noise) for model in models])
    base.problem.simulations += sum(left.simulations for left in found)
    return found


def held_out(base, model, runs, noise, work):
    """Judge a model with effects, and the calibrated machine, by runs that neither was fitted to; see `left_over`.

    Returns
    -------
    HeldOut
    """
    return compared([all_left_over(base, (base, model), runs, noise, work)])


def compared(pairs):
    """Compare what two models leave.

    Parameters
    ----------
    pairs : list of pairs of LeftOver
        Of the calibrated machine and of the model with effects, for each set of runs.

    Returns
    -------
    HeldOut
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


def leave_one_out(base, model, work):
    """Judge two models fitted anew without one operating point, for each, by the runs left out.

    Returns
    -------
    HeldOut or None
        None: there is one point alone.
    """
    points = points_of(base.problem.runs)
    if len(points) < 2:
        return None
    pairs = work.each("judging", _without, [(base, model, point) for point in points])
    base.problem.simulations += sum(left.simulations for pair in pairs for left in pair)
    return compared(pairs)


def _without(base, model, point):
    """What two models leave of an operating point that they are not fitted to."""
    runs, noise, starts, pair = base.problem.runs, base.problem.noise, {}, []
    kept = [run for run in runs if not is_at(run, point)]
    out = [run for run in runs if is_at(run, point)]
    for one in (base, model):
        problem = one.problem.on(kept)
        problem.starts = starts
        left = left_over(Model(one.candidates, problem, descend(problem, one.fitted.x)), out, noise)
        pair.append(left._replace(simulations=left.simulations + problem.simulations))
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
    runs, noise = measured.of(GATE), calibrated.problem.noise
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
