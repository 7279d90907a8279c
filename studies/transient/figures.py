"""Figures of starts and of runs over time, written into a folder."""

from functools import partial
from os import PathLike
from pathlib import Path

from matplotlib.figure import Figure

from apesim.studies.drawing.files import write_figures
from apesim.studies.transient.start import StartRun
from apesim.studies.transient.transient import PLOTS, TransientRun


def overview(run: TransientRun) -> Figure:
    """Draw speed, torque, air and timing of each revolution over time, below one another."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(len(PLOTS), 1, figsize=(6.5, 8.5), sharex=True, layout="constrained")
    for ax, what in zip(axes, PLOTS, strict=True):
        run.plot(ax, what)
        ax.set(title="", xlabel="")
    axes[-1].set_xlabel("time [s]")
    return figure


def draw_transient(run: TransientRun, folder: str | PathLike[str]) -> list[Path]:
    """Write the figure of a run over time into a folder, with its conditions below."""
    return write_figures({"transient": partial(overview, run)}, folder, conditions_line(run))


def draw_start(start: StartRun, folder: str | PathLike[str]) -> list[Path]:
    """Write the figure of a start, or of the angles of all, into a folder, with its conditions below."""

    def draw() -> Figure:
        ax = start.plot(what="speed" if start.march else "angles")
        ax.set_title("")
        figure = ax.figure
        assert isinstance(figure, Figure)
        return figure

    return write_figures({"start" if start.march else "starting_angles": draw}, folder, conditions_line(start))


def conditions_line(result: StartRun | TransientRun) -> str:
    """Conditions of a result in a line."""
    return ", ".join(f"{name}: {text}" for name, text in result.conditions.items())
