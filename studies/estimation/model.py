"""A machine as it was fitted: calibrated, and with what was added to it."""

from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.parameters import corrections
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.measured.prediction import with_value

MAX_PULL = 4.0
"""Prior standard deviations beyond which a number of the machine is itself a finding: noise alone pulls one of thirty
numbers that are known as well as is said so far in one of 500 cases."""
MIN_SENSITIVITY = 1e-6
"""Standard deviations over a parameter's range, below which the data do not depend on it."""


class Model(NamedTuple):
    """The calibrated machine with candidates added."""

    candidates: tuple[Any, ...]
    """Effects that were added, and faults of files, `apesim.studies.gap.search.candidates.Candidate`."""
    residuals: WhitenedResiduals
    """Residuals as a function of the nuisances and of the parameters of the candidates, in this order."""
    fitted: Fitted
    """Fit of the residuals."""
    profiles: dict[str, Any] | None = None
    """Both ends of the intervals of effects that have a shape, `apesim.studies.estimation.profile_likelihood.End` in x,
    by key; None: not sought, see `apesim.studies.gap.search.intervals`."""
    between: np.ndarray | None = None
    """Variances of the parameters that other models within reach add, in x, (p,); None: not sought, see
    `apesim.studies.gap.decide.standard_errors`."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the candidates."""
        return tuple(candidate.name for candidate in self.candidates)

    @property
    def pulled(self) -> list[int]:
        """Places of the nuisances that are pulled beyond `MAX_PULL`, the farthest first."""
        x = self.fitted.x
        far = np.flatnonzero(self.residuals.known & (np.abs(x) > MAX_PULL))
        return sorted(far.tolist(), key=lambda place: -abs(x[place]))

    @property
    def corrected(self) -> tuple[str, ...]:
        """Keys of the numbers of the machine that are pulled beyond `MAX_PULL`, the farthest first."""
        return tuple(self.residuals.parameters[place].key for place in self.pulled)

    @property
    def cost(self) -> float:
        """Twice the negative log likelihood, but for a constant: the sum of squares, priors included.

        Where runs scatter, it is that of Student's t, by which one run that lies far off is no finding yet; fits
        minimise the sum of squares all the same.
        """
        return self.fitted.cost - self.residuals.find_relief(self.fitted.data_residuals)

    @property
    def added(self) -> int:
        """Number of parameters of the candidates."""
        return sum(len(candidate.parameters) for candidate in self.candidates)

    @property
    def beyond(self) -> list[str]:
        """Keys of the parameters that are fitted beyond the range that a machine file takes."""
        return [
            p.key
            for p, x in zip(self.residuals.parameters, self.fitted.x, strict=True)
            if not p.prior and not p.ends[0] <= x <= p.ends[1]
        ]

    def own(self, number: int) -> np.ndarray:
        """Fitted values x of the parameters of the candidate at a place, in the order of its parameters."""
        return self.fitted.x[self.places(number)]

    def places(self, number: int) -> range:
        """Find the places of one candidate's parameters among all; `number` is the place of the candidate."""
        first = len(self.fitted.x) - self.added
        first += sum(len(candidate.parameters) for candidate in self.candidates[:number])
        return range(first, first + len(self.candidates[number].parameters))

    def machine(self) -> Machine:
        """The machine with the effects that were added and its numbers corrected, its other nuisances as they were.

        Parameters that the data do not depend on are left as they were, and values beyond the range of a machine file
        become the end of it.
        """
        machine, runs, corrected = self.residuals.machine, self.residuals.runs, self.corrected
        for p, x, told in zip(self.residuals.parameters, self.fitted.x, self.identifiable, strict=True):
            if told and not p.file and (not p.prior or p.key in corrected):
                for key, value in corrections(self.residuals.machine, p, np.clip(x, *p.ends), runs).items():
                    machine = with_value(machine, key, value)
        return machine

    @property
    def identifiable(self) -> np.ndarray:
        """Whether the data depend on each parameter at all: a sensitivity above `MIN_SENSITIVITY`, (p,) bool array."""
        return np.linalg.norm(self.fitted.jacobian, axis=0) > MIN_SENSITIVITY
