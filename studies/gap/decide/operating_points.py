"""Operating points of measured runs."""

from math import isclose, isnan

import numpy as np

from apesim.studies.measured import ENGINE

NEAR, WARMER = 0.01, 2.0
"""Share of supply pressure, pulse and speed, and difference of temperature [K], within which two runs are at one
operating point: gauges err by as much."""


def points_of(runs):
    """The operating points of runs, each by its first run."""
    found: list = []
    for run in runs:
        if not any(is_at(run, point) for point in found):
            found.append(run)
    return found


def is_at(run, point):
    """Whether a run is at the operating point of another, as far as gauges tell them apart."""
    warmer = 0.0 if isnan(run.temperature) or isnan(point.temperature) else run.temperature - point.temperature
    return abs(warmer) <= WARMER and all(
        isclose(one, other, rel_tol=NEAR) or (isnan(one) and isnan(other))
        for one, other in (
            (run.supply, point.supply),
            (run.pulse, point.pulse),
            (run.speed, point.speed),
        )
    )


def label_of(run, ambient_pressure):
    """An operating point in a few words."""
    supply = f"{(run.supply - ambient_pressure) * 1e-6:.2f} MPa gauge"
    if run.bench == ENGINE:
        return f"{run.speed * 30.0 / np.pi:.0f} r/min, {supply}"
    return f"{supply}, {run.pulse * 1e3:.3g} ms"
