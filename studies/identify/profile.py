"""Bounded least squares from a point, and intervals by profile likelihood around its end."""

from math import inf, nan

import numpy as np

DEVIATIONS = 1.959964
"""Half the width of a 95 % interval, in standard deviations."""
FINE = 1e-5
"""Relative tolerance, of parameters and sum of squares: a hundredth of a 95 % interval, and less."""
SHARP = 0.01
"""Of half an interval: where its end is sought no further."""
NEAR_NOTHING = 1e-3
"""Scaled parameter, up to which it does not change as a power of another."""
FACTOR = 1.5
"""Logarithm of the largest factor by which a guess changes a parameter."""
INSIDE = 0.1
"""Share of a bracket that the next point stays away from its ends."""


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


def _along(point, slopes, j, target):
    """A point with parameter j moved to a target, the others as the slopes say: as powers of it where that holds."""
    guess = point + slopes * (target - point[j])
    if point[j] > NEAR_NOTHING and target > NEAR_NOTHING:
        powers = point > NEAR_NOTHING
        exponents = slopes[powers] * point[j] / point[powers]
        guess[powers] = point[powers] * np.exp(np.clip(exponents * np.log(target / point[j]), -FACTOR, FACTOR))
    guess[j] = target
    return guess


def _held(problem, known, slopes, noise, j, target):
    """Least squares with parameter j held at a target, from the nearest known points of the profile, carried on.

    Parameters
    ----------
    problem : Problem
    known : list of (p,) float array
        From the optimum on.
    slopes : (p,) float array
        At the optimum, of all parameters along the profile.
    noise : dict
    j : int
    target : float

    Returns
    -------
    x, cost, success
        See `minimise`; where that is not reached from there, also from the nearest known point as it is.
    """
    near, *others = sorted(known, key=lambda point: abs(point[j] - target))
    if others:
        slopes = (others[0] - near) / (others[0][j] - near[j])
    found = None
    for guess in (_along(near, slopes, j, target), _along(near, np.zeros_like(near), j, target)):
        again = minimise(problem, np.clip(guess, *problem.bounds), noise, FINE, held=j)
        found = again if found is None or again[1] < found[1] else found
        if again[2]:
            break
    return found


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
    away = linear = side * DEVIATIONS * np.sqrt(covariance[j, j])
    inner, outer, known = (0.0, 0.0), (inf, inf), [best]  # away from the optimum, deviations there
    for _ in range(20):
        if problem.spent:
            problem.cut = True
            beyond = abs(linear) >= abs(limit)
            return best[j] + (limit if beyond else linear), beyond, None
        if abs(away) >= abs(limit):
            away = limit
        point, other, settled = _held(problem, known, covariance[:, j] / covariance[j, j], noise, j, best[j] + away)
        if other < cost - 0.05:
            return nan, False, point
        deviations = np.sqrt(max(other - cost, 0.0))
        if abs(deviations - DEVIATIONS) < 0.01:
            break
        if settled:
            known.append(point)
        if deviations < DEVIATIONS:
            if away == limit:
                return best[j] + limit, True, None
            inner = abs(away), deviations
        else:
            outer = abs(away), deviations if settled else inf
        if outer[0] == inf:
            size = abs(away) * min(DEVIATIONS / max(deviations, 1e-3), 10.0)
        elif outer[0] - inner[0] < SHARP * outer[0]:  # it jumps here
            away = side * outer[0]
            break
        else:
            share = (DEVIATIONS - inner[1]) / (outer[1] - inner[1]) if outer[1] < inf else 0.5
            size = inner[0] + min(max(share, INSIDE), 1.0 - INSIDE) * (outer[0] - inner[0])
        away = side * size
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
