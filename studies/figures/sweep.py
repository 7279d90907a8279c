"""Figures of a sweep."""

import matplotlib.pyplot as plt
import numpy as np

from engine.cylinder import INTAKES
from studies.figures.style import draw

COLOURS = {"epv": "#c1440e", "cam": "#2a6f97", "ideal": "#3a3a3a"}
NAMES = {"epv": "electro-pneumatic valve", "cam": "cam", "ideal": "ideal valve"}


def sweep_figures(archive, folder):
    """All figures of a sweep.

    Parameters
    ----------
    archive : Archive
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    figures = {"torque_and_air": torque_and_air, "indicator_diagrams": indicator_diagrams, "cycle_traces": cycle_traces}
    return draw({name: lambda make=make: make(archive) for name, make in figures.items()}, folder)


def intakes_of(archive):
    """Names of the intakes in an archive, in the library's order."""
    present = set(archive.variables["intake"].values.tolist())
    return [name for code, name in enumerate(INTAKES) if code in present]


def runs_of(archive, intake):
    """Indices of the runs with an intake, by rising speed."""
    v = archive.variables
    found = np.flatnonzero(v["intake"].values == INTAKES.index(intake))
    return found[np.argsort(v["speed_rpm"].values[found], kind="stable")]


def run_near(archive, intake, speed_rpm):
    """Index of the run with an intake whose speed is nearest [r/min]."""
    runs = runs_of(archive, intake)
    return runs[np.argmin(np.abs(archive.variables["speed_rpm"].values[runs] - speed_rpm))]


def torque_and_air(archive):
    """Torque and specific air consumption over speed.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = archive.variables
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.2, 3.7), layout="constrained")
    for name in intakes_of(archive):
        runs = runs_of(archive, name)
        speed = v["speed_rpm"].values[runs]
        colour = COLOURS[name]
        left.plot(speed, v["brake_torque_Nm"].values[runs], color=colour, marker="o", ms=3, label=NAMES[name])
        left.plot(speed, v["indicated_torque_Nm"].values[runs], color=colour, lw=1, ls="--")
        right.plot(speed, v["specific_air_kg_per_kWh"].values[runs], color=colour, marker="o", ms=3)
        right.plot(speed, v["indicated_specific_air_kg_per_kWh"].values[runs], color=colour, lw=1, ls="--")
    left.axhline(0.0, color="0.6", lw=0.8)
    left.plot([], [], color="0.4", label="brake")
    left.plot([], [], color="0.4", lw=1, ls="--", label="indicated")
    left.set(xlabel="speed [r/min]", ylabel="torque [N m]", title="Torque")
    left.legend(fontsize=8.5)
    right.set(xlabel="speed [r/min]", ylabel="specific air [kg/kWh]", title="All air, control air counted, over work")
    right.set_ylim(0.0, 150.0)
    return figure


def indicator_diagrams(archive, speeds_rpm=(400.0, 1000.0, 1600.0)):
    """Cylinder pressure over volume at some speeds, all intakes.

    Parameters
    ----------
    archive : Archive
    speeds_rpm : sequence of float
        The nearest runs are shown.

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = archive.variables
    figure, axes = plt.subplots(1, len(speeds_rpm), figsize=(9.2, 3.4), layout="constrained", sharey=True)
    for axis, speed_rpm in zip(axes, speeds_rpm, strict=True):
        for name in intakes_of(archive):
            run = run_near(archive, name, speed_rpm)
            volume = v["cylinder_volume"].values[run] * 1e6
            pressure = v["cylinder_pressure"].values[run] / 1e6
            axis.plot(volume, pressure, color=COLOURS[name], label=NAMES[name], lw=1.3)
        axis.set(xlabel="cylinder volume [cm³]", title=f"{v['speed_rpm'].values[run]:g} r/min")
        axis.set_ylim(bottom=0.0)
    axes[0].set_ylabel("cylinder pressure [MPa abs]")
    axes[-1].legend(fontsize=8.5)
    return figure


def cycle_traces(archive, speed_rpm=1000.0):
    """Lift, chamber pressures and cylinder pressure over crank angle, all intakes.

    Parameters
    ----------
    archive : Archive
    speed_rpm : float
        The nearest run is shown.

    Returns
    -------
    matplotlib.figure.Figure
    """
    v = archive.variables
    angle = v["crank_angle"].values
    figure, axes = plt.subplots(3, 1, figsize=(7.4, 7.0), layout="constrained", sharex=True)
    lift, chambers, cylinder = axes
    for name in intakes_of(archive):
        run = run_near(archive, name, speed_rpm)
        lift.plot(angle, v["lift"].values[run] * 1e3, color=COLOURS[name], label=NAMES[name])
        cylinder.plot(angle, v["cylinder_pressure"].values[run] / 1e6, color=COLOURS[name])
        if name == "epv":
            for letter, style in (("a", "-"), ("b", "--")):
                pressure = v[f"pressure_{letter}"].values[run] / 1e6
                pushes = {"a": "pushes to closed", "b": "pushes to open"}[letter]
                chambers.plot(
                    angle, pressure, color=COLOURS[name], ls=style, label=f"chamber {letter.upper()}, {pushes}"
                )
        shown = v["speed_rpm"].values[run]
    lift.set(ylabel="intake lift [mm]", title=f"One cycle at {shown:g} r/min")
    lift.legend(fontsize=8.5)
    chambers.set(ylabel="chamber pressure [MPa abs]")
    if chambers.lines:
        chambers.legend(fontsize=8.5)
    cylinder.set(ylabel="cylinder pressure [MPa abs]", xlabel="crank angle after TDC [deg]")
    cylinder.set_xlim(angle[0], angle[-1])
    cylinder.set_xticks(np.arange(0, angle[-1] + 1, 45))
    for axis in axes:
        axis.set_ylim(bottom=0.0)
    return figure
