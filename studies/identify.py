"""Identification: parameters of a machine from measured data, through the simulator.

The default is bounded least squares from several starts, with the colour of the noise taken off, 95 % intervals by
profile likelihood, and a warning where the data cannot tell parameters apart. The other method is the genetic
algorithm of doi 10.1631/jzus.A0820373, Table 2, which minimises Eq. 11.

The noise of a sensor is taken for AR(1): ``e_i = colour * e_(i-1) + white``. Its standard deviation is the stated one,
else from repeats, else from what is left at the optimum; its colour is from repeats, else from what is left.

The sum of squares bends wherever the simulated contact passes a sample, the more the redder the noise, so that there
are several minima close together: a profile that meets a better point starts the fit again from there.
"""

from math import inf, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from apesim.march import Status
from apesim.quantities import Culprit, InputError, Quantity
from studies.measured import FIT
from valve.bench import TRACE, run_bench

FITTED = {"lift": 1e-8, "pressure_a": 1.0, "pressure_b": 1.0}
"""Sensors that are fitted, and the error of the simulator, below which no noise is believed [SI]."""
COLUMN = {header.split(" [")[0]: i for i, header in enumerate(TRACE)}
POPULATION, GENERATIONS = 20, 80
STARTS = 3
STEP = 1e-3
"""Of a finite difference, as a share of a parameter's scale."""
DEVIATIONS = 1.959964
"""Half the width of a 95 % interval, in standard deviations."""
ALIKE = 0.99
MOST_RESTARTS = 5


class Free(NamedTuple):
    """A free parameter, SI."""

    key: str
    declaration: Quantity
    low: float
    high: float
    start: float
    scale: float
    local: bool
    """Whether starts stay within a factor of two of the machine's value; else they lie all over the range."""


class Identified(NamedTuple):
    """What the data say of the free parameters, SI, by key."""

    parameters: dict
    interval_95: dict
    """Low and high end; None from a method that has none."""
    correlation: Any
    """(p, p) float array in the order of the parameters, or None."""
    objective: float
    """Eq. 11 over all fitted samples of lift [m]; NaN without any."""
    noise: dict
    """Standard deviation [SI] and colour, by sensor."""
    evaluations: int
    """Simulations of one run each."""
    warnings: list
    machine: Any
    """With the parameters found."""
    converged: bool


def with_value(tree, key, value):
    """A machine with another value, SI, at a key with dots."""
    name, _, rest = key.partition(".")
    return tree._replace(**{name: with_value(getattr(tree, name), rest, value) if rest else value})


def run_of(machine, run):
    """The machine with the supply of a measured run, which is that of the control air, too."""
    supply = machine.supply._replace(pressure=run.supply, control_pressure=nan)
    if not isnan(run.temperature):
        supply = supply._replace(temperature=run.temperature)
    return machine._replace(supply=supply)


def predict(machine, run, sensors):
    """What ideal sensors would see of a measured run.

    Parameters
    ----------
    machine : engine.machine.Machine
        With the supply of the run, see `run_of`.
    run : studies.measured.MeasuredRun
    sensors : iterable of str

    Returns
    -------
    dict
        (n,) float arrays at the times of the run, by sensor; NaN if the simulation ended early.
    bench : valve.bench.BenchRun
    """
    until = float(run.times[-1])
    bench = run_bench(machine, run.pulse, until, sample=min(max(until / 1e4, 2e-5), 1e-4))
    if bench.status != Status.DONE:
        return {sensor: np.full(len(run.times), nan) for sensor in sensors}, bench
    lift = _lift_at(machine.valve.stroke, bench)
    found = {
        sensor: lift(run.times)
        if sensor == "lift"
        else np.interp(run.times, bench.times, bench.trace[:, COLUMN[sensor]])
        for sensor in sensors
    }
    return found, bench


def _lift_at(stroke, bench):
    """Lift as a function of time: cubic Hermite between the rows of the trace and the first contacts."""
    times, lift, speed = bench.times, bench.trace[:, COLUMN["lift"]], -bench.trace[:, COLUMN["velocity"]]
    for measures, met, sign in ((bench.opening, stroke, 1.0), (bench.closing, 0.0, -1.0)):
        if not isnan(measures.contact):
            at = np.searchsorted(times, measures.contact)
            times = np.insert(times, at, [measures.contact] * 2)
            lift = np.insert(lift, at, [met] * 2)
            # The speed jumps: before contact it is the seating speed, after it what the stop leaves of it.
            after = speed[at] if at < len(speed) else 0.0
            speed = np.insert(speed, at, [sign * measures.seating_speed, after])

    def at(t):
        i = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
        h = times[i + 1] - times[i]
        s = np.clip((t - times[i]) / np.where(h > 0.0, h, 1.0), 0.0, 1.0)
        rise = lift[i + 1] - lift[i]
        cubic = (speed[i] * (1.0 - s) - speed[i + 1] * s) * h - rise * (1.0 - 2.0 * s)
        return lift[i] + s * (rise + (1.0 - s) * cubic)

    return at


class Problem:
    """Measured runs against their simulation, as a function of the scaled free parameters.

    Parameters
    ----------
    machine : engine.machine.Machine
    runs : sequence of studies.measured.MeasuredRun
    free : sequence of Free
    report : callable, optional
        Told of the number of simulations after each.
    """

    def __init__(self, machine, runs, free, report=None):
        self.machine, self.runs, self.free, self.report = machine, runs, free, report
        self.evaluations = 0
        self.scale = np.array([f.scale for f in free])
        self.bounds = np.array([[f.low, f.high] for f in free]).T / self.scale
        self.blocks = [(run, sensor) for run in runs for sensor in FITTED if sensor in run.channels]
        self.sensors = [sensor for _, sensor in self.blocks]
        self._last = None, None

    def machine_at(self, x, run=None):
        """The machine with the parameters, and with the supply of a run, if one is given."""
        machine = self.machine if run is None else run_of(self.machine, run)
        for free, value in zip(self.free, np.asarray(x) * self.scale, strict=True):
            machine = with_value(machine, free.key, float(np.clip(value, free.low, free.high)))
        return machine

    def residuals(self, x):
        """Simulation less measurement, an array for each of `blocks` [SI]; large where a simulation ends early."""
        if self._last[0] is not None and np.array_equal(self._last[0], x):
            return self._last[1]
        found = []
        for run in self.runs:
            sensors = [sensor for sensor in FITTED if sensor in run.channels]
            values, _ = predict(self.machine_at(x, run), run, sensors)
            self.evaluations += 1
            if self.report:
                self.report(self.evaluations, None)
            for sensor in sensors:
                measured = run.channels[sensor]
                error = values[sensor] - measured
                found.append(np.where(np.isnan(error), 10.0 * np.abs(measured).max(), error))
        self._last = np.array(x), found
        return found

    def forget(self):
        """Simulate anew, even where the last simulation was."""
        self._last = None, None

    def objective(self, x):
        """Eq. 11 over all fitted samples of lift [m]; NaN without any."""
        lift = [r for r, sensor in zip(self.residuals(x), self.sensors, strict=True) if sensor == "lift"]
        errors = np.concatenate([[], *lift])
        return float(np.sqrt(np.sum(errors**2)) / (len(errors) - 1)) if len(errors) else nan

    def whitened(self, x, noise):
        """All residuals in standard deviations, the colour of their noise taken off; shape (n,)."""
        blocks = zip(self.residuals(x), self.blocks, strict=True)
        return np.concatenate([whiten(r, run.times, *noise[sensor]) for r, (run, sensor) in blocks])

    def jacobian(self, x, noise, only=None):
        """Sensitivities of `whitened` by forward differences, shape (n, p) or (n, len(only))."""
        base = self.whitened(x, noise)
        kept = self._last
        columns = []
        for j in range(len(x)) if only is None else only:
            step = min(STEP, 0.25 * (self.bounds[1, j] - self.bounds[0, j]))
            step = step if x[j] + step <= self.bounds[1, j] else -step
            moved = np.array(x)
            moved[j] += step
            columns.append((self.whitened(moved, noise) - base) / step)
        self._last = kept
        return np.column_stack(columns)


def whiten(residuals, times, deviation, colour):
    """AR(1) noise made white, of standard deviation 1.

    Parameters
    ----------
    residuals, times : (n,) float array
    deviation : float
        Of the noise.
    colour : float
        Correlation of neighbours a median interval apart; where intervals differ, it falls exponentially.

    Returns
    -------
    (n,) float array
    """
    steps = np.diff(times)
    usual = np.median(steps)
    even = np.ptp(steps) < 0.01 * usual
    r = np.full(len(steps), colour) if even else max(colour, 0.0) ** (steps / usual)
    rest = (residuals[1:] - r * residuals[:-1]) / np.sqrt(1.0 - r**2)
    return np.append(residuals[0], rest) / deviation


def noise_model(problem, x, stated):
    """Standard deviation and colour of each sensor's noise, and warnings.

    Parameters
    ----------
    problem : Problem
    x : (p,) float array
        The optimum.
    stated : dict
        Standard deviations that the user states [SI], by sensor.

    Returns
    -------
    dict
    warnings : list of str
    """
    noise, warnings = {}, []
    for sensor in dict.fromkeys(problem.sensors):
        pairs = [(run, r) for r, (run, of) in zip(problem.residuals(x), problem.blocks, strict=True) if of == sensor]
        deviation, colour = _deviation_and_colour([r for _, r in pairs])
        pure, pure_colour = _deviation_and_colour(_repeat_differences(pairs) or [r for _, r in pairs])
        known = max(stated.get(sensor, pure), FITTED[sensor])
        # Colour makes a standard deviation less certain: by this share.
        chance = np.sqrt((1.0 + colour**2) / (1.0 - colour**2) / (2.0 * sum(len(r) for _, r in pairs)))
        if deviation > (1.1 + 3.0 * chance) * known:
            warnings.append(
                f"{sensor}: the best fit is off by {deviation / known:.2f} times the noise; "
                "the intervals are widened accordingly, but the model may lack something"
            )
            known, pure_colour = deviation, colour
        noise[sensor] = known, pure_colour
    return noise, warnings


def _deviation_and_colour(errors):
    """Of AR(1) noise in several stretches."""
    power = sum(float(e @ e) for e in errors)
    lagged = sum(float(e[1:] @ e[:-1]) for e in errors)
    return np.sqrt(power / sum(map(len, errors))), min(max(lagged / power, -0.99), 0.999) if power else 0.0


def _repeat_differences(pairs):
    """Noise of runs that share a name, a pulse, a supply and times: what they differ by from their mean."""
    groups = {}
    for run, r in pairs:
        groups.setdefault((run.name, run.pulse, run.supply, run.times.tobytes()), []).append(r)
    found = []
    for repeats in groups.values():
        if len(repeats) > 1:
            found += list((np.array(repeats) - np.mean(repeats, axis=0)) * np.sqrt(len(repeats) / (len(repeats) - 1)))
    return found


def _rough_noise(problem, stated):
    """White noise, from the second differences where it is not stated."""
    noise = {}
    for sensor in dict.fromkeys(problem.sensors):
        bends = np.concatenate([np.diff(run.channels[sensor], 2) for run, of in problem.blocks if of == sensor])
        noise[sensor] = max(stated.get(sensor, np.sqrt(np.mean(bends**2) / 6.0)), FITTED[sensor]), 0.0
    return noise


def _is_white(problem, x, noise):
    """Whether the whitened residuals have no correlation left over 20 lags (Ljung and Box), at 0.1 %."""
    from scipy.stats import chi2

    for r, (run, sensor) in zip(problem.residuals(x), problem.blocks, strict=True):
        e = whiten(r, run.times, *noise[sensor])
        n, lags = len(e), np.arange(1, min(20, len(e) // 4) + 1)
        correlation = np.array([e[lag:] @ e[:-lag] for lag in lags]) / (e @ e)
        if n * (n + 2) * np.sum(correlation**2 / (n - lags)) > chi2.isf(1e-3, len(lags)):
            return False
    return True


def _minimise(problem, x, noise, tolerance, held=None):
    """Bounded least squares from a start; the parameter `held` stays where it is. Returns x, cost and success."""
    from scipy.optimize import least_squares

    x = np.array(x)
    moving = [j for j in range(len(x)) if j != held]
    if not moving:
        return x, float(np.sum(problem.whitened(x, noise) ** 2)), True

    def whole(part):
        full = x.copy()
        full[moving] = part
        return full

    low, high = problem.bounds[:, moving]
    margin = 1e-9 * (high - low)
    found = least_squares(
        lambda part: problem.whitened(whole(part), noise),
        np.clip(x[moving], low + margin, high - margin),
        lambda part: problem.jacobian(whole(part), noise, moving),
        bounds=(low, high),
        x_scale="jac",
        xtol=tolerance,
        ftol=tolerance,
        gtol=1e-10,
        max_nfev=30,
    )
    return whole(found.x), 2.0 * found.cost, bool(found.success)


def _starts(free):
    """Where the fits start: the machine's values, and points spread by a Halton sequence; shape (STARTS, p)."""
    from scipy.stats import qmc

    spread = qmc.Halton(len(free), scramble=False).random(STARTS + 1)[2:]
    starts = [[f.start / f.scale for f in free]]
    for point in spread:
        starts.append([])
        for f, u in zip(free, point, strict=True):
            value = f.start * 4.0 ** (u - 0.5) if f.local else f.low + u * (f.high - f.low)
            starts[-1].append(min(max(value, f.low), f.high) / f.scale)
    return np.array(starts)


def _along(best, slopes, j, away):
    """The optimum with parameter j moved, and the others as the slopes say: as powers of it where all is positive."""
    target = best[j] + away
    guess = best + slopes * away
    if best[j] > 0.0 and target > 0.0:
        powers = best > 0.0
        exponents = slopes[powers] * best[j] / best[powers]
        guess[powers] = best[powers] * np.exp(np.clip(exponents * np.log(target / best[j]), -20.0, 20.0))
    guess[j] = target
    return guess


def _profile_end(problem, best, cost, noise, j, side, curvature):
    """End of a parameter's profile-likelihood interval.

    Parameters
    ----------
    problem : Problem
    best : (p,) float array
        The optimum.
    cost : float
        Sum of squares there.
    noise : dict
    j : int
    side : {-1, 1}
    curvature : (p, p) float array
        Of half the sum of squares.

    Returns
    -------
    end : float
    at_bound : bool
    better : (p,) float array or None
        A point of a smaller sum of squares, if one was met.
    """
    limit = problem.bounds[(side + 1) // 2, j] - best[j]
    covariance = np.linalg.inv(curvature)
    away, inner, outer = side * DEVIATIONS * np.sqrt(covariance[j, j]), 0.0, inf
    for _ in range(20):
        if abs(away) >= abs(limit):
            away = limit
        guess = np.clip(_along(best, covariance[:, j] / covariance[j, j], j, away), *problem.bounds)
        point, other, _ = _minimise(problem, guess, noise, 1e-5, held=j)
        if other < cost - 0.05:
            return nan, False, point
        deviations = np.sqrt(max(other - cost, 0.0))
        if abs(deviations - DEVIATIONS) < 0.01:
            break
        if deviations < DEVIATIONS:
            if away == limit:
                return best[j] + limit, True, None
            inner = abs(away)
        else:
            outer = abs(away)
        # The root of the likelihood's loss is all but linear, unless a simulation changes its character on the way.
        size = abs(away) * min(DEVIATIONS / max(deviations, 1e-3), 10.0)
        away = side * (size if inner < size < outer else 0.5 * (inner + min(outer, abs(limit))))
        if outer - inner < 1e-6 * outer:
            break
    return best[j] + away, False, None


def _intervals(problem, best, cost, noise, curvature):
    """Both ends of every parameter's interval; or a better point, if one is met. See `_profile_end`."""
    intervals = []
    for j in range(len(best)):
        ends = [_profile_end(problem, best, cost, noise, j, side, curvature) for side in (-1, 1)]
        for _, _, better in ends:
            if better is not None:
                return intervals, better
        intervals.append(ends)
    return intervals, None


def identify(machine, measured, free, method="least-squares", report=None):
    """Parameters of a machine from measured data; only runs with the role "fit" are looked at.

    Parameters
    ----------
    machine : engine.machine.Machine
    measured : studies.measured.Measured
    free : sequence of Free
        See `studies.commands.fit.free_parameters`.
    method : {"least-squares", "ga"}
    report : callable, optional
        ``report(done, total)``, told of the number of simulations.

    Returns
    -------
    Identified
    """
    problem = Problem(machine, measured.of(FIT), free, report)
    _refuse(problem, measured, method)
    if method == "ga":
        x = genetic(problem)
        noise, warnings = noise_model(problem, x, measured.noise)
        return _identified(
            problem, x, None, None, noise, [*warnings, "the genetic algorithm states no uncertainty"], True
        )
    rough = _rough_noise(problem, measured.noise)
    fits = [_minimise(problem, x, rough, 1e-4) for x in _starts(free)]
    best, _, _ = _minimise(problem, min(fits, key=lambda fit: fit[1])[0], rough, 1e-6)
    noise, warnings = noise_model(problem, best, measured.noise)
    for _ in range(MOST_RESTARTS):
        best, cost, success = _minimise(problem, best, noise, 1e-8)
        jacobian = problem.jacobian(best, noise)
        curvature = jacobian.T @ jacobian
        curvature += np.diag(1e-10 * np.diag(curvature) + 1e-12)
        intervals, better = _intervals(problem, best, cost, noise, curvature)
        if better is None:
            break
        best = better
    success = success and better is None
    if not success:
        warnings.append("the fit has not converged; give narrower bounds or free fewer parameters")
    if not _is_white(problem, best, noise):
        warnings.append("what is left at the optimum is not AR(1) noise; the intervals may be too narrow")
    covariance = np.linalg.inv(curvature)
    deviations = np.sqrt(np.diag(covariance))
    return _identified(
        problem, best, intervals, covariance / np.outer(deviations, deviations), noise, warnings, success
    )


def _refuse(problem, measured, method):
    """Raises `InputError` where there is nothing to fit, or no one value of a free parameter."""
    culprits = []
    if not problem.blocks or (method == "ga" and "lift" not in problem.sensors):
        wrong = "no run of the role fit has " + ("lift" if method == "ga" else "lift or chamber pressures")
        culprits.append(Culprit(measured.folder, "run", wrong, 'measure "lift [mm]", and write role = "fit"'))
    for key, field in (("supply.pressure", "supply"), ("supply.temperature", "temperature")):
        given = {value for run in problem.runs if not isnan(value := getattr(run, field))}
        if key in [f.key for f in problem.free] and len(given) > 1:
            culprits.append(
                Culprit(measured.folder, key, "differs between the runs", "fit runs of one value, or hold it")
            )
    if culprits:
        raise InputError(culprits)


def _identified(problem, x, intervals, correlation, noise, warnings, converged):
    """The outcome, with warnings of what the data cannot tell."""
    keys = [f.key for f in problem.free]
    for j, key in enumerate(keys if intervals else ()):
        if any(at_bound for _, at_bound, _ in intervals[j]):
            warnings.append(f"{key}: its 95 % interval runs into a bound; these data do not hold it")
        for i in range(j):
            if abs(correlation[i, j]) > ALIKE:
                warnings.append(f"{keys[i]} and {key} cannot be told apart: correlation {correlation[i, j]:+.4f}")
    return Identified(
        dict(zip(keys, (x * problem.scale).tolist(), strict=True)),
        {
            key: tuple(float(end * problem.scale[j]) for end, _, _ in intervals[j]) if intervals else None
            for j, key in enumerate(keys)
        },
        correlation,
        problem.objective(x),
        {sensor: tuple(map(float, pair)) for sensor, pair in noise.items()},
        problem.evaluations,
        warnings,
        problem.machine_at(x),
        converged,
    )


def genetic(problem, generations=GENERATIONS, seed=0):
    """The parameters of least Eq. 11, by a genetic algorithm of floating-point strings; shape (p,), scaled."""
    try:
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.core.problem import ElementwiseProblem
        from pymoo.optimize import minimize
    except ImportError:
        right = "pip install 'apesim[ga]', or leave --method out"
        raise InputError([Culprit("command line", "--method", "the genetic algorithm needs pymoo", right)]) from None

    class Evaluation(ElementwiseProblem):
        def _evaluate(self, x, out, *args, **kwargs):
            problem.forget()  # strings may be equal; each is simulated, as in the paper
            out["F"] = problem.objective(x)

    low, high = problem.bounds
    strings = GA(pop_size=POPULATION, eliminate_duplicates=False)
    found = minimize(Evaluation(n_var=len(low), n_obj=1, xl=low, xu=high), strings, ("n_gen", generations), seed=seed)
    return np.atleast_1d(found.X)
