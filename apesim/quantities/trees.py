"""Trees: parameter classes in one another, and all their keys.

A parameter class is a `NamedTuple` whose fields are declared with `apesim.quantities`, or are parameter classes
themselves: the sections. A section that a file names starts from the defaults of its own class; one that is left out is
as the class above has it. A method ``faults`` may yield ``(key, what is wrong, what would be right)`` for what only
several keys together show. A method ``overruled`` may yield ``(key or section, by what)`` for what is ignored; where
that begins with a dot, it is a key of the same section. A method ``spellings`` of the class may give other ways to
write a key, each a `Spelling` by its name: what is read and printed is the key alone.

A class attribute ``due`` makes sections optional: to be present switches them on. It names, for each of these
sections, the keys of which at least one must be given in it::

    Effects.due = {"bounce": ("restitution",), "cylinder_wall_heat": ("h", "factor")}
"""

import typing
from collections.abc import Callable, Container, Iterator
from functools import lru_cache
from math import isfinite
from operator import attrgetter
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from apesim.quantities.declarations import AbsolutePressure, Declaration

Tree = TypeVar("Tree", bound=Any)
Function = TypeVar("Function", bound=Callable[..., Any])


def once_a_class(function: Function) -> Function:
    """Let a function of a parameter class, which never changes, compute once for each.

    It takes the class first. Nobody may change what it returns.
    """
    return cast(Function, lru_cache(maxsize=2048)(function))


class Leaf(NamedTuple):
    """One key of a tree."""

    key: str
    """Key with dots, e.g. "valve.solenoid.dead_time"."""
    declaration: Any
    default: Any


class Spelling(NamedTuple):
    """Another way to write a key: a quantity that the key's value follows from."""

    key: str
    """Key of the same section; from `spellings` the full one."""
    declaration: Any
    convert: Callable[[float], float]
    """Function from the quantity to the key's value, both in SI."""


@once_a_class
def fields(cls: Any) -> dict[str, Any]:
    """Return what each field of a parameter class is declared to be: a declaration, or a parameter class.

    Raises TypeError where a field has no declaration or no default.
    """
    found, defaults = {}, cls._field_defaults
    # A NamedTuple made by a call gets defaults through __new__ only; pydantic looks for them here.
    defaults.update(zip(cls._fields[::-1], (cls.__new__.__defaults__ or ())[::-1], strict=False))
    for key, hint in typing.get_type_hints(cls, include_extras=True).items():
        declared = [meta for meta in getattr(hint, "__metadata__", ()) if isinstance(meta, Declaration)]
        if not (declared or hasattr(hint, "_fields")) or key not in defaults:
            raise TypeError(f"{cls.__name__}.{key} needs a declaration and a default")
        found[key] = declared[0] if declared else hint
    return found


def is_section(field: Any) -> bool:
    """Return whether a field, a value of `fields` or None, is a parameter class."""
    return isinstance(field, type)


def due(cls: Any) -> dict[str, tuple[str, ...]]:
    """Return the keys of which at least one must be given, by optional section of a parameter class.

    Raises TypeError where the class attribute ``due`` names what is no key of a section.
    """
    sections = getattr(cls, "due", {})
    for section, keys in sections.items():
        field = fields(cls).get(section)
        inner = fields(field) if is_section(field) else {}
        if not keys or any(is_section(inner.get(key, dict)) for key in keys):
            raise TypeError(f"{cls.__name__}.due: {keys!r} are no keys of a section {section!r}")
    return sections


def joined(*keys: str) -> str:
    """Return a key of several parts, with dots between them but before a bracket; empty parts are left out.

    >>> joined("cylinder", "[2]", "valve.stroke")
    'cylinder[2].valve.stroke'
    """
    return ".".join(filter(None, keys)).replace(".[", "[")


@once_a_class
def leaves_of(cls: Any) -> dict[str, Leaf]:
    """Return every key of a tree with the defaults of its classes, see `schema`; nobody may change what is returned."""
    return {leaf.key: leaf for leaf in schema(cls)}


@once_a_class
def sections_of(cls: Any) -> frozenset[str]:
    """Return the keys of all sections of a tree, those in other sections among them."""
    found = set()
    for key in _sections_of(cls):
        found |= {key, *(joined(key, inner) for inner in sections_of(fields(cls)[key]))}
    return frozenset(found)


@once_a_class
def spellings(cls: Any, section: str = "") -> dict[str, Spelling]:
    """Return the other spellings of the keys of a tree, by the full key that is written instead.

    `section` is set before the keys. Nobody may change what is returned.
    """
    found = {
        joined(section, name): spelling._replace(key=joined(section, spelling.key))
        for name, spelling in getattr(cls, "spellings", dict)().items()
    }
    for key, field in fields(cls).items():
        if is_section(field):
            found |= spellings(field, joined(section, key))
    return found


def _sections_with(tree: Any, method: str) -> Iterator[str]:
    """Names of the sections of a tree that have a method, or have a section below them that has it."""
    for key in _sections_of(type(tree)):
        if _has_below(type(getattr(tree, key)), method):
            yield key


@once_a_class
def _sections_of(cls: Any) -> tuple[str, ...]:
    """Names of the fields of a parameter class that are sections."""
    return tuple(key for key, field in fields(cls).items() if is_section(field))


@once_a_class
def _has_below(cls: Any, method: str) -> bool:
    """Whether a parameter class has a method, or one of its sections has it: most have none to ask."""
    return hasattr(cls, method) or any(_has_below(fields(cls)[key], method) for key in _sections_of(cls))


def faults(tree: Any, section: str = "") -> Iterator[tuple[str, str, str]]:
    """Find what the ``faults`` methods of a tree say: full key, what is wrong, and what would be right.

    `section` is set before the keys.
    """
    for key in _sections_with(tree, "faults"):
        yield from faults(getattr(tree, key), joined(section, key))
    for key, wrong, right in getattr(tree, "faults", tuple)():
        yield joined(section, key), wrong, right


def overruled(tree: Any, section: str = "") -> Iterator[tuple[str, str]]:
    """Find the keys that are not used because of others, from the ``overruled`` methods of a tree.

    Yields the full key, with `section` before it, and what is used in its place.
    """
    for key in _sections_with(tree, "overruled"):
        yield from overruled(getattr(tree, key), joined(section, key))
    for key, reason in getattr(tree, "overruled", tuple)():
        field, path = fields(type(tree))[key], joined(section, key)
        inner = [leaf.key for leaf in schema(field, section=path)] if is_section(field) else [path]
        why = f"{section}{reason}" if reason.startswith(".") else reason
        yield from ((leaf, why) for leaf in inner)


def schema(cls: Any, default: Any = None, section: str = "") -> Iterator[Leaf]:
    """List every key of a tree of parameter classes, with its declaration and its default.

    Defaults are taken from the instance `default`, if it is given, else from the classes; `section` is set before the
    keys.
    """
    default = cls() if default is None else default
    for key, field in fields(cls).items():
        if is_section(field):
            yield from schema(field, getattr(default, key), joined(section, key))
        else:
            yield Leaf(joined(section, key), field, getattr(default, key))


def ambient_of(tree: Any) -> float | None:
    """Find ``ambient.pressure`` [Pa abs], which the gauge pressures of a tree stand above; None where it has none.

    A class stands for its defaults.
    """
    defaults = getattr(tree, "_field_defaults", {}) if isinstance(tree, type) else {}
    ambient = defaults.get("ambient") if isinstance(tree, type) else getattr(tree, "ambient", None)
    return getattr(ambient, "pressure", None)


def with_value(tree: Tree, key: str, value: Any) -> Tree:
    """Return a copy of a tree with another value, in SI, for one key with dots."""
    first, _, rest = key.partition(".")
    return tree._replace(**{first: with_value(getattr(tree, first), rest, value) if rest else value})


def move_gauge_pressures(tree: Tree, before: float | None, after: float | None, said: Container[str]) -> Tree:
    """Let the gauge pressures of a copy of a tree stand above another ambient pressure [Pa abs] than before.

    What was said as absolute stays, and so do the keys `said`, which were said above the new one already.

    >>> from apesim.engine.machine import Machine
    >>> move_gauge_pressures(Machine(), 101325.0, 80e3, ()).supply.pressure
    1080000.0
    """
    if before is None or after is None or before == after:
        return tree
    for leaf in leaves_of(type(tree)).values():
        if not leaf.declaration.is_gauge or leaf.key in said:
            continue
        value = attrgetter(leaf.key)(tree)
        if isfinite(value) and not isinstance(value, AbsolutePressure):
            text = leaf.declaration.render(value, before)
            tree = with_value(tree, leaf.key, leaf.declaration.read(text, after))
    return tree


def with_own_arrays(tree: Tree) -> Tree:
    """Return a tree that nobody else can change: its arrays, which are all that can be, are its own copies.

    It is the very tree where it holds none.
    """
    for key in _array_keys(type(tree)):
        array = attrgetter(key)(tree)
        if array.size:
            tree = with_value(tree, key, array.copy())
    return tree


@once_a_class
def _array_keys(cls: Any) -> tuple[str, ...]:
    """Keys of a parameter class whose values are arrays."""
    return tuple(leaf.key for leaf in leaves_of(cls).values() if isinstance(leaf.default, np.ndarray))


def contents_of(value: Any) -> Any:
    """Return what a tree holds, in a form that can be compared and hashed: NaN is NaN, and arrays are their numbers.

    Each section becomes a tuple with its class.

    >>> from typing import NamedTuple
    >>> class Valve(NamedTuple):
    ...     curve: np.ndarray
    ...     pressure: float = float("nan")
    >>> contents_of(Valve(np.zeros((2, 2)))) == contents_of(Valve(np.zeros((2, 2)), float("nan")))
    True
    """
    if isinstance(value, tuple):
        return (type(value), *map(contents_of, value))
    if isinstance(value, np.ndarray):
        return (value.shape, *map(contents_of, value.ravel().tolist()))
    return "NaN" if isinstance(value, float) and value != value else value
