"""What the page hands on: the machine as a file, and the command that gives the same numbers."""

import shlex

from apesim.engine.machine import Machine
from apesim.quantities.settings import differences

MAX_SETTINGS = 8
"""Keys that are written on the command line; more stand better in a machine file."""
FILE = "mine.toml"
"""Name of the machine file that the page saves."""


def command_of(machine: Machine, speed: str) -> str:
    """Write the command of the shell that runs a machine at a speed.

    >>> command_of(Machine().with_(engine_bore="90 mm"), "1000 rpm")
    "apesim engine run --speed '1000 rpm' --set 'engine.bore=90 mm'"
    """
    changed = list(differences(machine))
    words = ["apesim", "engine", "run", "--speed", speed]
    tables = {"cylinder", "effects.files", "known_to"}
    is_plain = not any(key in tables or "[" in key or text.startswith("a curve") for key, text in changed)
    if is_plain and len(changed) <= MAX_SETTINGS:
        for key, text in changed:
            words += ["--set", f"{key}={'' if text == 'not given' else text}"]
    else:
        words += ["--machine", FILE]
    return shlex.join(words)
