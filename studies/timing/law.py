"""Correction for the temperature of the control air: a time that is linear in it.

The form is that of the EPV paper (doi 10.1631/jzus.A0820373), which corrects its delay so.
"""

from typing import NamedTuple

import numpy as np

from apesim.studies.timing.table import Axes

REFERENCE = 287.0
"""Temperature T_0 of the EPV paper (its Table 1), at which a law is not corrected [K]."""


class Law(NamedTuple):
    """Time as a law of the temperature T_0: time = at_reference + slope (T_0 - 287 K), by least squares."""

    pressure: float
    """Pressure of the supply [Pa abs]."""
    speed: float
    """Speed of the crankshaft [rad/s]; NaN: one law for all speeds."""
    at_reference: float
    """Time at 287 K [s]."""
    slope: float
    """Change of the time with the temperature [s/K]."""
    max_error: float
    """Largest error of the law at its points [s]."""
    error_rms: float
    """Root mean square error of the law at its points [s]."""
    max_angle_error: float
    """Largest error of the law at its points, at their speeds [rad]."""
    angle_error_rms: float
    """Root mean square error of the law at its points, at their speeds [rad]."""
    points: int
    """Number of points that the law was fitted to."""

    @property
    def opposite_to_the_paper(self) -> bool:
        """Whether the time falls with the temperature; the delay of the EPV paper rises."""
        return self.slope < 0.0


def fitted(
    pressure: float, speed: float, temperatures: np.ndarray, times: np.ndarray, speeds: np.ndarray
) -> Law | None:
    """Fit a law of the supply temperature [K] to times [s], by least squares; all arrays are (n,).

    The delay is almost a line over the temperature [EPV, Fig. 8]. `pressure` [Pa abs] and `speed` [rad/s] (NaN where
    the points have several) are noted in the law; `speeds` [rad/s] turn its errors to angles. Points whose time is NaN
    are left out; None where fewer than two temperatures are left.
    """
    known = ~np.isnan(times)
    temperatures, times, speeds = temperatures[known], times[known], speeds[known]
    if len(np.unique(temperatures)) < 2:
        return None
    slope, at_reference = np.polyfit(temperatures - REFERENCE, times, 1)
    errors = at_reference + slope * (temperatures - REFERENCE) - times
    angles = errors * speeds
    sizes = [size for e in (errors, angles) for size in (np.abs(e).max(), np.sqrt((e**2).mean()))]
    largest, rms, largest_angle, rms_angle = (float(size) for size in sizes)
    return Law(pressure, speed, float(at_reference), float(slope), largest, rms, largest_angle, rms_angle, len(times))


def laws_of(axes: Axes, angles: np.ndarray) -> list[Law]:
    """Fit a law of the temperature for every pressure and speed, and one for every pressure over all speeds.

    `angles` [rad] are the advance of a command, (speeds, pressures, temperatures), NaN out of reach; the speed turns
    them into times. Laws come pressure by pressure, the one over all speeds last, without those that have fewer than
    two temperatures.

    >>> axes = Axes(np.array([100.0]), np.array([1.1e6]), np.array([250.0, 287.0, 324.0]))
    >>> laws = laws_of(axes, np.array([[[0.300, 0.337, 0.374]]]))
    >>> [(round(1e3 * law.at_reference, 6), round(1e6 * law.slope, 6)) for law in laws]  # [ms], [us/K]
    [(3.37, 10.0)]
    """
    laws = []
    speeds, temperatures = np.meshgrid(axes.speeds, axes.temperatures, indexing="ij")
    for j, pressure in enumerate(axes.pressures):
        times = angles[:, j] / speeds
        rows = [(speed, temperatures[i], times[i], speeds[i]) for i, speed in enumerate(axes.speeds)]
        if len(rows) > 1:
            rows.append((np.nan, temperatures.ravel(), times.ravel(), speeds.ravel()))
        laws += [fitted(pressure, *row) for row in rows]
    return [law for law in laws if law]
