"""The noise of measured data, and the machine with its uncertain numbers fitted to them."""

from typing import Any

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.estimation.levenberg_marquardt import ROUGH, Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.estimation import noise_of
from apesim.studies.estimation.priors import nuisances_of
from apesim.studies.estimation.residuals import Counter, WhitenedResiduals, unless_ended
from apesim.studies.estimation.scatter import (
    Scatter,
    find_changes,
    find_scatter,
    find_stated_sizes,
    is_repeated,
    warn_of_odd_repeats,
)
from apesim.studies.estimation.starts import starts_at
from apesim.studies.measured import CHECK, FIT, GATE, Measured

STARTS = 8
"""Number of further starts of a calibration."""
SEED = 8302
DEEPER = 1.0
"""Fall of the sum of squares from which another minimum is a better one."""


def uncalibrated(
    machine: Machine, measured: Measured, counter: Counter | None = None
) -> tuple[WhitenedResiduals, list[str]]:
    """The residuals of the runs to be fitted as a function of the machine's nuisances, with the noise of the data.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
        The noise is estimated from the runs to be fitted and from the gate runs.
    counter : apesim.studies.estimation.residuals.Counter, optional
        Counter of the simulations of the residuals; without it one of their own.

    Returns
    -------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    warnings : list of str
        See `apesim.studies.estimation.noise.estimation.noise_of`.

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The machine cannot be simulated.

    Examples
    --------
    Lift at rest, with a noise of 0.03 mm:

    >>> from apesim.studies.measured import MeasuredRun
    >>> times = np.arange(0.0, 1.5e-3, 1e-5)
    >>> lift = np.random.default_rng(1).normal(0.0, 3e-5, len(times))  # the dead time of the valve, at rest
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": lift})
    >>> residuals, _ = uncalibrated(Machine(), Measured("", {}, (run,), "valve"))
    >>> round(residuals.noise["lift"][1e-5].deviation, 5)
    3e-05
    """
    nuisances = nuisances_of(machine, measured)
    known = WhitenedResiduals(machine, measured.of(FIT) + measured.of(GATE), nuisances)
    noise, warnings = noise_of(known.blocks, known.predicted(np.zeros(len(nuisances))), measured.noise)
    return WhitenedResiduals(machine, measured.of(FIT), nuisances, noise, counter=counter), warnings


def calibrate(
    machine: Machine, measured: Measured, counter: Counter | None = None, known: Scatter | None = None
) -> tuple[Model, list[str]]:
    """Calibrate a machine: fit its nuisances to measured data under their priors.

    It minimises ``|e(x)|^2 + |x|^2`` from x = 0, with the whitened residuals e and the nuisances x in prior standard
    deviations. Where runs are repeated, their noise is found anew beside what may scatter between them. What they
    differ by beyond it, and what the user states, is whitened like noise, see
    `apesim.studies.estimation.scatter.find_scatter`.

    It is the most probable point under Gaussian noise and priors [1]_.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
    counter : apesim.studies.estimation.residuals.Counter, optional
        Counter of the simulations of the residuals; without it one of their own.
    known : apesim.studies.estimation.scatter.Scatter, optional
        Scatter between runs that more repeats than these have told.

    Returns
    -------
    model : apesim.studies.estimation.model.Model
        The calibrated machine, without candidates.
    warnings : list of str
        See `apesim.studies.estimation.noise.estimation.noise_of`, and
        `apesim.studies.estimation.scatter.warn_of_odd_repeats`.

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The machine cannot be simulated.

    Examples
    --------
    Lift at rest tells nothing but the offset of its sensor, here of 0.02 mm:

    >>> from apesim.studies.measured import MeasuredRun
    >>> times = np.arange(0.0, 1.5e-3, 1e-5)
    >>> lift = np.random.default_rng(1).normal(2e-5, 3e-5, len(times))  # in the dead time
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": lift})
    >>> model, _ = calibrate(Machine(), Measured("", {}, (run,), "valve"))
    >>> keys = [parameter.key for parameter in model.residuals.parameters]
    >>> round(float(model.fitted.x[keys.index("effects.sensor_offset.lift")]), 1)  # in prior standard deviations
    0.9

    References
    ----------
    .. [1] A. Tarantola, "Inverse Problem Theory and Methods for Model Parameter Estimation", SIAM, 2005,
       doi 10.1137/1.9780898717921, chapter 3.
    """
    residuals, warnings = uncalibrated(machine, measured, counter)
    fitted = descend(residuals, np.zeros(len(residuals.parameters)))
    stated = find_stated_sizes(machine, measured, residuals.parameters)
    if known or stated or is_repeated(measured):
        runs, checks = (
            residuals.with_runs(group, starts_at(machine, group, residuals.parameters, fitted.x))
            for group in (measured.of(FIT) + measured.of(GATE), measured.of(CHECK))
        )
        predicted = runs.predicted(fitted.x)
        changes = find_changes(runs, fitted.x, predicted)
        noise, warnings = noise_of(runs.blocks, predicted, measured.noise, changes)
        runs, checks = runs.with_noise(noise), checks.with_noise(noise)
        scatter = find_scatter(Model((), residuals, fitted), runs, checks, known, stated)
        warnings = [*warnings, *([] if known else warn_of_odd_repeats(scatter))]
        residuals.counter.add(runs.simulations + checks.simulations)
        residuals = residuals.with_noise(noise).with_scatter(scatter)
        fitted = descend(residuals, fitted.x, steps=fitted.steps)
    return _restarted(residuals, fitted), warnings


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

    Examples
    --------
    >>> from apesim.studies.gap.work import Work
    >>> from apesim.studies.measured import MeasuredRun
    >>> run = MeasuredRun("", "", 0.5e6, 287.0, 50e-3, "fit", np.arange(0.0, 1e-3, 1e-5), {"lift": np.zeros(100)})
    >>> base, _ = calibrate(Machine(), Measured("", {}, (run,), "valve"))
    >>> elsewhere(base, Work()) is base  # at rest there is no other minimum
    True
    """
    residuals, rng = base.residuals, np.random.default_rng(SEED)
    draws = rng.standard_normal((STARTS, len(base.fitted.x)))
    starts = np.clip(np.where(residuals.known, draws, base.fitted.x), residuals.low, residuals.high)
    found = work.each("calibrating", unless_ended, [(_descended, residuals, x, base.fitted) for x in starts])
    ended = [one for one in found if one]
    work.simulations.add(sum(simulations for _, simulations in ended))
    fitted = min((fitted for fitted, _ in ended), key=lambda one: one.cost, default=base.fitted)
    if fitted.cost > base.fitted.cost - DEEPER:
        return base
    return _restarted(residuals, fitted)


def _restarted(residuals: WhitenedResiduals, fitted: Fitted) -> Model:
    """Calibrated machine, with the starts of its runs at the optimum."""
    residuals = residuals.restarted_at(fitted.x)
    return Model((), residuals, fitted._replace(residuals=residuals.at(fitted.x)))


def _descended(residuals: WhitenedResiduals, x: np.ndarray, base: Fitted) -> tuple[Fitted, int]:
    """End of a descent from x, and how many simulations it takes; over where it comes to the minimum that is known."""
    own = residuals.with_parameters(residuals.parameters)
    limit = base.cost + ROUGH
    fitted = descend(own, x, base.jacobian, base.steps, known=base.cost, limit=limit, least_promise=0.0)
    return fitted, own.simulations
