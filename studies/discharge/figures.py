"""Figures of discharge tests: pressures with their fit, effective areas with their bands, and how they collapse."""

from collections.abc import Callable
from functools import partial
from math import inf
from os import PathLike
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from apesim.studies.discharge import Discharge, Vessel, figure_arrays
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import add_legend, label_axes, open_column
from apesim.studies.drawing.style import RED, STYLES, Look, colours_of

SIZE = (6.4, 4.6)
"""Size of the figures, with a panel for the residuals below [inch]."""
TIME = ("time after the switch", "ms")
"""Name and unit of the x axis of all panels."""
LONG = 20.0
"""Time that is reported over that at which the valve is open, above which the later part is drawn logarithmically."""
TOGETHER: Look = {"color": "0.1", "lw": 1.8, "ls": (0, (1, 2.5))}
"""Look of the line of all tests together: dots that are further apart than those of any test."""


def discharge_figures(vessel: Vessel, discharge: Discharge, folder: str | PathLike[str]) -> list[Path]:
    """Write all figures of discharge tests as PNG and PDF into a folder, made if it does not exist.

    `vessel` is what was emptied.
    """
    figures = {"pressure": partial(plot_pressures, discharge), "effective_area": partial(plot_areas, discharge)}
    return write_figures(figures, folder, conditions_of_vessel(vessel))


def conditions_of_vessel(vessel: Vessel) -> str:
    """Conditions of discharge tests, in one line: what emptied, and into what."""
    volume, ambient = vessel.volume * 1e6, vessel.ambient_pressure / 1e3
    kind = "isothermal vessel" if vessel.wall == inf else "vessel"
    return f"{kind} of {volume:.4g} cm³, {vessel.temperature:g} K at the switch, into {ambient:.4g} kPa abs"


def plot_pressures(discharge: Discharge) -> Figure:
    """Plot the pressure over time, measured and fitted, with the residuals below (Fig. 3 of the paper)."""
    tests = figure_arrays(discharge)["tests"]
    figure, panels = open_column(2, SIZE, height_ratios=(3, 1))
    above, below = panels
    for number, (test, colour) in enumerate(zip(tests, colours_of(len(tests)), strict=True)):
        style = STYLES[number % len(STYLES)]
        time, residuals = test["time"] * 1e3, test["pressure"] - test["fitted"]
        above.plot(time, test["pressure"] / 1e6, ".", color=colour, ms=2.5, alpha=0.5)
        above.plot(time, test["fitted"] / 1e6, color=colour, lw=1.3, ls=style, label=test["name"])
        below.plot(time, residuals / 1e3, ".", color=colour, ms=2.0, alpha=0.5)
    for axis in panels:
        axis.axvline(0.0, color="0.6", lw=0.8, ls="--")
    label_axes(above, y=("pressure", "MPa abs"), title="points: the tests; lines: Eq. 10 with the area found")
    above.set_ylim(bottom=0.0)
    add_legend(above)
    label_axes(below, x=TIME, y=("residual", "kPa"))
    return figure


def plot_areas(discharge: Discharge, true_area: Callable[[np.ndarray], np.ndarray] | None = None) -> Figure:
    """Plot the effective area over time from each test, and how far each is from all together (Fig. 4 of the paper).

    Bands are those of 95 %. `true_area` gives the effective area [m2] at times [s], both (n,), where it is known.

    >>> from apesim.studies.discharge.area import AreaFit
    >>> from apesim.studies.discharge.records import Record
    >>> knots, area = np.linspace(0.0, 2e-3, 3), 1e-6 * np.array([0.0, 9.0, 9.0])
    >>> record = Record("p060", knots, np.array([7e5, 6e5, 5e5]))
    >>> fit = AreaFit(knots, area, np.full(3, 2e-7), np.eye(3), np.array([500.0]), [record.pressures], 1.0)
    >>> result = Discharge([record], [500.0], [fit], [2e-3], fit, 2e-3, 9e-6, 2e-7, np.empty((0, 5)), None, [])
    >>> above, below = plot_areas(result).axes
    >>> above.lines[0].get_ydata().round(3)
    array([0., 9., 9.])
    """
    arrays = figure_arrays(discharge)
    pooled, tests = arrays["pooled"], arrays["tests"]

    # What the axis of the areas has to hold: the curves, whose bands may be cut off.
    highest = [arrays["full_area"] * 1.25, *(1.05 * test["area"].max() for test in (*tests, pooled))]
    in_percent = 100.0 / arrays["full_area"]
    figure, (above, below) = open_column(2, SIZE, height_ratios=(3, 2))
    for number, (test, colour) in enumerate(zip(tests, colours_of(len(tests)), strict=True)):
        style = STYLES[number % len(STYLES)]
        time, all_together = test["knots"] * 1e3, np.interp(test["knots"], pooled["knots"], pooled["area"])
        for axis, scale, zero in ((above, 1e6, 0.0), (below, in_percent, all_together)):
            low, area, high = (scale * (test[name] - zero) for name in ("low", "area", "high"))
            axis.fill_between(time, low, high, color=colour, alpha=0.18, lw=0.0)
            axis.plot(time, area, color=colour, lw=1.2, ls=style, label=test["name"])

    # A single test is all tests together, so that a line of these would lie on its own.
    if len(tests) > 1:
        above.plot(pooled["knots"] * 1e3, pooled["area"] * 1e6, label="all together", **TOGETHER)

    # The area that emptied the vessel, where it is known; the error ends with what all tests together report.
    if true_area is not None:
        fine = np.linspace(0.0, max(test["knots"][-1] for test in tests), 2000)
        above.plot(fine * 1e3, true_area(fine) * 1e6, color=RED, lw=1.0, label="the model's")
        highest.append(1.05 * true_area(fine).max())
        error = 100.0 * (true_area(fine) - np.interp(fine, pooled["knots"], pooled["area"])) / arrays["full_area"]
        within = fine <= pooled["knots"][-1]
        below.plot(fine[within] * 1e3, error[within], color=RED, lw=1.0)

    # What both panels say; the title warns of an area from which no curve follows.
    title = "bands: 95 %; no level that an open valve has" if discharge.refusal else "bands: 95 %"
    label_axes(above, y=("effective area", "mm²"), title=title)
    above.set_ylim(0.0, max(highest) * 1e6)
    above.set_xlim(left=0.0)
    add_legend(above, ncols=2)
    below.axhline(0.0, **TOGETHER)
    label_axes(below, x=TIME)
    is_open, end = discharge.curve[-1, 0] if len(discharge.curve) else np.inf, pooled["knots"][-1]
    if end > LONG * is_open:  # else the rise would be a line at the edge
        for axis in (above, below):
            axis.set_xscale("symlog", linthresh=2e3 * is_open)
            axis.axvline(2e3 * is_open, color="0.8", lw=0.8)
            axis.set_xlim(0.0, 1e3 * end)
        label_axes(below, x=("time after the switch, logarithmic from the grey line on", "ms"))
    below.set_ylabel(f"{'from all together' if len(tests) > 1 else 'band'}\n[% of full area]")

    # The lower panel is scaled by the bands but for their widest twentieth, which would flatten all the rest.
    half = 100.0 * max(np.quantile(test["high"] - test["area"], 0.95) for test in tests) / arrays["full_area"]
    below.set_ylim(-1.5 * half, 1.5 * half)
    return figure
