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


def machine_command(console, machine_file, settings, check):
    """Print a machine as a commented machine file, or check one; raises `InputError` where it is wrong."""
    machine = load_machine(check or machine_file, settings)
    if check:
        console.result({"file": str(check), "good": True}, f"{check}: good")
        return
    text = dumps(machine)
    console.result({"machine": text}, text.rstrip())
