"""All single candidates, pairs and sets of three, ranked by what a linear model of each takes of the gap.

A linear model costs nothing beside a fit, so that every set is looked at, and few are fitted. It is taken at the
calibrated machine, and again at the best model that was fitted, as effects that are large bend the data.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.gap.search.candidates import Candidate, Probe
from apesim.studies.gap.search.score_test import MIN_VISIBLE, Sensitivity

MAX_COSINE = 0.999
"""Cosine between two columns from which they are one: their difference is within the march's own error."""
LARGEST_SET = 3
"""Candidates in a set, at most."""


class Column(NamedTuple):
    """What a candidate does to the data at some size, in a linear model."""

    candidate: Candidate
    x: tuple[float, ...]
    """Values x of the candidate's parameters at that size."""
    change: np.ndarray
    """Change of the whitened residuals, nuisances projected out, (n,) [standard deviations]."""
    one_sided: bool
    """Whether the candidate cannot do the opposite."""
    probe: Probe | None = None
    """Probe that it is the change by; None: that of a fit."""

    def scale(self, factor: float) -> tuple[float, ...]:
        """Values x of the candidate's parameters where it does as many times as much."""
        if self.probe:
            return self.probe.scale(factor)
        number = len(self.candidate.strengths)
        strengths = zip(self.candidate.strengths, self.x[:number], strict=True)
        return tuple(min(max(x * factor, p.low), p.high) for p, x in strengths) + self.x[number:]


class LinearModel(NamedTuple):
    """The residuals about some machine, as a linear function of the sizes of all candidates."""

    columns: list[Column]
    errors: np.ndarray
    """Whitened residuals without any candidate, nuisances projected out, (n,) [standard deviations]."""


class LinearSet(NamedTuple):
    """A set of candidates with what it leaves in a linear model."""

    candidates: tuple[Candidate, ...]
    guesses: tuple[tuple[float, ...], ...]
    """Values x of the parameters of each candidate."""
    cost: float
    """Sum of squares that is left [standard deviations squared]."""

    @property
    def names(self) -> frozenset[str]:
        """Names of the candidates."""
        return frozenset(candidate.name for candidate in self.candidates)

    @property
    def added(self) -> int:
        """Number of parameters of the candidates."""
        return sum(len(candidate.parameters) for candidate in self.candidates)

    def price(self, penalty: float) -> float:
        """Sum of squares and the penalty of each candidate."""
        return self.cost + penalty * len(self.candidates)


def linearise_base(base: Model, sensitivities: Sequence[Sensitivity], singles: Sequence[Model]) -> LinearModel:
    """Take the linear model at the calibrated machine.

    What candidates take that were fitted alone, the `singles`, stands beside their sensitivities: where an effect is
    large, these foretell little of it.
    """
    space = find_nuisance_space(base.fitted.jacobian)
    columns = [_from_sensitivity(each, each.projected) for each in sensitivities if each.is_visible]
    for model in singles:
        change = model.fitted.residuals[: len(base.fitted.residuals)] - base.fitted.residuals
        columns += _from_fit(model, 0, space.project_out(change))
    return LinearModel(columns, space.project_out(base.fitted.residuals))


def linearise_best(model: Model, sensitivities: Sequence[Sensitivity]) -> LinearModel:
    """Take the linear model at a fitted model, extrapolated to where its own candidates are off.

    `sensitivities` are those of the other candidates at this model, and those of faults of files, which do the same
    whatever the machine does.
    """
    jacobian, errors = model.fitted.jacobian, model.fitted.residuals
    space = find_nuisance_space(jacobian[:, : len(model.fitted.x) - model.added])
    columns: list[Column] = []
    for number in range(len(model.candidates)):
        # A shape stays: it does nothing where the strengths are off, and has no value at which it is off.
        own = range(len(model.candidates[number].strengths))
        change = jacobian[:, model.places(number)][:, own] @ model.own(number)[own]
        errors = errors - change
        columns += _from_fit(model, number, space.project_out(change))
    for each in sensitivities:
        effect = np.append(each.effect, np.zeros(len(errors) - len(each.effect)))
        columns.append(_from_sensitivity(each, space.project_out(effect)))
    return LinearModel(columns, space.project_out(errors))


def _from_sensitivity(sensitivity: Sensitivity, change: np.ndarray) -> Column:
    """The column of a probe."""
    probe = sensitivity.probe
    return Column(probe.candidate, probe.x, change, probe.one_sided, probe)


def _from_fit(model: Model, number: int, change: np.ndarray) -> Iterator[Column]:
    """The column of a fitted candidate; none where it is off."""
    candidate, x = model.candidates[number], tuple(map(float, model.own(number)))
    strengths = [abs(value) for value in x[: len(candidate.strengths)]]
    if max(strengths) > 0.0:
        strength = candidate.strengths[int(np.argmax(strengths))]
        yield Column(candidate, x, change, strength.low >= 0.0)


def rank_sets(linear: LinearModel, penalty: float) -> list[LinearSet]:
    """Rank all single candidates, pairs and sets of three; the one that leaves least comes first.

    With the columns S of a set and the residuals e, nuisances projected out, the sizes ``w = -(S'S)^-1 S'e`` leave
    ``|e + S w|^2``; sets that need a size of a sign that it cannot have are left out. `penalty` is what each candidate
    costs, in units of the sum of squares; ``cost`` counts it not.
    """
    columns = [each for each in linear.columns if np.linalg.norm(each.change) >= MIN_VISIBLE]
    if not columns:
        return []
    lengths = np.array([np.linalg.norm(each.change) for each in columns])
    shapes = np.column_stack([each.change for each in columns]) / lengths
    cosines, scores = shapes.T @ shapes, -shapes.T @ linear.errors
    one_sided = np.array([each.one_sided for each in columns])
    least: dict[frozenset[str], tuple[float, tuple[int, ...], np.ndarray]] = {}
    for size in range(1, LARGEST_SET + 1):
        for places, weights, fall in _solve_sets(columns, cosines, scores, one_sided, size):
            names = frozenset(columns[place].candidate.name for place in places)
            if names not in least or fall > least[names][0]:
                least[names] = fall, places, weights
    whole = float(linear.errors @ linear.errors)
    sets = [
        LinearSet(
            tuple(columns[place].candidate for place in places),
            tuple(columns[place].scale(weight / lengths[place]) for place, weight in zip(places, weights, strict=True)),
            whole - fall,
        )
        for fall, places, weights in least.values()
    ]
    return sorted(sets, key=lambda each: each.price(penalty))


def _solve_sets(
    columns: Sequence[Column], cosines: np.ndarray, scores: np.ndarray, one_sided: np.ndarray, size: int
) -> Iterator[tuple[tuple[int, ...], np.ndarray, float]]:
    """Sets of some size, with the weights of their shapes and the fall of the sum of squares."""
    names = np.unique([each.candidate.name for each in columns], return_inverse=True)[1]
    places = np.arange(len(columns))
    if size == LARGEST_SET:  # of each candidate the column with the largest score: else there are too many
        signed = np.where(one_sided, scores, np.abs(scores))
        places = np.array([max(places[names == name], key=lambda place: signed[place]) for name in np.unique(names)])
    sets = np.array(list(combinations(places.tolist(), size)), dtype=int).reshape(-1, size)

    # Two columns of one candidate, or two that are alike, are no set.
    for first, second in combinations(range(size), 2):
        one, other = sets[:, first], sets[:, second]
        sets = sets[(names[one] != names[other]) & (np.abs(cosines[one, other]) < MAX_COSINE)]
    if not len(sets):
        return

    # Of three, two may do what the third does, too.
    normal = cosines[sets[:, :, None], sets[:, None, :]]
    is_apart = np.linalg.eigvalsh(normal)[:, 0] > 1.0 - MAX_COSINE
    sets, normal = sets[is_apart], normal[is_apart]
    if not len(sets):
        return

    # All sets of this size at once; of a set that needs a size of the wrong sign a smaller one does the work.
    seen = scores[sets]
    weights = np.linalg.solve(normal, seen[:, :, None])[:, :, 0]
    falls = np.sum(weights * seen, axis=1)
    is_allowed = np.all(~one_sided[sets] | (weights > 0.0), axis=1)
    for number in np.flatnonzero(is_allowed):
        yield tuple(sets[number].tolist()), weights[number], float(falls[number])
