"""Intervals by profile likelihood for effects that have a shape beside their strength.

The data may depend on a shape on one side only, or not at all: a breakaway below the sliding friction does nothing. The
curvature at the optimum knows nothing of that, and misleads about the strength beside it, too.
"""

from collections.abc import Sequence

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.profile_likelihood import End, Likelihood, find_end, first_better
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals
from apesim.studies.gap.work import Work

CLOSE = 0.05
"""Deviations from those of an interval's end, within which a point is the end: a fortieth of half an interval."""
UNIDENTIFIABLE = 1e6
"""Standard deviation of a parameter on which the data do not depend at the optimum: its ends are sought from its bounds
inwards."""
MAX_RESTARTS = 3
"""Better points that are followed."""
SIDES = -1, 1


class Held:
    """A least-squares residuals with one parameter held, as a function of the others.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    number : int
        Place of the parameter that is held.
    value : float
        Value x at which it is held.
    """

    def __init__(self, residuals: WhitenedResiduals, number: int, value: float) -> None:
        self.residuals, self.number, self.value = residuals, number, value
        self.others = [j for j in range(len(residuals.low)) if j != number]
        self.low, self.high = residuals.low[self.others], residuals.high[self.others]

    def whole(self, x: np.ndarray) -> np.ndarray:
        """All parameters: the free ones with the one held among them.

        Parameters
        ----------
        x : (p - 1,) float array

        Returns
        -------
        (p,) float array
        """
        return np.insert(x, self.number, self.value)

    def at(self, x: np.ndarray) -> np.ndarray:
        """Whitened residuals and pulls, see `apesim.studies.estimation.residuals.WhitenedResiduals.at`.

        Parameters
        ----------
        x : (p - 1,) float array

        Returns
        -------
        (n + p,) float array
            [standard deviations]
        """
        return self.residuals.at(self.whole(x))

    def jacobian(self, x: np.ndarray, residuals: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sensitivities to the free parameters.

        Parameters
        ----------
        x : (p - 1,) float array
        residuals : (n + p,) float array
            Residuals at x.
        steps : (p - 1,) float array
            Step of each difference, in units of x.

        Returns
        -------
        jacobian : (n + p, p - 1) float array
        steps : (p - 1,) float array
            Steps for the next differences, see `apesim.studies.estimation.residuals.WhitenedResiduals.jacobian`.
        """
        all_steps = np.insert(steps, self.number, np.nan)  # the parameter that is held takes none
        jacobian, all_steps = self.residuals.jacobian(self.whole(x), residuals, all_steps, self.others)
        return jacobian, all_steps[self.others]


def with_profiles(model: Model, work: Work) -> tuple[Model, int]:
    """Find the 95 % intervals of a model's effects that have a shape, by profile likelihood.

    It is the method of Venzon and Moolgavkar [1]_, see `apesim.studies.estimation.profile_likelihood`.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    work : apesim.studies.gap.work.Work

    Returns
    -------
    model : apesim.studies.estimation.model.Model
        The model with its ``profiles``, fitted anew where a profile meets a point of a smaller sum of squares; without
        them where such points are still met after `MAX_RESTARTS` fits.
    simulations : int
        Number of simulations that it took.

    References
    ----------
    .. [1] D. J. Venzon and S. H. Moolgavkar, "A method for computing profile-likelihood-based confidence intervals",
       Appl. Statist. 37, 1988, pp. 87-94, doi 10.2307/2347496.
    """
    simulations = 0
    for _ in range(1 + MAX_RESTARTS):
        profiles, better, more = _profiles(model, work)
        simulations += more
        if better is None:
            return model._replace(profiles=profiles), simulations
        residuals = _copy(model.residuals)
        model = model._replace(fitted=descend(residuals, better, steps=model.fitted.steps))
        simulations += residuals.simulations
    return model, simulations


def _profiles(model: Model, work: Work) -> tuple[dict[str, tuple[End, ...]], np.ndarray | None, int]:
    """Both ends of each interval by key; a better point, if one is met; and the number of simulations.

    A shape may stay where it does nothing while a strength moves: each strength is tried where the shapes do something,
    too.
    """
    profiles: dict[str, tuple[End, ...]] = {}
    aside: list[np.ndarray] = []
    simulations = 0
    for numbers in shaped(model):
        tasks = [(model, j, side, aside) for j in numbers for side in SIDES]
        found = work.each("finding intervals", _end, tasks)
        simulations += sum(more for _, more in found)
        ends = [end for end, _ in found]
        better = first_better(ends)
        if better is not None:
            return {}, better, simulations
        for j, *pair in zip(numbers, ends[::2], ends[1::2], strict=True):
            profiles[model.residuals.parameters[j].key] = tuple(pair)
            if any(end.is_open for end in pair):
                aside = [*aside, *(end.point for end in pair if not end.is_open)]
    return profiles, None, simulations


def _end(model: Model, j: int, side: int, aside: Sequence[np.ndarray]) -> tuple[End, int]:
    """One end of an interval, and the number of simulations."""
    residuals, fitted = _copy(model.residuals), model.fitted
    covariance = fitted.covariance
    for untold in np.flatnonzero(~model.identifiable):
        covariance[untold, untold] = UNIDENTIFIABLE**2

    def hold(guess: np.ndarray, j: int) -> tuple[np.ndarray, float, bool]:
        starts = [guess, *(np.where(np.arange(len(guess)) == j, guess, point) for point in aside)]
        return min((_held(residuals, fitted, start, j) for start in starts), key=lambda found: found[1])

    bounds = np.array([residuals.low, residuals.high])
    likelihood = Likelihood(fitted.x, fitted.cost, covariance, bounds, hold, close=CLOSE)
    return find_end(likelihood, j, side), residuals.simulations


def _copy(residuals: WhitenedResiduals) -> WhitenedResiduals:
    """Residuals like these, with a counter of their own."""
    return residuals.with_parameters(residuals.parameters)


def _held(residuals: WhitenedResiduals, fitted: Fitted, start: np.ndarray, j: int) -> tuple[np.ndarray, float, bool]:
    """Least squares from a start with parameter j held.

    See `apesim.studies.estimation.profile_likelihood.Likelihood.hold`.
    """
    held = Held(residuals, j, start[j])
    try:
        found = descend(held, start[held.others], fitted.jacobian[:, held.others], fitted.steps[held.others])
    except EndedEarly:
        return start, np.inf, False
    return held.whole(found.x), found.cost, found.converged


def is_shaped(model: Model) -> bool:
    """Whether an effect of a model has a shape: a parameter beside its strength, such as breakaway.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model

    Returns
    -------
    bool
    """
    return any(candidate.shapes for candidate in model.candidates)


def shaped(model: Model) -> tuple[list[int], list[int]]:
    """Places of the parameters of a model's effects that have a shape.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model

    Returns
    -------
    shapes : list of int
        Places of the shapes among all parameters of the model.
    strengths : list of int
        Places of the strengths of the effects with those shapes.
    """
    own = [candidate for candidate in model.candidates if candidate.shapes]
    keys = [p.key for p in model.residuals.parameters]
    return (
        [keys.index(p.key) for candidate in own for p in candidate.shapes],
        [keys.index(p.key) for candidate in own for p in candidate.strengths],
    )
