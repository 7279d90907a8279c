"""Variables of an archive over the axes that they have: those of its grid of runs, and their own."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.grid import axes_of, words_of
from apesim.archive.records import codes_of
from apesim.studies.drawing.spread import spread_out
from apesim.studies.report.figures.curves import Curves, Line
from apesim.studies.report.figures.labels import ONE_FRAME, Axis, Frames, find_shown_unit, format_number, shorten_name
from apesim.studies.report.figures.maps import Map

MAX_LINES = 8
"""Lines of one figure: more could not be told apart."""
MAX_FRAMES = 12
"""Values among which a slider chooses."""
MAX_TRACE_FRAMES = 5
"""Values among which a slider of traces chooses: they make a page large."""
MIN_MAP = 3
"""Values that both axes of a map have at least."""
MAX_HOLES = 4
"""Points of a grid for each run, up to which runs count as a grid with holes."""
MAX_SAMPLES = 400
"""Samples of a trace that a figure shows: some two for each of its pixels; of more, every second or third one."""
MEAN = "mean"
"""Frame that is shown first where there is one."""
DENSE = 20
"""Samples from which an axis of a variable itself is the one that it is drawn over."""


class GridAxis(NamedTuple):
    """One axis of a grid, with more than one value."""

    name: str
    label: str
    unit: str
    values: np.ndarray
    """Numbers in the shown unit; codes where the axis has words."""
    texts: Sequence[str]
    """Each value with its unit, in words."""
    is_category: bool

    @property
    def axis(self) -> Axis:
        """The axis as figures take it."""
        return Axis(self.label, self.unit)


class Combination(NamedTuple):
    """One value on each of some axes."""

    label: str
    places: dict[str, int]
    look: int = 0
    """Number of colour, dash and marker: the code of a word, or the place in the list."""


@dataclass(frozen=True)
class Layout:
    """How variables over the same axes are drawn: over one or two; others have a line or a frame for each value."""

    x: GridAxis
    y: GridAxis | None
    """Second axis of a map; None: curves."""
    lines: Sequence[Combination]
    frames: Sequence[Combination]
    left_out: str = ""
    """What the figure leaves out, in words."""

    def name_lines(self) -> str:
        """Say which axis the lines stand for, where their labels are bare numbers."""
        keys = [key for line in self.lines[:1] for key in line.places]
        is_bare = len(keys) == 1 and self.lines[0].label[:1].isdigit()
        return f"Lines: {shorten_name(keys[0])}" if is_bare else ""

    @property
    def named_frames(self) -> Frames:
        """Frames as figures take them; the middle one is shown first."""
        texts = tuple(frame.label for frame in self.frames)
        keys = " and ".join(name.replace("_", " ") for name in self.frames[0].places)
        start = texts.index(MEAN) if MEAN in texts else (len(texts) - 1) // 2
        return Frames(keys, texts, start) if len(texts) > 1 else ONE_FRAME


def find_run_axes(archive: Archive) -> tuple[list[GridAxis], np.ndarray]:
    """Find the axes that span the runs of an archive, and the run (-1: none) at each point of their grid."""
    names = _list_coordinates(archive)
    axes, places = [], []
    for name in names:
        axis, place = _split_values(name, archive.variables[name])
        if len(axis.values) > 1:
            axes.append(axis)
            places.append(place)
    shape = tuple(len(axis.values) for axis in axes)
    count = len(archive.runs)
    if (not axes and count > 1) or np.prod(shape, dtype=float) > MAX_HOLES * count + 8:
        axes, places, shape = [_count_runs(archive)], [np.arange(count)], (count,)
    runs = np.full(shape, -1)
    if axes:
        runs[tuple(places)] = np.arange(count)
    else:
        runs = np.array(0 if count else -1)
    return axes, runs


def _list_coordinates(archive: Archive) -> list[str]:
    """Name the variables that say where runs lie: those of the grid first."""
    try:
        names = list(axes_of(archive))
    except ValueError:
        names = []
    flagged = [
        name for name, variable in archive.variables.items() if variable.coordinate and variable.dims == ("run",)
    ]
    return names or flagged


def _count_runs(archive: Archive) -> GridAxis:
    """Axis of the runs by their numbers, where nothing else tells them."""
    numbers = archive.runs.astype(float)
    return GridAxis("run", "run", "", numbers, [f"run {run}" for run in archive.runs.tolist()], False)


def _split_values(name: str, variable: Variable) -> tuple[GridAxis, np.ndarray]:
    """Make an axis of the different values of a variable over the runs, and find the place of each run on it."""
    values, places = np.unique(variable.values, return_inverse=True)
    return make_axis(name, variable, values), places


def make_axis(name: str, variable: Variable, values: np.ndarray) -> GridAxis:
    """Make an axis of some values of a variable."""
    label = shorten_name(name)
    if variable.meanings or variable.kind == "text":
        words = codes_of(variable.meanings) if variable.meanings else {}
        texts = [str(words.get(value, value)).replace("_", " ") for value in values.tolist()]
        numbers = values if variable.meanings else np.arange(len(values))
        return GridAxis(name, label, "", numbers.astype(float), texts, True)
    factor, unit = find_shown_unit(variable.unit, values)
    shown = values * factor
    texts = [f"{format_number(float(value))} {unit}".strip() for value in shown]
    return GridAxis(name, label, unit, shown, texts, False)


class Cubes:
    """The variables of an archive, each over the axes that it has."""

    def __init__(self, archive: Archive, words: Mapping[str, str] | None = None) -> None:
        """Lay the runs of an archive out over their axes; `words` replace those of codes."""
        self.archive = archive
        self._values: dict[str, np.ndarray] = {}
        axes, self.runs = find_run_axes(archive)
        self.run_axes = [axis._replace(texts=[(words or {}).get(text, text) for text in axis.texts]) for axis in axes]

    def name_run(self, run: int) -> str:
        """Name a run by its place on each axis."""
        places = np.argwhere(self.runs == run)[0]
        return (
            ", ".join(_name_value(axis, place) for axis, place in zip(self.run_axes, places, strict=True)) or "the run"
        )

    def axes_of(self, name: str) -> list[GridAxis]:
        """Axes of a variable with more than one value, those of the runs first."""
        variables = self.archive.variables
        own = [dim for dim in variables[name].dims[1:] if len(variables[dim].values) > 1]
        return [*self.run_axes, *(make_axis(dim, variables[dim], variables[dim].values) for dim in own)]

    def values_of(self, name: str) -> np.ndarray:
        """Numbers of a variable over `axes_of` it, in its shown unit; NaN where there is no run."""
        if name in self._values:
            return self._values[name]
        variable = self.archive.variables[name]
        factor, _ = find_shown_unit(variable.unit, variable.values)
        flat = variable.values.astype(float).reshape(len(self.archive.runs), -1) * factor
        values = np.where(self.runs.ravel()[:, None] >= 0, flat[self.runs.ravel()], np.nan)
        self._values[name] = values.reshape([len(axis.values) for axis in self.axes_of(name)])
        return self._values[name]

    def unit_of(self, name: str) -> str:
        """Shown unit of a variable."""
        variable = self.archive.variables[name]
        return find_shown_unit(variable.unit, variable.values)[1]

    def has_numbers(self, name: str) -> bool:
        """Whether a variable is there, is a number over the runs and has a finite one."""
        variable = self.archive.variables.get(name)
        if variable is None or variable.dims[:1] != ("run",) or variable.kind == "text" or variable.meanings:
            return False
        return bool(np.isfinite(variable.values.astype(float)).any())

    def lay_out(self, name: str, *, as_map: bool = True) -> Layout | None:
        """Choose how a variable is drawn; None where it has no axis of numbers."""
        return lay_out(self.axes_of(name), as_map=as_map)

    def draw(self, name: str, *, as_map: bool = True, **more: Any) -> Curves | Map | None:
        """Draw a variable over its axes; None where it has no axis of numbers or no numbers."""
        return self.draw_together([name], as_map=as_map, **more)

    def draw_together(self, names: Sequence[str], *, as_map: bool = False, **more: Any) -> Curves | Map | None:
        """Draw variables of the same axes in one figure; `more` are `range` of the y axis, and what `Curves` takes."""
        names = [name for name in names if self.has_numbers(name)]
        layout = self.lay_out(names[0], as_map=as_map and len(names) == 1) if names else None
        if layout is None:
            return None
        label = more.pop("label", "") or find_common_words([shorten_name(name) for name in names])
        shown = Axis(label, self.unit_of(names[0]), more.pop("range", None))
        notes = [_describe(names[0], self.archive.variables[names[0]]) if len(names) == 1 else "", layout.left_out]
        if layout.y is not None:
            return self._draw_map(names[0], layout, shown, notes)
        return self._draw_curves(names, layout, shown, [*notes, layout.name_lines()], more)

    def _draw_map(self, name: str, layout: Layout, shown: Axis, notes: Sequence[str]) -> Map:
        """Draw a variable over two axes."""
        assert layout.y is not None
        frames = [self._take_map(name, layout, frame) for frame in layout.frames]
        axes, values = (layout.x.axis, layout.y.axis, shown), (layout.x.values, layout.y.values, frames)
        return Map(_begin(shown.label), *axes, *values, _join(notes), layout.named_frames)

    def _draw_curves(
        self, names: Sequence[str], layout: Layout, shown: Axis, notes: Sequence[str], more: dict[str, Any]
    ) -> Curves:
        """Draw variables over an axis, a line for each of them and for each value of other axes."""
        x = layout.x.values
        step = max(1, -(-len(x) // MAX_SAMPLES))
        thinned = f"Every {_ordinal(step)} of {len(x)} samples" if step > 1 else ""
        lines: list[Line] = []
        for name in names:
            own = (
                shorten_name(name).removesuffix(shown.label).removeprefix(shown.label).strip() if len(names) > 1 else ""
            )
            for line in layout.lines:
                label = ", ".join(filter(None, [own, line.label])) or shown.label
                values = [self._take(name, layout.x, line, frame)[::step] for frame in layout.frames]
                if not any(np.isfinite(each).any() for each in values):
                    continue  # an ideal valve has no seating speed
                lines.append(Line(label, values, look=line.look if len(names) == 1 else len(lines)))
        title, note = _begin(shown.label), _join([*notes, thinned])
        return Curves(
            title, layout.x.axis, shown, lines, [x[::step]], note, frames=layout.named_frames, name=names[0], **more
        )

    def _take(self, name: str, x: GridAxis, *chosen: Combination) -> np.ndarray:
        """Numbers of a variable along an axis at chosen values of the others."""
        places = {key: place for each in chosen for key, place in each.places.items()}
        axes = self.axes_of(name)
        return self.values_of(name)[tuple(slice(None) if axis.name == x.name else places[axis.name] for axis in axes)]

    def _take_map(self, name: str, layout: Layout, frame: Combination) -> np.ndarray:
        """Numbers of a variable over the two axes of a map, (y, x)."""
        axes, free = self.axes_of(name), (layout.x.name, layout.y.name if layout.y else "")
        values = self.values_of(name)[
            tuple(slice(None) if axis.name in free else frame.places[axis.name] for axis in axes)
        ]
        order = [axis.name for axis in axes if axis.name in free]
        return values.T if order[0] == layout.x.name else values


def find_common_words(names: Sequence[str]) -> str:
    """Find the words in which all names end, or else the one that they begin with, or else the first name.

    >>> find_common_words(["fixed brake torque", "least air brake torque"])
    'brake torque'
    """
    words = [name.split() for name in names]
    count = 0
    while count < min(map(len, words)) and len({each[-1 - count] for each in words}) == 1:
        count += 1
    if count:
        return " ".join(words[0][-count:])
    return words[0][0] if len({each[0] for each in words}) == 1 else names[0]


def _begin(label: str) -> str:
    """A label with a capital, as a title."""
    return label[:1].upper() + label[1:]


def _join(notes: Iterable[str]) -> str:
    """Notes as sentences, without the last full stop."""
    return ". ".join(filter(None, notes))


def lay_out(axes: Sequence[GridAxis], *, as_map: bool = True) -> Layout | None:
    """Choose the axis along which something is drawn, and what becomes of the others."""
    numbers = [axis for axis in axes if not axis.is_category]
    if not numbers:
        return None
    x = max(numbers, key=lambda axis: (len(axis.values) > DENSE, axis.name == "speed_rpm", len(axis.values)))
    others = [axis for axis in axes if axis is not x]
    second = [axis for axis in others if not axis.is_category and len(axis.values) >= MIN_MAP]
    if as_map and second and MIN_MAP <= len(x.values) <= MAX_SAMPLES:
        y = max(second, key=lambda axis: len(axis.values))
        frames = list(combine([axis for axis in others if axis is not y]))
        shown = [frames[k] for k in spread_out(len(frames), MAX_FRAMES)]
        return Layout(x, y, [Combination("", {})], shown, _tell_left_out(len(shown), len(frames)))
    combinations = list(combine(others))
    if len(combinations) <= MAX_LINES or len(others) == 1:
        shown = [combinations[k] for k in spread_out(len(combinations), MAX_LINES)]
        return Layout(x, None, shown, [Combination("", {})], _tell_left_out(len(shown), len(combinations)))
    # Lines for the axis of words whose values can best be told apart; the others become frames.
    along = min(others, key=lambda axis: (not axis.is_category, abs(len(axis.values) - 0.5 * MAX_LINES)))
    lines, frames = list(combine([along])), list(combine([axis for axis in others if axis is not along]))
    shown_lines = [lines[k] for k in spread_out(len(lines), MAX_LINES)]
    max_frames = MAX_TRACE_FRAMES if len(x.values) > DENSE else MAX_FRAMES
    shown = [frames[k] for k in spread_out(len(frames), max_frames)]
    said = _tell_left_out(len(shown_lines) * len(shown), len(combinations))
    return Layout(x, None, shown_lines, shown, said)


def combine(axes: Sequence[GridAxis]) -> Iterator[Combination]:
    """All combinations of the values of axes, in words and by their places; one of nothing where there is none."""
    for number, places in enumerate(product(*(range(len(axis.values)) for axis in axes))):
        pairs = list(zip(axes, places, strict=True))
        texts = [_name_value(axis, place) for axis, place in pairs]
        look = int(axes[0].values[places[0]]) if len(axes) == 1 and axes[0].is_category else number
        label = axes[0].texts[places[0]] if len(axes) == 1 else ", ".join(texts)
        yield Combination(label, {axis.name: place for axis, place in pairs}, look)


def _name_value(axis: GridAxis, place: int) -> str:
    """A value of an axis in words: a word alone, or a number behind the name of its axis."""
    text = axis.texts[place]
    return text if axis.is_category or axis.label == "speed" else f"{axis.label} {text.removeprefix('run ')}"


def _tell_left_out(shown: int, count: int) -> str:
    """Say how many of the values of other axes a figure shows."""
    return f"{shown} of {count} are shown" if shown < count else ""


def _describe(name: str, variable: Variable) -> str:
    """Describe a variable as a sentence without its full stop; "" where its name says as much."""
    text = variable.description
    is_said = set(text.split()) <= {*shorten_name(name).split(), "mean"}
    if is_said:
        return ""
    return text[:1].upper() + text[1:]


def _ordinal(number: int) -> str:
    """Word for one of so many."""
    return {2: "second", 3: "third"}.get(number, f"{number}th")


def words_over_runs(archive: Archive, name: str) -> list[str]:
    """Words of a variable over the runs."""
    return [str(word).replace("_", " ") for word in words_of(archive.variables[name]).tolist()]
