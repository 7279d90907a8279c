"""Whether the numbers of a fitted model are plausible."""

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.gap.reasons import Reason, ReasonKind
from apesim.studies.gap.thresholds import MAX_EXCESS, MAX_PULL


def pulled(model: Model) -> list[int]:
    """Find the nuisances that a fit pulls beyond `MAX_PULL` prior standard deviations.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model

    Returns
    -------
    list of int
        Their places among the parameters, the farthest pulled first.
    """
    far = [int(j) for j in np.flatnonzero(model.residuals.known) if abs(model.fitted.x[j]) > MAX_PULL]
    return sorted(far, key=lambda j: -abs(model.fitted.x[j]))


def implausible(model: Model) -> Reason | None:
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
    """
    far = [model.residuals.parameters[j].key for j in pulled(model)]
    if far:
        return ReasonKind.NUISANCE_STILL_FAR.with_facts(key=far[0], limit=MAX_PULL)
    deviations = np.sqrt(np.diag(model.fitted.covariance))
    for parameter, x, deviation in zip(model.residuals.parameters, model.fitted.x, deviations, strict=True):
        low, high = parameter.ends
        if parameter.reach > 1.0 and (x - MAX_EXCESS * deviation > high or x + MAX_EXCESS * deviation < low):
            return ReasonKind.BEYOND_ITS_RANGE.with_facts(key=parameter.key)
    return None
