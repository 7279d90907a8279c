"""The page of a sweep: over the speed, around the cycle, and where the exergy goes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from apesim.archive import Archive
from apesim.archive.grid import axes_of, places_of
from apesim.engine.cylinder import INTAKES
from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.drawing.cycle_order import order_of_cycle
from apesim.studies.drawing.spread import spread_out
from apesim.studies.report.figures.curves import Curves
from apesim.studies.report.figures.labels import Axis, Frames, find_shown_unit, format_number, shorten_name
from apesim.studies.report.figures.moving import Moving
from apesim.studies.report.grid import MAX_SAMPLES, Cubes, words_over_runs
from apesim.studies.report.machine import read_machine
from apesim.studies.report.pages.cycle import CycleLine, draw_cycle
from apesim.studies.report.pages.ledger import describe_ledger
from apesim.studies.report.pages.tables import list_runs
from apesim.studies.report.sections import Content, Fact, Figure, Section, Table

NAMES = {"epv": "EPV, fixed", "epv corrected": "EPV, corrected", "cam": "cam", "ideal": "ideal valve"}
"""Names of actuations."""
LOOKS = {"epv": 0, "epv corrected": 1, "cam": 2, "ideal": 3}
"""Number of colour, dash and marker of each actuation."""
MAX_SPECIFIC_AIR = 150.0
"""Upper end of axes of specific air [kg/kWh]: it grows without bound as the work goes to zero."""
OVER_SPEED = (
    "brake_torque_Nm",
    "specific_air_kg_per_kWh",
    "brake_power_W",
    "exergy_efficiency",
    "air_L_per_min_ANR",
    "valve_open_deg",
    "valve_close_deg",
    "closing_seating_speed_m_s",
)
"""Variables that are drawn at once."""
MORE = (
    "indicated_torque_Nm",
    "engine_air_kg_per_cycle",
    "control_air_kg_per_cycle",
    "peak_lift_m",
    "opening_seating_speed_m_s",
    "fluctuation",
    "energise_deg",
    "release_deg",
    "peak_cylinder_pressure_Pa",
    "lowest_cylinder_temperature_K",
    "exhaust_temperature_K",
    "isothermal_efficiency",
)
"""Variables that are drawn below, folded."""
COMPARED = (
    *("brake_torque_Nm", "brake_power_W", "specific_air_kg_per_kWh", "air_L_per_min_ANR", "exergy_efficiency"),
    *("valve_open_deg", "valve_close_deg"),
)
"""Variables of the table that compares actuations at one speed."""
BEST = (
    ("brake_torque_Nm", "highest brake torque", True),
    ("brake_power_W", "highest brake power", True),
    ("specific_air_kg_per_kWh", "least air over brake work", False),
    ("exergy_efficiency", "highest exergy efficiency", True),
)
"""Headline numbers: variable, label, and whether the highest is meant."""
MAPPED = "brake_torque_Nm", "specific_air_kg_per_kWh"
"""Variables that are drawn as maps where a key was varied, too."""
TRACES = (
    *("cylinder_pressure", "cylinder_temperature", "cylinder_volume", "lift", "pressure_a", "pressure_b"),
    *("groove_flow", "torque", "receiver_pressure"),
)
"""Traces that the page shows."""
MAX_CYCLES = 5
"""Speeds whose cycles are shown."""
INCOMPLETE = "warning_opens_partly"
"""Variable that tells in which runs the valve does not open fully."""
USUAL_SPEED = 1000.0
"""Speed about which numbers are told first [r/min]."""


def write_sweep(result: ArchiveResult) -> Content:
    """Say what a sweep found."""
    archive, cubes = (
        result.archive,
        Cubes(result.archive, {name.replace("_", " "): text for name, text in NAMES.items()}),
    )
    runs = choose_runs(archive)
    sections = [_compare(archive, runs), _draw_over_speed(cubes)]
    if any(axis.name not in ("actuation", "speed_rpm") and not axis.is_category for axis in cubes.run_axes):
        maps = [figure for name in MAPPED if (figure := cubes.draw(name))]
        sections.append(_section_of("Maps", maps))
    sections.append(_draw_cycles(archive))
    ledger = describe_ledger(archive, [(NAMES.get(name, name), run) for name, run in runs], _say_where(archive, runs))
    sections.append(ledger)
    more = [figure for name in MORE if (figure := cubes.draw(name, as_map=False))]
    sections.append(_section_of("More over the speed", more, is_folded=True))
    columns = ("actuation", "speed_rpm", *OVER_SPEED)
    table = list_runs(archive, columns)
    sections.append(Section("All runs", tables=[table], is_folded=True) if table else None)
    return Content(_name_page(cubes), _summarise(cubes), _list_facts(cubes), [each for each in sections if each])


def _name_page(cubes: Cubes) -> str:
    """Title of the page: what was swept."""
    axes = {axis.name: axis for axis in cubes.run_axes}
    keys = [axis.label for name, axis in axes.items() if name not in ("actuation", "speed_rpm")]
    speed = axes.get("speed_rpm")
    one = cubes.archive.variables["speed_rpm"].values[0]
    span = f"from {speed.values[0]:.5g} to {speed.values[-1]:.5g} r/min" if speed else f"at {one:.5g} r/min"
    actuations = sorted(set(words_over_runs(cubes.archive, "actuation")))
    intake = f": {NAMES.get(actuations[0], actuations[0])}" if len(actuations) == 1 else ""
    return f"The engine {span}{intake}" + (f", over {' and '.join(keys)}" if keys else "")


def _compare(archive: Archive, runs: list[tuple[str, int]]) -> Section:
    """Compare the actuations at the usual speed in a table."""
    names = [name for name in COMPARED if name in archive.variables]
    shown = [(find_shown_unit(archive.variables[name].unit), archive.variables[name].values) for name in names]
    units = [f" [{unit}]" if unit else "" for (_, unit), _ in shown]
    head = ("intake", *(shorten_name(name) + unit for name, unit in zip(names, units, strict=True)))
    rows = [
        (NAMES.get(name, name), *(format_number(float(values[run]) * factor) for (factor, _), values in shown))
        for name, run in runs
    ]
    return Section(f"At {_say_where(archive, runs)}", tables=[Table("", head, rows)])


def choose_runs(archive: Archive) -> list[tuple[str, int]]:
    """For each actuation, its run nearest to the usual speed; on other axes in the middle."""
    texts, places = axes_of(archive), places_of(archive)
    chosen = np.ones(len(archive.runs), dtype=bool)
    for (name, values), place in zip(texts.items(), places, strict=True):
        if name not in ("actuation", "speed_rpm"):
            chosen &= place == (len(values) - 1) // 2
    speeds = archive.variables["speed_rpm"].values
    rows = []
    for number, name in enumerate(texts["actuation"]):
        own = np.flatnonzero(chosen & (places[0] == number))
        if own.size:
            rows.append((name, int(own[np.abs(speeds[own] - USUAL_SPEED).argmin()])))
    return rows


def _say_where(archive: Archive, runs: list[tuple[str, int]]) -> str:
    """Speed and keys at which the numbers of some runs hold, in words."""
    _, run = runs[0]
    keys = [name for name in axes_of(archive) if name not in ("actuation", "speed_rpm")]
    speed = f"{archive.variables['speed_rpm'].values[run]:.5g} r/min"
    texts, places = axes_of(archive), dict(zip(axes_of(archive), places_of(archive), strict=True))
    return ", ".join([speed, *(f"{name.replace('_', ' ')} {texts[name][places[name][run]]}" for name in keys)])


def _summarise(cubes: Cubes) -> str:
    """Say in a sentence or two what the sweep covers and what stands out."""
    archive = cubes.archive
    torque, air = (_of_real_valves(archive, name) for name in MAPPED)
    speeds = archive.variables["speed_rpm"].values
    span = (
        f"{speeds.min():.5g} to {speeds.max():.5g} r/min" if speeds.min() < speeds.max() else f"{speeds[0]:.5g} r/min"
    )
    parts = [f"{len(speeds)} operating points, each at its periodic steady state, at {span}."]
    if np.isfinite(torque).any():
        best = int(np.nanargmax(torque))
        parts.append(f"The highest brake torque is {format_number(torque[best])} N·m ({cubes.name_run(best)})")
        good = np.where((torque > 0.0) & (air > 0.0), air, np.nan)
        if np.isfinite(good).any():
            least = int(np.nanargmin(good))
            parts[-1] += (
                f"; the least air for the work is {format_number(good[least])} kg/kWh ({cubes.name_run(least)})"
            )
        parts[-1] += "."
    return " ".join(parts)


def _of_real_valves(archive: Archive, name: str) -> np.ndarray:
    """Values of a variable over the runs, NaN for the ideal valve: nobody can build one, unless it is all there is."""
    is_ideal = np.array(words_over_runs(archive, "actuation")) == "ideal"
    values = archive.variables[name].values
    return values if is_ideal.all() else np.where(is_ideal, np.nan, values)


def _list_facts(cubes: Cubes) -> list[Fact]:
    """Best numbers of all runs, each with where it was found."""
    archive, torque = cubes.archive, cubes.archive.variables["brake_torque_Nm"].values
    facts = []
    for key, label, is_high in BEST:
        variable = archive.variables[key]
        values = np.where(torque > 0.0, _of_real_valves(archive, key), np.nan)
        if np.isfinite(values).any():
            run = int(np.nanargmax(values) if is_high else np.nanargmin(values))
            factor, unit = find_shown_unit(variable.unit)
            facts.append(Fact(format_number(float(values[run]) * factor), unit, f"{label}: {cubes.name_run(run)}"))
    return facts


def _draw_over_speed(cubes: Cubes) -> Section | None:
    """Draw what is asked for first over the speed."""
    figures = []
    for name in OVER_SPEED:
        values = cubes.archive.variables[name].values if name in cubes.archive.variables else np.empty(0)
        is_unbound = name == "specific_air_kg_per_kWh" and np.nanmax(values, initial=0.0) > MAX_SPECIFIC_AIR
        shown = (0.8 * float(np.nanmin(values)), MAX_SPECIFIC_AIR) if is_unbound else None
        figure = cubes.draw(name, as_map=False, range=shown)
        if is_unbound and isinstance(figure, Curves):
            figure = replace(figure, note=f"{figure.note}. More than {MAX_SPECIFIC_AIR:g} kg/kWh is not drawn")
        figures.append(figure)
    return _section_of("Over the speed", [each for each in figures if each], _say_incomplete(cubes.archive))


def _say_incomplete(archive: Archive) -> str:
    """Say at which speeds the valve does not open fully, for each actuation; nothing where it always does."""
    if INCOMPLETE not in archive.variables:
        return ""
    is_partly = archive.variables[INCOMPLETE].values > 0
    actuations = np.array(words_over_runs(archive, "actuation"))
    parts = []
    for name in dict.fromkeys(actuations[is_partly]):
        speeds = np.unique(archive.variables["speed_rpm"].values[is_partly & (actuations == name)])
        span = f"{speeds[0]:.5g}" if len(speeds) == 1 else f"{speeds[0]:.5g} to {speeds[-1]:.5g}"
        parts.append(f"{NAMES.get(name, name)} at {span} r/min")
    return f"The valve does not open fully: {'; '.join(parts)}." if parts else ""


def _section_of(title: str, figures: Sequence[Figure], note: str = "", *, is_folded: bool = False) -> Section | None:
    """Make a section of figures; None where there are none."""
    return Section(title, figures, note, is_folded=is_folded) if figures else None


def choose_cycles(archive: Archive) -> tuple[dict[str, dict[float, int]], list[float]]:
    """Choose the cycles that a page shows: runs by actuation and speed [r/min], and the speeds that all have.

    On other axes they are in the middle.
    """
    texts, places = axes_of(archive), dict(zip(axes_of(archive), places_of(archive), strict=True))
    middle = np.ones(len(archive.runs), dtype=bool)
    for name, values in texts.items():
        if name not in ("actuation", "speed_rpm"):
            middle &= places[name] == (len(values) - 1) // 2
    speeds = archive.variables["speed_rpm"].values
    runs: dict[str, dict[float, int]] = {}
    for number, name in enumerate(texts["actuation"]):
        own = np.flatnonzero(middle & (places["actuation"] == number))
        if own.size:
            runs[name] = {float(speeds[run]): int(run) for run in own}
    return runs, sorted(set.intersection(*map(set, runs.values()))) if runs else []


def _draw_cycles(archive: Archive) -> Section | None:
    """Draw the cycles of some speeds, with all actuations in one figure."""
    runs, common = choose_cycles(archive)
    if "crank_angle" not in archive.variables or not common:
        return None
    speeds = [common[k] for k in spread_out(len(common), MAX_CYCLES)]
    order, angles = order_of_cycle(archive.variables["crank_angle"].values)
    step = max(1, -(-len(angles) // MAX_SAMPLES))
    names = [name for name in TRACES if name in archive.variables]
    lines = {
        name: CycleLine(
            NAMES.get(name, name),
            LOOKS.get(name, number),
            [
                {trace: _trace_of(archive, trace, own[speed], name)[order][::step] for trace in names}
                for speed in speeds
            ],
        )
        for number, (name, own) in enumerate(runs.items())
    }
    start = int(np.abs(np.array(speeds) - USUAL_SPEED).argmin())
    frames = Frames("speed", tuple(f"{speed:.5g} r/min" for speed in speeds), start)
    x, xs = Axis("crank angle", "deg"), [angles[::step]]
    figures = draw_cycle(archive, read_machine(archive), x, xs, list(lines.values()), frames)

    # What is shown, and what is not.
    said = [f"cycles of {len(speeds)} of {len(common)} speeds"] if len(speeds) < len(common) else []
    said += [f"every {'second' if step == 2 else f'{step}th'} of {len(angles)} samples"] * (step > 1)
    said += ["the first cylinder"] * ("cylinder" in archive.variables)
    note = f"Shown: {', '.join(said)}; the archive holds all. " if said else ""
    moving = _move_machine(archive, lines, x, xs, frames)
    return Section("Around the cycle", [moving, *figures], f"{note}Crank angle 0 is top dead centre.")


def _move_machine(
    archive: Archive, lines: dict[str, CycleLine], x: Axis, xs: list[np.ndarray], frames: Frames
) -> Moving:
    """Let the machine move by the cycles of one actuation: the EPV with corrected timing, else the first of them."""
    name = "epv corrected" if "epv corrected" in lines else next(iter(lines))
    machine = read_machine(archive)
    intake = INTAKES.index(name.removesuffix(" corrected"))
    machine = machine._replace(engine=machine.engine._replace(intake=intake))
    title = f"Engine and valve to scale: {lines[name].label}"
    note = "Pressures by their colour. Play, or move the slider: the cursors of the figures below move along"
    line = list(lines).index(name)
    return Moving(title, machine, x, xs, lines[name].traces, line=line, note=note, frames=frames)


def _trace_of(archive: Archive, name: str, run: int, actuation: str) -> np.ndarray:
    """A trace of a run; NaN for chambers of an intake that has none."""
    values = archive.variables[name].values[run]
    has_chambers = actuation.startswith("epv") or name not in ("pressure_a", "pressure_b")
    return values if has_chambers else np.full_like(values, np.nan)
