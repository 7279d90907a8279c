"""What the nuisances can imitate, taken off everything that is judged."""

from typing import NamedTuple

import numpy as np

SAME = 1e-14
"""Power of a direction over that of the largest, below which it is rounding: the square of 1e-7."""


class NuisanceSpace(NamedTuple):
    """Space of the changes of the data that nuisances can imitate."""

    base: np.ndarray
    """Orthonormal columns, (n + p, p)."""

    def project_out(self, columns: np.ndarray) -> np.ndarray:
        """Take off what the nuisances can imitate.

        Parameters
        ----------
        columns : (n + p,) or (n + p, m) float array
            [standard deviations]

        Returns
        -------
        (n + p,) or (n + p, m) float array
            [standard deviations]

        Examples
        --------
        >>> space = find_nuisance_space(np.array([[1.0], [1.0], [0.0]]))
        >>> left = space.project_out(np.array([2.0, 0.0, 5.0])).round(12)
        >>> [float(value) for value in left]
        [1.0, -1.0, 5.0]
        """
        return columns - self.base @ (self.base.T @ columns)


def find_nuisance_space(jacobian: np.ndarray) -> NuisanceSpace:
    """Find the space that the sensitivities of the data to the nuisances span.

    What is projected off is as in a regression that has the nuisances fitted, too: theorem of Frisch, Waugh and Lovell
    [1]_.

    Parameters
    ----------
    jacobian : (n + p, p) float array
        Sensitivities [standard deviations], with the rows of the priors.

    Returns
    -------
    NuisanceSpace

    References
    ----------
    .. [1] M. C. Lovell, "Seasonal adjustment of economic time series and multiple regression analysis", J. Am. Statist.
       Assoc. 58, 1963, pp. 993-1010, doi 10.1080/01621459.1963.10480682.

    Examples
    --------
    >>> find_nuisance_space(np.array([[3.0, 6.0], [4.0, 8.0]])).base.shape  # two nuisances that do the same
    (2, 1)
    """
    powers, directions = np.linalg.eigh(jacobian.T @ jacobian)
    is_seen = powers > SAME * powers[-1]
    return NuisanceSpace(jacobian @ directions[:, is_seen] / np.sqrt(powers[is_seen]))
