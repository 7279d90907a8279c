"""What the nuisances can imitate, taken off everything that is judged."""

from typing import NamedTuple

import numpy as np


class Nuisances(NamedTuple):
    """What the nuisances can imitate."""

    base: np.ndarray
    """Orthonormal, (n + p, p)."""

    def removed(self, columns):
        """Columns without what the nuisances can imitate."""
        return columns - self.base @ (self.base.T @ columns)


def imitated(jacobian):
    """The space of the nuisances' sensitivities."""
    powers, directions = np.linalg.eigh(jacobian.T @ jacobian)
    told = powers > 1e-14 * powers[-1]
    return Nuisances(jacobian @ directions[:, told] / np.sqrt(powers[told]))
