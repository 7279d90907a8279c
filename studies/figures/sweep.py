"""Figures of a sweep: over speed, around the cycle, and over each key that was varied."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.archive.grid import axes_of, places_of
from apesim.studies.figures.conditions import conditions_of
from apesim.studies.figures.style import draw
from apesim.studies.sweep.plan import in_one_unit
from apesim.studies.sweep.results import has_incomplete_stroke

COLOURS = {"epv": "#c1440e", "epv corrected": "#1b9e77", "cam": "#2a6f97", "ideal": "#3a3a3a"}
NAMES = {"epv": "EPV, uncorrected", "epv corrected": "EPV, corrected", "cam": "cam", "ideal": "ideal valve"}
MARKERS = {"epv": "o", "epv corrected": "s", "cam": "^", "ideal": "D"}
HOLLOW = {"ls": "", "ms": 5, "mfc": "white"}
"""Points at which the valve does not open fully and close fully in every cycle."""
TRACE_START = -90.0
"""Crank angle at which a cycle is drawn from [deg]: before all intakes open, so that none is cut in two."""
OUTER = ("actuation", "speed_rpm")
"""Axes of every sweep; those between them are what was varied."""


def sweep_figures(archive, folder):
    """All figures of a sweep; where keys were varied, over each of them, the others at the middle of their values.

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
    make = {name: lambda make=make: make(archive) for name, make in figures.items()}
    for name in axes_of(archive):
        if name not in OUTER:
            make[f"over_{name}"] = lambda name=name: over_key(archive, name)
    varied = [name for name in axes_of(archive) if name not in OUTER]
    return draw(make, folder, conditions_of(archive.machine, varied))


def actuations_in(archive):
    """Names of what moves the intakes in an archive."""
    texts, places = axes_of(archive)["actuation"], places_of(archive)[0]
    return [name for number, name in enumerate(texts) if number in places]


def runs_of(archive, actuation, along="speed_rpm"):
    """Indices of the runs of an actuation along one axis; on the others they are in the middle.

    Parameters
    ----------
    archive : Archive
    actuation : str
    along : str
        Name of the axis.

    Returns
    -------
    (n,) int array
        By rising speed, or in the order of the values.
    """
    kept = np.ones(len(archive.runs), dtype=bool)
    for (name, texts), places in zip(axes_of(archive).items(), places_of(archive), strict=True):
        if name == "actuation":
            kept &= places == texts.index(actuation)
        elif name != along:
            kept &= places == (len(texts) - 1) // 2
    found = np.flatnonzero(kept)
    return found[np.argsort(archive.variables[along].values[found], kind="stable")] if along in OUTER else found


def in_the_middle(archive, along="speed_rpm"):
    """What the other axes are at, in words; "" if there are none."""
    texts = {name: texts[(len(texts) - 1) // 2] for name, texts in axes_of(archive).items()}
    shown = [f"{name} = {text}" for name, text in texts.items() if name not in ("actuation", "speed_rpm", along)]
    return ", ".join(shown + [texts["speed_rpm"]] * (along != "speed_rpm"))


def run_near(archive, actuation, speed_rpm):
    """Index of the run of an actuation whose speed is nearest [r/min]; None without any."""
    runs = runs_of(archive, actuation)
    speeds = archive.variables["speed_rpm"].values[runs]
    return runs[np.argmin(np.abs(speeds - speed_rpm))] if len(runs) else None


def torque_and_air(archive):
    """Torque and specific air consumption over speed.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    matplotlib.figure.Figure
    """

    def along(name):
        runs = runs_of(archive, name)
        return runs, archive.variables["speed_rpm"].values[runs]

    return _torque_and_air(archive, along, "speed [r/min]", in_the_middle(archive))


def over_key(archive, key):
    """Torque and specific air consumption over a key that was varied.

    Parameters
    ----------
    archive : Archive
    key : str
        Name of its axis.

    Returns
    -------
    matplotlib.figure.Figure
    """
    texts = axes_of(archive)[key]
    place = places_of(archive)[list(axes_of(archive)).index(key)]
    numbers, unit = in_one_unit(texts)
    are_words = numbers is texts
    values, label = np.array(numbers, dtype=str if are_words else float), key if are_words else f"{key} [{unit or '-'}]"

    def along(name):
        runs = runs_of(archive, name, key)
        return runs, values[place[runs]]

    return _torque_and_air(archive, along, label, in_the_middle(archive, key))


def _torque_and_air(archive, along, label, where):
    """Both of every actuation along an axis, given by a function of an actuation: its runs and where they stand."""
    v, incomplete = archive.variables, has_incomplete_stroke(archive)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.2, 3.9), layout="constrained")
    for name in actuations_in(archive):
        runs, x = along(name)
        colour = COLOURS[name]
        torque, air = (v[column].values[runs] for column in ("brake_torque_Nm", "specific_air_kg_per_kWh"))
        left.plot(x, torque, color=colour, marker=MARKERS[name], ms=3.5, label=NAMES[name])
        left.plot(x, v["indicated_torque_Nm"].values[runs], color=colour, lw=1, ls="--")
        right.plot(x, air, color=colour, marker=MARKERS[name], ms=3.5)
        for axis, values in ((left, torque), (right, air)):
            axis.plot(x[incomplete[runs]], values[incomplete[runs]], color=colour, marker=MARKERS[name], **HOLLOW)
        right.plot(x, v["indicated_specific_air_kg_per_kWh"].values[runs], color=colour, lw=1, ls="--")
    left.axhline(0.0, color="0.6", lw=0.8)
    left.plot([], [], color="0.4", label="brake")
    left.plot([], [], color="0.4", lw=1, ls="--", label="indicated")
    if incomplete.any():
        left.plot([], [], color="0.4", label="incomplete stroke", marker="o", **HOLLOW)
    left.set(xlabel=label, ylabel="torque [N m]", title="Torque")
    figure.legend(loc="outside lower center", ncols=7, fontsize=8.5)
    right.set(xlabel=label, ylabel="specific air [kg/kWh]", title="All air, control air counted, over work")
    right.set_ylim(0.0, 150.0)
    if where:
        figure.suptitle(where, fontsize=9.5)
    return figure


def indicator_diagrams(archive, speeds_rpm=(400.0, 1000.0, 1600.0)):
    """Cylinder pressure over volume at some speeds, all actuations.

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
        for name in actuations_in(archive):
            run = run_near(archive, name, speed_rpm)
            if run is None:
                continue
            volume = v["cylinder_volume"].values[run] * 1e6
            pressure = v["cylinder_pressure"].values[run] / 1e6
            axis.plot(volume, pressure, color=COLOURS[name], label=NAMES[name], lw=1.3)
            axis.set_title(f"{v['speed_rpm'].values[run]:g} r/min")
        axis.set_xlabel("cylinder volume [cm³]")
        axis.set_ylim(bottom=0.0)
    axes[0].set_ylabel("cylinder pressure [MPa abs]")
    axes[-1].legend(fontsize=8.5)
    return figure


def cycle_traces(archive, speed_rpm=1000.0):
    """Lift, chamber pressures and cylinder pressure over crank angle, all actuations.

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
    order = np.argsort((v["crank_angle"].values[:-1] - TRACE_START) % 360.0, kind="stable")
    angle = (v["crank_angle"].values[order] - TRACE_START) % 360.0 + TRACE_START
    figure, axes = plt.subplots(3, 1, figsize=(7.4, 7.0), layout="constrained", sharex=True)
    lift, chambers, cylinder = axes
    shown = ""
    for name in actuations_in(archive):
        run = run_near(archive, name, speed_rpm)
        if run is None:
            continue
        shown = f" at {v['speed_rpm'].values[run]:g} r/min"
        lift.plot(angle, v["lift"].values[run, order] * 1e3, color=COLOURS[name], label=NAMES[name])
        cylinder.plot(angle, v["cylinder_pressure"].values[run, order] / 1e6, color=COLOURS[name])
        if name.startswith("epv"):
            for letter, style in (("a", "-"), ("b", "--")):
                pressure = v[f"pressure_{letter}"].values[run, order] / 1e6
                chambers.plot(angle, pressure, color=COLOURS[name], ls=style)
    lift.set(ylabel="intake lift [mm]", title=f"One cycle{shown}")
    lift.legend(fontsize=8.5)
    chambers.set(ylabel="chamber pressure [MPa abs]")
    if chambers.lines:
        for style, label in (("-", "A, which pushes to closed"), ("--", "B, which pushes to open")):
            chambers.plot([], [], color="0.4", ls=style, label=label)
        chambers.legend(fontsize=8.5, loc="center", bbox_to_anchor=(0.85, 0.5))
    cylinder.set(ylabel="cylinder pressure [MPa abs]", xlabel="crank angle after TDC [deg]")
    cylinder.set_xlim(TRACE_START, TRACE_START + 360.0)
    cylinder.set_xticks(np.arange(TRACE_START, TRACE_START + 361.0, 45.0))
    for axis in axes:
        axis.set_ylim(bottom=0.0)
    return figure
