"""Figures of a fit: measured runs over the fitted machine, with what is left below."""

from collections.abc import Sequence
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.quantities import unit
from apesim.studies.drawing.conditions import CONTROL_AIR, VALVE_SECTIONS, conditions_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import (
    MAX_COLUMNS,
    add_figure_legend,
    break_at_gaps,
    draw_zero,
    gauge_in_mpa,
    label_axes,
    legend_handle,
    open_panels,
)
from apesim.studies.drawing.style import BLUE
from apesim.studies.identify.simulation import machine_for
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import predict
from apesim.studies.measured.sensors import SENSORS

if TYPE_CHECKING:
    from apesim.studies.identify.estimate import Fit

MAX_RUNS = 6
"""Runs on a page."""
PANEL = (3.1, 3.4)
"""Size of the two panels of a run [inch]."""
MIN_WIDTH = 6.4
"""Width of a page [inch]: the conditions below it are as wide."""
ROLES = {"fit": "fitted", "gate": "gate, not fitted", "check": "check, not fitted"}
"""What was done with a run, by its role."""


def fit_figures(fit: "Fit", folder: str | PathLike[str]) -> list[Path]:
    """Write all runs over the fitted machine, a page for each `MAX_RUNS` runs, as PNG and PDF.

    `folder` is made if it does not exist.

    >>> import tempfile
    >>> import apesim
    >>> from apesim.studies.gap.example_bench import read_example
    >>> fitted = apesim.fit(read_example(), ["valve.viscous_friction"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in fit_figures(fitted, folder)]
    ['fit_1.png', 'fit_1.pdf']
    """
    runs = list_drawable(fit)
    pages = [runs[start : start + MAX_RUNS] for start in range(0, len(runs), MAX_RUNS)]
    figures = {f"fit_{page}": partial(_plot_runs, fit, shown) for page, shown in enumerate(pages, 1)}
    assert fit.fitted_machine is not None
    conditions = conditions_of(fit.fitted_machine.to_toml(), CONTROL_AIR, sections=VALVE_SECTIONS)
    return write_figures(figures, folder, conditions)


def list_drawable(fit: "Fit") -> list[MeasuredRun]:
    """Runs of a fit that have a trace, those that were fitted first."""
    runs = [run for run in fit.measured.runs if run.channels] if fit.measured is not None else []
    return sorted(runs, key=lambda run: list(ROLES).index(run.role))


def _plot_runs(fit: "Fit", runs: Sequence[MeasuredRun]) -> Figure:
    """Plot runs side by side, three a row, each over what is left of it."""
    columns = min(len(runs), MAX_COLUMNS)
    rows = -(-len(runs) // columns)
    size = max(PANEL[0] * columns, MIN_WIDTH), PANEL[1] * rows + 0.4
    figure, panels = open_panels(2 * rows, columns, size, height_ratios=(2.2, 1) * rows)
    for number in range(rows * columns):
        row, column = divmod(number, columns)
        above, below = panels[2 * row, column], panels[2 * row + 1, column]
        if number < len(runs):
            draw_run(above, fit, runs[number])
            _draw_left(below, fit, runs[number])
            above.tick_params(labelbottom=False)
            above.set_xlabel("")
        else:
            above.set_axis_off()
            below.set_axis_off()
    figure.align_ylabels()
    handles = [
        legend_handle(color=BLUE, ls="", marker=".", label="measured"),
        legend_handle(color="0.15", lw=1.2, label="fitted machine"),
    ]
    add_figure_legend(figure, handles)
    return figure


def _channel(run: MeasuredRun) -> tuple[str, float, str]:
    """Channel of a run that is drawn, its scale to SI and its unit: the lift, where it is measured."""
    name = "lift" if "lift" in run.channels else next(iter(run.channels))
    declared = SENSORS[run.bench].traces[name].unit
    return name, unit(declared).si("1"), declared


def _predicted(fit: "Fit", run: MeasuredRun, name: str) -> np.ndarray:
    """A channel of a run by the fitted machine, at the times of the run."""
    assert fit.identified is not None
    return predict(machine_for(fit.identified, run), run, (name,)).channels[name]


def draw_run(axis: Axes, fit: "Fit", run: MeasuredRun) -> Axes:
    """Draw a measured run over the fitted machine, its lift, or else its first channel, and give the axes back."""
    name, scale, declared = _channel(run)
    times = run.times * 1e3
    axis.plot(times, run.channels[name] / scale, ls="", marker=".", ms=2.5, color=BLUE, label="measured")
    fitted = _predicted(fit, run, name) / scale
    axis.plot(*break_at_gaps(times, fitted), color="0.15", lw=1.2, label="fitted machine")
    assert fit.fitted_machine is not None
    gauge = gauge_in_mpa(np.array(run.supply), fit.fitted_machine.ambient.pressure)
    title = f"{run.data} ({ROLES[run.role]})\n{gauge:.3g} MPa gauge, pulse {1e3 * run.pulse:.4g} ms"
    label_axes(axis, x=("time after the command", "ms"), y=(name.replace("_", " "), declared), title=title)
    return axis


def _draw_left(axis: Axes, fit: "Fit", run: MeasuredRun) -> None:
    """Draw what is left of a run: fitted less measured."""
    name, scale, declared = _channel(run)
    left = (_predicted(fit, run, name) - run.channels[name]) / scale
    axis.plot(run.times * 1e3, left, ls="", marker=".", ms=2.0, color=BLUE)
    draw_zero(axis, colour="0.2")
    label_axes(axis, x=("time after the command", "ms"), y=("fitted less\nmeasured", declared))
