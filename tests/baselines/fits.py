"""Calibrate, then fit each effect alone by one parameter; the caller judges them by rms, or as Akaike does."""

import numpy as np
from scipy.optimize import least_squares

from apesim.studies.estimation.parameters import put
from apesim.studies.estimation.priors import nuisances_of
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.measured import FIT
from apesim.studies.measured.prediction import predict, run_of, start_of

STARTS = (0.1, 0.5)
"""Starts of a strength, over the upper end of its range; a fit begins with the better."""
PRECISE = 1e-6
"""Share of the sum of squares that another step has to take."""
FAILED = 1e3
"""Error of a sample that could not be simulated [standard deviations]."""
WHITE = 0.6745 * np.sqrt(6.0)
"""Median size of second differences of white noise, over its deviation."""


class Fits:
    """The runs to fit of measured data, and the machine's errors on them."""

    def __init__(self, machine, measured):
        self.machine, self.runs = machine, measured.of(FIT)
        self.parameters = nuisances_of(machine, measured)
        self.noise = measured.noise | {
            name: np.median([second(run.channels[name]) for run in self.runs])
            for name in self.runs[0].channels
            if name not in measured.noise
        }
        self.starts = [start_of(run_of(machine, run), run) for run in self.runs]

    def errors(self, parameters, x):
        """Measured less simulated over the noise, and the priors."""
        parts = []
        for run, start in zip(self.runs, self.starts, strict=True):
            found = predict(put(run_of(self.machine, run), parameters, x), run, start=start)
            seen, given = found.channels | found.means, run.channels | run.means
            parts += [np.atleast_1d(given[name] - seen[name]) / self.deviation(run, name) for name in given]
        errors = np.nan_to_num(np.concatenate(parts), nan=FAILED)
        return np.append(errors, [z for z, one in zip(x, parameters, strict=True) if one.prior])

    def deviation(self, run, name):
        """Standard deviation of a channel; where a mean has none stated, a percent of it."""
        return self.noise.get(name) or 0.01 * abs(run.means[name])

    def calibrated(self):
        """The nuisances [prior deviations] that suit best."""
        low, high = ([one[i] for one in self.parameters] for i in (2, 3))
        return least_squares(
            lambda x: self.errors(self.parameters, x),
            np.zeros(len(low)),
            bounds=(low, high),
            diff_step=1e-3,
            max_nfev=6,
        ).x


def second(trace):
    """Deviation of a trace's noise, were it white, from its second differences."""
    return np.median(np.abs(np.diff(trace, 2))) / WHITE


def one_parameter_fits(machine, measured, effects):
    """Fit each effect's first strength, the nuisances staying where calibration took them.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
    effects : sequence of apesim.effect.Effect

    Returns
    -------
    float
        Sum of squares of the calibrated machine.
    list of tuple
        Sum of squares, name, parameter and x with its standard deviation, the best first.
    """
    fits = Fits(machine, measured)
    calibrated = fits.calibrated()
    base = fits.errors(fits.parameters, calibrated)
    rows = []
    for candidate in find_candidates(machine, measured.bench, effects):
        parameter = candidate.strengths[0]
        both = [*fits.parameters, parameter]

        def errors(x, both=both):
            return fits.errors(both, [*calibrated, x[0]])

        largest = parameter.high or parameter.low
        first = min((share * largest for share in STARTS), key=lambda x, of=errors: float(np.sum(of([x]) ** 2)))
        found = least_squares(
            errors, [first], bounds=(parameter.low, parameter.high), diff_step=1e-3, ftol=PRECISE, max_nfev=8
        )
        slope = float(found.jac[:, 0] @ found.jac[:, 0])
        rows.append((2.0 * found.cost, candidate.name, parameter, found.x[0], slope**-0.5 if slope else np.inf))
    return float(base @ base), sorted(rows, key=lambda row: row[0])
