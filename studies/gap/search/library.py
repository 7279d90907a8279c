"""The library of effects, as data."""

import html
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from apesim.effect import Effect, library_for
from apesim.engine.effects import ALL_EFFECTS, library_of
from apesim.engine.machine import Machine
from apesim.engine.outside_machine import outside_effects_of
from apesim.quantities.settings import schema
from apesim.results import needed
from apesim.studies.execution.calls import arguments_of, public
from apesim.studies.gap.search.file_numbers import SUSPECTS
from apesim.studies.measured import CYLINDER, VALVE, Bench
from apesim.valve.effects import VALVE_EFFECTS, VALVE_LIBRARY
from apesim.valve.rig import shows_on_rig

if TYPE_CHECKING:
    import pandas

LAYERS = "valve", "engine"
"""Layers that have effects, in the order of the library."""


class Parameter(NamedTuple):
    """A parameter of an effect, as the library lists it."""

    name: str
    unit: str
    """Unit in the machine file; "" for a number without one."""
    range: str
    """Declared range in words."""
    strength: bool
    """Whether the effect is on where this differs from ``off``."""
    default: str
    """Default with its unit."""
    source: str
    """Source of the range."""


class EffectEntry(NamedTuple):
    """An effect as the library lists it."""

    name: str
    layer: str
    """valve or engine"""
    slots: tuple[str, ...]
    """Places in the model where it acts, see `apesim.effect`."""
    off: float
    """Strength at which it does nothing."""
    parameters: tuple[Parameter, ...]
    equation: str
    source: str
    """Source of the equation."""
    seen_in: str
    """What shows it, and what it is confused with."""
    isolated_by: str
    """The experiment that shows it by itself."""
    file: str = ""
    """Name of the file of an effect from outside."""
    benches: tuple[str, ...] = ()
    """Benches of measured data on which it can show."""
    isolated_on_rig: str = ""
    """The experiment on a cylinder moved by a drive; "": `isolated_by`."""


class EffectLibrary(Mapping[str, EffectEntry]):
    """Effects of a machine by their names, in the order of the library.

    Parameters
    ----------
    entries : iterable of EffectEntry
    """

    def __init__(self, entries: Iterable[EffectEntry]) -> None:
        self._entries = {entry.name: entry for entry in entries}

    def __getitem__(self, name: str) -> EffectEntry:
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __repr__(self) -> str:
        lines = [f"EffectLibrary: {len(self)} effects"]
        for layer in LAYERS:
            names = ", ".join(name for name, entry in self._entries.items() if entry.layer == layer)
            lines += textwrap.wrap(f"{layer}: {names}", 100, initial_indent="  ", subsequent_indent="    ")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Table for notebooks: effect, layer, parameters with their ranges, equation."""
        rows = [
            (entry.name, entry.layer, "; ".join(f"{p.name}: {p.range}" for p in entry.parameters), entry.equation)
            for entry in self.values()
        ]
        cells = "".join(f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
        head = "".join(f"<th>{name}</th>" for name in ("effect", "layer", "parameters", "equation"))
        return f"<table><thead><tr>{head}</tr></thead><tbody>{cells}</tbody></table>"

    def to_dict(self) -> dict[str, Any]:
        """Return the content of ``apesim gap effects --json``.

        Returns
        -------
        dict

        Examples
        --------
        >>> list_effects().to_dict()["effects"][0]["name"]
        'supply_droop'
        """
        effects = [
            entry._asdict() | {"parameters": [parameter._asdict() for parameter in entry.parameters]}
            for entry in self.values()
        ]
        return {"effects": effects}

    def to_pandas(self) -> "pandas.DataFrame":
        """Make a table with a row for each parameter of each effect.

        Returns
        -------
        pandas.DataFrame
            Index: effect and parameter.

        Raises
        ------
        ImportError
            pandas is not installed.

        Examples
        --------
        >>> list_effects().to_pandas().loc[("ring_leakage", "area"), "unit"]
        'mm^2'
        """
        rows = [
            {"effect": entry.name, "layer": entry.layer, "parameter": parameter.name}
            | {name: getattr(parameter, name) for name in ("unit", "range", "default", "strength")}
            | {"equation": entry.equation, "seen_in": entry.seen_in, "isolated_by": entry.isolated_by}
            for entry in self.values()
            for parameter in entry.parameters
        ]
        return needed("pandas").DataFrame(rows).set_index(["effect", "parameter"])


@public
def list_effects(machine: Machine | None = None) -> EffectLibrary:
    """List the library of effects: each with its parameters, equation, source and the experiment that isolates it.

    Parameters
    ----------
    machine : Machine, optional
        Machine whose effects from outside are listed, too.

    Returns
    -------
    EffectLibrary
        Effects by name, in the order of the library.

    Raises
    ------
    InputError
        The machine holds what no machine file could say.

    Examples
    --------
    >>> import apesim
    >>> leak = apesim.list_effects()["ring_leakage"]
    >>> leak.layer, [parameter.name for parameter in leak.parameters]
    ('valve', ['area'])
    """
    if machine is not None:
        _, machine = arguments_of("list_effects", machine)
    files = {outside.name: outside.path.name for outside in outside_effects_of(machine)} if machine else {}
    shown = {bench: select_effects(bench, machine=machine) for bench in Bench}
    return EffectLibrary(
        EffectEntry(
            effect.name,
            effect.layer or ("valve" if effect in VALVE_EFFECTS else "engine"),
            effect.slots,
            effect.off,
            tuple(list_parameters(effect)),
            effect.equation,
            effect.source,
            effect.seen_in,
            effect.isolated_by,
            files.get(effect.name, ""),
            tuple(str(bench) for bench in Bench if effect in shown[bench]),
            effect.search.isolated_on_rig,
        )
        for effect in (library_of(machine.effects) if machine else ALL_EFFECTS)
    )


def list_parameters(effect: Effect) -> Iterator[Parameter]:
    """The parameters of an effect as the library lists them, in the order in which they are declared."""
    for leaf in schema(effect.parameters):
        declared = leaf.declaration
        yield Parameter(
            leaf.key,
            getattr(declared, "unit", ""),
            declared.range_text,
            leaf.key in (effect.strengths or effect.parameters._fields[:1]),  # type: ignore[attr-defined]
            declared.render(leaf.default),
            declared.source,
        )


def select_effects(bench: str, without: Sequence[str] = (), machine: Machine | None = None) -> list[Effect]:
    """The effects that can show on a bench ("valve", "engine" or "cylinder"), those left out by name `without` them.

    A `machine` adds its effects from outside.
    """
    known = (machine or Machine()).effects
    effects = library_for(known, VALVE_LIBRARY, "valve").effects if bench in (VALVE, CYLINDER) else library_of(known)
    if bench == CYLINDER:
        effects = tuple(effect for effect in effects if shows_on_rig(effect))
    return [effect for effect in effects if effect.name not in without]


def find_faults(without: Iterable[str], machine: Machine) -> list[tuple[str, str, str]]:
    """Faults of a list of what is left out: the argument, what is wrong, what would be right.

    The effects of `machine` can be left out, ours and those from outside, and numbers that may be wrong, by their keys.
    """
    known = {effect.name for effect in library_of(getattr(machine, "effects", None))}
    known |= {suspect.key for bench in Bench for suspect in SUSPECTS[bench]}
    right = "see apesim gap effects, or give the key of a number"
    return [("without", f"{name!r} is no effect", right) for name in without if name not in known]
