"""The noise of measured data, and the machine with its uncertain numbers fitted to them."""

from typing import Any

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.estimation.engine_starts import starts_at
from apesim.studies.estimation.levenberg_marquardt import ROUGH, SAME, Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.discrepancy import state_discrepancy
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
from apesim.studies.measured import CHECK, FIT, GATE, Measured

STARTS = 8
"""Number of further starts of a calibration."""
SEED = 8302
MAX_FOLLOWED = 3
"""Further starts that are followed to their end: the lowest of those that do not lead back."""
DEEPER = 3.0
"""Fall of the sum of squares from which another minimum is a better one: odds of 4.5 to 1."""


def uncalibrated(
    machine: Machine, measured: Measured, counter: Counter | None = None
) -> tuple[WhitenedResiduals, list[str]]:
    """Return the residuals of the runs to be fitted, a function of the machine's nuisances, with the noise of the data.

    The noise is estimated from the runs to be fitted and from the gate runs; the warnings are those of `noise_of`.
    Without a counter of simulations the residuals have one of their own; raises EndedEarly where the machine cannot be
    simulated.
    """
    nuisances = nuisances_of(machine, measured)
    known = WhitenedResiduals(machine, measured.of(FIT) + measured.of(GATE), nuisances)
    noise, warnings = noise_of(known.blocks, known.predicted(np.zeros(len(nuisances))), measured.noise)
    noise = state_discrepancy(noise, measured.discrepancy)
    return WhitenedResiduals(machine, measured.of(FIT), nuisances, noise, counter=counter), warnings


def calibrate(
    machine: Machine, measured: Measured, counter: Counter | None = None, known: Scatter | None = None
) -> tuple[Model, list[str]]:
    """Calibrate a machine: fit its nuisances to measured data under their priors; the model is without candidates.

    It minimises ``|e(x)|^2 + |x|^2`` from x = 0, with the whitened residuals e and the nuisances x in prior standard
    deviations: the most probable point under Gaussian noise and priors (Tarantola 2005, doi 10.1137/1.9780898717921,
    chapter 3). Where runs are repeated, their noise is found anew beside what may scatter between them
    (`find_scatter`), which is whitened like noise; `known` is the scatter that more repeats have told. Raises
    EndedEarly where the machine cannot be simulated.
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
        noise = state_discrepancy(noise, measured.discrepancy)
        runs, checks = runs.with_noise(noise), checks.with_noise(noise)
        scatter = find_scatter(Model((), residuals, fitted), runs, checks, known, stated)
        warnings = [*warnings, *([] if known else warn_of_odd_repeats(scatter))]
        residuals.counter.add(runs.simulations + checks.simulations)
        residuals = residuals.with_noise(noise).with_scatter(scatter)
        fitted = descend(residuals, fitted.x, steps=fitted.steps)
    return _restarted(residuals, fitted), warnings


def elsewhere(base: Model, work: Any) -> Model:
    """Look for a deeper minimum of a calibration, from `STARTS` further starts drawn from the priors.

    An engine near the limit of its valve has ranges without any steady state, which no descent crosses. Returns `base`
    itself where no minimum is deeper by `DEEPER`.
    """
    residuals, rng = base.residuals, np.random.default_rng(SEED)
    draws = rng.standard_normal((STARTS, len(base.fitted.x)))
    starts = np.clip(np.where(residuals.known, draws, base.fitted.x), residuals.low, residuals.high)

    # A few steps without new sensitivities tell which starts lead back, as nearly all do.
    scouts = work.each("calibrating", unless_ended, [(_scout, residuals, x, base.fitted) for x in starts])
    arrived = [one for one in scouts if one]
    away = [
        fitted
        for fitted, _ in arrived
        if abs(fitted.cost - base.fitted.cost) > SAME and not base.fitted.leads_here(fitted.x, fitted.residuals)
    ]
    lowest = sorted(away, key=lambda fitted: fitted.cost)[:MAX_FOLLOWED]
    found = work.each("calibrating", unless_ended, [(_follow, residuals, start, base.fitted) for start in lowest])
    ended = [one for one in found if one]
    work.simulations.add(sum(simulations for _, simulations in (*arrived, *ended)))
    fitted = min((fitted for fitted, _ in ended), key=lambda one: one.cost, default=base.fitted)
    if fitted.cost > base.fitted.cost - DEEPER:
        return base
    return _restarted(residuals, fitted)


def _restarted(residuals: WhitenedResiduals, fitted: Fitted) -> Model:
    """Calibrated machine, with the starts of its runs at the optimum."""
    residuals = residuals.restarted_at(fitted.x)
    return Model((), residuals, fitted._replace(residuals=residuals.at(fitted.x)))


def _scout(residuals: WhitenedResiduals, x: np.ndarray, base: Fitted) -> tuple[Fitted, int]:
    """Point to which a descent from x comes without sensitivities of its own, and how many simulations it takes."""
    own = residuals.with_parameters(residuals.parameters)
    return descend(own, x, base.jacobian, base.steps, known=base, is_scout=True), own.simulations


def _follow(residuals: WhitenedResiduals, start: Fitted, base: Fitted) -> tuple[Fitted, int]:
    """End of a descent from where a scout has come, and how many simulations it takes; over where it leads back."""
    own = residuals.with_parameters(residuals.parameters)
    limit = base.cost + ROUGH
    fitted = descend(
        own, start.x, None, start.steps, errors=start.residuals, known=base, limit=limit, least_promise=0.0
    )
    return fitted, own.simulations
