"""The scatter between runs, taken at a machine with effects, for all models that are compared.

What is missing in a machine changes how supply, friction and dead time move the samples of a run. Scatter that is
whitened along the directions of the machine without it leaves a part of itself, which then looks like faults of single
files, or like further effects.
"""

from collections.abc import Sequence

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.nuisance_space import NuisanceSpace, find_nuisance_space
from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.estimation.scatter import Scatter, find_scatter_at
from apesim.studies.gap.search.calibrated_gap import CalibratedGap
from apesim.studies.gap.search.model_selection import PricedModel, find_limit
from apesim.studies.gap.search.phases import find_local_shapes
from apesim.studies.gap.search.score_test import Sensitivity, find_scores
from apesim.studies.gap.stage_work import Work
from apesim.studies.measured import MeasuredRun


def take_scatter_at_best(
    gap: CalibratedGap, fits: Sequence[PricedModel], others: Sequence[MeasuredRun], work: Work
) -> tuple[CalibratedGap, list[PricedModel]]:
    """Take the directions of a scatter at the best model with effects, and fit all models anew with them.

    The fits come the best first. The gap is the one given where runs do not scatter, or where no model with effects is
    better than the calibrated machine; `others` are runs that are held out, and scatter as much. The test for a gap
    stays as it is: it asks whether the machine without effects explains the data.
    """
    base = gap.calibrated

    # The best model with effects of the rig: a fault of one file does not change what supply or friction do in a run.
    best = min((choice for choice in fits if _is_of_rig(choice.model)), key=lambda choice: choice.cost, default=None)
    if base.residuals.scatter is None or best is None or best.cost >= base.cost:
        return gap, sorted(fits, key=lambda choice: choice.cost)

    # Where a run of that model ends early its directions are not known, and all stays as it is.
    scatter = unless_ended(find_scatter_at, best.model, others)
    if scatter is None:
        return gap, sorted(fits, key=lambda choice: choice.cost)

    # All models with one scatter, or their costs could not be compared. One far behind is not fitted to its end.
    calibrated = fit_with_scatter(base, scatter)
    limit = find_limit(base, best.model.cost)
    tasks = [(fit_with_scatter, choice.model, scatter, limit) for choice in fits]
    models = work.each("fitting effects", unless_ended, tasks)
    pairs = [(choice, model) for choice, model in zip(fits, models, strict=True) if model]
    work.simulations.add(sum(model.residuals.simulations for _, model in pairs))

    # What a model's effects are charged with stays: only its sum of squares is new.
    again = [PricedModel(model, choice.cost - choice.model.cost + model.cost) for choice, model in pairs]

    # Sensitivities keep what was simulated, and are whitened anew.
    space = find_nuisance_space(calibrated.fitted.jacobian)
    sensitivities, faults = (
        [_change_scatter(each, base, scatter, space) for each in every] for every in (gap.sensitivities, gap.faults)
    )
    return (
        gap._replace(
            calibrated=calibrated,
            sensitivities=sensitivities,
            faults=faults,
            scores=find_scores(sensitivities, calibrated.fitted.residuals),
            local_shapes=find_local_shapes(calibrated.residuals, gap.marks, space),
        ),
        sorted(again, key=lambda choice: choice.cost),
    )


def _is_of_rig(model: Model) -> bool:
    """Whether a model adds effects, and no fault of a file."""
    return bool(model.candidates) and not any(candidate.file for candidate in model.candidates)


def fit_with_scatter(model: Model, scatter: Scatter, limit: float = np.inf) -> Model:
    """Fit a model anew where what scatters moves the runs in other directions; its residuals know a scatter.

    A fit whose sum of squares stays above `limit` is of no interest, see
    `apesim.studies.estimation.levenberg_marquardt.descend`. Raises EndedEarly where a simulation does not come to its
    end.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> model = explain_example().best
    >>> again = fit_with_scatter(model, Scatter(("supply.pressure",), (0.3,), 1, {}))
    >>> again.residuals.scatter.keys, abs(again.cost - model.cost) < 0.1
    (('supply.pressure',), True)
    """
    before = model.fitted
    own = model.residuals.with_parameters(model.residuals.parameters)  # with a counter of its own
    n = len(before.data_residuals)
    jacobian = np.vstack([own.change_scatter(before.jacobian[:n], scatter), before.jacobian[n:]])
    residuals = own.with_scatter(scatter)
    fitted = descend(residuals, before.x, jacobian, before.steps, is_exact=before.converged, limit=limit)
    return model._replace(residuals=residuals, fitted=fitted)


def _change_scatter(sensitivity: Sensitivity, base: Model, scatter: Scatter, space: NuisanceSpace) -> Sensitivity:
    """A sensitivity of the calibrated machine, whitened by another scatter."""
    n = len(base.fitted.data_residuals)
    changed = base.residuals.change_scatter(sensitivity.effect[:n, None], scatter)[:, 0]
    effect = np.append(changed, sensitivity.effect[n:])
    projected = space.project_out(effect)
    return sensitivity._replace(
        effect=effect, projected=projected, retained=float(np.linalg.norm(projected) / np.linalg.norm(effect))
    )
