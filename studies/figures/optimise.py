"""Figures of the best commands over speed."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.studies.figures.conditions import conditions_of
from apesim.studies.figures.style import draw

LOOKS = {
    "uncorrected": ("0.55", "uncorrected"),
    "most_torque": ("#c0392b", "for most torque"),
    "least_air": ("#2166ac", "for least specific air"),
}


def optimise_figures(archive, ambient_pressure, folder):
    """All figures of the best commands.

    Parameters
    ----------
    archive : Archive
        See `apesim.studies.optimise.table.archive_of`.
    ambient_pressure : float
        Gauge pressures stand above it [Pa abs].
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    figures = {"optimum_angles": angles, "optimum_torque_and_air": torque_and_air}
    if "point" in archive.variables:
        figures["pareto_fronts"] = fronts
    makers = {name: lambda make=make: make(archive) for name, make in figures.items()}
    if any(name.endswith("_bound_supply_pressure") for name in archive.variables):
        makers["optimum_pressure"] = lambda: pressures(archive, ambient_pressure)
    free = ("supply.pressure",) if "optimum_pressure" in makers else ()
    return draw(makers, folder, conditions_of(archive.machine, free))


def _values(archive):
    return {name: variable.values for name, variable in archive.variables.items()}


def _kinds(v):
    """The machine's own commands, and those for each goal that was looked for."""
    return [kind for kind in LOOKS if f"{kind}_energise_deg" in v]


def angles(archive):
    """Commands over speed, and when the valve really opens and closes by them.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = _values(archive)
    kinds = _kinds(v)
    figure, axes = plt.subplots(1, len(kinds), figsize=(3.1 * len(kinds) + 1.2, 4.1), layout="constrained", sharey=True)
    shown = {
        "energise": ("energise_deg", "#2166ac", "--"),
        "opens": ("valve_open_deg", "#2166ac", "-"),
        "release": ("release_deg", "#c0392b", "--"),
        "closes": ("valve_close_deg", "#c0392b", "-"),
    }
    for axis, kind in zip(axes, kinds, strict=True):
        open_, close = v[f"{kind}_valve_open_deg"], v[f"{kind}_valve_close_deg"]
        axis.fill_between(v["speed_rpm"], open_, close, color="0.94", lw=0)
        for label, (name, colour, style) in shown.items():
            axis.plot(v["speed_rpm"], v[f"{kind}_{name}"], style, color=colour, marker="o", ms=3, label=label)
        axis.axhline(0.0, color="0.6", lw=0.8)
        axis.set(xlabel="speed [r/min]", title=LOOKS[kind][1])
    axes[0].set_ylabel("crank angle after TDC [deg]")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8.5, loc="outside right center")
    return figure


def torque_and_air(archive):
    """Brake torque and specific air over speed, at their best and with the machine's own commands.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = _values(archive)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.2, 3.9), layout="constrained")
    for kind in _kinds(v):
        colour, label = LOOKS[kind]
        for axis, column in ((left, "brake_torque_Nm"), (right, "specific_air_kg_per_kWh")):
            axis.plot(v["speed_rpm"], v[f"{kind}_{column}"], color=colour, marker="o", ms=3, label=label)
            axis.set_xlabel("speed [r/min]")
    left.axhline(0.0, color="0.6", lw=0.8)
    left.set(ylabel="brake torque [N m]", title="Torque")
    left.legend(fontsize=8.5)
    right.set(ylabel="specific air [kg/kWh]", title="All air, control air counted, over brake work")
    right.set_ylim(0.0, 150.0)
    return figure


def fronts(archive):
    """Pareto front of torque and specific air at each speed, beside the machine's own commands.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = _values(archive)
    figure, axis = plt.subplots(figsize=(7.6, 4.6), layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(v["speed_rpm"])))
    for run, (speed, colour) in enumerate(zip(v["speed_rpm"], colours, strict=True)):
        x, y = v["front_brake_torque_Nm"][run], v["front_specific_air_kg_per_kWh"][run]
        axis.plot(x, y, color=colour, marker="o", ms=2.5, label=f"{speed:g}")
        own = v["uncorrected_brake_torque_Nm"][run], v["uncorrected_specific_air_kg_per_kWh"][run]
        axis.plot(*own, color=colour, marker="x", ms=7, mew=1.6, lw=0, zorder=3)
    axis.plot([], [], color="0.3", marker="x", ms=7, mew=1.6, lw=0, label="uncorrected")
    axis.set(xlabel="brake torque [N m]", ylabel="specific air [kg/kWh]")
    axis.set_xlim(left=0.0)
    axis.set_ylim(top=min(axis.get_ylim()[1], 150.0))
    axis.set_title("Pareto fronts of torque and all air over brake work")
    figure.legend(fontsize=8.5, loc="outside right upper", title="speed [r/min]")
    return figure


def pressures(archive, ambient_pressure):
    """The best supply pressure over speed.

    Parameters
    ----------
    archive : Archive
    ambient_pressure : float
        [Pa abs]

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = _values(archive)
    figure, axis = plt.subplots(figsize=(6.6, 3.6), layout="constrained")
    for size, kind in zip((6, 9, 4), LOOKS, strict=True):  # goals often share the pressure: let both be seen
        if kind in _kinds(v):
            colour, label = LOOKS[kind]
            gauge = (v[f"{kind}_supply_pressure"] - ambient_pressure) / 1e6
            axis.plot(v["speed_rpm"], gauge, color=colour, marker="o", ms=size, lw=0.4 * size, label=label)
    axis.set(xlabel="speed [r/min]", ylabel="supply pressure [MPa gauge]")
    axis.set_ylim(0.0, 1.1 * axis.get_ylim()[1])
    figure.legend(fontsize=8.5, loc="outside right center")
    return figure
