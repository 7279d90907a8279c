"""Reading: a tree of parameter classes from parsed TOML, all faults told at once."""

import difflib
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from apesim.quantities.input_errors import (
    MAX_NAMED,
    Fault,
    InputError,
    InvalidValue,
    make_fault,
    name_unknown,
    quoted,
)
from apesim.quantities.trees import (
    ambient_of,
    due,
    faults,
    fields,
    is_section,
    joined,
    move_gauge_pressures,
    schema,
    spellings,
)

COMMAND_LINE = "--set"


def read(cls: Any, data: Mapping[str, Any], file: str, assigned: Container[str] = frozenset()) -> Any:
    """Return an instance of a parameter class, its values in SI, from the nested tables of parsed TOML.

    The ambient pressure (``ambient.pressure``, if the class has one) is read first, for the gauge pressures; paths
    start in the folder of `file`. Raises InputError with every fault where a key is unknown, a value is wrong, or an
    optional section lacks its due keys; or if none is, where the ``faults`` methods find a fault. `assigned` are keys
    that the command line has set, for messages.
    """
    from pydantic import ValidationError

    leaves = {leaf.key: leaf for leaf in schema(cls)}
    all_faults: list[Fault] = []

    # The form, before pydantic sees the data: it knows one spelling of a key, and would take a list for a table.
    data = _tables(cls, data, file, all_faults)
    all_faults += _respell(cls, data, lambda key: COMMAND_LINE if key in assigned else file)
    all_faults += absent_due(cls, data, file, assigned)

    def place(key: str) -> str:
        return COMMAND_LINE if key in assigned else file

    def blame(key: str, wrong: InvalidValue) -> None:
        leaf = leaves[key]
        for inner, each in wrong.parts or (("", wrong),):
            path = joined(key, inner)
            all_faults.append(make_fault(place(path), path, each, leaf.declaration, leaf.default, reference))

    # The ambient pressure, before the gauge pressures that stand above it. Its default stands in for a wrong one.
    reference, key = None, "ambient.pressure"
    if key in leaves:
        reference, given = leaves[key].default, data.get("ambient", {})
        try:
            reference = leaves[key].declaration.read(given["pressure"]) if "pressure" in given else reference
        except InvalidValue as wrong:
            blame(key, wrong)
            del given["pressure"]  # told, and the others can still be read

    # The whole tree. What values say together is looked at only where each is right by itself: else one mistake would
    # be told twice.
    try:
        context = {"ambient_pressure": reference, "folder": Path(file).parent}
        tree = _adapter(cls).validate_python(data, context=context)
        given_keys = {key for key in leaves if _is_given(data, key)}
        tree = move_gauge_pressures(tree, ambient_of(cls), reference, given_keys)  # the defaults, too
        if not all_faults:
            all_faults += [Fault(place(key), key, *fault) for key, *fault in faults(tree)]
    except ValidationError as errors:
        # Unknown keys are gathered: a file of something else may have any number of them, and only the first are named.
        strange: list[tuple[str, ...]] = []
        for error in errors.errors(include_url=False):
            path = tuple(map(str, error["loc"]))
            if error["type"] == "extra_forbidden":
                strange.append(path)
            else:
                blame(joined(*path), error["ctx"]["error"])
        all_faults += name_unknown(strange, lambda path: unknown(cls, path, file), file, "")
    if all_faults:
        raise InputError(all_faults)
    return tree


@lru_cache(maxsize=64)
def _adapter(cls: Any) -> Any:
    from pydantic import TypeAdapter

    return TypeAdapter(cls)


def _is_given(data: Any, key: str) -> bool:
    """Whether nested tables hold a key with dots."""
    for name in key.split("."):
        if not isinstance(data, dict) or name not in data:
            return False
        data = data[name]
    return True


def _tables(cls: Any, data: Mapping[str, Any], file: str, all_faults: list[Fault], section: str = "") -> dict[str, Any]:
    """A copy of `data` without what stands where a table is due: pydantic would take a list for one."""
    kept: dict[str, Any] = {}
    for key, raw in data.items():
        field, path = fields(cls).get(key), joined(section, key)
        if not is_section(field):
            kept[key] = raw
        elif isinstance(raw, dict):
            kept[key] = _tables(field, raw, file, all_faults, path)
        else:
            right = f"write [{path}], with keys of {', '.join(fields(field))}"
            all_faults.append(Fault(file, path, f"{quoted(raw)} is no table", right))
    return kept


def _respell(cls: Any, data: dict[str, Any], place: Callable[[str], str]) -> Iterator[Fault]:
    """Write the keys themselves in place of their other spellings; yields a fault where that cannot be."""
    for name, spelling in spellings(cls).items():
        (*sections, old), new, table, section_class = name.split("."), spelling.key.rpartition(".")[2], data, cls
        for section in sections:
            table, section_class = table.get(section, {}), fields(section_class)[section]
        if old not in table:
            continue
        raw = table.pop(old)
        if new in table:
            yield given_beside(place(name), name, spelling.key)
            continue
        try:
            value = spelling.convert(spelling.declaration.read(raw))
        except InvalidValue as wrong:
            yield make_fault(place(name), name, wrong, spelling.declaration)
        else:
            table[new] = fields(section_class)[new].render(value)


def given_beside(file: str, key: str, other: str) -> Fault:
    """Return the fault of a key that is given in two spellings, `key` and `other`."""
    return Fault(file, key, f"is given beside {other}, whose other spelling it is", "give one of them")


def absent_due(
    cls: Any, data: Mapping[str, Any], file: str, assigned: Container[str], section: str = ""
) -> Iterator[Fault]:
    """Find the optional sections that are present without any of their due keys, see `apesim.quantities.trees.due`.

    `section` is set before the keys; `assigned` are full keys that the command line has set, for messages.

    >>> from typing import Annotated, NamedTuple
    >>> from apesim.quantities import Quantity
    >>> class Valve(NamedTuple):
    ...     stroke: Annotated[float, Quantity("mm", 1, 50, "chosen")] = 9e-3
    >>> class Machine(NamedTuple):
    ...     valve: Valve = Valve()
    >>> Machine.due = {"valve": ("stroke",)}
    >>> print(*absent_due(Machine, {"valve": {}}, "mine.toml", set()))
    mine.toml: valve: is present without stroke; give stroke = "50 mm"
    """
    for key, raw in data.items():
        field, path = fields(cls).get(key), joined(section, key)
        if not is_section(field):
            continue
        yield from absent_due(field, raw, file, assigned, path)
        keys = due(cls).get(key, ())
        strange = [name for name in raw if name not in fields(field)]
        misspelt = any(difflib.get_close_matches(name, keys) for name in strange[:MAX_NAMED])  # told as an unknown key
        if keys and not misspelt and not any(name in raw for name in keys):
            right = " or ".join(f"{name} = {fields(field)[name].strong}" for name in keys)
            place = COMMAND_LINE if _is_assigned(raw, assigned, path) else file
            yield Fault(place, path, f"is present without {' or '.join(keys)}", f"give {right}")


def _is_assigned(data: Mapping[str, Any], assigned: Container[str], section: str) -> bool:
    """Whether a table holds nothing but what the command line has set."""
    for key, raw in data.items():
        path = joined(section, key)
        if not (_is_assigned(raw, assigned, path) if isinstance(raw, dict) else path in assigned):
            return False
    return bool(data)


def unknown(cls: Any, path: Sequence[str], file: str) -> Fault:
    """Return the fault of an unknown key, with the nearest right one: in its section, or elsewhere by its name.

    `path` holds the sections that the key stands in, which exist, and the key.
    """
    *sections, key = path
    valid = cls
    for section in sections:
        valid = fields(valid)[section]
    section = ".".join(sections)
    others = [name.rpartition(".")[2] for name in spellings(cls) if name.rpartition(".")[0] == section]
    near = difflib.get_close_matches(key, [*fields(valid), *others], n=1)
    keys = [joined(section, near[0])] if near else [x.key for x in schema(cls) if x.key.endswith(f".{key}")]
    right = f"did you mean {' or '.join(keys)}?" if keys else f"valid here: {', '.join(fields(valid))}"
    return Fault(file, joined(section, key), "unknown key", right)
