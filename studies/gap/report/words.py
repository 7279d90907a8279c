"""Names of effects and keys of the machine in words, for sentences."""


def format_name(name: str) -> str:
    """A name without underscores."""
    return name.replace("_", " ")


def format_key(key: str) -> str:
    """A key of the machine in words.

    >>> format_key("effects.side_force.force")
    'side force, force'
    """
    return format_name(key.removeprefix("effects.").replace(".", ", "))


def format_explanation(name: str) -> str:
    """An explanation in words: effects, keys of the machine and faults of files, whose names keep their dots.

    >>> format_explanation("run_clock in p_16.csv with valve.piston_area")
    'run clock in p_16.csv with valve, piston area'
    """
    parts = (part.partition(" in ") for part in name.split(" with "))
    return " with ".join(format_key(kind) + found + file for kind, found, file in parts)
