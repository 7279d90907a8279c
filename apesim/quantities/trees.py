"""Trees: parameter classes in one another, and all their keys.

A parameter class is a `NamedTuple` whose fields are declared with `apesim.quantities`, or are parameter
classes themselves: the sections. A section that a file names starts from the defaults of its own class; one
that is left out is as the class above has it. A method ``faults`` may yield
``(key, what is wrong, what would be right)`` for what only several keys together show. A method ``overruled`` may
yield ``(key or section, by what)`` for what is not looked at.

A class attribute ``due`` makes sections optional: to be present switches them on. It names, for each of these
sections, the keys of which at least one must be given in it::

    Effects.due = {"bounce": ("restitution",), "cylinder_wall_heat": ("h", "factor")}
"""

import typing
from functools import lru_cache
from typing import NamedTuple

from apesim.quantities.declarations import Declaration


class Leaf(NamedTuple):
    """One key of a tree."""

    key: str
    """With dots, e.g. "valve.solenoid.dead_time"."""
    declaration: Declaration
    default: object


@lru_cache(maxsize=512)
def fields(cls):
    """What each field of a parameter class is declared to be: a declaration, or a parameter class."""
    found, defaults = {}, cls._field_defaults
    # A NamedTuple made by a call gets defaults through __new__ only; pydantic looks for them here.
    defaults.update(zip(cls._fields[::-1], (cls.__new__.__defaults__ or ())[::-1], strict=False))
    for key, hint in typing.get_type_hints(cls, include_extras=True).items():
        declared = [meta for meta in getattr(hint, "__metadata__", ()) if isinstance(meta, Declaration)]
        if not (declared or hasattr(hint, "_fields")) or key not in defaults:
            raise TypeError(f"{cls.__name__}.{key} needs a declaration and a default")
        found[key] = declared[0] if declared else hint
    return found


def is_section(field):
    """Whether a field is a parameter class."""
    return isinstance(field, type)


def due(cls):
    """The keys of which at least one must be given, by optional section of a parameter class."""
    sections = getattr(cls, "due", {})
    for section, keys in sections.items():
        field = fields(cls).get(section)
        inner = fields(field) if is_section(field) else {}
        if not keys or any(is_section(inner.get(key, dict)) for key in keys):
            raise TypeError(f"{cls.__name__}.due: {keys!r} are no keys of a section {section!r}")
    return sections


def joined(*keys):
    """A key of several parts, e.g. "valve.stroke"."""
    return ".".join(filter(None, keys))


def faults(tree, section=""):
    """What the ``faults`` methods of a tree find: full key, what is wrong, what would be right."""
    for key, field in fields(type(tree)).items():
        if is_section(field):
            yield from faults(getattr(tree, key), joined(section, key))
    for key, wrong, right in getattr(tree, "faults", tuple)():
        yield joined(section, key), wrong, right


def overruled(tree, section=""):
    """Keys that are not looked at because of others, with the reason; see the method of that name."""
    for key, field in fields(type(tree)).items():
        if is_section(field):
            yield from overruled(getattr(tree, key), joined(section, key))
    for key, reason in getattr(tree, "overruled", tuple)():
        field, path = fields(type(tree))[key], joined(section, key)
        inner = [leaf.key for leaf in schema(field, section=path)] if is_section(field) else [path]
        yield from ((leaf, reason) for leaf in inner)


def schema(cls, default=None, section=""):
    """Every key of a tree of parameter classes.

    Parameters
    ----------
    cls : type
        The parameter class at the root.
    default : cls, optional
        Where defaults are taken from.
    section : str
        Set before the keys.

    Yields
    ------
    Leaf
    """
    default = cls() if default is None else default
    for key, field in fields(cls).items():
        if is_section(field):
            yield from schema(field, getattr(default, key), joined(section, key))
        else:
            yield Leaf(joined(section, key), field, getattr(default, key))
