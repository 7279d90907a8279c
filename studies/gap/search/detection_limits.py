"""The size from which data show an effect."""

from itertools import combinations
from math import copysign, inf, log

import numpy as np

from apesim.engine.effects import ALL_EFFECTS
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.gap.search.score_test import Sensitivity, cosine
from apesim.studies.gap.thresholds import ALIKE, N_SIGMA_VISIBLE

SMALL = 0.1
"""Share of the range of what acts by itself."""
STEPS = 4
CLOSE = 0.02
"""Share of a size, within which it is the size that was looked for."""
POWERS = 0.5, 3.0
"""Powers of its size, with which an effect may grow."""
STRENGTHS = {effect.name: effect.strengths for effect in ALL_EFFECTS}


def clearest(columns):
    """For each candidate the column by which it is seen first.

    Of the probes of one strength and shape, which differ in size, that one which is nearest to what it says: an effect
    need not grow straight. Of shapes the one that is seen best; but what acts by itself, as breakaway does,
    is kept small.

    Parameters
    ----------
    columns : list of apesim.studies.gap.search.score_test.Sensitivity

    Returns
    -------
    dict of apesim.studies.gap.search.score_test.Sensitivity
    """
    alike: dict = {}
    for column in columns:
        probe = column.probe
        shape = probe.x[len(probe.candidate.strengths) :]
        alike.setdefault((probe.candidate.name, probe.strength, shape), []).append(column)
    found: dict = {}
    for (name, _, shape), own in alike.items():
        parameters = own[0].probe.candidate.shapes
        acting = [value for value, p in zip(shape, parameters, strict=True) if p.key.split(".")[-1] in STRENGTHS[name]]
        if any(value > SMALL for value in acting):
            continue
        nearest = min(own, key=lambda column: abs(log(N_SIGMA_VISIBLE / column.length)))
        if name not in found or least(nearest) < least(found[name]):
            found[name] = nearest
    return found


def least(column):
    """Size over the range from which a column says that its effect is seen."""
    return abs(column.probe.x[column.probe.strength]) * N_SIGMA_VISIBLE / column.length if column.length else inf


def sharpened(problem, fitted, column):
    """A column for the very size from which its effect is seen, as an effect need not grow straight.

    Parameters
    ----------
    problem : apesim.studies.estimation.residuals.Problem
        Of the nuisances.
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
    column : apesim.studies.gap.search.score_test.Sensitivity

    Returns
    -------
    apesim.studies.gap.search.score_test.Sensitivity
        For the end of the range, where it is not seen even there.
    """
    probe, space = column.probe, find_nuisance_space(fitted.jacobian)
    wider = problem.with_parameters([*problem.parameters, *probe.candidate.parameters])
    power = 1.0
    for _ in range(STEPS):
        own = probe.x[probe.strength]
        size = min(abs(own) * (N_SIGMA_VISIBLE / column.length) ** (1.0 / power), 1.0)
        if abs(log(size / abs(own))) < CLOSE:
            break
        x = list(probe.x)
        x[probe.strength] = copysign(size, own)
        probe = probe._replace(x=tuple(x))
        try:
            effect = wider.errors(np.append(fitted.x, x))[: len(fitted.errors)] - fitted.errors
        except EndedEarly:
            break
        projected = space.project_out(effect)
        length = float(np.linalg.norm(projected))
        if length == 0.0:
            break
        power = np.clip(log(length / column.length) / log(size / abs(own)), *POWERS)
        column = Sensitivity(probe, effect, projected, length / float(np.linalg.norm(effect)))
    return column


def detection_limits(columns):
    """For each candidate the size that these data show with `N_SIGMA_VISIBLE` deviations; None beyond its range.

    Parameters
    ----------
    columns : list of apesim.studies.gap.search.score_test.Sensitivity

    Returns
    -------
    dict of dict
        ``parameter``, ``unit``, ``limit``; ``kept``: the share that is left once nuisances are projected out;
        ``class``: the others that are seen, and that sensors and runs hardly tell from it, whatever the data say.
    """
    found, best = {}, clearest(columns)
    for name, column in best.items():
        parameter, x = column.probe.parameter, least(column)
        if parameter.inverse:  # the weakest there is may be seen already
            x = max(x, parameter.low)
        found[name] = {
            "parameter": parameter.key.split(".")[-1],
            "unit": parameter.declaration.unit,
            "limit": abs(parameter.shown(parameter.value(x) - parameter.origin)) if x <= 1.0 else None,
            "kept": column.retained,
            "class": [],
        }
    seen = [name for name, limit in found.items() if limit["limit"] is not None]
    for one, other in combinations(seen, 2):
        if abs(cosine(best[one].projected, best[other].projected)) > ALIKE:
            found[one]["class"].append(other)
            found[other]["class"].append(one)
    return found
