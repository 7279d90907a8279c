"""Settings: a whole tree of parameter classes, from a TOML file and the assignments of a command line."""

import re
from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence
from math import nan
from operator import attrgetter
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from apesim.quantities.arguments import checked_value
from apesim.quantities.checking import check_values
from apesim.quantities.curves import Curve
from apesim.quantities.files import text_of
from apesim.quantities.input_errors import Fault, InputError, InvalidValue, make_fault, quoted
from apesim.quantities.printing import dumps
from apesim.quantities.reading import COMMAND_LINE, absent_due, given_beside, read, unknown
from apesim.quantities.toml_text import parse_toml
from apesim.quantities.trees import (
    Leaf,
    ambient_of,
    due,
    faults,
    fields,
    is_section,
    joined,
    leaves_of,
    move_gauge_pressures,
    once_a_class,
    overruled,
    schema,
    spellings,
    with_value,
)
from apesim.quantities.uncertainties import flatten

__all__ = [
    "COMMAND_LINE",
    "differences",
    "dumps",
    "load",
    "misassigned",
    "overruled",
    "read",
    "replaced",
    "schema",
    "toml_of",
]

Tree = TypeVar("Tree", bound=Any)


def load(cls: type, path: Any = None, assignments: Iterable[str] = (), data: dict | None = None) -> Any:
    """Return an instance of a parameter class, in SI, from a TOML file and the assignments of a command line.

    Without a path, the defaults hold. Assignments, e.g. ``engine.bore=90 mm``, are read in order, the later one wins;
    paths of curves in them start in the working directory. `data` is what the file says, where it was read already; it
    is changed. Raises InputError with every fault where the file cannot be read or is no TOML, a value or key is
    refused as in `read`, or a key is assigned that is not looked at.
    """
    if data is None:
        data = {} if path is None else toml_of(path)

    # What can be assigned: every key, in each of its spellings.
    declarations = {key: leaf.declaration for key, leaf in leaves_of(cls).items()}
    others = spellings(cls)
    declarations |= {name: spelling.declaration for name, spelling in others.items()}

    # Assignments are put into the data of the file, so that they are read and judged together with it.
    assigned: set[str] = set()
    all_faults: list[Fault] = []
    for assignment in assignments:
        key, equals, text = (part.strip() for part in assignment.partition("="))
        table, entry = _table_of(key, declarations), _entry_of(key, declarations)
        if not equals:
            wrong = f"{quoted(assignment)} assigns nothing"
            all_faults.append(Fault(COMMAND_LINE, "", wrong, 'write KEY=VALUE, e.g. engine.bore="85 mm"'))
        elif entry:
            assigned.add(key)
            all_faults += _put_into_array(data, *entry, _without_quotes(text), key)
        elif key not in declarations and not table:
            all_faults.append(misassigned(cls, key, COMMAND_LINE))
        else:
            text = _without_quotes(text)
            for other in _twins(key, others) - assigned:  # what the file says of it in another spelling
                _drop(data, other.split("."))
            assigned.add(key)
            if table:
                _put_into_table(data, table, key.removeprefix(f"{table}."), text)
                continue
            names_file = isinstance(declarations[key], Curve) and text
            _put(
                data, key.split("."), Path(text).absolute() if names_file else text
            )  # the user's own may lead anywhere

    # The tree is read although assignments were refused, so that the faults of the file are told with them.
    file = str(path) if path is not None else COMMAND_LINE if assigned else "default"
    try:
        tree = read(cls, data, file, assigned)
        all_faults += _ignored(tree, assigned, COMMAND_LINE)
    except InputError as error:
        all_faults += error.faults
    if all_faults:
        raise InputError(all_faults)
    return tree


def _without_quotes(text: str) -> str:
    """A text without the quotation marks that a value has in the file, which a shell may leave."""
    is_quoted = len(text) > 1 and text[0] == text[-1] and text[0] in "\"'"
    return text[1:-1] if is_quoted else text


def _twins(key: str, others: Mapping[str, Any]) -> set[str]:
    """All other spellings of a key, the key itself among them where it is written in one of them."""
    base = _base(key, others)
    return {base, *(name for name, spelling in others.items() if spelling.key == base)} - {key}


def _base(key: str, others: Mapping[str, Any]) -> str:
    """Key that a spelling stands for; a key stands for itself."""
    return others[key].key if key in others else key


def _drop(data: Any, path: Sequence[str]) -> None:
    """Delete a nested key, if it is there."""
    *sections, key = path
    for section in sections:
        data = data.get(section, {}) if isinstance(data, dict) else {}
    if isinstance(data, dict):
        data.pop(key, None)


def _table_of(key: str, declarations: Mapping[str, Any]) -> str:
    """Name of the table that a key stands in, see `Declaration.is_table`; "": it stands in none."""
    sections = (key[:at] for at, sign in enumerate(key) if sign == ".")
    return next((section for section in sections if section in declarations and declarations[section].is_table), "")


def _entry_of(key: str, declarations: Mapping[str, Any]) -> tuple[Any, int, str] | None:
    """Declaration of an array of tables, number of the table from 1, and its key, of "cylinder[2].valve.stroke"."""
    found = re.fullmatch(r"([\w.]+)\[([0-9]{1,6})\]\.(.+)", key)
    is_entry = found and found[1] in declarations and declarations[found[1]].is_array
    return (declarations[found[1]], int(found[2]), found[3]) if found and is_entry else None


def _put_into_array(
    data: dict[str, Any], declaration: Any, number: int, key: str, text: str, where: str
) -> Iterator[Fault]:
    """Set a key of a table of an array, counted from 1; a fault of the file on the way is left for `read` to tell."""
    if not 1 <= number <= declaration.max_count:
        yield Fault(COMMAND_LINE, where, f"there is no number {number}", f"count from 1 to {declaration.max_count}")
        return
    given = data.get(declaration.name, [])
    if not isinstance(given, list) or not all(isinstance(table, dict) for table in given):
        return
    tables = [dict(declaration.flatten(table)) for table in given]
    tables += [{} for _ in range(number - len(tables))]
    names_file = isinstance(declaration.declared(key), Curve) and text
    tables[number - 1][key] = Path(text).absolute() if names_file else text
    data[declaration.name] = tables


def _put_into_table(data: dict[str, Any], table: str, key: str, text: str) -> None:
    """Set a key of a table; a fault of the file on the way is left for `read` to tell."""
    section, _, name = table.rpartition(".")
    for each in filter(None, section.split(".")):
        data = data.setdefault(each, {})
    given = data.get(name, {})
    if isinstance(given, dict):
        data[name] = dict(flatten(given)) | {key: text}


def _ignored(tree: Any, assigned: Container[str], where: str) -> Iterator[Fault]:
    """Faults of the keys that are assigned and ignored because of others."""
    for key, reason in overruled(tree):
        if key in assigned:
            yield Fault(where, key, f"is ignored: {reason}", "change that, or leave it out")


def find_ignored_keys(tree: Any) -> dict[str, str]:
    """Find the keys of a tree that differ from their defaults and have no effect, because of others.

    Returns by key what is used in its place.

    >>> from typing import Annotated, NamedTuple
    >>> from apesim.quantities import Quantity
    >>> class Valve(NamedTuple):
    ...     stroke: Annotated[float, Quantity("mm", 1, 50, "chosen")] = 9e-3
    >>> class Machine(NamedTuple):
    ...     valve: Valve = Valve()
    >>> Machine.overruled = lambda self: [("valve", "a cam is given")]
    >>> find_ignored_keys(Machine()), find_ignored_keys(Machine(Valve(8e-3)))
    ({}, {'valve.stroke': 'a cam is given'})
    """
    standard = leaves_of(type(tree))
    return {
        key: reason
        for key, reason in overruled(tree)
        if not np.array_equal(attrgetter(key)(tree), standard[key].default, equal_nan=True)
    }


def replaced(tree: Tree, values: Mapping[str, Any], where: str) -> Tree:
    """Return a copy of a tree with other values for some keys; what a file or a command line may not give is refused.

    Keys are as in "engine.bore" or, where that is clear, "engine_bore"; values a text with its unit, a number with its
    unit as in ``(9, "mm")``, or a number in SI, which an angle cannot be. Gauge pressures, given ones and those of the
    tree, stand above the new ambient pressure, where it is among the values. Raises InputError with every fault, which
    names `where`, where a key is unknown, given twice or ignored, or a value is refused.
    """
    cls: Any = type(tree)
    all_faults: list[Fault] = []
    given: dict[str, Any] = {}
    leaves, by_underscores = _all_spellings(cls)
    others = spellings(cls)

    # Which key each name means: written with underscores, it may be that of several.
    for name, value in values.items():
        keys = [name] if name in leaves else by_underscores.get(name, [])
        if len(keys) == 1 and keys[0] not in given:
            given[keys[0]] = value
        elif len(keys) == 1:
            all_faults.append(Fault(where, keys[0], "is given twice", "give it once"))
        elif keys:
            right = " or ".join(f'**{{"{key}": ...}}' for key in keys)
            all_faults.append(Fault(where, name, "is the name of several keys", f"write {right}"))
        else:
            all_faults.append(misassigned(cls, _with_dots(cls, name), where))

    # The values, the ambient pressure first: gauge pressures among the others stand above the new one.
    ambient_key = "ambient.pressure"
    ambient = stood_above = ambient_of(tree)
    for key in sorted(given, key=lambda key: key != ambient_key):
        declaration, default = leaves[key].declaration, leaves[key].default
        try:
            value = checked_value(given[key], declaration, ambient)
        except InvalidValue as wrong:
            for inner, each in wrong.parts or (("", wrong),):
                all_faults.append(make_fault(where, joined(key, inner), each, declaration, default, ambient))
            continue
        ambient = value if key == ambient_key else ambient
        if key in others and others[key].key in given:
            all_faults.append(given_beside(where, key, others[key].key))
        value = others[key].convert(value) if key in others else value
        tree = with_value(tree, _base(key, others), value)

    # The gauge pressures of the tree follow the ambient pressure; those that were given stand above it already.
    given = {_base(key, others): value for key, value in given.items()}
    tree = move_gauge_pressures(tree, stood_above, ambient, given)

    # The tree as a whole, only where each value was taken, and what values say together only where that is sound.
    if not all_faults:
        tree = check_values(tree, cls, where)
        all_faults += absent_due(cls, _present(tree, given), where, frozenset())
        all_faults += _ignored(tree, given, where)
    if not all_faults:
        all_faults += (Fault(where, *fault) for fault in faults(tree))
    if all_faults:
        raise InputError(all_faults)
    return tree


@once_a_class
def _all_spellings(cls: Any) -> tuple[dict[str, Leaf], dict[str, list[str]]]:
    """Keys of a parameter class in all their spellings; and the keys by their names with underscores for dots."""
    others = {name: Leaf(name, spelling.declaration, nan) for name, spelling in spellings(cls).items()}
    leaves = leaves_of(cls) | others
    by_underscores: dict[str, list[str]] = {}
    for key in leaves:
        by_underscores.setdefault(key.replace(".", "_"), []).append(key)
    return leaves, by_underscores


def _with_dots(cls: type, name: str) -> str:
    """The key that a name with underscores most likely means: sections that it begins with are told apart by dots."""
    if "." not in name:
        for key, field in fields(cls).items():
            if is_section(field) and name.startswith(f"{key}_"):
                return joined(key, _with_dots(field, name.removeprefix(f"{key}_")))
    return name


def _present(tree: Any, assigned: Collection[str]) -> dict[str, Any]:
    """Nested tables of the optional sections with assigned keys, as a file holds them: what is not as by default."""
    data: dict[str, Any] = {}
    cls = type(tree)
    above = {key[:at] for key in assigned for at, sign in enumerate(key) if sign == "."}  # what they stand in
    sections = above & _keys_of_optional(cls).keys()
    if not sections:
        return data
    ambient, standard_ambient, leaves = ambient_of(tree), ambient_of(cls), leaves_of(cls)
    for section, keys in _keys_of_optional(cls).items():
        if section in sections:
            for key in keys:
                value = attrgetter(key)(tree)
                if key in assigned or _has_another_text(leaves[key], value, ambient, standard_ambient):
                    _put(data, key.split("."), value)
    return data


@once_a_class
def _keys_of_optional(cls: Any, section: str = "", is_optional: bool = False) -> dict[str, list[str]]:
    """Keys of the sections that are optional, see `apesim.quantities.trees.due`, or stand in one that is."""
    found = {}
    if is_optional:
        found[section] = [joined(section, key) for key, field in fields(cls).items() if not is_section(field)]
    for key, field in fields(cls).items():
        if is_section(field):
            found |= _keys_of_optional(field, joined(section, key), is_optional or key in due(cls))
    return found


def _has_another_text(standard: Leaf, value: Any, ambient: float | None, standard_ambient: float | None) -> bool:
    """Whether a value is written otherwise than the default; both gauge pressures stand above an ambient one."""
    if value is standard.default and not standard.declaration.is_gauge:
        return False
    text = standard.declaration.render(value, ambient)
    return bool(text != standard.declaration.render(standard.default, standard_ambient))


def differences(tree: Any) -> Iterator[tuple[str, str]]:
    """Find the keys of a tree that are not as by default, each with its value as text with its unit.

    A curve is told by its number of points, and a value that is not given by "not given".
    """
    ambient, standard_ambient = ambient_of(tree), ambient_of(type(tree))
    for standard, leaf in zip(leaves_of(type(tree)).values(), schema(type(tree), tree), strict=True):
        if not _has_another_text(standard, leaf.default, ambient, standard_ambient):
            continue
        text = leaf.declaration.render(leaf.default, ambient)
        if leaf.declaration.is_array:
            yield from _differences_of_array(leaf.key, text)
        elif leaf.declaration.is_table:
            yield from ((joined(leaf.key, inner), each) for inner, each in dict(text or {}).items())
        else:
            yield leaf.key, _shown(text)


def _shown(text: Any) -> str:
    """What stands for a value that is printed as a text, a bare number or a curve."""
    if isinstance(text, dict):
        return f"a curve of {len(next(iter(text.values())))} points"
    return f"{text:g}" if isinstance(text, float) else text or "not given"


def _differences_of_array(name: str, tables: Any) -> Iterator[tuple[str, str]]:
    """Keys of the tables of an array, each with its value as text; a table without a key is told, too."""
    if not tables:
        yield name, "not given"
    for number, table in enumerate(tables, 1):
        for key, value in table.items() or [("", "no key of its own")]:
            yield joined(f"{name}[{number}]", key), _shown(value)


def toml_of(path: Any) -> dict:
    r"""Return the data of a TOML file.

    The format is TOML [1]_.

    Parameters
    ----------
    path : path
        TOML file.

    Returns
    -------
    dict
        Nested tables, as `tomllib` returns them.

    Raises
    ------
    InputError
        The file cannot be read or is no TOML; holds one fault.

    References
    ----------
    .. [1] "TOML", version 1.0.0, https://toml.io/en/v1.0.0.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "mine.toml")
    ...     _ = path.write_text('[valve]\nstroke = "8 mm"\n')
    ...     toml_of(path)
    {'valve': {'stroke': '8 mm'}}
    """
    try:
        text = text_of(path)
    except InvalidValue as wrong:
        right = wrong.right or "give a machine file of TOML"
        raise InputError([Fault(str(path), "", wrong.wrong, right)]) from None
    return parse_toml(str(path), text, 'bore = "85 mm"')


def misassigned(cls: Any, key: str, file: str) -> Fault:
    """Return the fault of an assignment to `key`, which is no key of the tree of `cls`."""
    path, at = key.split("."), cls
    for depth, name in enumerate(path):
        field = fields(at).get(name)
        if field is None:
            return unknown(cls, path[: depth + 1], file)
        if not is_section(field):
            return Fault(file, key, "unknown key", f"did you mean {'.'.join(path[: depth + 1])}?")
        at = field
    keys = ", ".join(joined(key, inner) for inner in fields(at))
    return Fault(file, key, "is a section, no key", f"set one of {keys}")


def _put(data: dict[str, Any], path: Sequence[str], text: Any) -> None:
    """Set a nested key; a fault of the file on the way is left for `read` to tell."""
    *sections, key = path
    for section in sections:
        data = data.setdefault(section, {})
        if not isinstance(data, dict):
            return
    data[key] = text
