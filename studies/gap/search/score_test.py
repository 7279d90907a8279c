"""The score of each candidate: how many standard deviations of the gap it would explain, nuisances projected out."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals
from apesim.studies.gap.search.candidates import Candidate, Probe, probes_of
from apesim.studies.gap.work import Work

MIN_VISIBLE = 0.02
"""Standard deviations of a probe: less is not told from the march's own error."""
SAME = 0.98
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

    column: Sensitivity
    """What the best probe does to the data."""
    deviations: float
    """Length of the gap in the direction of the probe [standard deviations]."""
    size: float
    """Size that the gap suggests, over that of the probe."""

    @property
    def guess(self) -> tuple[float, ...]:
        """Values x that the score suggests for the parameters of its candidate."""
        return self.column.probe.scaled(self.size)

    @property
    def name(self) -> str:
        """Name of the candidate."""
        return self.column.probe.candidate.name


def find_sensitivities(
    residuals: WhitenedResiduals, fitted: Fitted, candidates: Sequence[Candidate], work: Work, stage: str = "scoring"
) -> list[Sensitivity]:
    """Find what each candidate would do to the data at a calibrated machine.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
        Its parameters are the nuisances, and the effects that are in the model already.
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
        Fit of the residuals.
    candidates : sequence of Candidate
    work : apesim.studies.gap.work.Work
    stage : str
        Name of the stage whose progress is reported.

    Returns
    -------
    list of Sensitivity
        For each candidate one or several, in their order; none where no simulation comes to its end, or where nuisances
        imitate all of it.
    """
    found = work.each(stage, probe_candidate, [(residuals, fitted, candidate) for candidate in candidates])
    work.simulations.add(sum(simulations for _, simulations in found))
    return [column for columns, _ in found for column in columns]


def probe_candidate(
    residuals: WhitenedResiduals, fitted: Fitted, candidate: Candidate
) -> tuple[list[Sensitivity], int]:
    """Find what one candidate would do to the data, by probes of which no two are alike.

    A probe is left out where its simulation ends early, or where the cosine with one before it is above `SAME`.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
        Fit of the residuals.
    candidate : Candidate

    Returns
    -------
    sensitivities : list of Sensitivity
    simulations : int
        Number of simulations that it took.
    """
    space = find_nuisance_space(fitted.jacobian)
    found: list[Sensitivity] = []
    wider = residuals.with_parameters([*residuals.parameters, *candidate.parameters])
    for probe in probes_of(candidate):
        try:
            errors = wider.at(np.append(fitted.x, probe.x))
        except EndedEarly:
            continue
        effect = np.delete(errors, np.s_[len(errors) - len(probe.x) :]) - fitted.residuals
        projected = space.project_out(effect)
        length = np.linalg.norm(projected)
        if length == 0.0 or any(abs(projected @ c.projected) > SAME * length * c.length for c in found):
            continue
        found.append(Sensitivity(probe, effect, projected, float(length / np.linalg.norm(effect))))
    return found, wider.simulations


def freed(columns: Sequence[Sensitivity], fitted: Fitted, added: int) -> list[Sensitivity]:
    """Project sensitivities anew for a larger model: what its effects can imitate is taken off, too.

    Parameters
    ----------
    columns : sequence of Sensitivity
        Sensitivities at the calibrated machine.
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
        Fit of the larger model.
    added : int
        Number of parameters that it has more than the calibrated machine.

    Returns
    -------
    list of Sensitivity
        ``projected`` has a row more for each parameter added.
    """
    space = find_nuisance_space(fitted.jacobian)
    return [
        column._replace(projected=space.project_out(np.append(column.effect, np.zeros(added)))) for column in columns
    ]


def cosine(one: np.ndarray, other: np.ndarray) -> float:
    """Cosine between two arrays, ``a'b / (|a| |b|)``; 0 where one of them is zero.

    Parameters
    ----------
    one, other : (n,) float array

    Returns
    -------
    float

    Examples
    --------
    >>> cosine(np.array([1.0, 0.0]), np.array([3.0, 4.0]))
    0.6
    """
    size = np.linalg.norm(one) * np.linalg.norm(other)
    return float(one @ other / size) if size > 0.0 else 0.0


def scores(columns: Sequence[Sensitivity], errors: np.ndarray) -> list[Score]:
    """Score each candidate by its best probe.

    With the projected change s of the data by a probe, and the whitened residuals e, the score and the size that the
    gap suggests are::

        score = -s'e / |s|,    size = -s'e / |s|^2

    A negative score counts as 0 where the strength cannot be negative, else by its magnitude. Probes that show no more
    than the march's own error are left out.

    It is Rao's score test [1]_ of each candidate, with the nuisances projected out.

    Parameters
    ----------
    columns : sequence of Sensitivity
    errors : (n + p,) float array
        Residuals of the calibrated machine, at its optimum [standard deviations].

    Returns
    -------
    list of Score
        One for each candidate that shows, the largest score first.

    References
    ----------
    .. [1] C. R. Rao, "Large sample tests of statistical hypotheses concerning several parameters with applications to
       problems of estimation", Math. Proc. Camb. Phil. Soc. 44, 1948, pp. 50-57, doi 10.1017/S0305004100023987.
    """
    best: dict[str, Score] = {}
    for column in columns:
        if not column.is_visible:
            continue
        signed = -float(column.projected @ errors) / column.length
        deviations = max(signed, 0.0) if column.probe.one_sided else abs(signed)
        score, name = Score(column, deviations, signed / column.length), column.probe.candidate.name
        if name not in best or score.deviations > best[name].deviations:
            best[name] = score
    return sorted(best.values(), key=lambda score: -score.deviations)
