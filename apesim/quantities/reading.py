"""Reading: a tree of parameter classes from parsed TOML, all faults told at once."""

import difflib
from functools import lru_cache
from pathlib import Path

from apesim.quantities.input_errors import Fault, InputError, InvalidValue, make_fault, quoted
from apesim.quantities.trees import due, faults, fields, is_section, joined, schema

COMMAND_LINE = "--set"


def read(cls, data, file, assigned=frozenset()):
    """An instance of a parameter class from parsed TOML.

    The ambient pressure (``ambient.pressure``, if the class has one) is read first, for the gauge pressures.

    Parameters
    ----------
    cls : type
    data : dict
        As `tomllib` returns it.
    file : str
        The file, for messages; paths in it start in its folder.
    assigned : set of str
        Keys that the command line has set, for messages.

    Returns
    -------
    cls

    Raises
    ------
    InputError
        With every fault: unknown keys, wrong values, optional sections without a due key; and if there is
        none, what the ``faults`` methods say.
    """
    from pydantic import ValidationError

    leaves = {leaf.key: leaf for leaf in schema(cls)}
    all_faults = []
    data = _tables(cls, data, file, all_faults)
    all_faults += absent_due(cls, data, file, assigned)

    def place(key):
        return COMMAND_LINE if key in assigned else file

    def blame(key, wrong):
        leaf = leaves[key]
        all_faults.append(make_fault(place(key), key, wrong, leaf.declaration, leaf.default, reference))

    reference, key = None, "ambient.pressure"
    if key in leaves:
        reference, given = leaves[key].default, data.get("ambient", {})
        try:
            reference = leaves[key].declaration.read(given["pressure"]) if "pressure" in given else reference
        except InvalidValue as wrong:
            blame(key, wrong)
            del given["pressure"]  # told, and the others can still be read
    try:
        context = {"ambient_pressure": reference, "folder": Path(file).parent}
        tree = _adapter(cls).validate_python(data, context=context)
        if not all_faults:
            all_faults += [Fault(place(key), key, *fault) for key, *fault in faults(tree)]
    except ValidationError as errors:
        for error in errors.errors(include_url=False):
            if error["type"] == "extra_forbidden":
                all_faults.append(unknown(cls, error["loc"], file))
            else:
                blame(joined(*error["loc"]), error["ctx"]["error"])
    if all_faults:
        raise InputError(all_faults)
    return tree


@lru_cache(maxsize=64)
def _adapter(cls):
    from pydantic import TypeAdapter

    return TypeAdapter(cls)


def _tables(cls, data, file, all_faults, section=""):
    """A copy of `data` without what stands where a table is due: pydantic would take a list for one."""
    kept = {}
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


def absent_due(cls, data, file, assigned, section=""):
    """The all_faults of optional sections that are present without any of their due keys."""
    for key, raw in data.items():
        field, path = fields(cls).get(key), joined(section, key)
        if not is_section(field):
            continue
        yield from absent_due(field, raw, file, assigned, path)
        keys = due(cls).get(key, ())
        strange = [name for name in raw if name not in fields(field)]
        misspelt = any(difflib.get_close_matches(name, keys) for name in strange)  # told as an unknown key
        if keys and not misspelt and not any(name in raw for name in keys):
            right = " or ".join(f"{name} = {fields(field)[name].strong}" for name in keys)
            place = COMMAND_LINE if _is_assigned(raw, assigned, path) else file
            yield Fault(place, path, f"is present without {' or '.join(keys)}", f"give {right}")


def _is_assigned(data, assigned, section):
    """Whether a table holds nothing but what the command line has set."""
    for key, raw in data.items():
        path = joined(section, key)
        if not (_is_assigned(raw, assigned, path) if isinstance(raw, dict) else path in assigned):
            return False
    return bool(data)


def unknown(cls, path, file):
    """The fault of an unknown key, with the nearest right one: in its section, or elsewhere by its name."""
    *sections, key = path
    valid = cls
    for section in sections:
        valid = fields(valid)[section]
    near = difflib.get_close_matches(key, fields(valid), n=1)
    section = ".".join(sections)
    right = [joined(section, near[0])] if near else [x.key for x in schema(cls) if x.key.endswith(f".{key}")]
    right = f"did you mean {' or '.join(right)}?" if right else f"valid here: {', '.join(fields(valid))}"
    return Fault(file, joined(section, key), "unknown key", right)
