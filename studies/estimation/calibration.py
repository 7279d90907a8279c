"""The noise of measured data, and the machine with its uncertain numbers fitted to them."""

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.estimation import noise_of
from apesim.studies.estimation.priors import nuisances_of
from apesim.studies.estimation.residuals import Problem, unless_ended
from apesim.studies.measured import FIT, GATE

STARTS = 8
"""Further starts of a calibration."""
SEED = 8302
DEEPER = 1.0
"""Fall of the sum of squares from which another minimum is a better one."""


def uncalibrated(machine, measured):
    """The runs to be fitted with the noise of the data, and the nuisances of the machine.

    Returns
    -------
    apesim.studies.estimation.residuals.Problem
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
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured

    Returns
    -------
    Model
    warnings : list of str
    """
    problem, warnings = uncalibrated(machine, measured)
    fitted = descend(problem, np.zeros(len(problem.parameters)))
    problem.start_at(fitted.x)
    return Model((), problem, fitted), warnings


def elsewhere(base, work):
    """The calibrated machine at the deepest of several minima, from further starts drawn from the priors.

    An engine whose valve is near the end of its breath has ranges without any steady state, which no descent crosses.

    Parameters
    ----------
    base : Model
    work : apesim.studies.gap.work.Work

    Returns
    -------
    Model
        The same where none is deeper.
    """
    problem, rng = base.problem, np.random.default_rng(SEED)
    draws = rng.standard_normal((STARTS, len(base.fitted.x)))
    starts = np.clip(np.where(problem.known, draws, base.fitted.x), problem.low, problem.high)
    found = work.each("calibrating", unless_ended, [(_descended, problem, x) for x in starts])
    ended = [one for one in found if one]
    problem.simulations += sum(simulations for _, simulations in ended)
    fitted = min((fitted for fitted, _ in ended), key=lambda one: one.cost, default=base.fitted)
    if fitted.cost > base.cost - DEEPER:
        return base
    problem.start_at(fitted.x)
    return Model((), problem, fitted)


def _descended(problem, x):
    """End of a descent from x, and how many simulations it takes."""
    own = problem.with_parameters(problem.parameters)
    return descend(own, x), own.simulations
