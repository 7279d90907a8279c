"""Variances of parameters by how far groups of runs agree, beside those by the curvature of the sum of squares.

The curvature believes the model: it counts thousands of samples, and knows nothing of an error that all samples of an
operating point share. Such an error leads each point to another value of the parameter.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

MIN_FREE = 0.01
"""Share of a variance from which groups of runs tell something of it: below, what a group leaves along a direction is
what the descent left of its last step, made ten times as large by the adjustment."""
CURVATURE_FREEDOM = 2.0
"""Degrees of freedom that the curvature counts for beside those of the groups. Two to six operating points have one to
five, and a variance of two is twice too large by chance alone in one case of seven. Of 2000 means of four points with
noise alone, 96 % of the intervals hold the truth; with an error of each point, as large as the noise of its mean or
twice as large, 89 and 83 %, where 82 and 61 % do by the curvature. With 4 in place of 2 it is 87 and 80 %."""


class GroupVariances(NamedTuple):
    """What groups of runs tell of the variance of each parameter."""

    shares: np.ndarray
    """Share of the variance by the curvature that comes of the noise, the rest being of the priors, (p,)."""
    ratios: np.ndarray
    """Variance of the noise by the groups over that by the curvature, (p,); 1 where they tell nothing."""
    freedom: np.ndarray
    """Degrees of freedom of the ratios, (p,); 0 where the groups tell nothing."""

    @property
    def factors(self) -> np.ndarray:
        """Factors, (p,), by which variances are larger than those by the curvature: 1 or more.

        A ratio r of nu degrees of freedom is drawn to 1, as if the curvature had ``nu_0`` = `CURVATURE_FREEDOM` of
        them: ``(nu_0 + nu r) / (nu_0 + nu)`` (Smyth 2004, doi 10.2202/1544-6115.1027). It never counts as less than 1,
        as groups that agree by chance are no sign of less noise. What comes of the priors stays as it is.
        """
        moderated = (CURVATURE_FREEDOM + self.freedom * self.ratios) / (CURVATURE_FREEDOM + self.freedom)
        return 1.0 + self.shares * (np.maximum(moderated, 1.0) - 1.0)


def compare_groups(jacobian: np.ndarray, residuals: np.ndarray, groups: Sequence[np.ndarray]) -> GroupVariances:
    """Compare the variances by what groups of samples leave with those by the curvature, at a least sum of squares.

    `jacobian` is J, (n, p), and `residuals` e, (n,), both whitened, the rows of the priors among them; `groups` are the
    places of the rows of each group g. Rows of the priors are in none: they are never left out, and count as they say.
    With ``C = pinv(J'J)`` and ``H_g = J_g C J_g'`` the variance is the diagonal of

    ``V = C sum_g(s_g s_g') C`` with ``s_g = J_g' (I - H_g)^(-1/2) e_g``

    which is CR2: it has no bias where the noise is as it was whitened (Bell and McCaffrey 2002, Survey Methodology 28,
    169; Pustejovsky and Tipton 2018, doi 10.1080/07350015.2016.1247004). Directions that a group alone determines, by
    `MIN_FREE`, are left out of its root. The degrees of freedom are Satterthwaite's, as there: twice the square of the
    mean of V over its variance, if the noise is white.

    Two groups of one sample each give a mean. They differ by 2, where noise makes that a number of variance 2:

    >>> compared = compare_groups(np.ones((2, 1)), np.array([1.0, -1.0]), [np.array([0]), np.array([1])])
    >>> compared.ratios.round(6).tolist(), compared.freedom.round(6).tolist()
    ([2.0], [1.0])
    """
    covariance = np.linalg.pinv(jacobian.T @ jacobian)
    number, width = len(groups), jacobian.shape[1]
    slopes, weights, scores = [], [], []
    for rows in groups:
        # A group counts in the directions alone in which parameters move it: J_g = Q R, and I - H_g = I - Q R C R' Q'.
        _, triangle = np.linalg.qr(np.column_stack([jacobian[rows], residuals[rows]]))
        slope, seen = triangle[:width, :width], triangle[:width, width]
        free, axes = np.linalg.eigh(np.eye(len(slope)) - slope @ covariance @ slope.T)
        is_free = free > MIN_FREE
        root = (axes[:, is_free] / np.sqrt(free[is_free])) @ axes[:, is_free].T
        slopes.append(slope)
        weights.append(covariance @ slope.T @ root)
        scores.append(weights[-1] @ seen)

    # White noise leaves residuals of covariance I - H: so much do the scores of two groups have in common, (p, g, h).
    common = np.empty((width, number, number))
    for g in range(number):
        for h in range(number):
            left = (g == h) * np.eye(len(slopes[g]), len(slopes[h])) - slopes[g] @ covariance @ slopes[h].T
            common[:, g, h] = np.einsum("pi,ij,pj->p", weights[g], left, weights[h])
    means, squares = np.einsum("pgg->p", common), np.einsum("pgh,pgh->p", common, common)

    # Where the groups tell too little, the curvature alone speaks.
    variances = np.diag(covariance)
    tells = means > MIN_FREE * variances
    shares, ratios, freedom = np.zeros(width), np.ones(width), np.zeros(width)
    shares[tells] = (means / np.where(tells, variances, 1.0))[tells]
    ratios[tells] = (np.sum(np.square(scores), axis=0) / np.where(tells, means, 1.0))[tells]
    freedom[tells] = (means**2 / np.where(tells, squares, 1.0))[tells]
    return GroupVariances(shares, ratios, freedom)
