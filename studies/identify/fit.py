"""Least squares from several starts, and intervals by profile likelihood."""

from collections.abc import Callable, Sequence
from math import isnan
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError
from apesim.studies.estimation.levenberg_marquardt import Fitted, descend
from apesim.studies.estimation.noise.process import Noise
from apesim.studies.estimation.noise.residual_noise import find_noise_left_over, find_rough_noise, is_white
from apesim.studies.estimation.profile_likelihood import End
from apesim.studies.estimation.residuals import WhitenedResiduals, first_steps, unless_ended
from apesim.studies.identify.free import Method
from apesim.studies.identify.genetic import minimise_genetically
from apesim.studies.identify.profile import FINE, find_intervals, invert_curvature
from apesim.studies.identify.simulation import (
    MAX_SIMULATIONS,
    SUPPLY,
    Free,
    ReportingCounter,
    find_differences,
    find_objective,
    free_residuals,
    machine_at,
)
from apesim.studies.measured import FIT, Measured

STARTS = 3
ALIKE, COUPLED = 0.99, 0.98
"""Correlation of one estimate with another, and with all others together, above which they may be confused."""
WIDE = 0.2
"""Half an interval as a share of the value, above which a parameter counts as badly known."""
HELP = "fit runs at more supply pressures, measure chamber pressures too, or hold some parameters"
MAX_RESTARTS = 5


class Identified(NamedTuple):
    """Parameters that were identified from measured data, in SI, by key of the machine file."""

    parameters: dict[str, float]
    interval_95: dict[str, tuple[float, float] | None]
    """Low and high end; None from a method that has none."""
    correlation: np.ndarray | None
    """Correlation of the estimates in the order of the parameters, (p, p)."""
    objective: float
    """Eq. 11 over all fitted samples of lift [m]; NaN without any."""
    noise: dict[str, dict[float, Noise]]
    """Noise of what is left at the optimum, by sensor."""
    sensor_noise: dict[str, dict[float, Noise]]
    """Noise of the sensor alone: less, where the best fit is off by more than the noise."""
    steps: np.ndarray
    """Steps of finite differences at the optimum, (p,)."""
    nominal: dict[str, float]
    """Supply that the fitted runs state, where a supply is free, by key."""
    evaluations: int
    """Simulations of one run each."""
    warnings: list[str]
    machine: Machine
    """With the parameters found."""
    converged: bool


def _starts(free: Sequence[Free]) -> np.ndarray:
    """Starts of the fits: the machine's values, and points spread by a Halton sequence; shape (STARTS, p)."""
    from scipy.stats import qmc

    spread = qmc.Halton(len(free), scramble=False).random(STARTS + 1)[2:]
    starts = [[f.start / f.scale for f in free]]
    for point in spread:
        starts.append([])
        for f, u in zip(free, point, strict=True):
            value = f.start * 4.0 ** (u - 0.5) if f.local else f.low + u * (f.high - f.low)
            starts[-1].append(min(max(value, f.low), f.high) / f.scale)
    return np.array(starts)


def identify(
    machine: Machine,
    measured: Measured,
    free: Sequence[Free],
    method: str = Method.LEAST_SQUARES,
    report: Callable[[int, None], object] | None = None,
) -> Identified:
    """Identify parameters of a machine from measured data; only runs with the role "fit" are used.

    Least squares start from the machine's own values and from points of a Halton sequence (Halton 1960, doi
    10.1007/BF01386213); the noise is then estimated from the residuals, and the fit and its 95 % intervals by profile
    likelihood (Venzon and Moolgavkar 1988, doi 10.2307/2347496) are repeated while a profile meets a better point,
    `MAX_RESTARTS` times at most. `method` is "least-squares" or "ga"; ``report(done, total)`` is called with the number
    of simulations. Raises InputError where there is nothing to fit, a free supply differs between the runs, or a
    parameter changes nothing in them.
    """
    counter = ReportingCounter(report)
    residuals = free_residuals(machine, measured.of(FIT), free, counter)
    _refuse(residuals, free, measured, method)

    def is_spent() -> bool:
        return counter.number >= MAX_SIMULATIONS * len(residuals.runs) * len(free)

    # The genetic algorithm has no sensitivities, and so neither covariance nor intervals.
    if method == Method.GENETIC:
        x = minimise_genetically(residuals)
        differences = find_differences(residuals, x)
        noise, own, warnings = find_noise_left_over(residuals.blocks, differences, measured.noise)
        return Identified(
            **_values_at(x, machine, residuals, free, differences),
            interval_95={f.key: None for f in free},
            correlation=None,
            noise=noise,
            sensor_noise=own,
            steps=first_steps(len(x)),
            warnings=[*warnings, "the genetic algorithm states no uncertainty"],
            converged=True,
        )

    # The best of several starts by a rough noise: the noise proper is known only from what a good fit leaves.
    rough = residuals.with_noise(find_rough_noise(residuals.blocks, measured.noise))
    best = _deepest(rough, _starts(free), measured)
    noise, own, warnings = find_noise_left_over(residuals.blocks, find_differences(residuals, best.x), measured.noise)
    residuals = residuals.with_noise(noise)

    # The fit by that noise, and its intervals. A better point on the way to their ends shows that this was no optimum.
    x = best.x
    for _ in range(MAX_RESTARTS):
        best = descend(residuals, x, steps=best.steps, converged=FINE)
        _refuse_idle(free, best.jacobian)
        curvature, covariance = invert_curvature(best.jacobian)
        intervals, better = find_intervals(residuals, best, covariance, is_spent)
        if better is None:
            break
        x = better

    # Whether the outcome is to be relied on: a fit at rest, residuals that are noise, ends that data hold.
    success = best.converged and better is None
    differences = find_differences(residuals, best.x)
    if not success:
        warnings.append("the fit has not converged; give narrower bounds or free fewer parameters")
    if not is_white(residuals.by_block(best.residuals)):
        warnings.append(
            "what is left at the optimum is not the noise that it is taken for; the intervals may be too narrow"
        )
    if any(end.is_cut for ends in intervals for end in ends):
        success = False
        warnings.append(
            f"stopped after {counter.number} simulations: intervals may be from the curvature at the optimum "
            "alone, which is not to be relied on; give narrower bounds or free fewer parameters"
        )

    # The intervals, and which estimates may be confused; after a fit whose profile met a better point there are none.
    sigmas = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(sigmas, sigmas)
    together = np.sqrt(np.maximum(0.0, 1.0 - 1.0 / (np.diag(covariance) * np.diag(curvature))))
    interval_95: dict[str, tuple[float, float] | None] = {f.key: None for f in free}
    if better is None:
        warnings += _badly_known([f.key for f in free], best.x, intervals, correlation, together)
        for f, ends in zip(free, intervals, strict=True):
            if any(end.is_open for end in ends):
                warnings.append(f"{f.key}: its 95 % interval runs into a bound; these data do not hold it")
            low, high = (float(end.at * f.scale) for end in ends)
            interval_95[f.key] = low, high
    return Identified(
        **_values_at(best.x, machine, residuals, free, differences),
        interval_95=interval_95,
        correlation=correlation,
        noise=noise,
        sensor_noise=own,
        steps=best.steps,
        warnings=warnings,
        converged=success,
    )


def _values_at(
    x: np.ndarray,
    machine: Machine,
    residuals: WhitenedResiduals,
    free: Sequence[Free],
    differences: Sequence[np.ndarray],
) -> dict[str, Any]:
    """What follows from the best parameters alone, by field of `Identified`."""
    return {
        "parameters": {f.key: float(number * f.scale) for f, number in zip(free, x, strict=True)},
        "objective": find_objective(residuals, differences),
        "nominal": {f.key: getattr(residuals.runs[0], SUPPLY[f.key]) for f in free if f.key in SUPPLY},
        "evaluations": residuals.simulations,
        "machine": machine_at(machine, free, x),
    }


def _deepest(residuals: WhitenedResiduals, starts: np.ndarray, measured: Measured) -> Fitted:
    """Deepest of the minima to which several starts lead; raises `InputError` where none can be simulated."""
    ended = [fitted for start in starts if (fitted := unless_ended(descend, residuals, start))]
    if not ended:
        right = "start from a machine that runs, or give narrower bounds"
        raise InputError([Fault(measured.folder, "run", "no simulation comes to its end", right)])
    best = min(ended, key=lambda fitted: fitted.cost)
    return descend(residuals, best.x, best.jacobian, best.steps, FINE)


def _badly_known(
    keys: list[str], best: np.ndarray, intervals: list[list[End]], correlation: np.ndarray, together: np.ndarray
) -> list[str]:
    """Warnings of parameters that are indistinguishable, and of those whose interval is wide.

    Pairs alone do not show it: of five parameters, any one may be made up for by the other four, while no two of them
    are strongly correlated. The curvature does not either, where it changes along the way; the `intervals` by profile,
    see `find_intervals`, do. `best` (p,) is the optimum, `correlation` is (p, p), `together` (p,) the multiple
    correlation of each estimate with all others.
    """
    widths = [high.at - low.at for low, high in intervals]
    shares = [0.5 * width / max(abs(x), 1e-12) for x, width in zip(best, widths, strict=True)]
    shown = [
        f"{key} (± {100.0 * share:.2g} %)" if share < 1.0 else f"{key} (± 100 % or more)"
        for key, share in zip(keys, shares, strict=True)
    ]
    coupled = [j for j in range(len(keys)) if together[j] > COUPLED]
    closest = np.abs(np.triu(correlation, 1)[np.ix_(coupled, coupled)]).max(initial=0.0)
    warnings, told = [], []
    if len(coupled) > 1 and (closest > ALIKE or max(shares[j] for j in coupled) > WIDE):
        *most, last = [shown[j] for j in coupled]
        warnings.append(
            f"{', '.join(most)} and {last} are indistinguishable: the others make up for a change of one, "
            f"and where one interval misses its true value, most of them do; {HELP}"
        )
        told = coupled
    for j, ends in enumerate(intervals):
        if j not in told and shares[j] > WIDE and not any(end.is_open for end in ends):
            warnings.append(f"{shown[j]} is badly known from these data; {HELP}")
    return warnings


def _refuse(residuals: WhitenedResiduals, free: Sequence[Free], measured: Measured, method: str) -> None:
    """Raises `InputError` where there is nothing to fit, or no one value of a free parameter."""
    faults, sensors = [], [block.sensor for block in residuals.blocks]
    if not sensors or (method == Method.GENETIC and "lift" not in sensors):
        wrong = "no run of the role fit has " + ("lift" if method == Method.GENETIC else "lift or chamber pressures")
        faults.append(Fault(measured.folder, "run", wrong, 'measure "lift [mm]", and write role = "fit"'))
    for key, field in SUPPLY.items():
        given = {value for run in measured.of(FIT) if not isnan(value := getattr(run, field))}
        if key in [f.key for f in free] and len(given) > 1:
            faults.append(Fault(measured.folder, key, "differs between the runs", "fit runs of one value, or hold it"))
    if faults:
        raise InputError(faults)


def _refuse_idle(free: Sequence[Free], jacobian: np.ndarray) -> None:
    """Raises `InputError` where a free parameter changes nothing in the fitted runs."""
    idle = [parameter.key for parameter, column in zip(free, jacobian.T, strict=True) if not column.any()]
    if idle:
        right = "leave it out, or switch on what it belongs to"
        raise InputError([Fault("command line", "--free", f"{key} changes nothing in the runs", right) for key in idle])
