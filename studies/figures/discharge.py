"""Figures of discharge tests: pressures with their fit, effective areas with their bands, and how they collapse."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.studies.discharge import figure_arrays
from apesim.studies.figures.conditions import conditions_of_vessel
from apesim.studies.figures.style import draw


def discharge_figures(vessel, found, folder):
    """All figures of discharge tests.

    Parameters
    ----------
    vessel : apesim.studies.discharge.Vessel
    found : apesim.studies.discharge.Discharge
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    figures = {"pressure": lambda: pressures(found), "effective_area": lambda: areas(found)}
    return draw(figures, folder, conditions_of_vessel(vessel))


def _colours(count):
    return plt.get_cmap("viridis")(np.linspace(0.0, 0.8, count))


def pressures(found):
    """Pressure over time, of the tests and fitted, and what the fit leaves (Fig. 3 of doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    found : apesim.studies.discharge.Discharge

    Returns
    -------
    matplotlib.figure.Figure
    """
    tests = figure_arrays(found)["tests"]
    size = {"figsize": (6.4, 4.6), "layout": "constrained", "sharex": True, "height_ratios": (3, 1)}
    figure, (above, below) = plt.subplots(2, 1, **size)
    for test, colour in zip(tests, _colours(len(tests)), strict=True):
        time, left = test["time"] * 1e3, test["pressure"] - test["fitted"]
        above.plot(time, test["pressure"] / 1e6, ".", color=colour, ms=2.5, alpha=0.5)
        above.plot(time, test["fitted"] / 1e6, color=colour, lw=1.3, label=test["name"])
        below.plot(time, left / 1e3, ".", color=colour, ms=2.0, alpha=0.5)
    for axis in (above, below):
        axis.axvline(0.0, color="0.6", lw=0.8, ls="--")
    above.set(ylabel="pressure [MPa abs]", title="points: the tests; lines: Eq. 10 with the area found")
    above.set_ylim(bottom=0.0)
    above.legend(fontsize=8.5)
    below.set(ylabel="residual [kPa]", xlabel="time after the switch [ms]")
    return figure


def areas(found, true=None):
    """Effective area over time from each test, with its 95 % band, and how far each is from all together (Fig. 4).

    Parameters
    ----------
    found : apesim.studies.discharge.Discharge
    true : function, optional
        The area [m2] at times [s], where it is known.

    Returns
    -------
    matplotlib.figure.Figure
    """
    arrays = figure_arrays(found)
    pooled, tests = arrays["pooled"], arrays["tests"]
    size = {"figsize": (6.4, 4.6), "layout": "constrained", "sharex": True, "height_ratios": (3, 2)}
    figure, (above, below) = plt.subplots(2, 1, **size)
    for test, colour in zip(tests, _colours(len(tests)), strict=True):
        time, all_together = test["knots"] * 1e3, np.interp(test["knots"], pooled["knots"], pooled["area"])
        for axis, scale, zero in ((above, 1e6, 0.0), (below, 100.0 / arrays["full_area"], all_together)):
            low, area, high = (scale * (test[name] - zero) for name in ("low", "area", "high"))
            axis.fill_between(time, low, high, color=colour, alpha=0.18, lw=0.0)
            axis.plot(time, area, color=colour, lw=1.2, label=test["name"])
    if len(tests) > 1:
        above.plot(pooled["knots"] * 1e3, pooled["area"] * 1e6, color="0.1", lw=1.0, ls="--", label="all together")
    if true is not None:
        fine = np.linspace(0.0, max(test["knots"][-1] for test in tests), 2000)
        above.plot(fine * 1e3, true(fine) * 1e6, color="#c1440e", lw=1.0, label="the model's")
        error = 100.0 * (true(fine) - np.interp(fine, pooled["knots"], pooled["area"])) / arrays["full_area"]
        within = fine <= pooled["knots"][-1]
        below.plot(fine[within] * 1e3, error[within], color="#c1440e", lw=1.0)
    highest = arrays["full_area"] * 1e6
    above.set(ylabel="effective area [mm²]", title="bands: 95 %")
    above.set_ylim(0.0, 1.25 * highest)
    above.set_xlim(left=0.0)
    above.legend(fontsize=8.5, loc="lower right", ncols=2)
    below.axhline(0.0, color="0.1", lw=1.0, ls="--")
    shown = "from all together" if len(tests) > 1 else "band"
    below.set(ylabel=f"{shown}\n[% of full area]", xlabel="time after the switch [ms]")
    half = 100.0 * max(np.quantile(test["high"] - test["area"], 0.95) for test in tests) / arrays["full_area"]
    below.set_ylim(-1.5 * half, 1.5 * half)
    return figure
