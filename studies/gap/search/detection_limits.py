"""The size from which data show an effect."""

from collections.abc import Iterable
from itertools import combinations
from math import copysign, inf, log
from typing import Any

import numpy as np

from apesim.engine.effects import ALL_EFFECTS
from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals
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


def clearest(columns: Iterable[Sensitivity]) -> dict[str, Sensitivity]:
    """The probe of each candidate by which it is seen from the smallest size on.

    Among probes of one strength and shape, which differ in size, the one counts whose length is nearest to
    `N_SIGMA_VISIBLE`, as an effect need not grow in proportion. Among shapes the one counts that is seen best; a shape
    that acts by itself, as breakaway does, is kept small.

    Parameters
    ----------
    columns : iterable of apesim.studies.gap.search.score_test.Sensitivity

    Returns
    -------
    dict of apesim.studies.gap.search.score_test.Sensitivity
        By name of the candidate.
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


def least(column: Sensitivity) -> float:
    """The smallest size at which an effect is seen, by one probe and in proportion to it.

    It is ``|x| N_SIGMA_VISIBLE / length`` for a probe of size x and the length of what it does to the data.

    Parameters
    ----------
    column : apesim.studies.gap.search.score_test.Sensitivity

    Returns
    -------
    float
        Over the range of the strength; inf where the probe does nothing that nuisances cannot imitate.
    """
    return abs(column.probe.x[column.probe.strength]) * N_SIGMA_VISIBLE / column.length if column.length else inf


def sharpened(residuals: WhitenedResiduals, fitted: Fitted, column: Sensitivity) -> Sensitivity:
    """A probe at the very size from which its effect is seen, as an effect need not grow in proportion to its size.

    Up to `STEPS` probes are simulated, each where a power law through the last two reaches `N_SIGMA_VISIBLE`.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
        Its parameters are the nuisances.
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
        Fit of the residuals.
    column : apesim.studies.gap.search.score_test.Sensitivity
        The probe to begin with.

    Returns
    -------
    apesim.studies.gap.search.score_test.Sensitivity
        At the end of the range where the effect is not seen even there; the last that could be simulated where a
        simulation ends early.
    """
    probe, space = column.probe, find_nuisance_space(fitted.jacobian)
    wider = residuals.with_parameters([*residuals.parameters, *probe.candidate.parameters])
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
            effect = wider.at(np.append(fitted.x, x))[: len(fitted.residuals)] - fitted.residuals
        except EndedEarly:
            break
        projected = space.project_out(effect)
        length = float(np.linalg.norm(projected))
        if length == 0.0:
            break
        power = np.clip(log(length / column.length) / log(size / abs(own)), *POWERS)
        column = Sensitivity(probe, effect, projected, length / float(np.linalg.norm(effect)))
    return column


def detection_limits(columns: Iterable[Sensitivity]) -> dict[str, dict[str, Any]]:
    """The detection limit of each candidate: the size that these data would show with `N_SIGMA_VISIBLE` sigmas.

    Two effects are of one class where the cosine between what they do to the data, nuisances projected out, is above
    `ALIKE`.

    Parameters
    ----------
    columns : iterable of apesim.studies.gap.search.score_test.Sensitivity

    Returns
    -------
    dict of dict
        By name of the candidate: ``parameter``, ``unit``; ``limit`` in that unit, None where it is beyond the range;
        ``kept``, the share of the effect that is left once nuisances are projected out; ``class``, the other effects
        within their limits that sensors and runs hardly distinguish from it.
    """
    found, best = {}, clearest(columns)
    for name, column in best.items():
        parameter, x = column.probe.parameter, least(column)
        if parameter.inverse:  # the weakest there is may be seen already
            x = max(x, parameter.low)
        found[name] = {
            "parameter": parameter.key.split(".")[-1],
            "unit": parameter.declaration.unit,  # type: ignore[attr-defined]
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
