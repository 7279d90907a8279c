"""Forward selection by BIC over the effects of the library, as PEtab Select ranks them, with all nuisances free."""

from math import log
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from apesim.studies.gap.search.candidates import find_candidates

from .fits import STARTS, Fits

MOST = 3
"""Effects that are added, at most."""
REFITTED = 2
"""Effects of each step that are fitted through the simulator; a straight model says which."""
STEP = 1e-3


class Selected(NamedTuple):
    """A model of the space, fitted with all nuisances."""

    bic: float
    """Up to a constant that all models share."""
    effects: tuple
    """Candidates that it adds."""
    x: np.ndarray
    """Nuisances, then the effects' strengths."""
    deviation: np.ndarray
    """Standard deviations of x by the curvature."""


def select_by_bic(machine, measured, effects):
    """Fit the calibrated machine, then add the effect that lowers BIC most, until none does.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
    effects : sequence of apesim.effect.Effect

    Returns
    -------
    Selected
        The last model.
    list of Selected
        All that were fitted, the last step's alone in the end.
    list of apesim.studies.estimation.parameters.Parameter
        Nuisances.
    """
    fits = Fits(machine, measured)
    candidates = find_candidates(machine, measured.bench, effects)
    best = fitted(fits, (), np.zeros(len(fits.parameters)))
    tried = [best]
    for _ in range(MOST):
        others = [one for one in candidates if one.name not in {each.name for each in best.effects}]
        models = [fitted(fits, (*best.effects, one), start) for one, start in promising(fits, best, others)]
        tried += models
        lowest = min(models, key=lambda model: model.bic, default=best)
        if lowest.bic >= best.bic:
            break
        best = lowest
    return best, tried, fits.parameters


def parameters_of(fits, effects):
    """Nuisances and the first strength of each effect."""
    return [*fits.parameters, *(one.strengths[0] for one in effects)]


def fitted(fits, effects, start):
    """A model from a start."""
    parameters = parameters_of(fits, effects)
    low, high = (np.array([one[i] for one in parameters]) for i in (2, 3))
    found = least_squares(
        lambda x: fits.errors(parameters, x), np.clip(start, low, high), bounds=(low, high), diff_step=STEP, max_nfev=5
    )
    n = len(found.fun) - len(fits.parameters)
    deviation = np.sqrt(np.diag(np.linalg.pinv(found.jac.T @ found.jac)))
    return Selected(2.0 * found.cost + log(n) * len(effects), effects, found.x, deviation)


def promising(fits, model, candidates):
    """The effects that a straight model adds with most effect, each with where a fit may start."""
    parameters = parameters_of(fits, model.effects)
    errors = fits.errors(parameters, model.x)

    def column(among, x, i, step):
        return (fits.errors(among, x + step * np.eye(len(x))[i]) - errors) / step

    columns = np.column_stack([column(parameters, model.x, i, STEP) for i in range(len(parameters))])
    ranked = []
    for one in candidates:
        parameter = one.strengths[0]
        step = STARTS[0] * (parameter.high or parameter.low)
        x = np.append(model.x, 0.0)
        own = column([*parameters, parameter], x, len(parameters), step)
        slopes = np.column_stack([columns, own])
        change = np.linalg.lstsq(slopes, -errors, rcond=None)[0]
        change[-1] = np.clip(change[-1], parameter.low, parameter.high)
        ranked.append((float(np.sum((errors + slopes @ change) ** 2)), one, x + change))
    ranked.sort(key=lambda row: row[0])
    return [(one, start) for _, one, start in ranked[:REFITTED]]
