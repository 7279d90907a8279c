"""Checking: a tree of parameter classes that was made in Python, by what a file of it would be refused for."""

from typing import Any

from apesim.quantities.input_errors import Fault, InputError, InvalidValue
from apesim.quantities.reading import unknown
from apesim.quantities.trees import faults, fields, is_section, joined


def check(tree: Any, cls: Any, where: str) -> Any:
    """Refuse a tree whose text `apesim.quantities.reading.read` would refuse; else return it as kernels need it.

    Where a number is an int, a fraction or of another precision, that is a copy with a float for it. Raises InputError
    with every fault where something is of another class than `cls` has it, unknown, no number or out of range, or if
    nothing is, where the ``faults`` methods find a fault; messages name `where`.
    """
    tree = check_values(tree, cls, where)
    if all_faults := [Fault(where, *fault) for fault in faults(tree)]:
        raise InputError(all_faults)
    return tree


def check_values(tree: Any, cls: Any, where: str) -> Any:
    """Refuse a tree with a value that is wrong by itself; else return it as kernels need it, see `check`.

    Raises InputError with every fault where something is of another class than `cls` has it, unknown, no number or out
    of range; messages name `where`.
    """
    all_faults: list[Fault] = []
    tree = _checked(tree, cls, all_faults, where, cls, ())
    if all_faults:
        raise InputError(all_faults)
    return tree


def _checked(tree: Any, cls: Any, all_faults: list[Fault], where: str, root: Any, path: tuple[str, ...]) -> Any:
    """Note what is wrong with a section and with those below it; else return it with the types that kernels need."""
    if not isinstance(tree, cls):
        given = getattr(tree, "_fields", ())
        strange = [key for key in given if key not in cls._fields] if set(cls._fields) <= set(given) else ()
        all_faults += (unknown(root, (*path, key), where) for key in strange)
        if not strange:
            wrong = f"is of the class {type(tree).__name__}"
            all_faults.append(Fault(where, ".".join(path) or "machine", wrong, f"give a {cls.__name__}"))
        return tree
    changes, defaults = {}, cls._field_defaults
    for key, field in fields(cls).items():
        value = getattr(tree, key)
        if value is defaults[key]:  # most sections are the very defaults
            continue
        if is_section(field):
            held = _checked(value, field, all_faults, where, root, (*path, key))
        else:
            try:
                field.check(value)
                held = field.convert(value)
            except InvalidValue as wrong:
                all_faults.append(Fault(where, joined(*path, key), wrong.wrong, wrong.right))
                continue
        if held is not value:
            changes[key] = held
    return tree._replace(**changes) if changes else tree
