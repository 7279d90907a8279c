"""The library of effects, as data."""

from collections.abc import Iterable
from typing import NamedTuple

from apesim.engine.effects import ALL_EFFECTS
from apesim.quantities.settings import schema
from apesim.studies.measured import VALVE
from apesim.valve.effects import VALVE_EFFECTS


class Parameter(NamedTuple):
    """A parameter of an effect."""

    name: str
    unit: str
    range: str
    strength: bool
    """Whether the effect is on where this differs from ``off``."""
    default: str
    source: str


class Entry(NamedTuple):
    """An effect as the library lists it."""

    name: str
    layer: str
    """valve or engine"""
    slots: tuple[str, ...]
    off: float
    """Strength at which it does nothing."""
    parameters: tuple[Parameter, ...]
    equation: str
    source: str
    seen_in: str
    isolated_by: str


def library():
    """Every effect, in the order of the library.

    Returns
    -------
    list of Entry
    """
    return [
        Entry(
            effect.name,
            "valve" if effect in VALVE_EFFECTS else "engine",
            effect.slots,
            effect.off,
            tuple(parameters_of(effect)),
            effect.equation,
            effect.source,
            effect.seen_in,
            effect.isolated_by,
        )
        for effect in ALL_EFFECTS
    ]


def parameters_of(effect):
    """Parameters of an effect, the strength first."""
    for leaf in schema(effect.parameters):
        declared = leaf.declaration
        yield Parameter(
            leaf.key,
            getattr(declared, "unit", ""),
            declared.range_text,
            leaf.key in (effect.strengths or effect.parameters._fields[:1]),
            declared.render(leaf.default),
            declared.source,
        )


def effects_on(bench, without=()):
    """The effects that can show on a bench."""
    effects = VALVE_EFFECTS if bench == VALVE else ALL_EFFECTS
    return [effect for effect in effects if effect.name not in without]


def faults_of(without: Iterable[str]) -> list[tuple[str, str, str]]:
    """Faults of a list of effects to leave out: the argument, what is wrong, what would be right."""
    known = {effect.name for effect in ALL_EFFECTS}
    return [("without", f"{name!r} is no effect", "see apesim gap effects") for name in without if name not in known]
