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
from apesim.studies.gap.search.score_test import Sensitivity, find_cosine
from apesim.studies.gap.thresholds import ALIKE, N_SIGMA_VISIBLE

MAX_ACTING_SHAPE = 0.1
"""Share of the range of what acts by itself."""
MAX_STEPS = 4
MIN_STEP = 0.02
"""Share of a size, within which it is the size that was looked for."""
POWER_RANGE = 0.5, 3.0
"""Powers of its size, with which an effect may grow."""
STRENGTHS = {effect.name: effect.strengths for effect in ALL_EFFECTS}


def select_clearest(sensitivities: Iterable[Sensitivity]) -> dict[str, Sensitivity]:
    """The probe of each candidate, by its name, by which it is seen from the smallest size on.

    Among probes of one strength and shape, which differ in size, the one counts whose length is nearest to
    `N_SIGMA_VISIBLE`, as an effect need not grow in proportion. Among shapes the one counts that is seen best; a shape
    that acts by itself, as breakaway does, is kept small.
    """
    alike: dict = {}
    for sensitivity in sensitivities:
        probe = sensitivity.probe
        shape = probe.x[len(probe.candidate.strengths) :]
        alike.setdefault((probe.candidate.name, probe.strength, shape), []).append(sensitivity)
    clearest: dict = {}
    for (name, _, shape), same_shape in alike.items():
        parameters = same_shape[0].probe.candidate.shapes
        acting_shapes = [
            value for value, p in zip(shape, parameters, strict=True) if p.key.split(".")[-1] in STRENGTHS[name]
        ]
        if any(value > MAX_ACTING_SHAPE for value in acting_shapes):
            continue
        nearest = min(same_shape, key=lambda sensitivity: abs(log(N_SIGMA_VISIBLE / sensitivity.length)))
        if name not in clearest or find_visible_size(nearest) < find_visible_size(clearest[name]):
            clearest[name] = nearest
    return clearest


def find_visible_size(sensitivity: Sensitivity) -> float:
    """The smallest size, over the range of the strength, at which an effect is seen, by one probe in proportion to it.

    It is ``|x| N_SIGMA_VISIBLE / length`` for a probe of size x and the length of what it does to the data; inf where
    the probe does nothing that nuisances cannot imitate.

    >>> from apesim.studies.gap.search.candidates import Probe
    >>> probe = Probe(None, x=(0.25,), strength=0)
    >>> find_visible_size(Sensitivity(probe, np.array([6.0, 8.0]), np.array([6.0, 8.0]), 1.0))
    0.125
    """
    return (
        abs(sensitivity.probe.x[sensitivity.probe.strength]) * N_SIGMA_VISIBLE / sensitivity.length
        if sensitivity.length
        else inf
    )


def sharpen_probe(residuals: WhitenedResiduals, fitted: Fitted, sensitivity: Sensitivity) -> Sensitivity:
    """A probe at the very size from which its effect is seen, as an effect need not grow in proportion to its size.

    Up to `MAX_STEPS` probes are simulated, each where a power law through the last two reaches `N_SIGMA_VISIBLE`;
    `residuals` has the nuisances as parameters, `fitted` is its fit. Ends at the end of the range where the effect is
    not seen even there, or at the last that could be simulated where a simulation ends early.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> calibrated = explain_example().calibrated
    >>> clearest = select_clearest(explain_example().sensitivities)["side_force"]
    >>> sharp = sharpen_probe(calibrated.residuals, calibrated.fitted, clearest)
    >>> abs(sharp.length / N_SIGMA_VISIBLE - 1.0) < 0.05
    True
    """
    probe, space = sensitivity.probe, find_nuisance_space(fitted.jacobian)
    wider = residuals.with_parameters([*residuals.parameters, *probe.candidate.parameters])
    power = 1.0
    for _ in range(MAX_STEPS):
        strength = probe.x[probe.strength]
        size = min(abs(strength) * (N_SIGMA_VISIBLE / sensitivity.length) ** (1.0 / power), 1.0)
        if abs(log(size / abs(strength))) < MIN_STEP:
            break
        x = list(probe.x)
        x[probe.strength] = copysign(size, strength)
        probe = probe._replace(x=tuple(x))
        try:
            effect = wider.at(np.append(fitted.x, x))[: len(fitted.residuals)] - fitted.residuals
        except EndedEarly:
            break
        projected = space.project_out(effect)
        length = float(np.linalg.norm(projected))
        if length == 0.0:
            break
        power = np.clip(log(length / sensitivity.length) / log(size / abs(strength)), *POWER_RANGE)
        sensitivity = Sensitivity(probe, effect, projected, length / float(np.linalg.norm(effect)))
    return sensitivity


def find_detection_limits(sensitivities: Iterable[Sensitivity]) -> dict[str, dict[str, Any]]:
    """The detection limit of each candidate: the size that these data would show with `N_SIGMA_VISIBLE` sigmas.

    ``limit`` is in ``unit``, counted from ``off``, the value without effect, and None where it is beyond the range;
    ``grows`` is "down" where the effect is the larger the smaller the parameter, as of an area that feeds. ``kept`` is
    the share of the effect that is left once nuisances are projected out; ``class`` are the other effects within their
    limits whose cosine with it, nuisances projected out, is above `ALIKE`.
    """
    limits, best = {}, select_clearest(sensitivities)
    for name, sensitivity in best.items():
        parameter, x = sensitivity.probe.parameter, find_visible_size(sensitivity)
        if parameter.inverse:  # the weakest there is may be seen already
            x = max(x, parameter.low)
        is_within = x <= max(map(abs, parameter.ends))
        limits[name] = {
            "parameter": parameter.key.split(".")[-1],
            "unit": parameter.declaration.unit,  # type: ignore[attr-defined]
            "limit": abs(parameter.shown(parameter.value(x) - parameter.origin)) if is_within else None,
            "off": parameter.shown(parameter.origin),
            "grows": "down" if parameter.inverse else "up",
            "kept": sensitivity.retained,
            "class": [],
        }
    seen = [name for name, limit in limits.items() if limit["limit"] is not None]
    for name, other in combinations(seen, 2):
        if abs(find_cosine(best[name].projected, best[other].projected)) > ALIKE:
            limits[name]["class"].append(other)
            limits[other]["class"].append(name)
    return limits


def format_limit(limit: dict[str, Any] | None) -> str:
    """The size from which an effect is visible, as text; "and below" where it is the larger the smaller its parameter.

    The limit is one of `find_detection_limits`; None is beyond its range.

    >>> format_limit({"limit": 1.2345, "unit": "N", "off": 0.0, "grows": "up"}), format_limit(None)
    ('1.2 N', 'beyond its range')
    >>> format_limit({"limit": 12.0, "unit": "mm^2", "off": 0.0, "grows": "down"})
    '12 mm^2 and below'
    >>> format_limit({"limit": 0.05, "unit": "", "off": 0.528, "grows": "up"})
    '0.05 away from 0.528'
    """
    if limit is None or limit["limit"] is None:
        return "beyond its range"
    rounded = float(f"{limit['limit']:.2g}")  # to first order: it is not known better
    size = f"{rounded:g} {limit['unit']}".strip()
    if limit["grows"] == "down":
        return f"{size} and below"
    return f"{size} away from {limit['off']:.4g}" if limit["off"] else size
