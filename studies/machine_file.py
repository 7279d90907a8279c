"""The machine file of a study, with what is set besides."""

from collections.abc import Sequence
from pathlib import Path

from apesim.engine.machine import Machine


def load_machine(machine_file: str | Path | None = None, settings: Sequence[str] | None = None) -> Machine:
    """The machine of a file, with what is set besides.

    Parameters
    ----------
    machine_file : path or None
        TOML; the embedded machine if left out.
    settings : sequence of str or None
        ``KEY=VALUE``, e.g. ``engine.bore="90 mm"``; ``effects.files=PATH`` names an effect from outside.

    Returns
    -------
    Machine

    Raises
    ------
    InputError
        With one culprit for each fault.
    """
    return Machine.load(machine_file, settings or ())
