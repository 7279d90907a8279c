"""How large the gap is on runs that nothing was fitted to: the size that names an effect, or refuses it.

The parameters may move within their uncertainty: what counts is the least of ``|e(x + d)|^2 + d' C^-1 d`` over shifts d
of the parameters, with the covariance C that the fitted runs give them. Noise is averaged out over windows, so that a
gap far below the noise of a sample is seen.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.engine_starts import starts_at
from apesim.studies.estimation.levenberg_marquardt import Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.decide.operating_points import find_points, is_at
from apesim.studies.gap.decide.windows import average_over_windows
from apesim.studies.gap.search.model_selection import PricedModel
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, MIN_SHOWN, SURE
from apesim.studies.measured import GATE, Measured, MeasuredRun


class HeldOut(NamedTuple):
    """The gap that the calibrated machine and a model with effects leave on runs that neither was fitted to."""

    samples: int
    """Number of samples."""
    rms_before: float
    """Root mean square of the residuals of the calibrated machine, over the noise."""
    rms_after: float
    """Root mean square of the residuals of the model with its effects, over the noise."""
    removed_energy: float
    """Energy of the gap that the effects take away: by how much they lower the sum of squares [standard deviations
    squared]."""
    remaining_energy: float
    """Energy of the gap that is still there: the sum of squares of the means over windows, less what noise gives them
    [standard deviations squared]."""
    remaining_sigma: float
    """Standard deviation of `remaining_energy` by noise alone [standard deviations squared]."""
    noise_floor: float = 1.0
    """Root mean square of what varies within windows of what the model with its effects leaves, over the noise."""
    misfit: float = 0.0
    """Sum of squares of what the model with its effects leaves, the parameters' uncertainty taken off."""

    @property
    def settled_before(self) -> float:
        """Size `rms_before`, the parameters' uncertainty taken off."""
        return float(np.sqrt((self.misfit + self.removed_energy) / self.samples))

    @property
    def settled_after(self) -> float:
        """Size `rms_after`, the parameters' uncertainty taken off."""
        return float(np.sqrt(self.misfit / self.samples))

    @property
    def significant_energy(self) -> float:
        """Energy that is still there and stands out of noise: ``remaining_energy - SURE remaining_sigma`` or 0."""
        return max(0.0, self.remaining_energy - SURE * self.remaining_sigma)

    @property
    def removed_share(self) -> float:
        """Share of the gap's energy that is gone, ``removed / (removed + significant)``; 0 if nothing was removed."""
        whole = self.removed_energy + self.significant_energy
        return self.removed_energy / whole if self.removed_energy > 0.0 else 0.0

    @property
    def size_after(self) -> float:
        """Root mean square of the gap that is still there, over the noise."""
        return float(np.sqrt(self.significant_energy / self.samples))

    @property
    def size_before(self) -> float:
        """Root mean square of the gap without the effects."""
        return float(np.sqrt(max(0.0, self.removed_energy + self.remaining_energy) / self.samples))


class HeldOutResiduals(NamedTuple):
    """The residuals of a model on runs that it was not fitted to."""

    residuals: np.ndarray
    """Whitened residuals with the parameters as fitted, (n,) [standard deviations]."""
    misfit: float
    """Least sum of squares with the parameters moved, and the price of that: ``|e(x + d)|^2 + d' C^-1 d``."""
    window_means: np.ndarray
    """Means over windows with the parameters moved, (m,) [standard deviations of a mean]."""
    scatter: float
    """Sum of squares of `residuals` about its means over windows."""
    simulations: int
    """Number of simulations that it took."""


def find_held_out_residuals(model: Model, runs: Sequence[MeasuredRun], noise: dict[str, Any]) -> HeldOutResiduals:
    """The residuals of a model on runs it was not fitted to, with its parameters moved within their uncertainty.

    `noise` is that of `apesim.studies.estimation.noise.estimation.noise_of`. Raises EndedEarly where the simulation of
    a run does not come to its end with the parameters as fitted.

    >>> from apesim.studies.gap.example_bench import explain_example, read_example
    >>> explanation = explain_example()
    >>> checked = find_held_out_residuals(explanation.best, read_example().of("check"), explanation.noise)
    >>> len(checked.residuals), len(checked.window_means), round(float(checked.residuals.std()), 1)
    (160, 50, 1.0)
    """
    residuals, errors, settled = settle(model, runs, noise)
    n = len(errors) - len(model.fitted.x)
    window_means, before = (
        np.concatenate([average_over_windows(values) for values in residuals.by_block(each)])
        for each in (settled.residuals, errors)
    )
    scatter = float(errors[:n] @ errors[:n] - before @ before)
    return HeldOutResiduals(errors[:n], settled.cost, window_means, scatter, residuals.simulations)


def settle(
    model: Model, runs: Sequence[MeasuredRun], noise: dict[str, Any]
) -> "tuple[AnchoredResiduals, np.ndarray, Fitted]":
    """Move the parameters of a model within their uncertainty, to runs that it was not fitted to.

    The second value holds the residuals with the parameters as fitted, (n + p,) [standard deviations], the pulls last;
    the third is the fit with the parameters moved. `noise` is that of
    `apesim.studies.estimation.noise.estimation.noise_of`. Raises EndedEarly where the simulation of a run does not come
    to its end with the parameters as fitted.
    """
    residuals = AnchoredResiduals(model, runs, noise)
    errors = residuals.at(model.fitted.x)
    return residuals, errors, descend(residuals, model.fitted.x, steps=model.fitted.steps, errors=errors)


class AnchoredResiduals(WhitenedResiduals):
    """Residuals of runs that a model was not fitted to, its fit standing for the priors of all its parameters.

    The pulls behind the residuals are ``R (x - x_fit)`` with ``R'R = J'J`` of the fit, so that their squares add up to
    the price of a shift d of the parameters, ``d' C^-1 d``. `noise` is that of
    `apesim.studies.estimation.noise.estimation.noise_of`.
    """

    def __init__(self, model: Model, runs: Sequence[MeasuredRun], noise: dict[str, Any]) -> None:
        machine, parameters = model.residuals.machine, model.residuals.parameters
        starts = starts_at(machine, runs, parameters, model.fitted.x)
        super().__init__(machine, runs, parameters, noise, starts=starts, scatter=model.residuals.scatter)
        self.anchor, self.root = model.fitted.x, np.linalg.qr(model.fitted.jacobian, mode="r")

    def pulls(self, x: np.ndarray) -> np.ndarray:
        """Pulls towards the fit, ``R (x - x_fit)``, (p,) [standard deviations]; `x` (p,)."""
        return self.root @ (x - self.anchor)


def find_all_held_out_residuals(
    base: Model, models: Iterable[Model], runs: Sequence[MeasuredRun], noise: dict[str, Any], work: Work
) -> list[HeldOutResiduals]:
    """The residuals of several models on runs that they were not fitted to, see `find_held_out_residuals`.

    They come in the order of the models; `base` is the calibrated machine. The simulations are added to those of
    `work`.
    """
    judged = work.each("judging", find_held_out_residuals, [(model, runs, noise) for model in models])
    work.simulations.add(sum(each.simulations for each in judged))
    return judged


def judge_by_runs(base: Model, model: Model, runs: Sequence[MeasuredRun], noise: dict[str, Any], work: Work) -> HeldOut:
    """Judge a model with effects, against the calibrated machine `base`, by runs that neither was fitted to.

    `noise` is that of `apesim.studies.estimation.noise.estimation.noise_of`; the simulations are added to those of
    `work`.

    >>> from apesim.studies.gap.example_bench import explain_example, read_example
    >>> explanation = explain_example()
    >>> models, runs = (explanation.calibrated, explanation.best), read_example().of("check")
    >>> judged = judge_by_runs(*models, runs, explanation.noise, Work())
    >>> judged.samples, judged.rms_before > judged.rms_after, judged.size_after < 0.15
    (160, True, True)
    """
    return compare_residuals([find_all_held_out_residuals(base, (base, model), runs, noise, work)])


def compare_residuals(pairs: Sequence[Sequence[HeldOutResiduals]]) -> HeldOut:
    """Compare the residuals of the calibrated machine with those of a model with effects.

    Each pair holds both, in this order, for one set of runs; the result is the sum over all sets. With the means w over
    m windows of the model with effects, the energy that it leaves and its standard deviation by noise alone are ``E =
    sum(w^2) - m`` and ``sqrt(2 m + 4 max(E, 0))``.

    >>> before = HeldOutResiduals(np.array([3.0, 3.0]), 18.0, np.array([3.0, 3.0]), 0.0, 1)
    >>> after = HeldOutResiduals(np.array([1.0, -1.0]), 2.0, np.array([1.0, -1.0]), 0.0, 1)
    >>> judged = compare_residuals([(before, after)])
    >>> judged.rms_before, judged.rms_after, judged.removed_energy, judged.remaining_energy, judged.remaining_sigma
    (3.0, 1.0, 16.0, 0.0, 2.0)
    """
    samples = sum(len(base.residuals) for base, _ in pairs)
    before = sum(float(base.residuals @ base.residuals) for base, _ in pairs)
    after = sum(float(model.residuals @ model.residuals) for _, model in pairs)
    removed = sum(base.misfit - model.misfit for base, model in pairs)
    windows = sum(len(model.window_means) for _, model in pairs)
    remaining = sum(float(model.window_means @ model.window_means) for _, model in pairs) - windows
    sigma = float(np.sqrt(2.0 * windows + 4.0 * max(remaining, 0.0)))
    floor = float(np.sqrt(sum(model.scatter for _, model in pairs) / max(1, samples - windows)))
    misfit = sum(model.misfit for _, model in pairs)
    before, after = (float(np.sqrt(squares / samples)) for squares in (before, after))
    return HeldOut(samples, before, after, removed, remaining, sigma, floor, misfit)


def leave_one_out(base: Model, model: Model, work: Work) -> HeldOut | None:
    """Judge two models by each operating point in turn, both fitted anew to all the others.

    It is cross-validation over operating points (Stone 1974, doi 10.1111/j.2517-6161.1974.tb00994.x), summed over all
    of them; None where there is one point alone. `base` is the calibrated machine, `model` the one with effects; the
    simulations are added to those of `work`.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> judged = leave_one_out(explanation.calibrated, explanation.best, Work())
    >>> judged.samples, judged.removed_energy > 0.0
    (320, True)
    """
    parts = _leave_each_out(base, model, work)
    return _compare_with_baseline(parts) if parts else None


def _leave_each_out(base: Model, model: Model, work: Work) -> list[list[HeldOutResiduals]]:
    """The residuals of two models and of the baseline at each operating point; none where there is one alone."""
    points = find_points(base.residuals.runs)
    if len(points) < 2:
        return []
    parts = work.each("judging", _judge_without, [(base, model, point) for point in points])
    work.simulations.add(sum(each.simulations for part in parts for each in part))
    return parts


def _compare_with_baseline(parts: Sequence[Sequence[HeldOutResiduals]]) -> HeldOut:
    """Compare a model with the calibrated machine, or with the baseline where the model leaves less than that machine.

    Each part holds the residuals of the calibrated machine, of the model and of the baseline, see `find_baseline`. A
    model that does no better than the calibrated machine has removed nothing, whatever the baseline leaves.
    """
    is_better = sum(after.misfit for _, after, _ in parts) < sum(before.misfit for before, _, _ in parts)
    return compare_residuals([(baseline if is_better else before, after) for before, after, baseline in parts])


def find_baseline(base: Model, model: Model) -> Model:
    """Find the machine without effects that a `model` is held against on runs held out.

    It is the calibrated machine `base`. Where that has pulled a number far, and the model none, the number has taken up
    what is missing: the machine then has the numbers of the model, with its effects off.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> explanation.calibrated.corrected  # stands in for the force that is missing
    ('air.heat_capacity_ratio',)
    >>> len(find_baseline(explanation.calibrated, explanation.best).pulled)
    0
    """
    if not base.pulled or model.pulled:
        return base
    return base._replace(fitted=base.fitted._replace(x=model.fitted.x[: len(base.fitted.x)]))


def _judge_without(base: Model, model: Model, point: MeasuredRun) -> list[HeldOutResiduals]:
    """The residuals of two models, both fitted anew without an operating point, and of their baseline there."""
    runs, noise, again = base.residuals.runs, base.residuals.noise, []
    fitted_runs = [run for run in runs if not is_at(run, point)]
    held_out_runs = [run for run in runs if is_at(run, point)]
    starts = starts_at(base.residuals.machine, fitted_runs, base.residuals.parameters, base.fitted.x)
    for whole in (base, model):
        residuals, known = whole.residuals.with_runs(fitted_runs, starts), whole.fitted
        rows = [own for run, own in zip(runs, whole.residuals.run_slices(), strict=True) if not is_at(run, point)]
        pulls = slice(len(known.data_residuals), None)
        jacobian = np.vstack([known.jacobian[own] for own in (*rows, pulls)])
        fitted = descend(residuals, known.x, jacobian, known.steps, is_exact=known.converged)
        again.append(Model(whole.candidates, residuals, fitted))
    baseline = find_baseline(*again)
    wanted = again if baseline is again[0] else [*again, baseline]
    judged = [find_held_out_residuals(each, held_out_runs, noise) for each in wanted]
    fitting = sum(each.residuals.simulations for each in again)
    before, after = judged[:2]
    against = judged[2] if judged[2:] else before._replace(simulations=0)  # which is counted already
    return [before, after._replace(simulations=after.simulations + fitting), against]


def judge_held_out(
    calibrated: Model, choices: list[PricedModel], measured: Measured, work: Work
) -> tuple[list[PricedModel], HeldOut | None]:
    """Judge the best explanation by the gate runs, or by operating points left out one at a time.

    Where there are gate runs, what each explanation leaves of them counts beside its cost, and those near the best and
    the best single effect alone are kept. Gate runs that hardly show the best one are judged together with the
    operating points. What it is held against is the calibrated machine, see `find_baseline`. The choices come and go
    with the best first; the second value is None where nothing is held out: there is one operating point alone, no
    explanation costs less than the calibrated machine, or without gate runs the best is a fault of one file.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> ranked, judged = judge_held_out(explanation.calibrated, explanation.fits, explanation.measured, Work())
    >>> ranked[0].names, judged.removed_share > 0.9
    (('side_force',), True)
    """
    runs, noise = measured.of(GATE), calibrated.residuals.noise
    if not choices or choices[0].cost >= calibrated.cost:
        return choices, None
    if not runs:
        # No other run tells anything of a fault of one file.
        is_of_file = any(candidate.file for candidate in choices[0].model.candidates)
        return choices, None if is_of_file else leave_one_out(calibrated, choices[0].model, work)
    single = next((choice for choice in choices if len(choice.names) == 1), None)
    near = [c for c in choices if c is single or c.cost - choices[0].cost < 4.0 * AMBIGUOUS_COST]
    before, *others = find_all_held_out_residuals(calibrated, [calibrated, *(c.model for c in near)], runs, noise, work)
    judged = {c.names: residuals for c, residuals in zip(near, others, strict=True)}
    near = [PricedModel(c.model, c.cost + judged[c.names].misfit - before.misfit) for c in near]
    choices = sorted(near, key=lambda choice: choice.cost)
    best = choices[0]

    # What the best one is held against.
    baseline, against, after = find_baseline(calibrated, best.model), before, judged[best.names]
    if baseline is not calibrated:
        (against,) = find_all_held_out_residuals(calibrated, [baseline], runs, noise, work)

    # Gate runs that hardly show the explanation cannot judge it alone: they are one part among the operating points.
    shown, parts = np.linalg.norm(after.window_means - against.window_means), [[before, after, against]]
    if shown < MIN_SHOWN and not any(candidate.file for candidate in best.model.candidates):
        parts += _leave_each_out(calibrated, best.model, work)
    return choices, _compare_with_baseline(parts)
