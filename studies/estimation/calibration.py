"""The noise of measured data, and the machine with its uncertain numbers fitted to them."""

from typing import Any

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.estimation.levenberg_marquardt import Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.estimation import noise_of
from apesim.studies.estimation.priors import nuisances_of
from apesim.studies.estimation.residuals import WhitenedResiduals, unless_ended
from apesim.studies.measured import FIT, GATE, Measured

STARTS = 8
"""Number of further starts of a calibration."""
SEED = 8302
DEEPER = 1.0
"""Fall of the sum of squares from which another minimum is a better one."""


def uncalibrated(machine: Machine, measured: Measured) -> tuple[WhitenedResiduals, list[str]]:
    """The residuals of the runs to be fitted as a function of the machine's nuisances, with the noise of the data.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
        The noise is estimated from the runs to be fitted and from the gate runs.

    Returns
    -------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    warnings : list of str
        See `apesim.studies.estimation.noise.estimation.noise_of`.

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The machine cannot be simulated.
    """
    nuisances = nuisances_of(machine, measured)
    known = WhitenedResiduals(machine, measured.of(FIT) + measured.of(GATE), nuisances)
    noise, warnings = noise_of(known.blocks, known.predicted(np.zeros(len(nuisances))), measured.noise)
    return WhitenedResiduals(machine, measured.of(FIT), nuisances, noise), warnings


def calibrate(machine: Machine, measured: Measured) -> tuple[Model, list[str]]:
    """Calibrate a machine: fit its nuisances to measured data under their priors.

    It minimises ``|e(x)|^2 + |x|^2`` from x = 0, with the whitened residuals e and the nuisances x in prior standard
    deviations.

    It is the most probable point under Gaussian noise and priors [1]_.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured

    Returns
    -------
    model : apesim.studies.estimation.model.Model
        The calibrated machine, without candidates.
    warnings : list of str
        See `apesim.studies.estimation.noise.estimation.noise_of`.

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The machine cannot be simulated.

    References
    ----------
    .. [1] A. Tarantola, "Inverse Problem Theory and Methods for Model Parameter Estimation", SIAM, 2005,
       doi 10.1137/1.9780898717921, chapter 3.
    """
    residuals, warnings = uncalibrated(machine, measured)
    fitted = descend(residuals, np.zeros(len(residuals.parameters)))
    residuals.start_at(fitted.x)
    return Model((), residuals, fitted), warnings


def elsewhere(base: Model, work: Any) -> Model:
    """Look for a deeper minimum of a calibration, from `STARTS` further starts drawn from the priors.

    An engine near the limit of its valve has ranges without any steady state, which no descent crosses.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    apesim.studies.estimation.model.Model
        The calibrated machine at the deepest minimum; `base` itself where none is deeper by `DEEPER`.
    """
    residuals, rng = base.residuals, np.random.default_rng(SEED)
    draws = rng.standard_normal((STARTS, len(base.fitted.x)))
    starts = np.clip(np.where(residuals.known, draws, base.fitted.x), residuals.low, residuals.high)
    found = work.each("calibrating", unless_ended, [(_descended, residuals, x) for x in starts])
    ended = [one for one in found if one]
    residuals.simulations += sum(simulations for _, simulations in ended)
    fitted = min((fitted for fitted, _ in ended), key=lambda one: one.cost, default=base.fitted)
    if fitted.cost > base.cost - DEEPER:
        return base
    residuals.start_at(fitted.x)
    return Model((), residuals, fitted)


def _descended(residuals: WhitenedResiduals, x: np.ndarray) -> tuple[Fitted, int]:
    """End of a descent from x, and how many simulations it takes."""
    own = residuals.with_parameters(residuals.parameters)
    return descend(own, x), own.simulations
