"""A machine as it was fitted: calibrated, and with what was added to it."""

from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.parameters import corrections
from apesim.studies.estimation.residuals import Problem
from apesim.studies.measured.prediction import with_value

MIN_SENSITIVITY = 1e-6
"""Standard deviations over a parameter's range, below which the data do not depend on it."""


class Model(NamedTuple):
    """The calibrated machine with candidates added."""

    candidates: tuple
    """None, one or two."""
    problem: Problem
    fitted: Fitted
    released: str = ""
    """Key of a nuisance whose prior was taken away."""
    profiles: dict | None = None
    """Both ends of the intervals of effects that have a shape, `apesim.studies.estimation.profile_likelihood.End` in x,
    by key; None: not sought, see `apesim.studies.gap.search.intervals`."""

    @property
    def names(self):
        """Names of the candidates, or of the nuisance released."""
        return (self.released,) if self.released else tuple(candidate.name for candidate in self.candidates)

    @property
    def cost(self):
        """Sum of squares, priors included."""
        return self.fitted.cost

    @property
    def added(self):
        """How many parameters were freed."""
        return sum(len(candidate.parameters) for candidate in self.candidates)

    @property
    def beyond(self):
        """Keys of what is fitted beyond what a machine file takes."""
        return [
            p.key
            for p, x in zip(self.problem.parameters, self.fitted.x, strict=True)
            if not p.prior and not p.ends[0] <= x <= p.ends[1]
        ]

    def own(self, number):
        """Values x of the parameters of one of its candidates."""
        first = len(self.fitted.x) - self.added
        first += sum(len(candidate.parameters) for candidate in self.candidates[:number])
        return self.fitted.x[first : first + len(self.candidates[number].parameters)]

    def machine(self):
        """The machine with the effects, within what a machine file allows; its nuisances as they were."""
        machine, runs = self.problem.machine, self.problem.runs
        for p, x, told in zip(self.problem.parameters, self.fitted.x, self.identifiable, strict=True):
            if told and not p.prior:
                for key, value in corrections(self.problem.machine, p, np.clip(x, *p.ends), runs).items():
                    machine = with_value(machine, key, value)
        return machine

    @property
    def identifiable(self):
        """Whether the data depend on each parameter at all, (p,) bool array."""
        return np.linalg.norm(self.fitted.jacobian, axis=0) > MIN_SENSITIVITY
