"""What measured data must have before anything is concluded from them."""

from collections.abc import Iterator

import numpy as np

from apesim.march.adaptive import TOLERANCE
from apesim.quantities import Fault, InputError
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.measured import CHECK, FIT, GATE, Measured
from apesim.studies.measured.sensors import FILE

MAX_SOLVER_ERROR = 0.05
"""Largest error of the simulator itself over the noise of a sample: more of it may be taken for a gap."""


def check_roles(measured: Measured) -> None:
    """Refuse a folder by whose roles nothing can be concluded.

    Raises InputError where no run is to be fitted, or a sensor is in runs to check alone.
    """
    file = f"{measured.folder}/{FILE}"
    if not measured.of(FIT):
        raise InputError([Fault(file, "run.role", "no run is to be fitted", f'give at least one run role = "{FIT}"')])
    faults = [*_find_unknown_noise(measured)]
    if faults:
        raise InputError(faults)


def _find_unknown_noise(measured: Measured) -> Iterator[Fault]:
    """Faults of sensors whose noise no run shows."""
    known = {sensor for run in measured.of(FIT) + measured.of(GATE) for sensor in (*run.channels, *run.means)}
    for run in measured.of(CHECK):
        for sensor in {**run.channels, **run.means}:
            if sensor not in known:
                wrong = "is in runs to check alone: its noise is unknown"
                right = "measure it in another run, too, or leave it out"
                yield Fault(f"{measured.folder}/{run.data or FILE}", sensor, wrong, right)


def find_solver_error(residuals: WhitenedResiduals, x: np.ndarray) -> float:
    """The simulator's own error, by a tenfold sharper march: the root mean square over all samples.

    It is over the noise of a sample; `x` (p,) are the scaled parameters.
    """
    usual, sharp = (residuals.predicted(x, tolerance) for tolerance in (TOLERANCE, 0.1 * TOLERANCE))
    change = residuals.whiten([a - b for a, b in zip(usual, sharp, strict=True)])
    return float(np.sqrt(np.mean(change**2)))
