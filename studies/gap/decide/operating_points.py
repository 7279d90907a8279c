"""Operating points of measured runs."""

from collections.abc import Iterable
from math import isclose, isnan

import numpy as np

from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.measured import CYLINDER, ENGINE, MeasuredRun

MAX_SHARE_APART, MAX_WARMER = 0.01, 2.0
"""Share of supply pressure, pulse and speed, and difference of temperature [K], within which two runs are at one
operating point: gauges err by as much."""


def find_points(runs: Iterable[MeasuredRun]) -> list[MeasuredRun]:
    """The operating points of measured runs, each stood for by the first run at it, in order; see `is_at`."""
    points: list[MeasuredRun] = []
    for run in runs:
        if not any(is_at(run, point) for point in points):
            points.append(run)
    return points


def list_point_rows(residuals: WhitenedResiduals) -> list[np.ndarray]:
    """List the places, among the whitened samples of all runs, of those of each operating point, see `find_points`."""
    points = find_points(residuals.runs)
    numbers = [next(k for k, point in enumerate(points) if is_at(each.run, point)) for each in residuals.blocks]
    at = np.repeat(numbers, [len(each.values) for each in residuals.blocks])
    return [np.flatnonzero(at == number) for number in range(len(points))]


def is_at(run: MeasuredRun, point: MeasuredRun) -> bool:
    """Whether a run is at the operating point of another, as far as gauges can distinguish them.

    Supply pressures, pulse and speed may differ by the share `MAX_SHARE_APART`, the temperature by `MAX_WARMER` [K]. A
    temperature that one of the two does not state is no difference.

    >>> import numpy as np
    >>> from apesim.studies.measured import MeasuredRun
    >>> run = MeasuredRun("a", "a.csv", 0.59e6, 293.0, 0.05, "fit", np.zeros(0), {})
    >>> is_at(run._replace(temperature=294.0), run), is_at(run._replace(supply=0.60e6), run)
    (True, False)
    """
    warmer = 0.0 if isnan(run.temperature) or isnan(point.temperature) else run.temperature - point.temperature
    return abs(warmer) <= MAX_WARMER and all(
        isclose(value, other, rel_tol=MAX_SHARE_APART) or (isnan(value) and isnan(other))
        for value, other in (
            (run.supply, point.supply),
            (run.control_supply, point.control_supply),
            (run.pulse, point.pulse),
            (run.speed, point.speed),
        )
    )


def label_point(run: MeasuredRun, ambient_pressure: float) -> str:
    """The operating point of a run in a few words: supply pressure, and pulse or speed.

    `ambient_pressure` [Pa abs] is taken off, so that the text gives the supply as a gauge pressure.
    """
    supply = f"{(run.supply - ambient_pressure) * 1e-6:.2f} MPa gauge"
    if run.bench == ENGINE:
        return f"{run.speed * 30.0 / np.pi:.0f} r/min, {supply}"
    if run.bench == CYLINDER:
        return f"{supply}, {1e3 * np.median(np.abs(run.given['velocity'])):.0f} mm/s"
    return f"{supply}, {run.pulse * 1e3:.3g} ms"
