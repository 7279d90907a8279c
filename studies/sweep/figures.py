"""Figures of a sweep: over speed, around the cycle, and over each key that was varied."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import cycle, product
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.archive import Archive
from apesim.archive.grid import axes_of, places_of
from apesim.studies.drawing.conditions import conditions_of
from apesim.studies.drawing.cycle_order import TRACE_START, order_of_cycle
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import (
    MAX_SPECIFIC_AIR,
    add_figure_legend,
    add_legend,
    add_legend_entry,
    add_title,
    draw_zero,
    label_axes,
    legend_handle,
    named,
    open_column,
    open_row,
)
from apesim.studies.drawing.spread import spread_out
from apesim.studies.drawing.style import BLUE, GREY, RED, STYLES, Look, colours_of, spaced
from apesim.studies.drawing.style import MARKERS as MARKS
from apesim.studies.sweep.plan import in_one_unit
from apesim.studies.sweep.results import has_incomplete_stroke
from apesim.studies.sweep.variation import varied_keys

COLOURS = {"epv": RED, "epv corrected": "#1b9e77", "cam": BLUE, "ideal": "#3a3a3a"}
"""Colour of each actuation."""
NAMES = {"epv": "EPV, fixed", "epv corrected": "EPV, corrected", "cam": "cam", "ideal": "ideal valve"}
"""Name of each actuation in legends."""
MARKERS = {"epv": "o", "epv corrected": "s", "cam": "^", "ideal": "D"}
"""Marker of each actuation."""
HOLLOW: Look = {"ls": "", "ms": 5, "mfc": "white"}
"""Look of points at which the valve does not open fully and close fully in every cycle."""
MAX_LINES = 12
"""Lines that one pair of axes holds at most: four actuations at three pressures can still be told apart."""
WIDE = (9.6, 4.8)
"""Size of a figure whose legend stands beside its panel [inch]."""
OUTER = ("actuation", "speed_rpm")
"""Axes of every sweep; those between them are what was varied."""


def sweep_figures(archive: Archive, folder: str | PathLike[str]) -> list[Path]:
    """Write all figures of a sweep as PNG and PDF; where keys were varied, over each, the others in the middle.

    `archive` is as `apesim.studies.sweep.run_sweep` gives it; without traces there are no figures of the cycle.
    `folder` is made if it does not exist.
    """
    varied = [name for name in axes_of(archive) if name not in OUTER]
    figures: dict[str, Callable[[], Figure]] = {"torque_and_air": partial(plot_over_speed, archive)}
    if "crank_angle" in archive.variables:
        figures["indicator_diagrams"] = partial(_plot_indicator_diagrams, archive)
        figures["cycle_traces"] = partial(plot_cycle, archive)
    figures |= {f"over_{name}": partial(_plot_over_key, archive, name) for name in varied}
    return write_figures(figures, folder, conditions_of(archive.machine, varied_keys(archive).values()))


def actuations_in(archive: Archive) -> list[str]:
    """List the names of what moves the intakes in an archive."""
    texts, places = axes_of(archive)["actuation"], places_of(archive)[0]
    return [name for number, name in enumerate(texts) if number in places]


def runs_of(archive: Archive, actuation: str, along: str = "speed_rpm") -> np.ndarray:
    """Indices (n,) of an actuation's runs by rising value along one axis; on the other axes they are in the middle."""
    selected = np.ones(len(archive.runs), dtype=bool)
    for (name, texts), places in zip(axes_of(archive).items(), places_of(archive), strict=True):
        if name == "actuation":
            selected &= places == texts.index(actuation)
        elif name != along:
            selected &= places == (len(texts) - 1) // 2
    runs = np.flatnonzero(selected)
    return runs[np.argsort(archive.variables[along].values[runs], kind="stable")] if along in OUTER else runs


def draw_over_speed(axis: Axes, archive: Archive, values: np.ndarray, **legend: Any) -> None:
    """Draw a variable over speed: a line for each actuation and for each combination of the keys that were varied.

    `values` (n,) are the variable over the runs, `legend` what `matplotlib.axes.Axes.legend` takes; where it has no
    place, one is looked for. The title says what the lines have in common and how many are left out.
    """
    texts, actuations = axes_of(archive), actuations_in(archive)
    places = dict(zip(texts, places_of(archive), strict=True))
    keys = [name for name in texts if name not in OUTER]
    several = [name for name in keys if len(texts[name]) > 1]
    # As many of the values as can be told apart.
    combinations = list(product(*(range(len(texts[name])) for name in several)))
    shown = [combinations[number] for number in spread_out(len(combinations), max(1, MAX_LINES // len(actuations)))]
    names = [_told(texts, dict(zip(several, combination, strict=True))) for combination in shown]
    # Colours tell the values apart where there are several, and else the actuations.
    colours, speed = colours_of(len(shown)), archive.variables["speed_rpm"].values
    looks: dict[str, Look] = {name: {"color": COLOURS[name], "marker": MARKERS[name], "ms": 4} for name in actuations}
    # In grey print markers distinguish the actuations, and styles of the line the values; of one actuation both do.
    own_looks: list[Look] = [{} for _ in shown]
    for look, colour, style, marker in zip(own_looks, colours, cycle(STYLES), cycle(MARKS)):
        look |= {"color": colour, "ls": style} if several else {}
        look |= {"marker": marker} if several and len(actuations) == 1 else {}
    for combination, name, own in zip(shown, names, own_looks, strict=True):
        is_there = np.all([places[key] == place for key, place in zip(several, combination, strict=True)], axis=0)
        for actuation, look in looks.items():
            runs = np.flatnonzero(is_there & (places["actuation"] == texts["actuation"].index(actuation)))
            runs = runs[np.argsort(speed[runs], kind="stable")]
            label = ", ".join([NAMES[actuation]] * (len(actuations) > 1 or not several) + [name] * bool(several))
            axis.plot(speed[runs], values[runs], label=label, **look | own)
    # With both, an entry for each value and each actuation, not for each pair of them.
    entries = [legend_handle(label=NAMES[name], **look | {"color": GREY, "ls": ""}) for name, look in looks.items()]
    entries += [legend_handle(label=name, **own) for name, own in zip(names, own_looks, strict=True)]
    if several and len(actuations) > 1:
        legend["handles"] = entries
    # What they have in common, and what is left out.
    told = [NAMES[actuations[0]]] * bool(several and len(actuations) == 1)
    told += [_told(texts, {name: 0}) for name in keys if name not in several]
    if len(shown) < len(combinations):
        what = " and ".join(name.replace("_", " ") for name in several)
        told.append(f"{len(shown)} of {len(combinations)} values of {what} are drawn")
    add_title(axis, ", ".join(told))
    if "loc" in legend:
        axis.legend(**legend)
    else:
        add_legend(axis, **legend)


def _told(texts: dict[str, list[str]], places: dict[str, int]) -> str:
    """Values of some axes in words: "supply pressure 1 MPa gauge"."""
    return ", ".join(f"{name.replace('_', ' ')} {texts[name][place]}" for name, place in places.items())


def in_the_middle(archive: Archive, along: str = "speed_rpm") -> str:
    """Values of the axes that a figure over the axis `along` does not show, in words; "" if there are none.

    >>> from apesim.archive.columns import column, run_axis
    >>> texts = '{"actuation": ["epv"], "engine_bore": ["80 mm", "90 mm"], "speed_rpm": ["600 rpm"]}'
    >>> variables = {name: column([0.0, 0.0], "1", name) for name in ("actuation", "engine_bore", "speed_rpm")}
    >>> in_the_middle(Archive("", {"axes": texts}, variables | {"run": run_axis(2)}))
    'engine bore 80 mm'
    """
    texts = axes_of(archive)
    middle = {name: (len(values) - 1) // 2 for name, values in texts.items()}
    shown = [_told(texts, {name: place}) for name, place in middle.items() if name not in (*OUTER, along)]
    return ", ".join(shown + [texts["speed_rpm"][middle["speed_rpm"]]] * (along != "speed_rpm"))


def _run_near(archive: Archive, actuation: str, speed_rpm: float) -> int | None:
    """Index of the run of an actuation whose speed is nearest; None where it has no run."""
    runs = runs_of(archive, actuation)
    speeds = archive.variables["speed_rpm"].values[runs]
    return int(runs[np.argmin(np.abs(speeds - speed_rpm))]) if len(runs) else None


def plot_over_speed(archive: Archive) -> Figure:
    """Plot torque and specific air over speed."""

    def along(name: str) -> tuple[np.ndarray, np.ndarray]:
        runs = runs_of(archive, name)
        return runs, archive.variables["speed_rpm"].values[runs]

    return _plot_torque_and_air(archive, along, "speed [r/min]", in_the_middle(archive))


def _plot_over_key(archive: Archive, key: str) -> Figure:
    """Plot torque and specific air over a key that was varied."""
    texts = axes_of(archive)[key]
    place = places_of(archive)[list(axes_of(archive)).index(key)]
    numbers, unit = in_one_unit(texts)
    are_words = numbers is texts
    values, name = np.array(numbers, dtype=str if are_words else float), key.replace("_", " ")
    label = name if are_words else named(name, unit or "-")

    def along(actuation: str) -> tuple[np.ndarray, np.ndarray]:
        runs = runs_of(archive, actuation, key)
        return runs, values[place[runs]]

    return _plot_torque_and_air(archive, along, label, in_the_middle(archive, key))


def _plot_torque_and_air(
    archive: Archive, along: Callable[[str], tuple[np.ndarray, np.ndarray]], label: str, where: str
) -> Figure:
    """Plot both over an axis; `along` gives the runs of an actuation and their places on the axis."""
    v, incomplete = archive.variables, has_incomplete_stroke(archive)
    figure, (left, right) = open_row(2)
    for name in actuations_in(archive):
        runs, x = along(name)
        line: Look = {"color": COLOURS[name], "marker": MARKERS[name]}
        dashed: Look = line | {"lw": 1, "ls": "--", "ms": 3}
        torque, air = (v[column].values[runs] for column in ("brake_torque_Nm", "specific_air_kg_per_kWh"))
        left.plot(x, torque, ms=3.5, label=NAMES[name], **line)
        left.plot(x, v["indicated_torque_Nm"].values[runs], **dashed)
        right.plot(x, air, ms=3.5, **line)

        # Hollow markers are drawn over the filled ones, so that the line of an actuation stays whole.
        for axis, values in ((left, torque), (right, air)):
            axis.plot(x[incomplete[runs]], values[incomplete[runs]], **line | HOLLOW)
        right.plot(x, v["indicated_specific_air_kg_per_kWh"].values[runs], **dashed)

    # Styles have entries of their own in grey, as the colours stand for the actuations.
    draw_zero(left)
    add_legend_entry(left, "brake")
    add_legend_entry(left, "indicated", lw=1, ls="--")
    if incomplete.any():
        add_legend_entry(left, "hollow: incomplete stroke", marker="o", **HOLLOW)

    # Names and limits. The axis of specific air has a fixed end, as that grows without bound near zero work.
    label_axes(left, y=("torque", "N m"), title="Torque")
    label_axes(right, y=("specific air", "kg/kWh"), title="All air, control air counted, over work")
    right.set_ylim(0.0, MAX_SPECIFIC_AIR)
    for axis in (left, right):
        axis.set_xlabel(label)
    add_figure_legend(figure, left.get_legend_handles_labels()[0])
    _say_where(figure, where)
    return figure


def _say_where(figure: Figure, where: str) -> None:
    """Write above all panels at which values of the other keys they are."""
    if where:
        figure.suptitle(where, fontsize=9.5)


def _plot_indicator_diagrams(archive: Archive, speeds_rpm: Sequence[float] = (400.0, 1000.0, 1600.0)) -> Figure:
    """Plot cylinder pressure over volume at the speeds nearest to some, all actuations."""
    speeds = np.unique(archive.variables["speed_rpm"].values)
    nearest = np.unique([speeds[np.argmin(np.abs(speeds - speed_rpm))] for speed_rpm in speeds_rpm])
    figure, panels = open_row(len(nearest), (3.1 * max(len(nearest), 2), 3.8), sharey=True)
    for axis, speed_rpm in zip(panels, nearest, strict=True):
        _draw_indicator_diagram(axis, archive, speed_rpm)
    label_axes(panels[0], y=("cylinder pressure", "MPa abs"))
    add_figure_legend(figure, panels[0].get_legend_handles_labels()[0])
    _say_where(figure, in_the_middle(archive))
    return figure


def _draw_indicator_diagram(axis: Axes, archive: Archive, speed_rpm: float) -> Axes:
    """Draw cylinder pressure over volume at a speed, a line for each actuation."""
    v, names = archive.variables, actuations_in(archive)
    for number, name in enumerate(names):
        run = _run_near(archive, name, speed_rpm)
        if run is None:
            continue
        volume = v["cylinder_volume"].values[run] * 1e6
        pressure = v["cylinder_pressure"].values[run] / 1e6
        marks = _marks(name, len(volume), number, len(names))
        axis.plot(volume, pressure, label=NAMES[name], lw=1.3, **marks)
        axis.set_title(f"{v['speed_rpm'].values[run]:g} r/min")
    label_axes(axis, x=("cylinder volume", "cm³"))
    axis.set_ylim(bottom=0.0)
    return axis


def _marks(name: str, size: int, number: int, count: int) -> Look:
    """Look of a trace of an actuation, with a few markers."""
    return {"color": COLOURS[name], "marker": MARKERS[name], "ms": 3.5, "markevery": spaced(size, number, count)}


def plot_cycle(archive: Archive, speed_rpm: float = 1000.0) -> Figure:
    """Plot lift, chamber pressures and cylinder pressure over crank angle, all actuations.

    Each actuation is shown by its run nearest to the speed.
    """
    v = archive.variables

    order, angle = order_of_cycle(v["crank_angle"].values)
    figure, panels = open_column(3, (7.4, 7.0))
    lift, chambers, cylinder = panels
    at_speed = ""
    names = actuations_in(archive)
    for number, name in enumerate(names):
        run = _run_near(archive, name, speed_rpm)
        if run is None:
            continue
        look = _marks(name, len(angle), number, len(names))
        at_speed = f" at {v['speed_rpm'].values[run]:g} r/min"
        lift.plot(angle, v["lift"].values[run, order] * 1e3, label=NAMES[name], **look)
        cylinder.plot(angle, v["cylinder_pressure"].values[run, order] / 1e6, **look)

        # Only the electro-pneumatic valve has chambers.
        if name.startswith("epv"):
            for letter, style in (("a", "-"), ("b", "--")):
                pressure = v[f"pressure_{letter}"].values[run, order] / 1e6
                chambers.plot(angle, pressure, ls=style, **look)

    # What the panels say; they share the x axis, which the lowest one sets for all.
    title = ", ".join(filter(None, [f"One cycle{at_speed}", in_the_middle(archive)]))
    label_axes(lift, y=("intake lift", "mm"), title=title)
    label_axes(chambers, y=("chamber pressure", "MPa abs"))
    if chambers.lines:
        for style, label in (("-", "A, which pushes to closed"), ("--", "B, which pushes to open")):
            add_legend_entry(chambers, label, color=GREY, ls=style)
    label_axes(cylinder, x=("crank angle after TDC", "deg"), y=("cylinder pressure", "MPa abs"))
    cylinder.set_xlim(TRACE_START, TRACE_START + 360.0)
    cylinder.set_xticks(np.arange(TRACE_START, TRACE_START + 361.0, 45.0))
    for axis in panels:
        axis.set_ylim(bottom=0.0)

    # Actuations are explained by the lift, which all of them have, and styles by the chambers.
    handles = lift.get_legend_handles_labels()[0] + chambers.get_legend_handles_labels()[0]
    add_figure_legend(figure, handles)
    return figure
