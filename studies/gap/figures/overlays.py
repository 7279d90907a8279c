"""Figure of the traces that the calibrated machine misses by most."""

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from apesim.studies.drawing.panels import add_figure_legend, break_at_gaps, find_gaps, label_axes, open_panels
from apesim.studies.gap.decide.operating_points import label_point
from apesim.studies.gap.figures.style import AFTER, BEFORE, MEASURED, WIDTH, WORDS
from apesim.studies.gap.report.comparison import find_display
from apesim.studies.gap.search.phases import PHASES, find_phases
from apesim.studies.measured import CYLINDER, ENGINE

if TYPE_CHECKING:
    from apesim.studies.gap.report.comparison import ComparedSignal

SHADES = {
    "dead time": "#e8e8e8",
    "opening flight": "#dcebf7",
    "impact": "#f9d9c8",
    "dwell": "#ffffff",
    "closing flight": "#e3f1dd",
    "charging": "#dcebf7",
    "expansion": "#ffffff",
    "exhaust": "#f3ead7",
    "stroke against the pressure": "#dcebf7",
    "stroke with the pressure": "#e3f1dd",
}
"""Background of each phase of the stroke or cycle."""
OVER = {ENGINE: ("crank angle", "deg"), CYLINDER: ("time after the turning point", "ms")}
"""What the traces of a bench stand over; those of the valve over the time after the command."""
STRIPES = {
    "opening flight": "////",
    "impact": "xxxx",
    "closing flight": "\\\\\\\\",
    "charging": "////",
    "exhaust": "\\\\\\\\",
    "stroke against the pressure": "////",
    "stroke with the pressure": "\\\\\\\\",
}
"""White stripes of phases, by which grey print distinguishes their shades."""
UNSHADED = "#ffffff"
"""Background of phases that a legend does not name."""
MEAN_SAMPLES = 9
"""Samples of a running mean: it shows what the noise hides, and keeps steps."""
NOISE_BAND = 2.0
"""Half the width of the band that noise alone would fill, in standard deviations."""


def plot_overlays(chosen: "Sequence[ComparedSignal]", added: str, ambient_pressure: float) -> Figure:
    r"""Plot traces over the models, each with its residuals below.

    `added` says in words what was added to the model; `ambient_pressure` is in [Pa abs].

    >>> from apesim.studies.estimation.residuals import Block
    >>> from apesim.studies.gap.report.comparison import ComparedSignal
    >>> from apesim.studies.measured import MeasuredRun
    >>> times, lift = np.linspace(0.0, 40e-3, 81), np.zeros(81)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 20e-3, "check", times, {"lift": lift})
    >>> marks = {"energise": 0.0, "release": 20e-3, "opening_start": 5e-3, "opening_contact": 12e-3}
    >>> marks |= {"closing_start": 25e-3, "closing_contact": 32e-3}
    >>> block = Block(0, run, "lift", times, lift, 5e-4)
    >>> signal = ComparedSignal(block, 3e-5, lift + 1e-4, None, lift + 3.0, None, marks)
    >>> figure = plot_overlays([signal], "ring leakage", 0.1e6)
    >>> [axis.get_ylabel() for axis in figure.axes]
    ['lift [mm]', 'model less\nmeasured\n[noise σ]']
    """
    size = (WIDTH, 0.8 + 3.0 * len(chosen))
    figure, panels = open_panels(2 * len(chosen), 1, size, height_ratios=(2.2, 1) * len(chosen))
    axes = panels[:, 0]
    shades: dict[str, None] = {}
    for above, below, signal in zip(axes[::2], axes[1::2], chosen, strict=True):
        shades |= _draw_overlay(above, below, signal, added=added, ambient_pressure=ambient_pressure)
    figure.align_ylabels()
    handles, _ = axes[0].get_legend_handles_labels()
    handles += [Patch(**_look_of(name), label=name) for name in shades]
    add_figure_legend(figure, handles)
    return figure


def _draw_overlay(
    above: Axes, below: Axes, signal: "ComparedSignal", *, added: str, ambient_pressure: float
) -> dict[str, None]:
    """Draw a trace over the models, and its residuals below; give the names of its phases."""
    block: Any = signal.block
    run, shown = block.run, find_display(block)
    x = np.degrees(block.angles) if run.bench == ENGINE else block.times * 1e3
    shades = _shade_phases(above, x, signal)
    above.plot(x, shown.convert(block.values), ".", color=MEASURED, ms=3, label="measured")
    above.plot(*break_at_gaps(x, shown.convert(signal.before)), color=BEFORE, lw=1.2, label="calibrated model")
    if signal.after is not None:
        above.plot(*break_at_gaps(x, shown.convert(signal.after)), color=AFTER, lw=1.2, ls="--", label=added)
    reference = " abs" if "pressure" in block.sensor else ""
    label_axes(above, y=(shown.name, shown.unit + reference))
    above.set_title(f"{label_point(run, ambient_pressure)}, {WORDS[signal.role]}", loc="left")
    above.tick_params(labelbottom=False)
    draw_left(below, signal, added)
    below.set_ylabel("model less\nmeasured\n[noise σ]")
    for axis in (above, below):
        axis.set_xlim(x[0], x[-1])
    return shades


def draw_left(axis: Axes, signal: "ComparedSignal", added: str) -> Axes:
    """Draw what is left of a trace over the noise, before and after something was added, and give the axes back.

    `added` says in words what was added to the model.
    """
    block: Any = signal.block
    x = np.degrees(block.angles) if block.run.bench == ENGINE else block.times * 1e3
    axis.axhspan(-NOISE_BAND, NOISE_BAND, color="0.93", lw=0, zorder=0, label="what noise alone fills")
    _draw_residuals(axis, x, (signal.before - block.values) / signal.noise, BEFORE, "calibrated model")
    if signal.after is not None:
        _draw_residuals(axis, x, (signal.after - block.values) / signal.noise, AFTER, added, "--")
    over = OVER.get(block.run.bench, ("time after the command", "ms"))
    label_axes(axis, x=over)
    return axis


def _draw_residuals(
    axis: Axes, x: np.ndarray, residuals: np.ndarray, colour: str, label: str, style: str = "-"
) -> None:
    """Draw residuals: their samples pale, their running mean strong."""
    if len(residuals) <= MEAN_SAMPLES:
        axis.plot(x, residuals, color=colour, lw=1.3, ls=style, label=label)
        return
    axis.plot(*break_at_gaps(x, residuals), color=colour, lw=0.6, alpha=0.35)
    gaps = find_gaps(x)
    for places, part in zip(np.split(x, gaps), np.split(residuals, gaps), strict=True):
        if len(part) >= MEAN_SAMPLES:
            mean = np.convolve(part, np.full(MEAN_SAMPLES, 1.0 / MEAN_SAMPLES), "valid")
            first = MEAN_SAMPLES // 2
            axis.plot(places[first : first + len(mean)], mean, color=colour, lw=1.3, ls=style, label=label)
            label = ""


def _look_of(phase: str) -> dict[str, Any]:
    """Look of the background of a phase."""
    return {"fc": SHADES[phase], "hatch": STRIPES.get(phase), "ec": "white", "lw": 0.0}


def _shade_phases(axis: Axes, x: np.ndarray, signal: "ComparedSignal") -> dict[str, None]:
    """Shade the phases of a run; returns the names of those that are shaded, in their order."""
    phase_of, used = find_phases(signal.block, signal.marks), dict[str, None]()
    for phase, samples in groupby(range(len(phase_of)), key=phase_of.__getitem__):
        inside = list(samples)
        name = PHASES[phase]
        end = x[min(inside[-1] + 1, len(x) - 1)]
        axis.axvspan(x[inside[0]], end, zorder=0, **_look_of(name))
        if SHADES[name] != UNSHADED:
            used[name] = None
    return used
