"""Anderson acceleration of cycles to the state that they repeat, and what tells where it must not be believed.

A cycle maps the state at its start to that at its end. From the last few states and their images the secants of that
map are known, and a combination of them leads to where the state would repeat if the map were a line there.
"""

import numpy as np

DEPTH = 4
"""Secants that a step is made of, at most: with 3 or 6 of them the slowest of 58 operating points took 25 and 13 cycles
for 12; they were measured for release 0.3."""
CONDITION = 1e-8
"""Singular values of the secants, over the largest, below which a combination of them is left out."""
MIN_SECANT, MAX_SECANT = 1e-6, 0.1
"""Relative lengths of a secant: below the first it shows the solver's error, above the second no slope."""
SLOWEST = 0.999
"""Factor by which a change falls from cycle to cycle, at most, when the way that is left is estimated."""
SHOWN = 0.05
"""Singular values of the secants, over the largest, above which they show a slope in that direction."""


def way_left(change: float, before: float) -> float:
    """Estimate how far a state has to go, where its changes from cycle to cycle fall by one factor for ever.

    Takes the changes over a cycle and over the one before it (0 where that is not known); returns the sum of this
    change and of all that follow.

    >>> way_left(1.0, 2.0), round(way_left(1.0, 0.0))
    (2.0, 1000)
    """
    return change / (1.0 - (min(change / before, SLOWEST) if before > 0.0 else SLOWEST))


class Secants:
    """States at the start of cycles and their images, and the secants between them."""

    def __init__(self) -> None:
        self._last: tuple[np.ndarray, np.ndarray] | None = None
        self._recent: list[tuple[np.ndarray, np.ndarray] | None] = []
        self._slopes: list[tuple[np.ndarray, np.ndarray]] = []
        self._unexplained = 0.0

    @property
    def are_shown(self) -> bool:
        """Whether one of the secants that a step is made of shows a slope."""
        return any(secant is not None for secant in self._recent)

    def forget(self) -> None:
        """Leave out what was seen before, as behind a change of phase."""
        self._last, self._unexplained = None, 0.0
        self._recent.clear()

    def add(self, state: np.ndarray, image: np.ndarray, sizes: np.ndarray) -> None:
        """Add the state (n,) at the start of a cycle and its image at the end; changes are related to `sizes` (n,)."""
        if self._last:
            moved, image_moved = state - self._last[0], image - self._last[1]
            length = np.abs(moved / sizes).max()
            self._recent = self._recent[1 - DEPTH :]
            self._recent.append((moved, image_moved - moved) if length > MIN_SECANT else None)
            if MIN_SECANT < length < MAX_SECANT:
                sizes = sizes * np.linalg.norm(moved / sizes)
                self._slopes.append((moved / sizes, image_moved / sizes))
        self._last = state, image

    def _relative(self, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The secants that a step is made of, each (k, n): by how much the state moved, and its gain with it."""
        moved, gained = zip(*(secant for secant in self._recent if secant), strict=True)
        return np.array(moved) / sizes, np.array(gained) / sizes

    def step(self, gain: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, float]:
        """Compute the way from the last state to where the map repeats it.

        It is the step of Anderson's method [1]_, by least squares over the secants. What these do not explain of the
        gain is taken as it is; how far it would lead is known from how it fell since the step before.

        Parameters
        ----------
        gain : (n,) float array
            Image less state, relative.
        sizes : (n,) float array
            What changes of each element are related to.

        Returns
        -------
        step : (n,) float array
            Way to the state that repeats, relative.
        left : float
            Largest element of the way that may be left to it.

        References
        ----------
        .. [1] D. G. Anderson, "Iterative procedures for nonlinear integral equations", J. ACM 12, 1965, pp. 547-560,
           doi 10.1145/321296.321305; H. F. Walker and P. Ni, "Anderson acceleration for fixed-point iterations", SIAM
           J. Numer. Anal. 49, 2011, pp. 1715-1735, doi 10.1137/10078356X.

        Examples
        --------
        The map x/2 + 1 takes 0 to 1 and 1 to 1.5; it repeats 2:

        >>> secants, one = Secants(), np.ones(1)
        >>> secants.add(np.array([0.0]), np.array([1.0]), one)
        >>> secants.add(np.array([1.0]), np.array([1.5]), one)
        >>> step, left = secants.step(np.array([0.5]), one)
        >>> round(float(step[0]), 6)
        1.0
        """
        step = rest = gain
        if self.are_shown:
            moved, gained = self._relative(sizes)
            weights = np.linalg.lstsq(gained.T, gain, rcond=CONDITION)[0]
            rest = gain - weights @ gained
            step = rest - weights @ moved
        unexplained = float(np.abs(rest).max())
        left = way_left(unexplained, self._unexplained)
        self._unexplained = unexplained
        return step, max(float(np.abs(step).max()), left)

    def correction(self, sizes: np.ndarray) -> np.ndarray:
        """Return the matrix (n, n) that gives the step of a gain, both relative to `sizes` (n,).

        States that never moved stay, see `apesim.march.periodic.Known`.

        The map x/2 + 1 gains half of the way to 2:

        >>> secants, one = Secants(), np.ones(1)
        >>> secants.add(np.array([0.0]), np.array([1.0]), one)
        >>> secants.add(np.array([1.0]), np.array([1.5]), one)
        >>> round(float(secants.correction(one)[0, 0]), 6)
        2.0
        """
        matrix = np.eye(len(sizes))
        if self.are_shown:
            moved, gained = self._relative(sizes)
            matrix -= (gained + moved).T @ np.linalg.pinv(gained.T, rcond=CONDITION)
            matrix[~moved.any(axis=0)] = 0.0
        return matrix

    def multipliers(self) -> np.ndarray:
        """Estimate the Floquet multipliers (k,), complex, in the directions that the secants show, if any.

        The map 1 - 1.2 x has the slope -1.2:

        >>> secants = Secants()
        >>> for x in (0.45, 0.46, 0.44):
        ...     secants.add(np.array([x]), np.array([1.0 - 1.2 * x]), np.ones(1))
        >>> secants.multipliers().real.round(3).tolist()
        [-1.2]
        """
        if not self._slopes:
            return np.empty(0)
        moved, image_moved = (np.array(side).T for side in zip(*self._slopes, strict=True))
        left, values, right = np.linalg.svd(moved, full_matrices=False)
        is_shown = values > SHOWN * values[0]
        return np.linalg.eigvals(left[:, is_shown].T @ image_moved @ right[is_shown].T / values[is_shown])
