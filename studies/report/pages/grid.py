"""The page of any other study: its variables over the axes that they have, those first that are looked for first."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.drawing.spread import spread_out
from apesim.studies.report.figures.curves import Curves, Line
from apesim.studies.report.figures.labels import ONE_FRAME, Axis, Frames, find_shown_unit, shorten_name
from apesim.studies.report.figures.moving import Moving
from apesim.studies.report.grid import MAX_SAMPLES, Cubes, combine
from apesim.studies.report.machine import read_machine
from apesim.studies.report.pages.march import list_facts
from apesim.studies.report.pages.tables import list_runs
from apesim.studies.report.sections import Content, Figure, Section

MAX_MOVING = 6
"""Runs whose valve moves."""
MAX_FIGURES = 24
"""Figures of a section at most: more would not be looked at."""
NOT_DRAWN = (
    *("run", "tolerance", "steps", "status", "marches", "runs", "sketches", "warnings", "cycles", "period_cycles"),
    *("rule_fitted", "periodic_change", "cylinder_volume"),
)
"""Variables that say how a result was found, not what it is."""
NOT_DRAWN_ENDS = "_closure", "_change", "_solenoids", "_apart"
"""Ends of the names of others of them."""


class GridPage(NamedTuple):
    """What the page of a kind shows first."""

    title: str
    first: Sequence[tuple[str, ...]] = ()
    """Variables of the archive that are drawn first; those of one entry in one figure."""
    columns: Sequence[str] = ()
    """Variables of the table, behind the coordinates; those of `first` if empty."""
    labels: Mapping[str, str] = {}
    """Labels of figures of `first`, by their first variables, where the names of their variables do not say it."""
    traces: Sequence[tuple[str, ...]] = ()
    """Variables over a time or an angle."""
    is_valve: bool = False
    """Whether its traces are those of a valve on its bench, which a picture shows in motion."""
    clouds: Sequence[tuple[str, str]] = ()
    """Pairs of variables over points of a run, one drawn over the other."""


def write_grid(result: ArchiveResult, page: GridPage) -> Content:
    """Say what a study found over its grid."""
    archive, cubes = result.archive, Cubes(result.archive)
    drawn: set[str] = set()

    def draw(groups: Sequence[tuple[str, ...]]) -> list[Figure]:
        figures: list[Figure] = []
        for names in groups:
            names = tuple(name for name in names if cubes.has_numbers(name))
            drawn.update(names)
            figure = cubes.draw_together(names, as_map=True, label=page.labels.get(names[0], "")) if names else None
            figures += [figure] if figure else []
        return figures

    first, traces = draw(page.first), draw(page.traces)
    moving = [_move_valve(cubes)] if page.is_valve and traces else []
    clouds = [figure for pair in page.clouds if (figure := _draw_cloud(cubes, *pair))]
    drawn.update(name for pair in page.clouds for name in pair)
    others = [(name,) for name in archive.variables if name not in drawn and _is_result(name, cubes)]
    rest = draw(others[:MAX_FIGURES])
    sections = [
        Section(title, figures, note, is_folded=is_folded)
        for title, figures, note, is_folded in (
            ("Results", first + clouds, "", False),
            ("The valve in motion", moving, "", False),
            ("Traces", traces, "", False),
            (
                "More results" if first or traces or clouds else "Results",
                rest,
                _tell_rest(len(others)),
                bool(first or traces or clouds),
            ),
        )
        if figures
    ]
    keys = [axis.name for axis in cubes.run_axes]
    columns = page.columns or [name for names in page.first for name in names] or [name for (name,) in others]
    table = list_runs(archive, dict.fromkeys([*keys, *columns]))
    if table:
        sections.append(Section("Numbers of each point", tables=[table], is_folded=len(table.rows) > 12))
    facts = list_facts(
        result,
        [
            name
            for name in result.scalars
            if name not in ("runs", "failed_runs", "wall_time") and not name.startswith("all_")
        ][:6],
    )
    return Content(page.title, _summarise(result), facts, sections)


def _move_valve(cubes: Cubes) -> Moving:
    """Let the valve move by the traces of some runs."""
    archive, machine = cubes.archive, read_machine(cubes.archive)
    times = archive.variables["time"].values
    step = max(1, -(-len(times) // MAX_SAMPLES))
    factor, unit = find_shown_unit("s", times)
    runs = spread_out(len(archive.runs), MAX_MOVING).tolist()
    names = [name for name in ("lift", "pressure_a", "pressure_b") if name in archive.variables]
    moved: list[dict[str, np.ndarray]] = [
        {name: archive.variables[name].values[run][::step] for name in names} for run in runs
    ]
    for run, traces in zip(runs, moved, strict=True):
        traces["receiver_pressure"] = np.full(len(traces["lift"]), archive.variables["supply_pressure"].values[run])
    frames = (
        Frames("run", tuple(cubes.name_run(run) for run in runs), (len(runs) - 1) // 2) if len(runs) > 1 else ONE_FRAME
    )
    x, xs = Axis("time", unit), [times[::step] * factor]
    return Moving("The valve to scale", machine, x, xs, moved, has_engine=False, frames=frames)


def _is_result(name: str, cubes: Cubes) -> bool:
    """Whether a variable is a result that can be drawn."""
    variable = cubes.archive.variables[name]
    is_left_out = (
        name in NOT_DRAWN or name.startswith("warning_") or name.endswith(NOT_DRAWN_ENDS) or variable.coordinate
    )
    return not is_left_out and cubes.has_numbers(name) and len(cubes.axes_of(name)) > 0


def _tell_rest(count: int) -> str:
    """Say how many variables are not drawn."""
    return f"{count - MAX_FIGURES} more variables are in the archive." if count > MAX_FIGURES else ""


def _summarise(result: ArchiveResult) -> str:
    """Say in a sentence what was computed."""
    count = len(result.archive.runs)
    said = "; ".join(f"{name.replace('_', ' ')} {text}" for name, text in result.conditions.items() if name != "by")
    text = f"{count} point{'s' * (count != 1)}"
    return f"{text}: {said}." if said else f"{text}."


def _draw_cloud(cubes: Cubes, x_name: str, y_name: str) -> Curves | None:
    """Draw points of one variable over another, a line of its own for each run."""
    if not (cubes.has_numbers(x_name) and cubes.has_numbers(y_name)):
        return None
    x, y = cubes.values_of(x_name), cubes.values_of(y_name)
    count = x.shape[-1]
    labels = [combination.label or "all points" for combination in combine(cubes.run_axes)]
    rows = list(zip(labels, x.reshape(-1, count), y.reshape(-1, count), strict=True))[:8]
    lines = [Line(label, [b], [a], look, has_line=False) for look, (label, a, b) in enumerate(rows)]
    axes = [Axis(shorten_name(name).removeprefix("front "), cubes.unit_of(name)) for name in (x_name, y_name)]
    return Curves("Pareto front", axes[0], axes[1], lines, is_loop=True)
