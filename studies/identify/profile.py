"""Bounded least squares from a point, and intervals by profile likelihood around its end."""

from math import inf, nan

import numpy as np

DEVIATIONS = 1.959964
"""Half the width of a 95 % interval, in standard deviations."""
FINE = 1e-5
"""Relative tolerance, of parameters and sum of squares: a hundredth of a 95 % interval, and less."""
SHARP = 0.01
"""Of half an interval: where its end is sought no further."""


def minimise(problem, x, noise, tolerance, held=None):
    """Bounded least squares from a start; the parameter `held` stays where it is. Returns x, cost and success."""
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


def _along(best, slopes, j, away):
    """The optimum with parameter j moved, and the others as the slopes say: as powers of it where all is positive."""
    target = best[j] + away
    guess = best + slopes * away
    if best[j] > 0.0 and target > 0.0:
        powers = best > 0.0
        exponents = slopes[powers] * best[j] / best[powers]
        guess[powers] = best[powers] * np.exp(np.clip(exponents * np.log(target / best[j]), -20.0, 20.0))
    guess[j] = target
    return guess


def _profile_end(problem, best, cost, noise, j, side, curvature):
    """End of a parameter's profile-likelihood interval; from the curvature alone once the simulations are spent.

    Parameters
    ----------
    problem : Problem
        It is told where the search is cut short.
    best : (p,) float array
        The optimum.
    cost : float
        Sum of squares there.
    noise : dict
    j : int
    side : {-1, 1}
    curvature : (p, p) float array
        Of half the sum of squares.

    Returns
    -------
    end : float
    at_bound : bool
    better : (p,) float array or None
        A point of a smaller sum of squares, if one was met.
    """
    limit = problem.bounds[(side + 1) // 2, j] - best[j]
    covariance = np.linalg.inv(curvature)
    away, inner, outer = side * DEVIATIONS * np.sqrt(covariance[j, j]), 0.0, inf
    linear = away
    for _ in range(20):
        if problem.spent:
            problem.cut = True
            beyond = abs(linear) >= abs(limit)
            return best[j] + (limit if beyond else linear), beyond, None
        if abs(away) >= abs(limit):
            away = limit
        guess = np.clip(_along(best, covariance[:, j] / covariance[j, j], j, away), *problem.bounds)
        point, other, _ = minimise(problem, guess, noise, FINE, held=j)
        if other < cost - 0.05:
            return nan, False, point
        deviations = np.sqrt(max(other - cost, 0.0))
        if abs(deviations - DEVIATIONS) < 0.01:
            break
        if deviations < DEVIATIONS:
            if away == limit:
                return best[j] + limit, True, None
            inner = abs(away)
        else:
            outer = abs(away)
        # The root of the likelihood's loss is all but linear, unless a simulation changes its character on the way.
        size = abs(away) * min(DEVIATIONS / max(deviations, 1e-3), 10.0)
        away = side * (size if inner < size < outer else 0.5 * (inner + min(outer, abs(limit))))
        if outer - inner < SHARP * outer:  # it jumps here
            away = side * outer
            break
    return best[j] + away, False, None


def intervals_of(problem, best, cost, noise, curvature):
    """Both ends of every parameter's interval; or a better point, if one is met. See `_profile_end`."""
    intervals = []
    for j in range(len(best)):
        ends = [_profile_end(problem, best, cost, noise, j, side, curvature) for side in (-1, 1)]
        for _, _, better in ends:
            if better is not None:
                return intervals, better
        intervals.append(ends)
    return intervals, None
