"""Whether the numbers of a fitted model are plausible."""

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.gap.reasons import Reason, ReasonKind
from apesim.studies.gap.thresholds import MAX_EXCESS, MAX_PULL


def pulled(model: Model) -> list[int]:
    """Numbers of the nuisances beyond `MAX_PULL`, the farthest first."""
    far = [int(j) for j in np.flatnonzero(model.problem.known) if abs(model.fitted.x[j]) > MAX_PULL]
    return sorted(far, key=lambda j: -abs(model.fitted.x[j]))


def implausible(model: Model) -> Reason | None:
    """Why a model is refused by its own numbers; None where it is not."""
    far = [model.problem.parameters[j].key for j in pulled(model)]
    if far:
        return ReasonKind.NUISANCE_STILL_FAR.with_facts(key=far[0], limit=MAX_PULL)
    deviations = np.sqrt(np.diag(model.fitted.covariance))
    for parameter, x, deviation in zip(model.problem.parameters, model.fitted.x, deviations, strict=True):
        low, high = parameter.ends
        if parameter.reach > 1.0 and (x - MAX_EXCESS * deviation > high or x + MAX_EXCESS * deviation < low):
            return ReasonKind.BEYOND_ITS_RANGE.with_facts(key=parameter.key)
    return None
