"""Settings: a whole tree of parameter classes, from a TOML file and the assignments of a command line."""

import tomllib
from pathlib import Path

from apesim.quantities.culprits import Culprit, InputError, Wrong, quoted
from apesim.quantities.curves import Curve
from apesim.quantities.files import text_of
from apesim.quantities.printing import dumps
from apesim.quantities.reading import COMMAND_LINE, read, unknown
from apesim.quantities.trees import fields, is_section, joined, overruled, schema

__all__ = ["COMMAND_LINE", "dumps", "load", "misassigned", "overruled", "read", "schema"]


def load(cls, path=None, assignments=()):
    """An instance of a parameter class from a TOML file and the assignments of a command line.

    Parameters
    ----------
    cls : type
    path : path, optional
        Without one, the defaults hold.
    assignments : iterable of str
        E.g. ``engine.bore=90 mm``; the later one wins. Paths of curves start in the working directory.

    Returns
    -------
    cls

    Raises
    ------
    InputError
        As `read`; or the file cannot be read, or is no TOML; or a key is assigned that is not looked at.
    """
    data = {} if path is None else _toml(path)
    declarations = {leaf.key: leaf.declaration for leaf in schema(cls)}
    assigned, culprits = set(), []
    for assignment in assignments:
        key, equals, text = (part.strip() for part in assignment.partition("="))
        if not equals:
            wrong = f"{quoted(assignment)} assigns nothing"
            culprits.append(Culprit(COMMAND_LINE, "", wrong, 'write KEY=VALUE, e.g. engine.bore="85 mm"'))
        elif key not in declarations:
            culprits.append(misassigned(cls, key, COMMAND_LINE))
        else:
            if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'":
                text = text[1:-1]
            if isinstance(declarations[key], Curve) and text:
                text = Path(text).absolute()  # no text: the user's own path may lead anywhere
            _put(data, key.split("."), text)
            assigned.add(key)
    file = str(path) if path is not None else COMMAND_LINE if assigned else "default"
    try:
        tree = read(cls, data, file, assigned)
        for key, reason in overruled(tree):
            if key in assigned:
                culprits.append(
                    Culprit(COMMAND_LINE, key, f"is not looked at: {reason}", "change that, or leave it out")
                )
    except InputError as error:
        culprits += error.culprits
    if culprits:
        raise InputError(culprits)
    return tree


def _toml(path):
    """The data of a TOML file."""
    try:
        text = text_of(path)
    except Wrong as wrong:
        right = wrong.right or "give a machine file of TOML"
        raise InputError([Culprit(str(path), "", wrong.wrong, right)]) from None
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        what, _, where = str(error).partition(" (at ")
        right = 'write key = "value", a quantity in quotes: bore = "85 mm"'
        raise InputError([Culprit(str(path), where.rstrip(")"), f"no TOML: {what}", right)]) from None


def misassigned(cls, key, file):
    """The culprit of an assignment to what is no key.

    Parameters
    ----------
    cls : type
        The parameter class at the root.
    key : str
    file : str
        Where it was given, for the message.

    Returns
    -------
    Culprit
    """
    path, at = key.split("."), cls
    for depth, name in enumerate(path):
        field = fields(at).get(name)
        if field is None:
            return unknown(cls, path[: depth + 1], file)
        if not is_section(field):
            return Culprit(file, key, "unknown key", f"did you mean {'.'.join(path[: depth + 1])}?")
        at = field
    keys = ", ".join(joined(key, inner) for inner in fields(at))
    return Culprit(file, key, "is a section, no key", f"set one of {keys}")


def _put(data, path, text):
    """Sets a nested key; a fault of the file on the way is left for `read` to tell."""
    *sections, key = path
    for section in sections:
        data = data.setdefault(section, {})
        if not isinstance(data, dict):
            return
    data[key] = text
