"""The paper's correction for the temperature of the control air: a time that is linear in it."""

from typing import NamedTuple

import numpy as np

REFERENCE = 287.0
"""The paper's T_0 (Table 1) [K]."""


class Law(NamedTuple):
    """time = at_reference + slope (T_0 - 287 K), by least squares."""

    pressure: float
    """[Pa abs]"""
    speed: float
    """[rad/s]; NaN: one law for all speeds."""
    at_reference: float
    """[s]"""
    slope: float
    """[s/K]"""
    max_error: float
    """[s]"""
    error_rms: float
    """[s]"""
    max_angle_error: float
    """Largest error at the speeds of the points [rad]."""
    angle_error_rms: float
    points: int

    @property
    def opposite_to_the_paper(self):
        """Whether the time falls with the temperature; the paper's delay rises."""
        return self.slope < 0.0


def fitted(pressure, speed, temperatures, times, speeds):
    """A law from points; None from fewer than two temperatures.

    Parameters
    ----------
    pressure, speed : float
        As in `Law`.
    temperatures, times, speeds : (n,) float array
        [K], [s], [rad/s]; a time that is NaN is left out.

    Returns
    -------
    Law or None
    """
    known = ~np.isnan(times)
    temperatures, times, speeds = temperatures[known], times[known], speeds[known]
    if len(np.unique(temperatures)) < 2:
        return None
    slope, at_reference = np.polyfit(temperatures - REFERENCE, times, 1)
    errors = at_reference + slope * (temperatures - REFERENCE) - times
    angles = errors * speeds
    sizes = [size for e in (errors, angles) for size in (np.abs(e).max(), np.sqrt((e**2).mean()))]
    return Law(pressure, speed, float(at_reference), float(slope), *(float(size) for size in sizes), len(times))


def laws_of(axes, angles):
    """A law for every pressure and speed, and one for every pressure over all speeds.

    Parameters
    ----------
    axes : apesim.studies.timing.table.Axes
    angles : (i, j, k) float array
        Advance [rad]; NaN out of reach.

    Returns
    -------
    list of Law
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
