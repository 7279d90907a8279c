"""Whether the numbers of a fitted model are plausible."""

import numpy as np

from apesim.studies.estimation.model import MAX_PULL, Model
from apesim.studies.gap.reasons import Reason, ReasonKind
from apesim.studies.gap.thresholds import MAX_CORRECTED, MAX_CORRECTION, MAX_EXCESS


def find_implausible(model: Model) -> Reason | None:
    """The reason for which a fitted model is refused by its own numbers; None: they are plausible.

    More than `MAX_CORRECTED` numbers of the machine are pulled beyond `MAX_PULL`, or one beyond `MAX_CORRECTION`, or a
    strength is beyond its range by more than `MAX_EXCESS` standard deviations of its estimate, or a number of the file
    that counts as exact is at the end of what is tried.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> model = explain_example().best
    >>> find_implausible(model) is None
    True
    >>> far = np.where(model.residuals.known, 5.0, model.fitted.x)
    >>> str(find_implausible(model._replace(fitted=model.fitted._replace(x=far))))  # doctest: +ELLIPSIS
    'the best explanation needs ... numbers of the machine beyond 4 prior sigmas'
    """
    if len(model.pulled) > MAX_CORRECTED:
        return ReasonKind.MANY_FAR_NUMBERS.with_facts(number=len(model.pulled), limit=MAX_PULL)
    if model.pulled and abs(model.fitted.x[model.pulled[0]]) > MAX_CORRECTION:
        return ReasonKind.NUMBER_TOO_FAR.with_facts(key=model.corrected[0], limit=MAX_CORRECTION)
    sigmas = np.sqrt(np.diag(model.fitted.covariance))
    for parameter, x, sigma in zip(model.residuals.parameters, model.fitted.x, sigmas, strict=True):
        low, high = parameter.ends
        if parameter.is_file_number and not low < x < high:
            return ReasonKind.BEYOND_ITS_RANGE.with_facts(key=parameter.key)
        if parameter.reach > 1.0 and (x - MAX_EXCESS * sigma > high or x + MAX_EXCESS * sigma < low):
            return ReasonKind.BEYOND_ITS_RANGE.with_facts(key=parameter.key)
    return None
