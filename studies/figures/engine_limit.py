"""Figure of the highest speeds at which the valve meets its targets."""

import matplotlib.pyplot as plt
import numpy as np

from studies.engine_limit import PAPER_RPM
from studies.figures.style import draw


def engine_limit_figures(archive, ambient_pressure, folder):
    """The figure of a map of limits.

    Parameters
    ----------
    archive : Archive
        See `studies.engine_limit.map_engine_limit`.
    ambient_pressure : float
        Gauge pressures stand above it [Pa abs].
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    return draw({"engine_limit": lambda: engine_limits(archive, ambient_pressure)}, folder)


def engine_limits(archive, ambient_pressure):
    """Limit over pressure, for each duration and temperature, against the paper's.

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
    pressure = (v["supply_pressure"] - ambient_pressure) / 1e6
    temperatures, durations = np.unique(v["supply_temperature"]), np.unique(v["duration_deg"])
    figure, axis = plt.subplots(figsize=(8.2, 4.4), layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(durations)))
    styles = ["-", "--", ":", "-."]
    for duration, colour in zip(durations, colours, strict=True):
        for number, temperature in enumerate(temperatures):
            chosen = (v["duration_deg"] == duration) & (v["supply_temperature"] == temperature)
            label = f"{duration:g}°, {temperature:g} K"
            style = styles[number % len(styles)]
            axis.plot(pressure[chosen], v["limit_rpm"][chosen], color=colour, ls=style, marker="o", ms=3, label=label)
    for (name, speed), style in zip(PAPER_RPM.items(), ("-", "--"), strict=True):
        axis.axhline(speed, color="0.3", lw=0.9, ls=style, label=f"the paper's {speed:g} r/min\n({name})")
    axis.set(xlabel="supply pressure [MPa gauge]", ylabel="highest speed [r/min]")
    axis.set_title("Targets met within 0.5°, strokes complete, every cycle the same")
    axis.set_ylim(bottom=0.0)
    figure.legend(fontsize=8.5, loc="outside right upper", title="opening to closing, air")
    return figure
