"""The score of each candidate: how many deviations of the gap it would explain, the nuisances projected out."""

from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.nuisance_space import imitated
from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.gap.search.candidates import probes_of

SEEN_LEAST = 0.02
"""Standard deviations of a probe: less is not told from the march's own error."""
SAME = 0.98
"""Cosine from which two probes of one candidate are one."""


class Column(NamedTuple):
    """What a probe does to the data."""

    probe: object
    effect: np.ndarray
    """(n + p,), for the probe's size [standard deviations]."""
    bare: np.ndarray
    """Sensitivities with what nuisances can imitate taken off."""
    kept: float
    """Share of its length that is left."""

    @property
    def length(self):
        """Length of what is left [standard deviations]."""
        return float(np.linalg.norm(self.bare))

    @property
    def is_told(self):
        """Whether it is more than the march's own error."""
        return self.length >= SEEN_LEAST


class Score(NamedTuple):
    """A candidate's best probe."""

    column: Column
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


def bank(problem, fitted, candidates, work, stage="scoring"):
    """The columns of all candidates at a calibrated machine.

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
    list of Column
    """
    found = work.each(stage, probed, [(problem, fitted, candidate) for candidate in candidates])
    problem.simulations += sum(simulations for _, simulations in found)
    return [column for columns, _ in found for column in columns]


def probed(problem, fitted, candidate):
    """The columns of one candidate, no two alike.

    Parameters
    ----------
    problem, fitted
        See `bank`.
    candidate : Candidate

    Returns
    -------
    list of Column
    simulations : int
    """
    space, found = imitated(fitted.jacobian), []
    wider = problem.with_parameters([*problem.parameters, *candidate.parameters])
    for probe in probes_of(candidate):
        try:
            errors = wider.errors(np.append(fitted.x, probe.x))
        except EndedEarly:
            continue
        effect = np.delete(errors, np.s_[len(errors) - len(probe.x) :]) - fitted.errors
        bare = space.removed(effect)
        length = np.linalg.norm(bare)
        if length == 0.0 or any(abs(bare @ c.bare) > SAME * length * c.length for c in found):
            continue
        found.append(Column(probe, effect, bare, float(length / np.linalg.norm(effect))))
    return found, wider.simulations


def freed(columns, fitted, added):
    """Columns of a bank, freed of what a larger model can imitate, too.

    Parameters
    ----------
    columns : list of Column
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
        Of the larger model.
    added : int
        Parameters that it has more.

    Returns
    -------
    list of Column
    """
    space = imitated(fitted.jacobian)
    return [column._replace(bare=space.removed(np.append(column.effect, np.zeros(added)))) for column in columns]


def cosine(one, other):
    """Between two arrays; 0 where one is nothing."""
    size = np.linalg.norm(one) * np.linalg.norm(other)
    return float(one @ other / size) if size > 0.0 else 0.0


def scores(columns, errors):
    """The best probe of each candidate, the largest first.

    Parameters
    ----------
    columns : list of Column
    errors : (n + p,) float array
        What is left at the calibrated machine, free of what nuisances can imitate.

    Returns
    -------
    list of Score
    """
    best = {}
    for column in columns:
        if not column.is_told:
            continue
        signed = -float(column.bare @ errors) / column.length
        deviations = max(signed, 0.0) if column.probe.one_sided else abs(signed)
        score, name = Score(column, deviations, signed / column.length), column.probe.candidate.name
        if name not in best or score.deviations > best[name].deviations:
            best[name] = score
    return sorted(best.values(), key=lambda score: -score.deviations)
