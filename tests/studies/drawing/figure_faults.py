"""What is wrong with a drawn figure, found by code: labels, legends, curves in grey print, texts, levels."""

import os
import re
from itertools import combinations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.contour import ContourSet
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.transforms import Bbox

from apesim.studies.drawing import files
from apesim.studies.gap.figures import files as gap_files

PURE = {"engine cylinders", "turns to start"}
"""Names of axes of pure numbers."""
TOLERANCE = 1.5
"""Pixels by which texts may overlap or stand out: boxes of texts are wider than their ink."""
NUMBER = re.compile(r"[-\N{MINUS SIGN}]?[\d.]+")


def watch_figures(monkeypatch, told=None):
    """Faults of each figure that is written from now on, by its name; it is laid out, and rendered into no file.

    The conditions of each are kept in ``told``.
    """
    found, save = {}, files.save

    def watched(figure, folder, name, conditions=""):
        paths = save(figure, folder, name, conditions)
        found[name] = faults_of(figure)
        if told is not None:
            told[name] = conditions
        return paths

    for module in (files, gap_files):
        monkeypatch.setattr(module, "save", watched)
    monkeypatch.setattr(files, "LEFT_OUT", {})
    monkeypatch.setattr(os, "cpu_count", lambda: 1)  # figures that another process draws would be lost
    return found


def faults_of(figure):
    """Faults of a figure that is laid out, a text each."""
    figure.draw_without_rendering()
    visible = [axis for axis in figure.axes if axis.get_visible() and axis.axison]
    return [
        *(fault for axis in visible for fault in _unlabelled(axis)),
        *(fault for axis in figure.axes for fault in _alike(_labelled_lines(axis))),
        *_alike_in_legends(figure),
        *_legends_in_the_way(figure),
        *_texts_in_the_way(figure),
        *(fault for axis in visible for fault in _odd_levels(axis)),
    ]


# --- names of axes ---


def _unlabelled(axis):
    if axis.name == "polar":
        return
    for letter, each in (("x", axis.xaxis), ("y", axis.yaxis)):
        shown = _shown_ticks(each)
        if not any(NUMBER.fullmatch(label.get_text()) for label in shown):
            continue  # words, or an axis that shares the ticks of another
        joined = axis.get_shared_x_axes() if letter == "x" else axis.get_shared_y_axes()
        names = {getattr(other, f"get_{letter}label")() for other in (axis, *joined.get_siblings(axis))} - {""}
        if not any("[" in name or name in PURE for name in names):
            yield f"{letter} axis {sorted(names)} without a unit"


def _shown_ticks(axis):
    """Labels of an axis that are drawn."""
    low, high = sorted(axis.get_view_interval())
    slack = 1e-9 * (high - low)
    ticks = [tick for tick in axis.get_major_ticks() if low - slack <= tick.get_loc() <= high + slack]
    labels = [label for tick in ticks for label in (tick.label1, tick.label2)]
    return [label for label in labels if label.get_visible() and label.get_text()] if axis.get_visible() else []


# --- curves in grey print ---


def _labelled_lines(axis):
    lines = axis.get_legend_handles_labels()[0]
    return [line for line in lines if isinstance(line, Line2D)]


def _alike_in_legends(figure):
    for legend in _legends(figure):
        lines = [handle for handle in legend.legend_handles if isinstance(handle, Line2D)]
        yield from _alike(lines)


def _alike(lines):
    for one, other in combinations(lines, 2):
        if _grey_look(one) == _grey_look(other) and not _same_colour(one, other):
            yield f"{one.get_label()!r} and {other.get_label()!r} differ in colour alone"


def _grey_look(line):
    dashes = line._unscaled_dash_pattern if line.get_linestyle() != "None" else None
    has_marker = line.get_marker() not in ("None", "", None)
    is_hollow = has_marker and (line.get_fillstyle() == "none" or _is_white(line.get_markerfacecolor()))
    return str(dashes), str(line.get_marker()) if has_marker else "", is_hollow


def _is_white(colour):
    red, green, blue, opacity = to_rgba(colour)
    return opacity == 0.0 or red == green == blue == 1.0


def _same_colour(one, other):
    return np.allclose(to_rgba(one.get_color()), to_rgba(other.get_color()))


# --- legends ---


def _legends(figure):
    return [*figure.legends, *(axis.get_legend() for axis in figure.axes if axis.get_legend())]


def _room(figure):
    """The figure, with the conditions below it."""
    below = [text.get_window_extent() for text in figure.texts if text.get_position()[1] == 0.0]
    return Bbox.union([figure.bbox, *(Bbox([[0.0, box.y0], [1.0, 0.0]]) for box in below)])


def _legends_in_the_way(figure):
    room = _room(figure).padded(TOLERANCE)
    for legend in _legends(figure):
        box = legend.get_window_extent()
        if not (room.contains(box.x0, box.y0) and room.contains(box.x1, box.y1)):
            yield f"legend {_named(legend)} cut"
        for axis in figure.axes:
            for what in _data_within(axis, box):
                yield f"legend {_named(legend)} upon {what}"


def _named(legend):
    return [text.get_text() for text in legend.get_texts()][:2]


def _data_within(axis, box):
    """What is drawn in a box."""
    if not axis.get_visible():
        return
    inside = Bbox.intersection(box, axis.get_window_extent())
    if inside is None or inside.width <= 0.0 or inside.height <= 0.0:
        return
    for line in axis.lines:
        path = line.get_transform().transform_path(line.get_path()).cleaned(remove_nans=True, curves=False)
        points = np.asarray(path.vertices)[:-1]
        has_line = line.get_linestyle() != "None" and len(points) > 1
        if len(points) and (inside.count_contains(points) or (has_line and path.intersects_bbox(inside, False))):
            yield f"line {line.get_label()!r}"
    for collection in axis.collections:
        if isinstance(collection, LineCollection):
            paths = (collection.get_transform().transform_path(path) for path in collection.get_paths())
            if any(path.intersects_bbox(inside, False) for path in paths):
                yield "bars"
    for patch in axis.patches:
        extent = patch.get_window_extent()
        is_band = extent.height >= 0.99 * axis.bbox.height or extent.width >= 0.99 * axis.bbox.width
        if isinstance(patch, Rectangle) and not is_band and extent.overlaps(inside):
            yield "a bar"


# --- texts ---


def _texts(figure):
    """All texts that are drawn, with what they are."""
    for text in figure.texts:
        yield "text", text
    for name in ("_suptitle",):
        if getattr(figure, name, None) is not None:
            yield "title", getattr(figure, name)
    for legend in _legends(figure):
        yield from (("legend", text) for text in (*legend.get_texts(), legend.get_title()))
    for axis in figure.axes:
        if not axis.get_visible():
            continue
        yield from (("title", text) for text in (axis.title, axis._left_title, axis._right_title))
        yield from (("text", text) for text in axis.texts)
        if axis.axison:
            for each in (axis.xaxis, axis.yaxis):
                yield "name", each.label
                yield from (("tick", label) for label in _shown_ticks(each))
        for child in axis.child_axes:
            yield "name", child.yaxis.label
            yield from (("tick", label) for label in _shown_ticks(child.yaxis))


def _texts_in_the_way(figure):
    seen, boxes = set(), []
    for kind, text in _texts(figure):
        if id(text) not in seen and text.get_visible() and text.get_text().strip():
            seen.add(id(text))
            boxes.append((kind, text, text.get_window_extent()))
    room = _room(figure).padded(TOLERANCE)
    for kind, text, box in boxes:
        if not (room.contains(box.x0, box.y0) and room.contains(box.x1, box.y1)):
            yield f"{kind} {text.get_text()!r} cut"
    for (kind, one, box), (_, other, other_box) in combinations(boxes, 2):
        is_slanted = any(text.get_rotation() % 90.0 for text in (one, other))  # boxes overlap where texts do not
        if not is_slanted and _overlap(box, other_box):
            yield f"{kind} {one.get_text()!r} upon {other.get_text()!r}"


def _overlap(box, other):
    both = Bbox.intersection(box, other)
    return both is not None and both.width > TOLERANCE and both.height > TOLERANCE


# --- levels ---


def _odd_levels(axis):
    if axis.get_label() == "<colorbar>" and not (axis.get_ylabel() or axis.get_xlabel()):
        yield "colour bar without a name"
    for lines in (each for each in axis.collections if isinstance(each, ContourSet) and not each.filled):
        steps = np.unique(np.diff(lines.levels).round(9))
        if any(f"{step:.6e}"[0] not in "125" or float(f"{step:.0e}") != float(f"{step:.6e}") for step in steps):
            yield f"levels by {steps}"
        for text in lines.labelTexts:
            if not np.isclose(lines.levels, float(text.get_text()), rtol=1e-9, atol=1e-12).any():
                yield f"level {text.get_text()} is no level"
