"""The score of each candidate: how many standard deviations of the gap it would explain, nuisances projected out."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals
from apesim.studies.gap.search.candidates import Candidate, Probe, list_probes
from apesim.studies.gap.stage_work import Work

MIN_VISIBLE = 0.02
"""Sigmas that a probe has to show: fewer are indistinguishable from the march's own error."""
MAX_ALIKE = 0.98
"""Cosine from which two probes of one candidate are one."""


class Sensitivity(NamedTuple):
    """The change of the data by a probe, as it is and with what nuisances can imitate taken off."""

    probe: Probe
    effect: np.ndarray
    """Change of the whitened residuals by the probe, (n + p,) [standard deviations]."""
    projected: np.ndarray
    """Change with what nuisances can imitate taken off, (n + p,) [standard deviations]."""
    retained: float
    """Length of `projected` over that of `effect`."""

    @property
    def length(self) -> float:
        """Length of `projected` [standard deviations]: how clearly the probe shows."""
        return float(np.linalg.norm(self.projected))

    @property
    def is_visible(self) -> bool:
        """Whether the probe shows more than the march's own error, `MIN_VISIBLE`."""
        return self.length >= MIN_VISIBLE


class Score(NamedTuple):
    """The score of a candidate: that of its best probe."""

    sensitivity: Sensitivity
    """What the best probe does to the data."""
    n_sigma: float
    """Length of the gap in the direction of the probe [standard deviations]."""
    size: float
    """Size that the gap suggests, over that of the probe."""

    @property
    def guess(self) -> tuple[float, ...]:
        """Values x that the score suggests for the parameters of its candidate."""
        return self.sensitivity.probe.scale(self.size)

    @property
    def name(self) -> str:
        """Name of the candidate."""
        return self.sensitivity.probe.candidate.name


def find_sensitivities(
    residuals: WhitenedResiduals, fitted: Fitted, candidates: Sequence[Candidate], work: Work, stage: str = "scoring"
) -> list[Sensitivity]:
    """Find what each candidate would do to the data at a calibrated machine.

    For each candidate one or several, in their order; none where no simulation comes to its end, or where nuisances
    imitate all of it. Parameters of `residuals` are the nuisances, and the effects that are in the model already;
    `stage` names the progress that is reported.
    """
    probed = work.each(stage, probe_candidate, [(residuals, fitted, candidate) for candidate in candidates])
    work.simulations.add(sum(simulations for _, simulations in probed))
    return [sensitivity for sensitivities, _ in probed for sensitivity in sensitivities]


def probe_candidate(
    residuals: WhitenedResiduals, fitted: Fitted, candidate: Candidate
) -> tuple[list[Sensitivity], int]:
    """Find what one candidate would do to the data, by probes of which no two are alike.

    A probe is left out where its simulation ends early, or where the cosine with one before it is above `MAX_ALIKE`.
    The int is the number of simulations that it took.
    """
    space = find_nuisance_space(fitted.jacobian)
    sensitivities: list[Sensitivity] = []
    wider = residuals.with_parameters([*residuals.parameters, *candidate.parameters])
    for probe in list_probes(candidate):
        try:
            errors = wider.at(np.append(fitted.x, probe.x))
        except EndedEarly:
            continue
        effect = np.delete(errors, np.s_[len(errors) - len(probe.x) :]) - fitted.residuals
        projected = space.project_out(effect)
        length = np.linalg.norm(projected)
        if length == 0.0 or any(
            abs(projected @ other.projected) > MAX_ALIKE * length * other.length for other in sensitivities
        ):
            continue
        sensitivities.append(Sensitivity(probe, effect, projected, float(length / np.linalg.norm(effect))))
    return sensitivities, wider.simulations


def project_for_model(sensitivities: Sequence[Sensitivity], fitted: Fitted, added: int) -> list[Sensitivity]:
    """Project sensitivities anew for a larger model: what its effects can imitate is taken off, too.

    They come from the calibrated machine; `fitted` is the fit of the larger model, which has `added` parameters more,
    and ``projected`` gets a row more for each of these.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> before = next(each for each in explanation.sensitivities if each.probe.candidate.name == "side_force")
    >>> (after,) = project_for_model([before], explanation.best.fitted, explanation.best.added)
    >>> after.length < before.length
    True
    """
    space = find_nuisance_space(fitted.jacobian)
    return [
        sensitivity._replace(projected=space.project_out(np.append(sensitivity.effect, np.zeros(added))))
        for sensitivity in sensitivities
    ]


def find_cosine(array: np.ndarray, other: np.ndarray) -> float:
    """Cosine between two arrays (n,), ``a'b / (|a| |b|)``; 0 where one of them is zero."""
    size = np.linalg.norm(array) * np.linalg.norm(other)
    return float(array @ other / size) if size > 0.0 else 0.0


def find_scores(sensitivities: Sequence[Sensitivity], errors: np.ndarray) -> list[Score]:
    """Score each candidate by its best probe; the largest score comes first.

    With the projected change s of the data by a probe, and the residuals e of the calibrated machine at its optimum,
    `errors` (n + p,) [standard deviations], the score is ``-s'e / |s|`` and the size that the gap suggests ``-s'e /
    |s|^2``. A negative score counts as 0 where the strength cannot be negative, else by its magnitude; probes that show
    no more than the march's own error are left out. It is Rao's score test (Rao 1948, doi 10.1017/S0305004100023987),
    with the nuisances projected out.
    """
    best: dict[str, Score] = {}
    for sensitivity in sensitivities:
        if not sensitivity.is_visible:
            continue
        signed = -float(sensitivity.projected @ errors) / sensitivity.length
        n_sigma = max(signed, 0.0) if sensitivity.probe.one_sided else abs(signed)
        score, name = Score(sensitivity, n_sigma, signed / sensitivity.length), sensitivity.probe.candidate.name
        if name not in best or score.n_sigma > best[name].n_sigma:
            best[name] = score
    return sorted(best.values(), key=lambda score: -score.n_sigma)
