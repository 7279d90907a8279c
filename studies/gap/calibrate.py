"""The noise of measured data, and the machine with its uncertain numbers fitted to them."""

import numpy as np

from studies.gap.descent import descend
from studies.gap.noise_source import noise_of
from studies.gap.nuisances import nuisances_of
from studies.gap.problem import Problem
from studies.gap.refit import Model
from studies.measured import FIT, GATE


def uncalibrated(machine, measured):
    """The runs to be fitted with the noise of the data, and the nuisances of the machine.

    Returns
    -------
    studies.gap.problem.Problem
    warnings : list of str
    """
    nuisances = nuisances_of(machine, measured)
    known = Problem(machine, measured.of(FIT) + measured.of(GATE), nuisances)
    noise, warnings = noise_of(known.blocks, known.predicted(np.zeros(len(nuisances))), measured.noise)
    return Problem(machine, measured.of(FIT), nuisances, noise), warnings


def calibrate(machine, measured):
    """The noise of the data, and the machine with its nuisances fitted under their priors.

    Parameters
    ----------
    machine : engine.machine.Machine
    measured : studies.measured.Measured

    Returns
    -------
    Model
    warnings : list of str
    """
    problem, warnings = uncalibrated(machine, measured)
    fitted = descend(problem, np.zeros(len(problem.parameters)))
    problem.start_at(fitted.x)
    return Model((), problem, fitted), warnings
