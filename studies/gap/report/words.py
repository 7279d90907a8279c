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
