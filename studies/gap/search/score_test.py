"""The score of each candidate: how many deviations of the gap it would explain, the nuisances projected out."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import EndedEarly, Problem
from apesim.studies.gap.search.candidates import Candidate, Probe, probes_of
from apesim.studies.gap.work import Work

MIN_VISIBLE = 0.02
"""Standard deviations of a probe: less is not told from the march's own error."""
SAME = 0.98
"""Cosine from which two probes of one candidate are one."""


class Sensitivity(NamedTuple):
    """What a probe does to the data."""

    probe: Probe
    effect: np.ndarray
    """(n + p,), for the probe's size [standard deviations]."""
    projected: np.ndarray
    """Sensitivities with what nuisances can imitate taken off."""
    retained: float
    """Share of its length that is left."""

    @property
    def length(self) -> float:
        """Length of what is left [standard deviations]."""
        return float(np.linalg.norm(self.projected))

    @property
    def is_visible(self) -> bool:
        """Whether it is more than the march's own error."""
        return self.length >= MIN_VISIBLE


class Score(NamedTuple):
    """A candidate's best probe."""

    column: Sensitivity
    deviations: float
    """Length of the gap in its direction [standard deviations]."""
    size: float
    """Times the probe's size that the gap suggests."""

    @property
    def guess(self):
        """The x that it suggests for its candidate."""
        return self.column.probe.scaled(self.size)

    @property
    def name(self):
        """Name of the candidate."""
        return self.column.probe.candidate.name


def find_sensitivities(
    problem: Problem, fitted: Fitted, candidates: Sequence[Candidate], work: Work, stage: str = "scoring"
) -> list[Sensitivity]:
    """Find what each candidate would do to the data at a calibrated machine.

    Parameters
    ----------
    problem : apesim.studies.estimation.residuals.Problem
        Of the nuisances, and of the effects that are in the model already.
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
    candidates : sequence of Candidate
    work : apesim.studies.gap.work.Work
    stage : str
        As whose part it is told.

    Returns
    -------
    list of Sensitivity
    """
    found = work.each(stage, probe_candidate, [(problem, fitted, candidate) for candidate in candidates])
    problem.simulations += sum(simulations for _, simulations in found)
    return [column for columns, _ in found for column in columns]


def probe_candidate(problem: Problem, fitted: Fitted, candidate: Candidate) -> tuple[list[Sensitivity], int]:
    """Find what one candidate would do to the data, by probes of which no two are alike.

    Parameters
    ----------
    problem, fitted
        See `find_sensitivities`.
    candidate : Candidate

    Returns
    -------
    list of Sensitivity
    simulations : int
    """
    space = find_nuisance_space(fitted.jacobian)
    found: list[Sensitivity] = []
    wider = problem.with_parameters([*problem.parameters, *candidate.parameters])
    for probe in probes_of(candidate):
        try:
            errors = wider.errors(np.append(fitted.x, probe.x))
        except EndedEarly:
            continue
        effect = np.delete(errors, np.s_[len(errors) - len(probe.x) :]) - fitted.errors
        projected = space.project_out(effect)
        length = np.linalg.norm(projected)
        if length == 0.0 or any(abs(projected @ c.projected) > SAME * length * c.length for c in found):
            continue
        found.append(Sensitivity(probe, effect, projected, float(length / np.linalg.norm(effect))))
    return found, wider.simulations


def freed(columns: Sequence[Sensitivity], fitted: Fitted, added: int) -> list[Sensitivity]:
    """Take off sensitivities what a larger model can imitate, too.

    Parameters
    ----------
    columns : list of Sensitivity
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
        Of the larger model.
    added : int
        Parameters that it has more.

    Returns
    -------
    list of Sensitivity
    """
    space = find_nuisance_space(fitted.jacobian)
    return [
        column._replace(projected=space.project_out(np.append(column.effect, np.zeros(added)))) for column in columns
    ]


def cosine(one: np.ndarray, other: np.ndarray) -> float:
    """Cosine between two arrays; 0 where one is nothing.

    Examples
    --------
    >>> cosine(np.array([1.0, 0.0]), np.array([3.0, 4.0]))
    0.6
    """
    size = np.linalg.norm(one) * np.linalg.norm(other)
    return float(one @ other / size) if size > 0.0 else 0.0


def scores(columns: Sequence[Sensitivity], errors: np.ndarray) -> list[Score]:
    """Score each candidate by its best probe, the largest score first.

    Parameters
    ----------
    columns : list of Sensitivity
    errors : (n + p,) float array
        What is left at the calibrated machine, free of what nuisances can imitate.

    Returns
    -------
    list of Score
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
