"""Bounded least squares from a point, and the profile likelihood around its end."""

import numpy as np

from apesim.studies.estimation.profile_likelihood import Likelihood, find_end, first_better

FINE = 1e-5
"""Relative tolerance, of parameters and sum of squares: a hundredth of a 95 % interval, and less."""


def minimise(problem, x, noise, tolerance, held=None):
    """Minimise the sum of squares of the whitened residuals within the bounds, from a start.

    The method is that of Branch, Coleman and Li [1]_, a trust region within bounds, from SciPy.

    Parameters
    ----------
    problem : apesim.studies.identify.simulation.Problem
    x : (p,) float array
        Start, scaled.
    noise : dict of (float, float)
        Standard deviation [SI] and colour by sensor.
    tolerance : float
        Relative tolerance of the parameters and of the sum of squares.
    held : int, optional
        Place of a parameter that stays where it is.

    Returns
    -------
    x : (p,) float array
    cost : float
        Sum of squares.
    success : bool

    References
    ----------
    .. [1] M. A. Branch, T. F. Coleman and Y. Li, "A subspace, interior, and conjugate gradient method for large-scale
       bound-constrained minimization problems", SIAM J. Sci. Comput. 21, 1999, pp. 1-23, doi 10.1137/S1064827595289108.
    """
    from scipy.optimize import least_squares

    x = np.array(x)
    moving = [j for j in range(len(x)) if j != held]
    if not moving:
        return x, float(np.sum(problem.whitened(x, noise) ** 2)), True

    def whole(part):
        full = x.copy()
        full[moving] = part
        return full

    low, high = problem.bounds[:, moving]
    margin = 1e-9 * (high - low)
    found = least_squares(
        lambda part: problem.whitened(whole(part), noise),
        np.clip(x[moving], low + margin, high - margin),
        lambda part: problem.jacobian(whole(part), noise, moving),
        bounds=(low, high),
        x_scale="jac",
        xtol=tolerance,
        ftol=tolerance,
        gtol=1e-10,
        max_nfev=30,
    )
    return whole(found.x), 2.0 * found.cost, bool(found.success)


def intervals_of(problem, best, cost, noise, covariance):
    """Both ends of every parameter's interval; or a better point, if one is met.

    The intervals are those of the profile likelihood [1]_.

    Parameters
    ----------
    problem : Problem
        It is told where the search is cut short.
    best : (p,) float array
        The optimum.
    cost : float
        Sum of squares there.
    noise : dict
    covariance : (p, p) float array

    Returns
    -------
    intervals : list of pairs of apesim.studies.estimation.profile_likelihood.End
    better : (p,) float array or None

    References
    ----------
    .. [1] D. J. Venzon and S. H. Moolgavkar, "A method for computing profile-likelihood-based confidence intervals",
       Appl. Statist. 37, 1988, pp. 87-94, doi 10.2307/2347496.
    """

    def hold(guess, j):
        return minimise(problem, guess, noise, FINE, held=j)

    likelihood = Likelihood(best, cost, covariance, problem.bounds, hold, lambda: problem.spent)
    intervals = []
    for j in range(len(best)):
        ends = [find_end(likelihood, j, side) for side in (-1, 1)]
        problem.cut |= any(end.is_cut for end in ends)
        better = first_better(ends)
        if better is not None:
            return intervals, better
        intervals.append(ends)
    return intervals, None
