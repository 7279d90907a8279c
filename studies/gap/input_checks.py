"""What measured data must have before anything is concluded from them."""

from collections.abc import Iterator

import numpy as np

from apesim.march.adaptive import TOLERANCE
from apesim.quantities import Fault, InputError
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.measured import CHECK, FIT, GATE, Measured
from apesim.studies.measured.sensors import FILE

MAX_SATURATED = 0.05
"""Share of samples at the very largest or smallest value, above which a sensor may be at its end: noise alone puts one
sample there."""
MAX_SOLVER_ERROR = 0.05
"""Largest error of the simulator itself over the noise of a sample: more of it may be taken for a gap."""


def check_input(measured: Measured) -> list[str]:
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

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import read_example
    >>> check_input(read_example())
    []
    """
    file = f"{measured.folder}/{FILE}"
    if not measured.of(FIT):
        raise InputError([Fault(file, "run.role", "no run is to be fitted", f'give at least one run role = "{FIT}"')])
    faults = [*_find_constant_sensors(measured), *_find_unknown_noise(measured)]
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
            if sensor != "lift" and len(values) > 40 and _is_saturated(values):
                warnings.append(
                    f"{run.data}: {sensor} stays at its largest or smallest value: is the sensor at its end?"
                )
    return warnings


def _find_constant_sensors(measured: Measured) -> Iterator[Fault]:
    """Faults of sensors that show nothing, not even noise."""
    for run in measured.runs:
        for sensor, values in run.channels.items():
            if np.ptp(values) == 0.0:
                file = f"{measured.folder}/{run.data}"
                yield Fault(file, sensor, "never changes", "is the sensor connected? else leave the column out")


def _find_unknown_noise(measured: Measured) -> Iterator[Fault]:
    """Faults of sensors whose noise no run shows."""
    known = {sensor for run in measured.of(FIT) + measured.of(GATE) for sensor in (*run.channels, *run.means)}
    for run in measured.of(CHECK):
        for sensor in {**run.channels, **run.means}:
            if sensor not in known:
                wrong = "is in runs to check alone: its noise is unknown"
                right = "measure it in another run, too, or leave it out"
                yield Fault(f"{measured.folder}/{run.data or FILE}", sensor, wrong, right)


def _is_saturated(values: np.ndarray) -> bool:
    """Whether a sensor is often at its very largest or smallest value."""
    ends = values.min(), values.max()
    return bool(ends[0] < ends[1] and any(np.mean(values == end) > MAX_SATURATED for end in ends))


def find_solver_error(residuals: WhitenedResiduals, x: np.ndarray) -> float:
    """The simulator's own error, by a tenfold sharper march: the root mean square over all samples.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    x : (p,) float array
        Scaled parameters.

    Returns
    -------
    float
        Over the noise of a sample.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> calibrated = explain_example().calibrated
    >>> find_solver_error(calibrated.residuals, calibrated.fitted.x) < MAX_SOLVER_ERROR
    True
    """
    usual, sharp = (residuals.predicted(x, tolerance) for tolerance in (TOLERANCE, 0.1 * TOLERANCE))
    change = residuals.whiten([a - b for a, b in zip(usual, sharp, strict=True)])
    return float(np.sqrt(np.mean(change**2)))
