"""The machine of a command: read, checked, printed."""

from apesim.quantities.settings import dumps, load
from engine.machine import Machine


def load_machine(machine_file, settings):
    """The machine of a command line.

    Parameters
    ----------
    machine_file : path or None
    settings : list of str or None
        ``KEY=VALUE``

    Returns
    -------
    Machine

    Raises
    ------
    InputError
        With one culprit for each fault.
    """
    return load(Machine, machine_file, settings or ())


def print_machine(console, machine_file, settings):
    """Print a machine as a commented machine file."""
    text = dumps(load_machine(machine_file, settings))
    console.result({"machine": text}, text.rstrip())


def check_machine(console, path, settings):
    """Check a machine file; raises `InputError` where it is wrong."""
    load_machine(path, settings)
    console.result({"file": str(path), "good": True}, f"{path}: good")
