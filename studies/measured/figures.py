"""Figures of measured data over the machine, with what the checks of plausibility found."""

import textwrap
from collections.abc import Sequence
from functools import partial
from itertools import zip_longest
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.quantities import unit
from apesim.studies.drawing.conditions import CONTROL_AIR, SUPPLY, VALVE_SECTIONS, conditions_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import (
    MAX_COLUMNS,
    add_figure_legend,
    break_at_gaps,
    gauge_in_mpa,
    label_axes,
    legend_handle,
    open_panels,
    open_wrapped,
)
from apesim.studies.drawing.style import BLUE, GREY, RED
from apesim.studies.measured import CYLINDER, ENGINE, VALVE, Disturbance, MeasuredRun
from apesim.studies.measured.plausibility import Finding, Kind
from apesim.studies.measured.sensors import SENSORS

if TYPE_CHECKING:
    from apesim.studies.measured.check import MeasuredCheck

MAX_ROWS = 4
"""Runs on a page."""
PANEL = (3.9, 2.6)
"""Size of a panel [inch]."""
MIN_WIDTH = 7.8
"""Width of a page [inch]: the conditions below it are as wide."""
COLOURS = {Kind.FAULT: RED, Kind.WARNING: "#b07d00", Kind.HINT: GREY}
"""Colour of what was found."""
LONG = 2.0
"""Length of a record from which its times are shown in seconds [s]."""
TITLE_LETTERS = 40
"""Letters on a line of a title: the width of a panel."""
MASKED: dict[str, Any] = {
    "ls": "",
    "marker": "x",
    "ms": 6,
    "mew": 1.4,
    "clip_on": False,
    "color": COLOURS[Kind.WARNING],
}
"""Mark of a masked sample."""
LETTERS = 56
"""Letters on a line of a finding: the width of a panel."""
LINE_SHARE = 0.085
"""Height of a line of a finding over that of a panel."""
MAX_SHOWN = 2
"""Findings that a panel has room for; the others are counted."""


def measured_figures(check: "MeasuredCheck", folder: str | PathLike[str]) -> list[Path]:
    """Write all runs over the machine, a page for each `MAX_ROWS` runs, and the means of an engine on a page.

    Pages are PNG and PDF; `folder` is made if it does not exist.

    >>> from tempfile import TemporaryDirectory
    >>> import apesim
    >>> from apesim.studies.gap.example_bench import read_example
    >>> check = apesim.check_measured(apesim.Machine(), read_example())
    >>> with TemporaryDirectory() as folder:
    ...     [path.name for path in measured_figures(check, folder)]
    ['runs_1.png', 'runs_1.pdf']
    """
    traced = [number for number, run in enumerate(check.measured.runs) if run.channels]
    if check.measured.bench == CYLINDER:  # the ways of a record are repeats: the first stands for all
        files = [check.measured.runs[number].data for number in traced]
        traced = [number for number, file in zip(traced, files, strict=True) if files.index(file) == number]
    pages = [traced[start : start + MAX_ROWS] for start in range(0, len(traced), MAX_ROWS)]
    figures = {f"runs_{page}": partial(plot_runs, check, numbers) for page, numbers in enumerate(pages, 1)}
    if any(run.means for run in check.measured.runs):
        figures["means"] = partial(plot_means, check)
    is_valve = check.measured.bench == VALVE
    shown, sections = (CONTROL_AIR, VALVE_SECTIONS) if is_valve else (SUPPLY, None)
    return write_figures(figures, folder, conditions_of(check.machine.to_toml(), shown, sections=sections))


def plot_runs(check: "MeasuredCheck", numbers: Sequence[int]) -> Figure:
    """Plot runs over the machine: a row for each run, a column for each channel, `MAX_COLUMNS` at most.

    The numbers of the runs count from 0.
    """
    runs = [check.measured.runs[number] for number in numbers]
    names = [name for name in SENSORS[check.measured.bench].traces if any(name in run.channels for run in runs)]
    columns = min(len(names), MAX_COLUMNS)
    rows = -(-len(names) // columns)
    size = max(PANEL[0] * columns, MIN_WIDTH), PANEL[1] * rows * len(numbers) + 0.4
    figure, panels = open_panels(rows * len(numbers), columns, size)
    for row, number in zip(panels.reshape(len(numbers), rows * columns), numbers, strict=True):
        for axis, channel in zip_longest(row, names):
            if channel in check.measured.runs[number].channels:
                draw_channel(axis, check, number, channel)
            else:
                axis.set_axis_off()
    is_masked = any(masked.run in numbers for masked in check.measured.masked)
    handles = [
        legend_handle(color=BLUE, ls="", marker=".", label="measured"),
        legend_handle(color="0.15", lw=1.2, label="machine, as the run is stated"),
        *([legend_handle(**MASKED, label="masked, used by nothing; far ones at the edge")] if is_masked else []),
    ]
    add_figure_legend(figure, handles)
    return figure


def draw_channel(axis: Axes, check: "MeasuredCheck", number: int, channel: str) -> Axes:
    """Draw a channel of run `number`, from 0, over the machine, with what was found of it.

    >>> import apesim
    >>> from apesim.studies.drawing.panels import open_one
    >>> from apesim.studies.gap.example_bench import read_example
    >>> check = apesim.check_measured(apesim.Machine(), read_example())
    >>> draw_channel(open_one()[1], check, 0, "lift").get_title()
    'p30.csv: 0.3 MPa gauge, pulse 40 ms'
    """
    run, expected = check.measured.runs[number], check.expected[number]
    declared = SENSORS[run.bench].traces[channel].unit
    scale = unit(declared).si("1")
    is_engine = run.bench == ENGINE
    per_place, x = 1e3, ("time", "ms")
    if is_engine:
        per_place, x = 180.0 / np.pi, ("crank angle", "deg")
    elif np.ptp(run.times) > LONG:
        per_place, x = 1.0, ("time", "s")
    places = per_place * (run.angles if is_engine else run.times)
    axis.plot(places, run.channels[channel] / scale, ls="", marker=".", ms=2.5, color=BLUE, label="measured")
    if expected is not None and channel in expected.channels:
        everywhere = run._replace(channels={})  # where cells of the file are missing, too
        shown = expected.at(channel, everywhere) / scale
        axis.plot(*break_at_gaps(places, shown), color="0.15", lw=1.2, label="machine")
    low, high = axis.get_ylim()
    for masked in check.measured.masked:
        if (masked.run, masked.channel) == (number, channel) and masked.disturbance != Disturbance.REPEATED:
            shown = np.clip(masked.values / scale, low, high)  # far ones stand at the edge
            axis.plot(per_place * masked.places, shown, **MASKED, label="masked")
    axis.set_ylim(low, high)
    unit_name = f"{declared} abs" if "pressure" in channel else declared
    label_axes(axis, x=x, y=(channel.replace("_", " "), unit_name), title=_title(check, run))
    _write_findings(axis, [finding for finding in check.findings if _belongs(finding, run, number, channel)])
    return axis


def plot_means(check: "MeasuredCheck") -> Figure:
    """Plot the means of an engine over the runs, measured and of the machine.

    >>> import apesim
    >>> from apesim.studies.measured import Measured
    >>> run = MeasuredRun(
    ...     "n600", "", 1.1e6, 287.0, float("nan"), "fit", np.zeros(0), {}, bench="engine", speed=62.8,
    ...     energise=-0.1, release=1.2, means={"torque": 31.0})
    >>> measured = Measured("measured", {}, (run,), "engine")
    >>> figure = plot_means(apesim.check_measured(apesim.Machine(), measured))
    >>> figure.axes[0].get_ylabel()
    'torque [N m]'
    """
    runs, sensors = check.measured.runs, SENSORS[check.measured.bench].means
    names = [name for name in sensors if any(name in run.means for run in runs)]
    width = max(PANEL[0], MIN_WIDTH / min(len(names), MAX_COLUMNS))
    figure, panels = open_wrapped(len(names), (width, PANEL[1] + 0.9))
    labels = _name_runs(runs)
    for axis, name in zip(panels, names, strict=True):
        scale = unit(sensors[name].unit).si("1")
        places = [number for number, run in enumerate(runs) if name in run.means]
        measured = [runs[number].means[name] / scale for number in places]
        axis.plot(places, measured, ls="", marker="o", color=BLUE, label="measured")
        shown = [(number, one.means[name] / scale) for number in places if (one := check.expected[number]) is not None]
        if shown:
            axis.plot(*zip(*shown, strict=True), ls="", marker="_", ms=14, mew=1.6, color="0.15", label="machine")
        axis.set_xticks(places, [labels[number] for number in places], rotation=30, ha="right")
        axis.margins(x=0.15)
        label_axes(axis, y=(name.replace("_", " "), sensors[name].unit))
        _write_findings(axis, [finding for finding in check.findings if finding.channel.endswith(f".{name}")])
    add_figure_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure


def _name_runs(runs: Sequence[MeasuredRun]) -> list[str]:
    """Speed of each run of an engine, and its name where others have the same speed."""
    speeds = [f"{run.speed * 30.0 / np.pi:.4g} r/min" for run in runs]
    return [
        speed if speeds.count(speed) == 1 else f"{speed}, {run.name}" for speed, run in zip(speeds, runs, strict=True)
    ]


def _title(check: "MeasuredCheck", run: MeasuredRun) -> str:
    """File and operating point of a run."""
    supply = f"{gauge_in_mpa(np.array(run.supply), check.machine.ambient.pressure):.3g} MPa gauge"
    points = {ENGINE: f", {run.speed * 30.0 / np.pi:.4g} r/min", VALVE: f", pulse {1e3 * run.pulse:.4g} ms"}
    point = supply + points.get(run.bench, "")
    title = f"{run.data}: {point}"
    return title if len(title) <= TITLE_LETTERS else f"{run.data}\n{point}"


def _belongs(finding: Finding, run: MeasuredRun, number: int, channel: str) -> bool:
    """Whether a finding is written at a channel: its own, and at the first one what is about the run as a whole."""
    if finding.run != number or any(finding.channel.endswith(f".{name}") for name in run.means):
        return False
    if channel in finding.channel.replace(",", "").split():
        return True
    return channel == next(iter(run.channels)) and not any(
        name in finding.channel.replace(",", "").split() for name in run.channels
    )


def _write_findings(axis: Axes, findings: Sequence[Finding]) -> None:
    """Write findings above the data of a panel, the gravest first, in the colour of their kind."""
    blocks = []
    for finding in findings[:MAX_SHOWN]:
        reason = f" ({finding.reason})" if finding.reason else ""
        run, _, key = finding.channel.partition(".")
        text = f"{finding.kind}: {f'{run}: {key} '.replace('_', ' ') if key else ''}{finding.seen}{reason}"
        blocks.append((textwrap.fill(text, LETTERS), COLOURS[finding.kind]))
    if len(findings) > MAX_SHOWN:
        blocks.append((f"and {len(findings) - MAX_SHOWN} more", GREY))
    height = LINE_SHARE * sum(text.count("\n") + 1 for text, _ in blocks)
    if not blocks:
        return
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + (high - low) * height / max(1.0 - height, 0.3))
    place = 0.99
    for text, colour in blocks:
        axis.text(0.01, place, text, transform=axis.transAxes, va="top", fontsize=7.5, color=colour, linespacing=1.1)
        place -= LINE_SHARE * (text.count("\n") + 1)
