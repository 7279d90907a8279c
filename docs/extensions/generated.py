"""Pages that the program writes itself: commands, machine file, library of effects.

Each function of PAGES returns Markdown. It is written to docs/generated/NAME.md before Sphinx reads, and a page takes
it in by an include. A name with a suffix is that of a file to download.
"""

import itertools
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import apesim
from apesim.engine.effects import ALL_EFFECTS, ENGINE_EFFECTS
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.measured.sensors import SENSORS
from apesim.valve.effects import VALVE_EFFECTS
from docs.extensions.citation import write_citation
from docs.extensions.commands import write_commands, write_common_options, write_python_names
from docs.extensions.folders import write_folders
from docs.extensions.machine_keys import write_machine, write_machine_keys
from docs.extensions.markdown import escape

HERE = Path(__file__).parent.parent / "generated"


SLOTS = {
    "adjust": "An effect of the slot `adjust` changes numbers of the machine before the march begins.",
    "law": "An effect of the slot `law` adds to the balances of force, mass and heat at every instant of the march.",
    "contact": "An effect of the slot `contact` says how fast the piston leaves a stop that it has met.",
    "volume": "An effect of the slot `volume` adds a gas volume of its own, fed through an area.",
    "tables": "A table has values at fixed nodes in place of a law. It can close a gap, and it never names one.",
    "sensor": "An effect of the slot `sensor` changes what is recorded of a run, after the march. It is an error of "
    "the measurement, no physics of the machine.",
}
"""Groups of the library: the slots, and the tables of any slot."""
NUISANCES = {effect.name for effect in ALL_EFFECTS if effect.search.is_nuisance}
"""Effects that the search knows within a prior, and never names."""


def write_effects() -> str:
    """The library of effects by slot: contents, then equation, source, signs and parameters of each."""
    tables = {effect.name for effect in ALL_EFFECTS if effect.tabulated}
    library = apesim.list_effects()
    groups: dict[str, list[Any]] = {group: [] for group in SLOTS}
    for entry in library.values():
        groups["tables" if entry.name in tables else entry.slots[0]].append(entry)
    lines = ["## Contents", "", f"The library holds {len(library)} effects.", ""]
    for group, entries in groups.items():
        for layer in ("valve", "engine"):
            names = [f"[{entry.name}](#{entry.name})" for entry in entries if entry.layer == layer]
            if names:
                lines.append(f"- **{group}, {layer}:** {', '.join(names)}")
    for group, entries in groups.items():
        lines += ["", f"## {group.capitalize()}", "", SLOTS[group]]
        for entry in entries:
            lines += ["", *_describe_effect(entry)]
    return "\n".join(lines) + "\n"


def _describe_effect(entry: Any) -> Iterator[str]:
    """Section of one effect."""
    yield f"### {entry.name}\n\nActs on the {entry.layer}. Can show on the bench {_join(entry.benches)}."
    yield from ("", "```text", *textwrap.wrap(entry.equation, 78, subsequent_indent="    "), "```", "")
    for head, text in (("Source", entry.source), ("Seen in", entry.seen_in), ("Isolated by", entry.isolated_by)):
        yield f"- **{head}:** {escape(text)}"
    yield from (
        "",
        "| parameter | unit | range | default | source of the range | in the search |",
        "|---|---|---|---|---|---|",
    )
    for names, first in _group_nodes(entry.parameters):
        cells = (names, first.unit or "–", first.range, first.default, first.source, _say_search(entry, first))
        yield f"| {' | '.join([cells[0], *map(escape, cells[1:])])} |"


def _join(names: Sequence[str]) -> str:
    """Names in a sentence: "valve, engine or cylinder"."""
    *others, last = names
    return f"{', '.join(others)} or {last}" if others else last


def _group_nodes(parameters: Iterable[Any]) -> Iterator[tuple[str, Any]]:
    """Parameters that share unit, range, default and source are nodes of one table: their names together."""
    for _, group in itertools.groupby(parameters, lambda p: (p.name.split("_at_")[0], p._replace(name=""))):
        first, *others = group
        names = f"`{first.name}`" + (f" … `{others[-1].name}` ({1 + len(others)} nodes)" if others else "")
        yield names, first


def _say_search(entry: Any, parameter: Any) -> str:
    """What `apesim gap explain` does with a parameter of an effect."""
    if entry.name in NUISANCES:
        return "calibrated within a prior"
    if f"effects.{entry.name}.{parameter.name}" in _find_fitted_keys():
        return "fitted"
    return "fitted where the library is refused" if entry.name.startswith("tabulated_") else "stays as it is"


@cache
def _find_fitted_keys() -> set[str]:
    """Keys of the parameters that the search for a missing effect fits."""
    candidates = find_candidates(apesim.Machine(), "engine", ALL_EFFECTS)
    return {parameter.key for candidate in candidates for parameter in candidate.parameters}


RUN_KEYS = {
    "data": "file with the traces, in the folder or below it",
    "name": "name of the run; repeats of one run share it; the file if left out",
    "supply": "pressure of the supply; of the control air, too, unless an engine's has its own",
    "control_supply": "pressure of the engine's control air; the machine file's, or that of the supply, if left out",
    "temperature": "temperature of the supply; the machine file's if left out",
    "pulse": "time for which the solenoids are energised",
    "speed": "speed of the engine",
    "energise": "crank angle at which the solenoids are energised",
    "release": "crank angle at which they are released, after `energise` and within one turn of it",
    "torque": "mean brake torque over the cycle, if it is measured",
    "air_flow": "mean flow of all air, control air with it, if it is measured",
    "role": "what the run is there for; `fit` if left out",
}
"""Meanings of the keys of a measured run."""


def write_measured() -> str:
    """Keys of a measured run and columns of its file, for each bench."""
    lines = []
    for bench, sensors in SENSORS.items():
        lines += ["", f"### Keys of a run of the {bench}'s bench", "", "| key | value | meaning |", "|---|---|---|"]
        for key in ("data", "name", *sensors.keys):
            value = escape(sensors.keys[key].range_text) if key in sensors.keys else "text"
            required = key in sensors.due
            lines.append(f"| `{key}`{', **required**' * required} | {value} | {RUN_KEYS[key]} |")
        lines += ["", f"### Columns of a file of the {bench}'s bench", ""]
        lines += ["| column | a head | `noise` of the sensor, as an example |", "|---|---|---|"]
        lines.append(f"| `{sensors.axis}`, **required** | `{sensors.axis} [{sensors.axis_unit}]` | – |")
        for name, unit in sensors.given.items():
            lines.append(f"| `{name}`, **required** | `{name} [{unit}]` | – |")
        for name, sensor in sensors.traces.items():
            head = f"{name} [{sensors.columns[name]}]"
            lines.append(f'| `{name}` | `{head}` | `[sensor.{name}]` `noise = "{sensor.typical}"` |')
        for name, sensor in sensors.means.items():
            lines.append(f'| – (mean `{name}`, a key) | – | `[sensor.{name}]` `noise = "{sensor.typical}"` |')
    return "\n".join(lines) + "\n"


VALVE_ORDER = (
    "In the order in which air flows: supply line, solenoids, chambers, piston, stops; then tables, and what a record "
    "passes."
)


def write_effect_laws() -> str:
    """Pages of the laws, in the order of the library."""
    lines = []
    for layer, effects, order in (("valve", VALVE_EFFECTS, VALVE_ORDER), ("engine", ENGINE_EFFECTS, "")):
        lines += [f"## Effects of the {layer}", "", order, "", "```{eval-rst}", ".. autosummary::"]
        lines += ["   :toctree: ../reference/generated", "   :nosignatures:", ""]
        lines += [f"   {effect.parameters.__module__}" for effect in effects]
        lines += ["```", ""]
    return "\n".join(lines)


PAGES: dict[str, Callable[[], str]] = {"effects": write_effects, "measured": write_measured}
PAGES |= {"commands": write_commands, "common_options": write_common_options, "python_names": write_python_names}
PAGES |= {"machine_keys": write_machine_keys, "machine.toml": write_machine, "folders": write_folders}
PAGES |= {"citation": write_citation, "effect_laws": write_effect_laws}


def write(_app: Sphinx) -> None:
    """Write what has changed."""
    HERE.mkdir(exist_ok=True)
    for name, function in PAGES.items():
        path, text = HERE / (name if "." in name else f"{name}.md"), function()
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register."""
    app.connect("builder-inited", write, priority=400)  # before autosummary, which reads one of them
    return {"parallel_read_safe": True, "parallel_write_safe": True}
