"""Figure of the highest speeds at which the valve meets its targets."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.engine.angles import DEGREE
from apesim.studies.figures.conditions import SUPPLY, conditions_of
from apesim.studies.figures.lines import draw_own_point, over_pressure
from apesim.studies.figures.style import draw
from apesim.studies.limit.design_rule import PAPER_RPM, RPM, DesignRule
from apesim.studies.limit.points import Point, own_run

SOLID_AND_DASHED = ("-", "--")


def engine_limit_figures(archive, ambient_pressure, folder):
    """The figure of a map of limits.

    Parameters
    ----------
    archive : Archive
        See `apesim.studies.limit.engine_limit.map_engine_limit`.
    ambient_pressure : float
        Gauge pressures stand above it [Pa abs].
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    return draw(
        {"engine_limit": lambda: engine_limits(archive, ambient_pressure)},
        folder,
        conditions_of(archive.machine, SUPPLY),
    )


def engine_limits(archive, ambient_pressure):
    """Limit over pressure, for each duration and temperature, and over the window with the design rule.

    Parameters
    ----------
    archive : Archive
    ambient_pressure : float
        [Pa abs]

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = {name: variable.values for name, variable in archive.variables.items()}
    figure, (left, right) = plt.subplots(1, 2, figsize=(12.4, 4.6), layout="constrained", sharey=True)
    of_grid = {name: values[v["point"] != Point.OWN] for name, values in v.items()}
    over_pressure(left, of_grid, "limit_rpm", "duration_deg", "{:g}°", ambient_pressure, 0.85)
    draw_own_point(left, v, "limit_rpm", ambient_pressure)
    for axis in (left, right):
        for (name, speed), style in zip(PAPER_RPM.items(), SOLID_AND_DASHED, strict=True):
            label = f"the paper's {speed:g} r/min\n({name})" if axis is left else None
            axis.axhline(speed, color="0.3", lw=0.9, ls=style, label=label)
    left.set(xlabel="supply pressure [MPa gauge]", ylabel="highest speed [r/min]")
    left.set_title("Targets met within 0.5°, strokes complete, every cycle the same")
    left.set_ylim(bottom=0.0)
    draw_rule(right, v)
    figure.legend(fontsize=8.5, loc="outside right upper", title="opening to closing, air")
    return figure


def draw_rule(axis, v):
    """Draw limits over the window, and the design rule of each supply, where there is one."""
    axis.set(xlabel="window: target opening to target closing [deg]")
    axis.plot(v["duration_deg"], v["limit_rpm"], "o", ms=3, color="0.55")
    own = own_run(v)
    axis.plot(v["duration_deg"][own], v["limit_rpm"][own], "*", color="#c1440e", ms=11)
    times = np.unique(v["rule_lap_to_lap_s"][~np.isnan(v["rule_lap_to_lap_s"])])
    if not len(times):
        return
    needed = v["rule_window_deg"][own]
    longest = np.nanmax([*v["duration_deg"], needed])
    windows = np.linspace(0.0, 1.08 * longest, 2)
    for time in times:
        axis.plot(windows, DesignRule(time).limit(windows * DEGREE) / RPM, color="0.8", lw=0.8, zorder=1)
    title = "Design rule: limit = (window + 1°)/(6 t)"
    time = v["rule_lap_to_lap_s"][own]
    if not np.isnan(time):
        axis.plot(windows, DesignRule(time).limit(windows * DEGREE) / RPM, color="#c1440e", lw=1.2)
        paper = PAPER_RPM["30 Hz, one event a revolution"]
        axis.plot([needed, needed], [0.0, paper], color="#c1440e", lw=0.9, ls=":")
        axis.annotate(
            f"30 Hz need {needed:.0f}°",
            (needed, 0.12 * paper),
            (-4, 0),
            textcoords="offset points",
            ha="right",
            color="#c1440e",
        )
        title += f", t = {1e3 * time:.2f} ms (red, its own air)"
    axis.set_title(f"{title}\nand {1e3 * times[0]:.2f} to {1e3 * times[-1]:.2f} ms (grey, all air)")
    axis.set_xlim(0.0, windows[-1])
