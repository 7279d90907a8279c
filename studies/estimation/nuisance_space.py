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
        """Take off columns, (n + p,) or (n + p, m) [standard deviations], what the nuisances can imitate."""
        return columns - self.base @ (self.base.T @ columns)


def find_nuisance_space(jacobian: np.ndarray) -> NuisanceSpace:
    """Find the space that the sensitivities of the data to the nuisances span.

    `jacobian` is (n + p, p) [standard deviations], with the rows of the priors; nuisances that do the same count once.
    What is projected off is as in a regression that has the nuisances fitted, too (Lovell 1963, doi
    10.1080/01621459.1963.10480682).
    """
    powers, directions = np.linalg.eigh(jacobian.T @ jacobian)
    is_seen = powers > SAME * powers[-1]
    return NuisanceSpace(jacobian @ directions[:, is_seen] / np.sqrt(powers[is_seen]))
