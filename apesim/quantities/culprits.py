"""Culprits: what is told of bad input, one line for each fault, with its remedy."""

import math
from typing import NamedTuple

from apesim.terminal import visible


class Wrong(ValueError):
    """One wrong text: what is wrong, and what would be right (empty: an example says it best)."""

    def __init__(self, wrong, right=""):
        super().__init__(wrong, right)
        self.wrong, self.right = wrong, right


class Culprit(NamedTuple):
    """One fault of the input, printed on one line."""

    file: str
    key: str
    wrong: str
    right: str

    def __str__(self):
        line = ": ".join(part for part in (self.file, _shortened(self.key), self.wrong) if part) + f"; {self.right}"
        return visible(line)


class InputError(Exception):
    """Bad input. `culprits` lists every fault found; as text, one line for each."""

    def __init__(self, culprits):
        super().__init__(culprits)
        self.culprits = list(culprits)

    def __str__(self):
        return "\n".join(map(str, self.culprits))


def quoted(raw):
    """What the user wrote, on one line and not too long."""
    try:
        text = repr(raw)
    except ValueError:  # Python refuses to print integers of thousands of digits
        return "a huge number"
    return _shortened(text)


def _shortened(text):
    return text if len(text) <= 60 else f"{text[:24]}…{text[-34:]}"


def culprit(file, key, wrong, declaration, default=math.nan, ambient_pressure=None):
    """The `Culprit` of a `Wrong`; where that names no right form, the default shows one."""
    return Culprit(file, key, wrong.wrong, wrong.right or declaration.example(default, ambient_pressure))
