"""Intervals by profile likelihood for effects that have a shape beside their strength.

The data may depend on a shape on one side only, or not at all: a breakaway below the sliding friction does nothing. The
curvature at the optimum knows nothing of that, and misleads about the strength beside it, too.
"""

from collections.abc import Sequence

import numpy as np

from apesim.studies.estimation.fixed_parameter import fit_held
from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.profile_likelihood import End, Likelihood, find_end, first_better
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.stage_work import Work

MAX_END_ERROR = 0.05
"""Deviations from those of an interval's end, within which a point is the end: a fortieth of half an interval."""
UNIDENTIFIABLE_SIGMA = 1e6
"""Standard deviation of a parameter on which the data do not depend at the optimum: its ends are sought from its bounds
inwards."""
MAX_RESTARTS = 3
"""Better points that are followed."""
SIDES = -1, 1


def find_profiles(model: Model, work: Work) -> tuple[Model, int]:
    """Find the 95 % intervals of a model's effects that have a shape, by profile likelihood, and count the simulations.

    It is the method of Venzon and Moolgavkar (1988, doi 10.2307/2347496). The model is fitted anew where a profile
    meets a point of a smaller sum of squares, and stays without ``profiles`` where such points are still met after
    `MAX_RESTARTS` fits.
    """
    simulations = 0
    for _ in range(1 + MAX_RESTARTS):
        profiles, better, more = _profile_all(model, work)
        simulations += more
        if better is None:
            return model._replace(profiles=profiles), simulations
        residuals = _copy(model.residuals)
        model = model._replace(fitted=descend(residuals, better, steps=model.fitted.steps))
        simulations += residuals.simulations
    return model, simulations


def _profile_all(model: Model, work: Work) -> tuple[dict[str, tuple[End, ...]], np.ndarray | None, int]:
    """Both ends of each interval by key; a better point, if one is met; and the number of simulations.

    A shape may stay where it does nothing while a strength moves: each strength is tried where the shapes do something,
    too.
    """
    profiles: dict[str, tuple[End, ...]] = {}
    further_starts: list[np.ndarray] = []
    simulations = 0
    for numbers in find_shapes(model):
        tasks = [(model, j, side, further_starts) for j in numbers for side in SIDES]
        ends_and_simulations = work.each("finding intervals", _find_end, tasks)
        simulations += sum(more for _, more in ends_and_simulations)
        ends = [end for end, _ in ends_and_simulations]
        better = first_better(ends)
        if better is not None:
            return {}, better, simulations
        for j, *pair in zip(numbers, ends[::2], ends[1::2], strict=True):
            profiles[model.residuals.parameters[j].key] = tuple(pair)
            if any(end.is_open for end in pair):
                further_starts = [*further_starts, *(end.point for end in pair if not end.is_open)]
    return profiles, None, simulations


def _find_end(model: Model, j: int, side: int, further_starts: Sequence[np.ndarray]) -> tuple[End, int]:
    """One end of an interval, and the number of simulations."""
    residuals, fitted = _copy(model.residuals), model.fitted
    covariance = fitted.covariance
    for unidentifiable in np.flatnonzero(~model.identifiable):
        covariance[unidentifiable, unidentifiable] = UNIDENTIFIABLE_SIGMA**2

    def hold(guess: np.ndarray, j: int) -> tuple[np.ndarray, float, bool]:
        starts = [guess, *(np.where(np.arange(len(guess)) == j, guess, point) for point in further_starts)]
        return min((fit_held(residuals, fitted, start, j) for start in starts), key=lambda held: held[1])

    bounds = np.array([residuals.low, residuals.high])
    likelihood = Likelihood(fitted.x, fitted.cost, covariance, bounds, hold, close=MAX_END_ERROR)
    return find_end(likelihood, j, side), residuals.simulations


def _copy(residuals: WhitenedResiduals) -> WhitenedResiduals:
    """Residuals like these, with a counter of their own."""
    return residuals.with_parameters(residuals.parameters)


def has_shape(model: Model) -> bool:
    """Whether an effect of a model has a shape: a parameter beside its strength, such as breakaway.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> fits = explain_example().fits
    >>> {choice.names[0]: has_shape(choice.model) for choice in fits if len(choice.names) == 1}["coulomb_friction"]
    True
    """
    return any(candidate.shapes for candidate in model.candidates)


def find_shapes(model: Model) -> tuple[list[int], list[int]]:
    """Places, among all parameters, of the shapes of a model's effects, and of the strengths of those effects.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> friction = next(each.model for each in explain_example().fits if each.names == ("coulomb_friction",))
    >>> (shape,), (strength,) = find_shapes(friction)
    >>> [friction.residuals.parameters[number].key for number in (shape, strength)]
    ['effects.coulomb_friction.breakaway', 'effects.coulomb_friction.force']
    """
    shaped = [candidate for candidate in model.candidates if candidate.shapes]
    keys = [p.key for p in model.residuals.parameters]
    return (
        [keys.index(p.key) for candidate in shaped for p in candidate.shapes],
        [keys.index(p.key) for candidate in shaped for p in candidate.strengths],
    )
