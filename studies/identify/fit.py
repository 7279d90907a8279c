"""Least squares from several starts, and intervals by profile likelihood."""

from math import isnan
from typing import Any, NamedTuple

import numpy as np

from apesim.quantities import Fault, InputError
from apesim.studies.estimation.noise.first_order import is_white, noise_model, rough_noise
from apesim.studies.identify.genetic import genetic
from apesim.studies.identify.profile import FINE, intervals_of, minimise
from apesim.studies.identify.simulation import SUPPLY, Problem
from apesim.studies.measured import FIT

STARTS = 3
ALIKE, COUPLED = 0.99, 0.98
"""Correlation of one estimate with another, and with all others together, above which they may be confused."""
WIDE = 0.2
"""Half an interval as a share of the value, above which a parameter counts as badly known."""
HELP = "fit runs at more supply pressures, measure chamber pressures too, or hold some parameters"
MAX_RESTARTS = 5
BASIN = 1e-2
"""Relative tolerance of parameters and sum of squares with which a start is followed; the best goes on to `FINE`."""


class Identified(NamedTuple):
    """The parameters that were identified from measured data, SI, by key of the machine file."""

    parameters: dict
    interval_95: dict
    """Low and high end; None from a method that has none."""
    correlation: Any
    """(p, p) float array in the order of the parameters, or None."""
    objective: float
    """Eq. 11 over all fitted samples of lift [m]; NaN without any."""
    noise: dict
    """Standard deviation [SI] and colour of what is left at the optimum, by sensor."""
    sensor_noise: dict
    """Noise of the sensor alone: less, where the best fit is off by more than the noise."""
    nominal: dict
    """What the fitted runs say of a supply that is free, by key."""
    evaluations: int
    """Simulations of one run each."""
    warnings: list
    machine: Any
    """With the parameters found."""
    converged: bool


def _starts(free):
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


def identify(machine, measured, free, method="least-squares", report=None):
    """Identify parameters of a machine from measured data; only runs with the role "fit" are used.

    Least squares start from several points; the noise is then estimated from the residuals, and the fit and its 95 %
    intervals by profile likelihood are repeated while a profile meets a better point, `MAX_RESTARTS` times at most.

    The first start is the machine's own values, the others are points of a Halton sequence [1]_; intervals are those of
    the profile likelihood [2]_.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
        Machine from which the search starts.
    measured : apesim.studies.measured.Measured
    free : sequence of Free
        See `apesim.studies.identify.free.free_parameters`.
    method : {"least-squares", "ga"}
    report : callable, optional
        ``report(done, total)``, told of the number of simulations.

    Returns
    -------
    Identified

    Raises
    ------
    apesim.quantities.InputError
        There is nothing to fit, a free supply differs between the runs, or a parameter changes nothing in them.

    References
    ----------
    .. [1] J. H. Halton, "On the efficiency of certain quasi-random sequences of points in evaluating multi-dimensional
       integrals", Numer. Math. 2, 1960, pp. 84-90, doi 10.1007/BF01386213.
    .. [2] D. J. Venzon and S. H. Moolgavkar, "A method for computing profile-likelihood-based confidence intervals",
       Appl. Statist. 37, 1988, pp. 87-94, doi 10.2307/2347496.
    """
    problem = Problem(machine, measured.of(FIT), free, report)
    _refuse(problem, measured, method)
    if method == "ga":
        x = genetic(problem)
        *noises, warnings = noise_model(problem, x, measured.noise)
        return _identified(
            problem, x, None, None, noises, [*warnings, "the genetic algorithm states no uncertainty"], True
        )
    rough = rough_noise(problem, measured.noise)
    fits = [minimise(problem, x, rough, BASIN) for x in _starts(free)]
    best, _, _ = minimise(problem, min(fits, key=lambda fit: fit[1])[0], rough, FINE)
    noise, own, warnings = noise_model(problem, best, measured.noise)
    for _ in range(MAX_RESTARTS):
        best, cost, success = minimise(problem, best, noise, FINE)
        jacobian = problem.jacobian(best, noise)
        _refuse_idle(problem, jacobian)
        curvature = jacobian.T @ jacobian
        curvature += np.diag(1e-10 * np.diag(curvature) + 1e-12)
        covariance = np.linalg.inv(curvature)
        intervals, better = intervals_of(problem, best, cost, noise, covariance)
        if better is None:
            break
        best = better
    success = success and better is None
    if not success:
        warnings.append("the fit has not converged; give narrower bounds or free fewer parameters")
    if not is_white(problem, best, noise):
        warnings.append("what is left at the optimum is not AR(1) noise; the intervals may be too narrow")
    if problem.cut:
        success = False
        warnings.append(
            f"stopped after {problem.evaluations} simulations: intervals may be from the curvature at the optimum "
            "alone, which is not to be relied on; give narrower bounds or free fewer parameters"
        )
    deviations = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviations, deviations)
    together = np.sqrt(np.maximum(0.0, 1.0 - 1.0 / (np.diag(covariance) * np.diag(curvature))))
    if better is not None:
        intervals = None
    else:
        warnings += _badly_known([f.key for f in problem.free], best, intervals, correlation, together)
    return _identified(problem, best, intervals, correlation, (noise, own), warnings, success)


def _badly_known(keys, best, intervals, correlation, together):
    """Warnings of parameters that cannot be told apart, and of those whose interval is wide.

    Pairs alone do not show it: of five parameters, any one may be made up for by the other four, while no two of them
    are strongly correlated. The curvature does not either, where it changes along the way; intervals by profile do.

    Parameters
    ----------
    keys : list of str
    best : (p,) float array
        The optimum.
    intervals : list
        See `intervals_of`.
    correlation : (p, p) float array
    together : (p,) float array
        Multiple correlation of each estimate with all others.

    Returns
    -------
    list of str
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
            f"{', '.join(most)} and {last} cannot be told apart: the others make up for a change of one, "
            f"and where one interval misses its true value, most of them do; {HELP}"
        )
        told = coupled
    for j, ends in enumerate(intervals):
        if j not in told and shares[j] > WIDE and not any(end.is_open for end in ends):
            warnings.append(f"{shown[j]} is badly known from these data; {HELP}")
    return warnings


def _refuse(problem, measured, method):
    """Raises `InputError` where there is nothing to fit, or no one value of a free parameter."""
    faults = []
    if not problem.blocks or (method == "ga" and "lift" not in problem.sensors):
        wrong = "no run of the role fit has " + ("lift" if method == "ga" else "lift or chamber pressures")
        faults.append(Fault(measured.folder, "run", wrong, 'measure "lift [mm]", and write role = "fit"'))
    for key, field in SUPPLY.items():
        given = {value for run in problem.runs if not isnan(value := getattr(run, field))}
        if key in [f.key for f in problem.free] and len(given) > 1:
            faults.append(Fault(measured.folder, key, "differs between the runs", "fit runs of one value, or hold it"))
    if faults:
        raise InputError(faults)


def _refuse_idle(problem, jacobian):
    """Raises `InputError` where a free parameter changes nothing in the fitted runs."""
    idle = [free.key for free, column in zip(problem.free, jacobian.T, strict=True) if not column.any()]
    if idle:
        right = "leave it out, or switch on what it belongs to"
        raise InputError([Fault("command line", "--free", f"{key} changes nothing in the runs", right) for key in idle])


def _identified(problem, x, intervals, correlation, noises, warnings, converged):
    """The outcome, with warnings of what the data cannot tell; noises: both of `noise_model`."""
    keys = [f.key for f in problem.free]
    for j, key in enumerate(keys if intervals else ()):
        if any(end.is_open for end in intervals[j]):
            warnings.append(f"{key}: its 95 % interval runs into a bound; these data do not hold it")
    return Identified(
        dict(zip(keys, (x * problem.scale).tolist(), strict=True)),
        {
            key: tuple(float(end.at * problem.scale[j]) for end in intervals[j]) if intervals else None
            for j, key in enumerate(keys)
        },
        correlation,
        problem.objective(x),
        *({sensor: tuple(map(float, pair)) for sensor, pair in noise.items()} for noise in noises),
        {key: getattr(problem.runs[0], SUPPLY[key]) for key in keys if key in SUPPLY},
        problem.evaluations,
        warnings,
        problem.machine_at(x),
        converged,
    )
