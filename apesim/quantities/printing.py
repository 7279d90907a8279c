"""Printing: a tree of parameter classes as a commented TOML text."""

import json
import textwrap
from collections.abc import Collection, Mapping
from typing import Any

from apesim.quantities.declarations import Quantity
from apesim.quantities.trees import ambient_of, due, fields, is_section, joined, schema

WIDTH = 110
"""Columns of a line; a remark that does not fit behind its value stands above it."""

LEGEND = "Behind each value: its range; the source of its default, which holds if the key is left out."
"""Second line of a printed tree."""
OTHERS = "Keys that do not stand here have their defaults."
"""Third line of a tree of which only some keys are printed."""


def dumps(
    tree: Any,
    folder: Any = None,
    notes: Mapping[str, str] | None = None,
    keys: Collection[str] | None = None,
    sources: Mapping[str, str] | None = None,
) -> str:
    """Return the commented TOML text of a tree of parameter classes; `load` reads the very same tree from it.

    An optional section that is as its class has it by default is a comment.

    The format is TOML [1]_.

    Parameters
    ----------
    tree : NamedTuple
        Instance of a parameter class. A section with a method ``stated`` of a folder names in lines of its own what
        is no parameter: the files that its class was made from.
    folder : path, optional
        Folder that the text is to stand in as a file; without one it is a record, which names files without folders.
    notes : mapping of str to str, optional
        Remarks on single values, by key; each stands in a comment above its value.
    keys : collection of str, optional
        Keys to print, and no others; all of them if left out. It is the same tree that reads back where the others are
        as by default.
    sources : mapping of str to str, optional
        Where single values come from, by key; each stands in place of the source of the default.

    Returns
    -------
    str
        Text of TOML.

    References
    ----------
    .. [1] "TOML", version 1.0.0, https://toml.io/en/v1.0.0.

    Examples
    --------
    >>> from typing import Annotated, NamedTuple
    >>> from apesim.quantities import Quantity
    >>> class Valve(NamedTuple):
    ...     stroke: Annotated[float, Quantity("mm", 1, 50, "chosen")] = 9e-3
    >>> class Machine(NamedTuple):
    ...     valve: Valve = Valve()
    >>> Machine.__doc__ = "A machine."
    >>> print(dumps(Machine()).splitlines()[-1])
    stroke = "9 mm" # 1 to 50 mm; chosen
    >>> print(dumps(Machine(), notes={"valve.stroke": "measured in May"}).splitlines()[-2])
    # measured in May
    """
    ambients = ambient_of(tree), ambient_of(type(tree))
    body = _section(tree, ambients, folder, notes=notes or {}, only=keys, sources=sources or {})
    gap = [""] * (body[:1] != [""])
    others = [] if keys is None else _comment(OTHERS)
    return "\n".join([*_comment(_title(type(tree))), *_comment(LEGEND), *others, *gap, *body, ""])


def _section(
    tree: Any,
    ambients: tuple[float | None, float | None],
    folder: Any,
    path: str = "",
    wanted: tuple[str, ...] = (),
    *,
    notes: Mapping[str, str],
    only: Collection[str] | None,
    sources: Mapping[str, str],
) -> list[str]:
    """What stands below a header: keys (the `wanted` ones are never a comment), curves, sections.

    Gauge pressures stand above the first ambient pressure, those of the defaults above the second.
    """
    cls: Any = type(tree)
    ambient_pressure, standard_ambient = ambients

    # Four lists, joined at the end: in TOML a key below another header would belong to that section.
    keys, curves, sections, tables = [], [], [], []
    for key, field in fields(cls).items():
        value, default, name = getattr(tree, key), cls._field_defaults[key], joined(path, key)
        stated = value.stated(folder) if hasattr(value, "stated") else ()
        starts = f"{name}.", f"{name}["
        is_asked_for = only is None or key in wanted or any(f"{each}.".startswith(starts) for each in only)
        if not is_asked_for and not stated:
            continue

        # A section. An optional one that is as by default becomes a comment: written out, it would count as given.
        if is_section(field):
            sections += ["", *_comment(_title(field))]
            any_of = due(cls).get(key, ())
            lines = [
                f"[{name}]",
                *stated,
                *_section(value, ambients, folder, name, any_of, notes=notes, only=only, sources=sources),
            ]
            if any_of and _texts(value, ambient_pressure) == _texts(default, standard_ambient):
                lines = [f"# {line}".rstrip() for line in lines]
            sections += lines
            continue

        # A key, by its form: a table or a curve has a header of its own, all else is one line.
        text = field.render(value, ambient_pressure)
        remark = field.range_text, sources.get(name) or " ".join(field.source.split())
        note = _comment(notes[name]) if name in notes else []
        if field.is_array:
            entries = [line for table in text for line in ("", f"[[{name}]]", *_entries(table))][1:]
            entries = entries or [f"# [[{name}]]", f"# {field.entry}"]
            tables += ["", *note, *_comment(remark[1]), *entries]
        elif field.is_table:
            lines = [f"{_string(inner)} = {_string(each)}" for inner, each in text.items()] if text else []
            entries = [f"[{name}]", *lines] if lines else [f"# [{name}]", f"# {field.entry}"]
            tables += ["", *note, *_comment(remark[1]), *entries]
        elif isinstance(text, dict):
            curves += ["", *note, *_comment(*remark), f"[{name}]", *_columns(text)]
        elif text == "" == field.render(default, ambient_pressure) and key not in wanted:
            # Not given: the line is a comment, which shows how the key is written and what holds without it.
            held = f"default: {field.text}" if getattr(field, "text", None) else "not given"
            keys += [*note, *_remarked(f'# {key} = ""  # {held}', "; ", *remark)]
        else:
            bare = isinstance(field, Quantity) and not field.unit and text not in ("", "inf")
            keys += [*note, *_remarked(f"{key} = {float(text) if bare else _string(text)}", " # ", *remark)]
    return keys + curves + sections + tables


def _entries(table: Mapping[str, Any]) -> list[str]:
    """Lines of a table of an array: keys with dots, curves as tables in a line."""
    lines = []
    for key, value in table.items():
        if isinstance(value, dict):
            columns = ", ".join(f"{_string(header)} = {numbers!r}" for header, numbers in value.items())
            lines.append(f"{key} = {{ {columns} }}")
        else:
            lines.append(f"{key} = {value!r}" if isinstance(value, float) else f"{key} = {_string(value)}")
    return lines


def _texts(tree: Any, ambient_pressure: float | None) -> list[Any]:
    """All values of a tree as they are printed, to compare trees: NaN equals itself."""
    return [leaf.declaration.render(leaf.default, ambient_pressure) for leaf in schema(type(tree), tree)]


def _title(cls: Any) -> str:
    return cls.__doc__.strip().splitlines()[0]


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)  # TOML escapes as JSON does


def _comment(*parts: str) -> list[str]:
    """Lines of comment: all parts in one, or each in lines of its own."""
    text = f"# {'; '.join(parts)}"
    if len(text) <= WIDTH:
        return [text]
    return [f"# {line}" for part in parts for line in textwrap.wrap(part, WIDTH - 2, break_on_hyphens=False)]


def _remarked(line: str, separator: str, *remark: str) -> list[str]:
    """A line with its remark behind it, or above it if that would be too long."""
    whole = f"{line}{separator}{'; '.join(remark)}"
    return [whole] if len(whole) <= WIDTH else [*_comment(*remark), line]


def _columns(columns: dict[str, list[float]]) -> list[str]:
    """The lists of a curve."""
    lines = []
    for header, numbers in columns.items():
        line = f"{_string(header)} = [{', '.join(map(repr, numbers))}]"
        if len(line) > WIDTH:
            rows = [numbers[i : i + 4] for i in range(0, len(numbers), 4)]  # of at most 24 characters each
            lines += [f"{_string(header)} = [", *(f"    {', '.join(map(repr, row))}," for row in rows), "]"]
        else:
            lines.append(line)
    return lines
