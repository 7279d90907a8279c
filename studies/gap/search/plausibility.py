"""Whether the numbers of a fitted model are plausible."""

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.gap.reasons import Reason, ReasonKind
from apesim.studies.gap.thresholds import MAX_EXCESS, MAX_PULL


def find_pulled(model: Model) -> list[int]:
    """Find the nuisances that a fit pulls beyond `MAX_PULL` prior standard deviations.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model

    Returns
    -------
    list of int
        Their places among the parameters, the farthest pulled first.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> find_pulled(explain_example().best)
    []
    """
    far = [int(j) for j in np.flatnonzero(model.residuals.known) if abs(model.fitted.x[j]) > MAX_PULL]
    return sorted(far, key=lambda j: -abs(model.fitted.x[j]))


def find_implausible(model: Model) -> Reason | None:
    """The reason for which a fitted model is refused by its own numbers.

    A nuisance is pulled beyond `MAX_PULL` prior standard deviations, or a strength is beyond its range by more than
    `MAX_EXCESS` standard deviations of its estimate.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model

    Returns
    -------
    apesim.studies.gap.reasons.Reason or None
        None: its numbers are plausible.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> model = explain_example().best
    >>> find_implausible(model) is None
    True
    >>> far = np.where(model.residuals.known, 5.0, model.fitted.x)
    >>> str(find_implausible(model._replace(fitted=model.fitted._replace(x=far))))
    'the best explanation still needs valve.viscous_friction 4 prior sigmas away'
    """
    far = [model.residuals.parameters[j].key for j in find_pulled(model)]
    if far:
        return ReasonKind.NUISANCE_STILL_FAR.with_facts(key=far[0], limit=MAX_PULL)
    sigmas = np.sqrt(np.diag(model.fitted.covariance))
    for parameter, x, sigma in zip(model.residuals.parameters, model.fitted.x, sigmas, strict=True):
        low, high = parameter.ends
        if parameter.reach > 1.0 and (x - MAX_EXCESS * sigma > high or x + MAX_EXCESS * sigma < low):
            return ReasonKind.BEYOND_ITS_RANGE.with_facts(key=parameter.key)
    return None
