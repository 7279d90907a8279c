"""Checking: a tree of parameter classes that was made in Python, by what a file of it would be refused for."""

from apesim.quantities.culprits import Culprit, InputError, Wrong
from apesim.quantities.reading import unknown
from apesim.quantities.trees import faults, fields, is_section, joined


def check(tree, cls, where):
    """Refuse a tree whose text `apesim.quantities.reading.read` would refuse.

    Parameters
    ----------
    tree : object
    cls : type
        The parameter class that it has to be of.
    where : str
        What it was given to, for messages.

    Raises
    ------
    InputError
        With every culprit: what is of another class, unknown, no number or out of range; and if there is none, what
        the ``faults`` methods say.
    """
    culprits = list(_culprits(tree, cls, where, cls))
    culprits = culprits or [Culprit(where, *fault) for fault in faults(tree)]
    if culprits:
        raise InputError(culprits)


def _culprits(tree, cls, where, root, path=()):
    """What is wrong with a section and those below it."""
    if not isinstance(tree, cls):
        given = getattr(tree, "_fields", ())
        strange = [key for key in given if key not in cls._fields] if set(cls._fields) <= set(given) else ()
        yield from (unknown(root, (*path, key), where) for key in strange)
        if not strange:
            wrong = f"is of the class {type(tree).__name__}"
            yield Culprit(where, ".".join(path) or "machine", wrong, f"give a {cls.__name__}")
        return
    for key, field in fields(cls).items():
        value = getattr(tree, key)
        if value is cls._field_defaults[key]:  # most sections are the very defaults
            continue
        if is_section(field):
            yield from _culprits(value, field, where, root, (*path, key))
            continue
        try:
            field.check(value)
        except Wrong as wrong:
            yield Culprit(where, joined(*path, key), wrong.wrong, wrong.right)
