"""Forecasts: what each explanation that is still in play foresees of an experiment."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag, solve_triangular

from apesim.studies.estimation.engine_starts import Starts, starts_at
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.nuisance_space import NuisanceSpace
from apesim.studies.estimation.residuals import WhitenedResiduals, first_steps
from apesim.studies.gap.design.expected_information import Forecast
from apesim.studies.gap.design.experiments import Experiment, make_residuals
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.search.phases import find_local_shapes
from apesim.studies.gap.thresholds import AMBIGUOUS_COST

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

MAX_ALTERNATIVES = 4
"""Explanations that an experiment has to split, besides the machine as it is and none of the library: with more, none
of the list does, and each costs seconds."""
NONE_SHARE = 0.5
"""Weight of what is not in the library after a refusal: as much as all that was tried, none of which has earned its
name. A rule, not measured."""
AS_IT_IS = "the machine as it is"
"""Name of the calibrated machine, where it is one of the explanations."""
NONE_OF_THEM = "none of the library"
"""Name of an unknown effect, where it is one of the explanations."""


class Alternative(NamedTuple):
    """An explanation that is still in play."""

    name: str
    weight: float
    """Weight by penalised likelihood, the sum over all alternatives being 1: no probability, as none is calibrated."""
    model: Model | None
    """Fitted machine; None: an effect that is not in the library."""


def list_alternatives(explanation: "Explanation") -> list[Alternative]:
    """List the explanations that are still in play, with their weights, the best first; empty where nothing is in play.

    After a tie they are the best explanation and its rivals; after a refusal the best that were fitted, tables aside,
    the machine as it is, and an effect that is not in the library. The weights are ``exp(-cost / 2)`` by penalised
    cost, of which none counts as more than `AMBIGUOUS_COST` above the best.
    """
    decision, base = explanation.decision, explanation.calibrated
    is_refused = decision.verdict == Verdict.REFUSED
    if not is_refused and decision.verdict not in (Verdict.AMBIGUOUS, Verdict.NAMED_CLASS):
        return []
    choices = [choice for choice in (decision.best, *decision.rivals) if choice]
    if is_refused:
        choices += explanation.ranked or explanation.fits
    models: dict[str, tuple[Model, float]] = {}
    for model, cost in choices:
        models.setdefault(" with ".join(model.names) or AS_IT_IS, (model, cost))
    models = dict(list(models.items())[:MAX_ALTERNATIVES])
    if is_refused or len(models) < 2 or decision.reason.kind is ReasonKind.FAINT:
        models.setdefault(AS_IT_IS, (base, base.cost))
    costs = np.array([cost for _, cost in models.values()])
    weights = np.exp(-0.5 * np.minimum(costs - costs.min(), AMBIGUOUS_COST))
    weights *= (1.0 - NONE_SHARE if is_refused else 1.0) / weights.sum()
    rows = zip(models.items(), weights, strict=True)
    alternatives = [Alternative(name, float(weight), model) for (name, (model, _)), weight in rows]
    return alternatives + [Alternative(NONE_OF_THEM, NONE_SHARE, None)] * is_refused


class Preview(NamedTuple):
    """An experiment as the explanations in play foresee it."""

    experiment: Experiment
    residuals: WhitenedResiduals
    """Residuals of the experiment as a function of the nuisances of the calibrated machine."""
    marks: dict[str, Any]
    """Instants that divide the run, as the calibrated machine has it."""
    base: Forecast
    """Forecast of the calibrated machine."""
    base_values: list[np.ndarray]
    """Values of each block that the calibrated machine gives, (m,) [SI]."""
    forecasts: list[Forecast]
    """Forecast of each alternative."""
    values: list[list[np.ndarray]]
    """Values of each block that each alternative gives, (m,) [SI]; those of the calibrated machine for one that is not
    in the library."""


def preview_experiment(
    experiment: Experiment, explanation: "Explanation", alternatives: Sequence[Alternative], *, refine: bool = True
) -> Preview:
    """Foresee an experiment by each explanation in play, with all that is uncertain.

    With `refine` the sensitivities of the nuisances are found for each explanation anew; without it those of the
    calibrated machine serve all, at a third of the work. Raises EndedEarly where a simulation does not come to its end.
    """
    base, noise = explanation.calibrated, explanation.noise
    leading = next((each.model for each in alternatives if each.model), base)
    starts = starts_at(leading.residuals.machine, [experiment.run], leading.residuals.parameters, leading.fitted.x)
    foreseen, values, residuals, slopes = _foresee(experiment, base, noise, starts)
    (marks,) = residuals.marks(np.append(base.fitted.x, np.zeros(len(residuals.parameters) - len(base.fitted.x))))
    forecasts, each_values = [], []
    for alternative in alternatives:
        if alternative.model is None:
            spread = _spread_unknown(residuals, marks, explanation.gap_size)
            forecasts.append(foreseen._replace(spread=np.column_stack([foreseen.spread, spread])))
            each_values.append(values)
            continue
        known = None if refine else slopes
        forecast, own_values, _, _ = _foresee(experiment, alternative.model, noise, starts, known)
        forecasts.append(forecast)
        each_values.append(own_values)
    return Preview(experiment, residuals, marks, foreseen, values, forecasts, each_values)


def _foresee(
    experiment: Experiment, model: Model, noise: dict[str, Any], starts: Starts, known: np.ndarray | None = None
) -> tuple[Forecast, list[np.ndarray], WhitenedResiduals, np.ndarray]:
    """The forecast of a model, its values by block [SI], the residuals, and the sensitivities (n, p).

    ``known`` are sensitivities of the nuisances, (n, q), that are taken in place of the model's own.
    """
    residuals = make_residuals(experiment, model.residuals.machine, model.residuals.parameters, noise, starts)
    fitted = len(model.fitted.x)
    new = len(residuals.parameters) - fitted
    x, steps = np.append(model.fitted.x, np.zeros(new)), np.append(model.fitted.steps, first_steps(new))
    values = residuals.predicted(x)
    errors = residuals.at(x)  # the experiment has measured nothing: less zero
    n = len(errors) - len(x)
    if known is None:
        slopes = residuals.jacobian(x, errors, steps)[0][:n]
    else:
        own = list(range(fitted - model.added, fitted))
        columns = residuals.jacobian(x, errors, steps, own)[0][:n] if own else np.zeros((n, 0))
        slopes = np.column_stack([known[:, : own[0]], columns, known[:, own[0] :]]) if own else known
    spans = np.array([0.0 if p.prior else 1.0 / (p.high - p.low) for p in model.residuals.parameters])
    information = block_diag(model.fitted.jacobian.T @ model.fitted.jacobian + np.diag(spans**2), np.eye(new))
    root = np.linalg.cholesky(information)
    spread = solve_triangular(root, slopes.T, lower=True).T  # its covariance is that of the fit
    if scatter := model.residuals.scatter:  # the run to come has its own
        spread = np.column_stack([spread, scatter.scale_slopes(residuals.parameters, slopes)])
    return Forecast(errors[:n], spread), values, residuals, slopes


def _spread_unknown(residuals: WhitenedResiduals, marks: dict[str, Any], size: float) -> np.ndarray:
    """Changes of an experiment by an unknown effect, (n, q): as large as the gap, of no known shape.

    They are a constant and a slope of each signal in each phase, each of a root mean square of ``size`` there.
    """
    n = sum(len(block.values) for block in residuals.blocks)
    nothing = NuisanceSpace(np.zeros((n + len(residuals.parameters), 0)))
    shapes = find_local_shapes(residuals, [marks], nothing)[:n]
    counts = np.count_nonzero(shapes, axis=0)
    return size * np.sqrt(counts) * shapes / np.maximum(np.linalg.norm(shapes, axis=0), 1e-12)
