"""Figures of starts and of runs over time, written into a folder."""

from collections.abc import Mapping
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.studies.drawing.conditions import conditions_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import ONE, open_column, open_one, open_panels
from apesim.studies.sweep.variation import varied_keys
from apesim.studies.transient.circle import size_for
from apesim.studies.transient.start_curves import draw_over_keys
from apesim.studies.transient.transient import PLOTS

if TYPE_CHECKING:
    from apesim.studies.transient.start import StartRun
    from apesim.studies.transient.start_map import StartMap
    from apesim.studies.transient.transient import TransientRun

WIDTH = ONE[0]
"""Width of figures with panels below one another [inch]."""
SUPPLY, CYLINDERS = "supply", "cylinders"
"""Conditions that the machine says, too."""


def overview(run: "TransientRun") -> Figure:
    """Draw speed, torque, air and timing of each revolution over time, below one another."""
    figure, axes = open_column(len(PLOTS), (WIDTH, 8.5))
    for ax, what in zip(axes, PLOTS, strict=True):
        run.plot(ax, what)
        ax.set(title="", xlabel="")
    axes[-1].set_xlabel("time [s]")
    return figure


def draw_transient(run: "TransientRun", folder: str | PathLike[str]) -> list[Path]:
    """Write the figure of a run over time into a folder, with its conditions below."""
    return write_figures({"transient": partial(overview, run)}, folder, conditions_line(run))


def draw_start(start: "StartRun", folder: str | PathLike[str]) -> list[Path]:
    """Write the figure of a start, or of the angles of all, into a folder, with its conditions below."""

    def draw() -> Figure:
        figure, ax = _open_circle([""]) if start.is_of_all_angles else open_one()
        start.plot(ax).set_title("")
        return figure

    name = "starting_angles" if start.is_of_all_angles else "start"
    return write_figures({name: draw}, folder, conditions_line(start))


def draw_start_map(starts: "StartMap", folder: str | PathLike[str]) -> list[Path]:
    """Write the figures of starts over keys into a folder: rings and shares of all angles, or numbers of one."""
    archive = starts.archive

    def draw_rings() -> Figure:
        figure, ax = _open_circle(starts.rings()[1])
        starts.plot(ax, "angles")
        return figure

    def draw_numbers() -> Figure:
        names = starts.plots()
        figure, axes = open_column(len(names), (WIDTH, 2.1 * len(names)))
        for ax, what in zip(axes, names, strict=True):
            draw_over_keys(ax, archive, what, legend=ax is axes[0])
            if ax is not axes[-1]:
                ax.set_xlabel("")
        return figure

    def draw_share() -> Figure:
        figure, ax = open_one()
        draw_over_keys(ax, archive, "share")
        return figure

    figures = {"starting_angles": draw_rings, "starting_share": draw_share}
    chosen = figures if starts.is_of_all_angles else {"start": draw_numbers}
    return write_figures(chosen, folder, conditions_line(starts, varied_keys(archive)))


def _open_circle(names: list[str]) -> tuple[Figure, Axes]:
    """Open a figure of no window with polar axes, for rings of these names."""
    figure, panels = open_panels(1, 1, size_for(names), subplot_kw={"projection": "polar"})
    return figure, panels[0, 0]


def conditions_line(result: "StartRun | StartMap | TransientRun", varied: Mapping[str, str] | None = None) -> str:
    """Conditions of a result, and in which keys its machine departs from the default one.

    `varied` are the keys that the figure shows over a range, by their names in the archive.
    """
    varied = varied or {}
    shown = {name.replace("_", " ") for name in varied} | {SUPPLY, CYLINDERS}
    told = [f"{name}: {text}" for name, text in result.conditions.items() if name not in shown]
    return conditions_of(result.archive.machine, tuple(varied.values()), ", ".join(told))
