"""Figure of the highest speeds at which the valve meets its targets."""

import matplotlib.pyplot as plt

from studies.engine_limit import PAPER_RPM
from studies.figures.lines import over_pressure
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
    figure, axis = plt.subplots(figsize=(8.2, 4.4), layout="constrained")
    over_pressure(axis, v, "limit_rpm", "duration_deg", "{:g}°", ambient_pressure, 0.85)
    for (name, speed), style in zip(PAPER_RPM.items(), ("-", "--"), strict=True):
        axis.axhline(speed, color="0.3", lw=0.9, ls=style, label=f"the paper's {speed:g} r/min\n({name})")
    axis.set(xlabel="supply pressure [MPa gauge]", ylabel="highest speed [r/min]")
    axis.set_title("Targets met within 0.5°, strokes complete, every cycle the same")
    axis.set_ylim(bottom=0.0)
    figure.legend(fontsize=8.5, loc="outside right upper", title="opening to closing, air")
    return figure
