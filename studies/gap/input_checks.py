"""What measured data must have before anything is concluded from them."""

import numpy as np

from apesim.march.adaptive import TOLERANCE
from apesim.quantities import Fault, InputError
from apesim.studies.measured import CHECK, FIT, GATE
from apesim.studies.measured.sensors import FILE

SATURATED = 0.05
"""Share of samples at the very largest or smallest value, from which a sensor may be at its end."""
MAX_SOLVER_ERROR = 0.05
"""Standard deviations per sample, up to which the simulator's own error is let pass."""


def check_input(measured):
    """Refuse data that nothing can be concluded from, and warn of what looks wrong.

    Parameters
    ----------
    measured : apesim.studies.measured.Measured

    Returns
    -------
    list of str
        Warnings.

    Raises
    ------
    InputError
        No run is to be fitted, a sensor never changes, or is in runs to check alone.
    """
    file = f"{measured.folder}/{FILE}"
    if not measured.of(FIT):
        raise InputError([Fault(file, "run.role", "no run is to be fitted", f'give at least one run role = "{FIT}"')])
    faults = [*_dead(measured), *_unknown(measured)]
    if faults:
        raise InputError(faults)
    warnings = []
    for run in measured.runs:
        steps = np.diff(run.times)
        if len(steps) and np.ptp(steps) > 0.02 * np.median(steps):
            warnings.append(
                f"{run.data}: the samples are not evenly spaced; the colour of noise is taken as if they were"
            )
        for sensor, values in run.channels.items():
            if sensor != "lift" and len(values) > 40 and _saturated(values):
                warnings.append(
                    f"{run.data}: {sensor} stays at its largest or smallest value: is the sensor at its end?"
                )
    return warnings


def _dead(measured):
    """Faults of sensors that show nothing, not even noise."""
    for run in measured.runs:
        for sensor, values in run.channels.items():
            if np.ptp(values) == 0.0:
                file = f"{measured.folder}/{run.data}"
                yield Fault(file, sensor, "never changes", "is the sensor connected? else leave the column out")


def _unknown(measured):
    """Faults of sensors of which no run tells the noise."""
    known = {sensor for run in measured.of(FIT) + measured.of(GATE) for sensor in (*run.channels, *run.means)}
    for run in measured.of(CHECK):
        for sensor in {**run.channels, **run.means}:
            if sensor not in known:
                wrong = "is in runs to check alone: its noise is unknown"
                right = "measure it in another run, too, or leave it out"
                yield Fault(f"{measured.folder}/{run.data or FILE}", sensor, wrong, right)


def _saturated(values):
    ends = values.min(), values.max()
    return ends[0] < ends[1] and any(np.mean(values == end) > SATURATED for end in ends)


def find_solver_error(residuals, x):
    """The simulator's own error by a tenfold sharper march [standard deviations per sample], root mean square.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    x : (p,) float array
    """
    usual, sharp = (residuals.predicted(x, tolerance) for tolerance in (TOLERANCE, 0.1 * TOLERANCE))
    change = residuals.whiten([a - b for a, b in zip(usual, sharp, strict=True)])
    return float(np.sqrt(np.mean(change**2)))
