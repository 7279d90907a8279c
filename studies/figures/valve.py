"""Figures of the valve alone: maps over pressure and temperature, velocity traces, working limits."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from apesim.studies.figures.conditions import SUPPLY, conditions_of
from apesim.studies.figures.lines import draw_own_point, over_pressure
from apesim.studies.figures.style import draw
from apesim.studies.limit.design_rule import PAPER_RPM
from apesim.studies.limit.points import Point, own_run

MAPS = {
    "delay_time": ("delay_s", 1e3, "delay time [ms]"),
    "stroke_time": ("stroke_time_s", 1e3, "full stroke time [ms]"),
    "seating_speed": ("seating_speed_m_s", 1.0, "seating speed [m/s]"),
    "fluctuation": ("fluctuation", 1.0, "fluctuation of the speed [-]"),
}


def map_figures(archive, ambient_pressure, folder):
    """All figures of a valve map.

    Parameters
    ----------
    archive : Archive
        See `apesim.studies.valve_map.compute_map`.
    ambient_pressure : float
        Gauge pressures stand above it [Pa abs].
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    figures = {
        name: lambda column=column, factor=factor, label=label: contours(
            archive, ambient_pressure, column, factor, label
        )
        for name, (column, factor, label) in MAPS.items()
    }
    figures["velocity"] = lambda: velocities(archive, ambient_pressure)
    return draw(figures, folder, conditions_of(archive.machine, SUPPLY, _pulse(archive)))


def _pulse(archive):
    """What the bench was driven with, in words."""
    return f"{1e3 * float(archive.provenance['pulse_s']):g} ms pulse"


def grid_of(archive, ambient_pressure):
    """Axes of a map: gauge pressures [MPa] and temperatures [K]."""
    v = archive.variables
    pressures = np.unique(v["supply_pressure"].values)
    return (pressures - ambient_pressure) / 1e6, np.unique(v["supply_temperature"].values)


def contours(archive, ambient_pressure, column, factor, label):
    """A measure over pressure and temperature, for opening and closing.

    Parameters
    ----------
    archive : Archive
    ambient_pressure : float
        [Pa abs]
    column : str
        Name of the measure without its stroke.
    factor : float
        From SI to the unit of the label.
    label : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    pressures, temperatures = grid_of(archive, ambient_pressure)
    shape = (len(pressures), len(temperatures))
    values = {
        stroke: archive.variables[f"{stroke}_{column}"].values.reshape(shape).T * factor
        for stroke in ("opening", "closing")
    }
    figure, axes = plt.subplots(1, 2, figsize=(9.2, 3.7), layout="constrained", sharey=True)
    if min(shape) < 2:
        return _lines(figure, axes, values, pressures, temperatures, label)
    low, high = (function([function(v) for v in values.values()]) for function in (np.nanmin, np.nanmax))
    levels = MaxNLocator(11).tick_values(low, high)
    for axis, (stroke, field) in zip(axes, values.items(), strict=True):
        filled = axis.contourf(pressures, temperatures, field, levels, cmap="viridis")
        lines = axis.contour(pressures, temperatures, field, levels, colors="white", linewidths=0.6)
        _label(axis, lines)
        axis.set(xlabel="control pressure [MPa gauge]", title=stroke)
        axis.grid(False)
    axes[0].set_ylabel("control air temperature [K]")
    figure.colorbar(filled, ax=axes, label=label, format="%.3g")
    return figure


def _label(axis, lines):
    """Levels on their lines, but for those that the frame would cut off or that would stand on one another."""
    style, to_axes, kept = {"fmt": "%.3g", "fontsize": 7.5}, axis.transData + axis.transAxes.inverted(), {}
    for text in axis.clabel(lines, inline=False, **style):
        x, y = to_axes.transform(text.get_position())
        apart = all(abs(x - u) > 0.04 or abs(y - v) > 0.1 for u, v in kept.values())
        if apart and 0.04 < x < 0.96 and 0.04 < y < 0.96:
            kept[text.get_text()] = x, y
        text.remove()
    for level in lines.levels:
        if style["fmt"] % level in kept:
            # Yellow and light green, the upper end of the colour map, would swallow white.
            on_light = level - lines.levels[0] > 0.6 * np.ptp(lines.levels)
            axis.clabel(lines, [level], colors="black" if on_light else "white", **style)


def _lines(figure, axes, values, pressures, temperatures, label):
    """What `contours` shows, for a grid with one pressure or one temperature only."""
    along_pressure = len(pressures) >= len(temperatures)
    x, name = (pressures, "control pressure [MPa gauge]") if along_pressure else (temperatures, "temperature [K]")
    for axis, (stroke, field) in zip(axes, values.items(), strict=True):
        axis.plot(x, field.ravel(), marker="o", ms=3)
        axis.set(xlabel=name, title=stroke)
    axes[0].set_ylabel(label)
    return figure


def velocities(archive, ambient_pressure, max_traces=5):
    """Velocity of the opening and closing piston at several pressures, at the temperature in the middle (Fig. 9).

    Parameters
    ----------
    archive : Archive
    ambient_pressure : float
        [Pa abs]
    max_traces : int
        Traces at most.

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = archive.variables
    pressures, temperatures = grid_of(archive, ambient_pressure)
    middle = len(temperatures) // 2
    shown = np.unique(np.linspace(0, len(pressures) - 1, max_traces).round().astype(int))
    time = v["time"].values * 1e3
    release = float(archive.provenance["pulse_s"]) * 1e3
    figure, axes = plt.subplots(1, 2, figsize=(9.2, 3.7), layout="constrained", sharey=True)
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(shown)))
    last = 0.0
    for colour, number in zip(colours, shown, strict=True):
        run = number * len(temperatures) + middle
        velocity = v["velocity"].values[run]
        moving = np.flatnonzero((np.abs(velocity) > 0.0) & (time < release))
        last = max(last, time[moving[-1]] if len(moving) else 0.0)
        for axis, stroke, start, sign in zip(axes, ("opening", "closing"), (0.0, release), (1.0, -1.0), strict=True):
            contact = sum(v[f"{stroke}_{name}"].values[run] for name in ("delay_s", "stroke_time_s")) * 1e3
            # The speed ends at contact, between two rows of the trace.
            at = np.searchsorted(time - start, contact)
            times = np.insert(time - start, at, [contact] * 2)
            speeds = np.insert(sign * velocity, at, [v[f"{stroke}_seating_speed_m_s"].values[run], 0.0])
            axis.plot(times, speeds, color=colour, lw=1.3, label=f"{pressures[number]:.3g}")
    for axis, name in zip(axes, ("opening", "closing"), strict=True):
        axis.set(xlabel="time after the command [ms]", title=f"{name}, {temperatures[middle]:g} K")
        axis.set_xlim(0.0, last + 2.0)
        axis.set_ylim(bottom=0.0)
    axes[0].set_ylabel("speed of the piston [m/s]")
    axes[1].legend(title="control pressure\n[MPa gauge]", fontsize=8.5)
    return figure


def limit_figures(archive, ambient_pressure, folder):
    """The figure of a map of working limits.

    Parameters
    ----------
    archive : Archive
        See `apesim.studies.limit.valve_limit.limit_map`.
    ambient_pressure : float
        [Pa abs]
    folder : path

    Returns
    -------
    list of Path
    """
    return draw(
        {"working_limit": lambda: limits(archive, ambient_pressure)}, folder, conditions_of(archive.machine, SUPPLY)
    )


def limits(archive, ambient_pressure):
    """Working limit over pressure, for each temperature and duty, against the paper's 30 Hz and 2000 r/min.

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
    figure, axis = plt.subplots(figsize=(7.8, 4.2), layout="constrained")
    of_grid = {name: values[v["point"] != Point.OWN] for name, values in v.items()}
    over_pressure(axis, of_grid, "limit_hz", "duty", "duty {:g}", ambient_pressure, 0.9)
    own = own_run(v)
    draw_own_point(axis, v, "limit_hz", ambient_pressure, f", duty {v['duty'][own]:.3g}")
    for speed, style in zip(PAPER_RPM.values(), ("-", "--"), strict=True):
        axis.axhline(speed / 60.0, color="0.3", lw=0.9, ls=style, label=f"{speed / 60.0:.3g} Hz = {speed:g} r/min")
    axis.set(xlabel="control pressure [MPa gauge]", ylabel="highest working rate [Hz]")
    title = "Every stroke complete"
    if not np.isnan(v["rule_window_deg"][own]):
        time, needed = 1e3 * v["rule_lap_to_lap_s"][own], v["rule_window_deg"][own]
        title += f"; at its own point above the lap\nfor {time:.2f} ms, so that 30 Hz need a window of {needed:.0f}°"
    axis.set_title(title)
    axis.set_ylim(bottom=0.0)
    side = axis.secondary_yaxis("right", functions=(lambda hz: 60.0 * hz, lambda rpm: rpm / 60.0))
    side.set_ylabel("engine speed, one event a revolution [r/min]")
    figure.legend(fontsize=8.5, loc="outside right upper")
    return figure
