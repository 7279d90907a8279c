"""Figures of corrected commands over speed, pressure and temperature."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.studies.figures.conditions import SUPPLY, conditions_of
from apesim.studies.figures.style import draw


def timing_figures(timing_map, ambient_pressure, folder):
    """All figures of a map of corrected commands.

    Parameters
    ----------
    timing_map : apesim.studies.timing.grid.TimingMap
    ambient_pressure : float
        Gauge pressures stand above it [Pa abs].
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    figures = {"advance": advances, "won_back": won_back, "shortcut": shortcut}
    if timing_map.laws["advance"]:
        figures["temperature_law"] = temperature_law
    make_all = {name: lambda make=make: make(timing_map, ambient_pressure) for name, make in figures.items()}
    return draw(make_all, folder, conditions_of(timing_map.archive.machine, SUPPLY))


def _columns(timing_map):
    """Results on the axes (speed, pressure, temperature)."""
    return {
        name: variable.values.reshape(timing_map.axes.shape)
        for name, variable in timing_map.archive.variables.items()
        if name != "run"
    }


def _pressures(axes, ambient_pressure):
    """For each pressure its number, colour and label."""
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(axes.pressures)))
    labels = [f"{(pressure - ambient_pressure) / 1e6:.3g} MPa gauge" for pressure in axes.pressures]
    return list(zip(range(len(labels)), colours, labels, strict=True))


def _middle(axes):
    """Number of the temperature in the middle, and its text."""
    number = len(axes.temperatures) // 2
    return number, f"{axes.temperatures[number]:g} K"


def advances(timing_map, ambient_pressure):
    """Advance of energising and release over speed; thin, what the delays of the bench would give.

    Parameters
    ----------
    timing_map : apesim.studies.timing.grid.TimingMap
    ambient_pressure : float
        [Pa abs]

    Returns
    -------
    matplotlib.figure.Figure
    """
    axes, v = timing_map.axes, _columns(timing_map)
    k, temperature = _middle(axes)
    figure, both = plt.subplots(1, 2, figsize=(9.2, 3.9), layout="constrained", sharey=True)
    speed = v["speed_rpm"][:, 0, k]
    command = timing_map.command
    sides = ("advance", "energise", command.open_target), ("release_advance", "release", command.close_target)
    for axis, (advance, name, target) in zip(both, sides, strict=True):
        for j, colour, label in _pressures(axes, ambient_pressure):
            by_bench = target / DEGREE - v[f"shortcut_{name}_deg"][:, j, k]
            axis.plot(speed, v[f"{advance}_deg"][:, j, k], color=colour, marker="o", ms=3, label=label)
            axis.plot(speed, by_bench, color=colour, lw=0.9, ls="--")
        axis.set(xlabel="speed [r/min]", title=f"{name}, {temperature}")
    both[0].plot([], [], color="0.4", lw=0.9, ls="--", label="by the delay on the bench")
    both[0].set_ylabel("target less command angle [deg]")
    both[0].set_ylim(bottom=0.0)
    both[0].legend(fontsize=8.5)
    return figure


def won_back(timing_map, ambient_pressure):
    """Brake torque and specific air over speed, corrected and with the machine's own commands.

    Parameters
    ----------
    timing_map : apesim.studies.timing.grid.TimingMap
    ambient_pressure : float
        [Pa abs]

    Returns
    -------
    matplotlib.figure.Figure
    """
    axes, v = timing_map.axes, _columns(timing_map)
    k, temperature = _middle(axes)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.2, 3.9), layout="constrained")
    speed = v["speed_rpm"][:, 0, k]
    for axis, column in ((left, "brake_torque_Nm"), (right, "specific_air_kg_per_kWh")):
        for j, colour, label in _pressures(axes, ambient_pressure):
            axis.plot(speed, v[column][:, j, k], color=colour, marker="o", ms=3, label=label)
            axis.plot(speed, v[f"uncorrected_{column}"][:, j, k], color=colour, lw=1, ls="--")
        axis.set_xlabel("speed [r/min]")
    left.axhline(0.0, color="0.6", lw=0.8)
    left.plot([], [], color="0.4", lw=1, ls="--", label="uncorrected")
    left.set(ylabel="brake torque [N m]", title=f"Torque, {temperature}")
    left.legend(fontsize=8.5)
    right.set(ylabel="specific air [kg/kWh]", title="All air, control air counted, over brake work")
    right.set_ylim(0.0, 150.0)
    return figure


def shortcut(timing_map, ambient_pressure):
    """Error of opening and closing over speed if commands stand the delay of the bench before their targets.

    Parameters
    ----------
    timing_map : apesim.studies.timing.grid.TimingMap
    ambient_pressure : float
        [Pa abs]

    Returns
    -------
    matplotlib.figure.Figure
    """
    axes, v = timing_map.axes, _columns(timing_map)
    k, temperature = _middle(axes)
    figure, both = plt.subplots(1, 2, figsize=(9.2, 3.9), layout="constrained")
    speed = v["speed_rpm"][:, 0, k]
    for axis, name in zip(both, ("open", "close"), strict=True):
        for j, colour, label in _pressures(axes, ambient_pressure):
            axis.plot(speed, v[f"shortcut_{name}_error_deg"][:, j, k], color=colour, marker="o", ms=3, label=label)
        axis.axhline(0.0, color="0.6", lw=0.8)
        axis.set_xlim(speed[0] - 50.0, speed[-1] + 50.0)
        axis.set(xlabel="speed [r/min]", title=f"{name.removesuffix('e')}ing, {temperature}")
    both[0].set_ylabel("true less target angle [deg]")
    both[1].legend(fontsize=8.5, title="a line ends where the shortcut\ndoes not open the valve", title_fontsize=8)
    return figure


def temperature_law(timing_map, ambient_pressure):
    """Advance as a time over the temperature, and the straight lines through it, at the speed in the middle.

    Parameters
    ----------
    timing_map : apesim.studies.timing.grid.TimingMap
    ambient_pressure : float
        [Pa abs]

    Returns
    -------
    matplotlib.figure.Figure
    """
    axes, v = timing_map.axes, _columns(timing_map)
    i = len(axes.speeds) // 2
    figure, both = plt.subplots(1, 2, figsize=(9.2, 3.9), layout="constrained")
    ends = axes.temperatures[[0, -1]]
    for axis, name, title in zip(both, ("advance", "release_advance"), ("energise", "release"), strict=True):
        for j, colour, label in _pressures(axes, ambient_pressure):
            times = v[f"{name}_deg"][i, j] * DEGREE / axes.speeds[i] * 1e3
            axis.plot(axes.temperatures, times, color=colour, marker="o", ms=4, lw=0, label=label)
            for law in timing_map.laws[name]:
                if law.speed == axes.speeds[i] and law.pressure == axes.pressures[j]:
                    axis.plot(ends, 1e3 * (law.at_reference + law.slope * (ends - 287.0)), color=colour, lw=1)
        axis.set(
            xlabel="temperature of the control air [K]", title=f"{title}, {axes.speeds[i] / TURN * 60.0:.5g} r/min"
        )
    both[0].set_ylabel("advance as a time [ms]")
    both[0].legend(fontsize=8.5)
    return figure
