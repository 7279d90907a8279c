"""Figure of torque and air flow over speed: the curve of a dynamometer, and the models."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from apesim.studies.drawing.panels import add_figure_legend, label_axes, legend_handle, open_panels
from apesim.studies.drawing.style import GREY, MARKERS, Look
from apesim.studies.gap.figures.overlays import NOISE_BAND
from apesim.studies.gap.figures.style import AFTER, BEFORE, WIDTH
from apesim.studies.gap.report.comparison import find_display
from apesim.studies.measured import FIT

if TYPE_CHECKING:
    from apesim.studies.gap.report.comparison import ComparedSignal
    from apesim.studies.gap.report.engine_curve import EngineCurve

INK = "0.1"
"""Colour of what was measured: it lies upon the lines of the models."""
KNOWN = 2.0
"""Half the width of the band of what is known of the machine, in standard deviations."""
MARGIN = 1.15
"""Half the height of the panel of what is left, over the largest of it."""
SHADE: Look = {"fc": "0.9", "lw": 0}
"""Look of the band."""
POINT: Look = {"ms": 5, "color": INK, "capsize": 2, "lw": 1.0, "zorder": 3}
"""Look of what was measured, with its error bar."""
STATED: Look = {"color": GREY, "lw": 1.0, "ls": ":"}
CALIBRATED: Look = {"color": BEFORE, "lw": 1.3}
ADDED: Look = {"color": AFTER, "lw": 1.3, "ls": "--"}
"""Looks of the lines of the three models."""


def plot_curves(curves: "Sequence[EngineCurve]", added: str) -> Figure:
    """Plot each mean over the speed with the models, and below what the models leave of it over the noise.

    `added` says in words what was added to the model.
    """
    sensors = list(dict.fromkeys(curve.sensor for curve in curves))
    size = (WIDTH if len(sensors) > 1 else 0.6 * WIDTH, 4.6)
    markers = mark_supplies(curves)
    figure, panels = open_panels(2, len(sensors), size, height_ratios=(2.4, 1), sharex=True)
    for column, sensor in enumerate(sensors):
        above, below = panels[:, column]
        own = [curve for curve in curves if curve.sensor == sensor]
        draw_curves(above, own, markers)
        above.set_xlabel("")
        _draw_left(below, own, markers)
        label_axes(below, x=("speed", "r/min"))
        below.set_ylabel("model less\nmeasured\n[noise σ]")
    figure.align_ylabels()
    add_figure_legend(figure, list_handles(curves, added), side="upper")
    return figure


def mark_supplies(curves: "Sequence[EngineCurve]") -> dict[str, str]:
    """The marker of each supply pressure, by its label: the same in all panels."""
    labels = dict.fromkeys(curve.label for curve in curves)
    return {label: MARKERS[number % len(MARKERS)] for number, label in enumerate(labels)}


def draw_curves(axis: Axes, curves: "Sequence[EngineCurve]", markers: dict[str, str]) -> Axes:
    """Draw one mean over the speed at all supply pressures, with the models, and give the axes back."""
    shown = find_display(curves[0].points[0].block)
    for curve in curves:
        marker = markers[curve.label]
        speeds = _to_rpm(curve.speeds)
        stated, spread = shown.convert(curve.stated), KNOWN * shown.convert(curve.spread)
        axis.fill_between(speeds, stated - spread, stated + spread, zorder=0, **SHADE)
        axis.plot(speeds, stated, **STATED)
        axis.plot(speeds, shown.convert(curve.before), **CALIBRATED)
        if curve.after is not None:
            axis.plot(speeds, shown.convert(curve.after), **ADDED)

        # Measured points lie upon all lines; those that nothing was fitted to are hollow.
        for point in curve.points:
            value, noise = shown.convert(point.block.values[0]), shown.convert(point.noise)
            look: Look = {"fmt": marker, "mfc": _fill(point), **POINT}
            axis.errorbar(_to_rpm(point.block.run.speed), value, yerr=NOISE_BAND * noise, **look)
    label_axes(axis, x=("speed", "r/min"), y=(shown.name, shown.unit))
    return axis


def list_handles(curves: "Sequence[EngineCurve]", added: str) -> list[Line2D | Patch]:
    """Entries of the legend of curves; the supply pressures where there are several."""
    points = [point for curve in curves for point in curve.points]
    markers = mark_supplies(curves)
    mark = {"ls": "", "marker": MARKERS[0], "ms": 5, "color": INK}
    handles: list[Line2D | Patch] = []
    for is_fitted, label in ((True, "measured, ±2σ of the noise"), (False, "not fitted")):
        chosen = [point for point in points if (point.role == FIT) == is_fitted]
        if chosen:
            handles.append(legend_handle(label=label, mfc=_fill(chosen[0]), **mark))
    if len(markers) > 1:
        handles += [legend_handle(label=label, **mark | {"marker": marker}) for label, marker in markers.items()]
    handles += [
        legend_handle(label="machine file as it is", **STATED),
        Patch(label="what is known of it, ±2σ", **SHADE),
    ]
    handles.append(legend_handle(label="calibrated model", **CALIBRATED))
    if curves[0].after is not None:
        handles.append(legend_handle(label=added, **ADDED))
    return handles


def _draw_left(axis: Axes, curves: "Sequence[EngineCurve]", markers: dict[str, str]) -> None:
    """Draw what the models leave of each mean over its noise, before and after something was added."""
    axis.axhspan(-NOISE_BAND, NOISE_BAND, color="0.93", lw=0, zorder=0)
    for curve in curves:
        marker = markers[curve.label]
        speeds = [_to_rpm(point.block.run.speed) for point in curve.points]
        before = [(point.before[0] - point.block.values[0]) / point.noise for point in curve.points]
        axis.plot(speeds, before, marker=marker, ms=4, **CALIBRATED | {"lw": 0.8})
        if curve.after is not None:
            values = [point.before if point.after is None else point.after for point in curve.points]
            after = [(value[0] - p.block.values[0]) / p.noise for value, p in zip(values, curve.points, strict=True)]
            axis.plot(speeds, after, marker=marker, ms=4, **ADDED | {"lw": 0.8})
    reach = MARGIN * max(NOISE_BAND, *map(abs, axis.dataLim.intervaly))
    axis.set_ylim(-reach, reach)


def _fill(point: "ComparedSignal") -> str:
    """Inside of a marker: hollow where nothing was fitted to the run."""
    return INK if point.role == FIT else "white"


def _to_rpm(speed: Any) -> Any:
    """Speeds [r/min] from [rad/s], one or (n,)."""
    return speed * 30.0 / np.pi
