"""The library of effects, as data."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from apesim.effect import Effect, library_for
from apesim.engine.effects import ALL_EFFECTS, library_of
from apesim.engine.machine import Machine
from apesim.engine.outside_machine import outside_effects_of
from apesim.quantities.settings import schema
from apesim.studies.measured import VALVE
from apesim.valve.effects import VALVE_EFFECTS, VALVE_LIBRARY


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


class Entry(NamedTuple):
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


def list_library(machine: Machine | None = None) -> list[Entry]:
    """The library of effects as data: every effect with its parameters, equation and source.

    Parameters
    ----------
    machine : Machine, optional
        Machine whose effects from outside are listed, too.

    Returns
    -------
    list of Entry
        In the order of the library.

    Examples
    --------
    >>> entry = next(entry for entry in list_library() if entry.name == "ring_leakage")
    >>> entry.layer, [parameter.name for parameter in entry.parameters]
    ('valve', ['area'])
    """
    files = {outside.name: outside.path.name for outside in outside_effects_of(machine)} if machine else {}
    return [
        Entry(
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
        )
        for effect in (library_of(machine.effects) if machine else ALL_EFFECTS)
    ]


def list_parameters(effect: Effect) -> Iterator[Parameter]:
    """The parameters of an effect as the library lists them, in the order in which they are declared.

    Parameters
    ----------
    effect : apesim.effect.Effect

    Yields
    ------
    Parameter

    Examples
    --------
    >>> from apesim.valve.effects import coulomb_friction
    >>> [(parameter.name, parameter.unit, parameter.strength) for parameter in list_parameters(coulomb_friction.EFFECT)]
    [('force', 'N', True), ('breakaway', 'N', True)]
    """
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
    """The effects that can show on a bench.

    Parameters
    ----------
    bench : {"valve", "engine"}
    without : sequence of str
        Names of effects that are left out.
    machine : Machine, optional
        Machine whose effects from outside are among them.

    Returns
    -------
    list of apesim.effect.Effect

    Examples
    --------
    >>> "blow_by" in [effect.name for effect in select_effects("valve")]
    False
    """
    known = (machine or Machine()).effects
    effects = library_for(known, VALVE_LIBRARY, "valve").effects if bench == VALVE else library_of(known)
    return [effect for effect in effects if effect.name not in without]


def find_faults(without: Iterable[str], machine: Machine) -> list[tuple[str, str, str]]:
    """Faults of a list of effects to leave out: the argument, what is wrong, what would be right.

    Parameters
    ----------
    without : iterable of str
    machine : Machine
        Machine whose effects, ours and those from outside, can be left out.

    Returns
    -------
    list of tuple of str

    Examples
    --------
    >>> find_faults(["blow_by", "magic"], Machine())
    [('without', "'magic' is no effect", 'see apesim gap effects')]
    """
    known = {effect.name for effect in library_of(getattr(machine, "effects", None))}
    return [("without", f"{name!r} is no effect", "see apesim gap effects") for name in without if name not in known]
