"""The machine of a command: read, checked, printed."""

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps, load, overruled, schema


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
        standard = {leaf.key: leaf.default for leaf in schema(Machine)}
        given = {leaf.key: leaf.default for leaf in schema(Machine, machine)}
        idle = {
            key: reason
            for key, reason in overruled(machine)
            if not np.array_equal(given[key], standard[key], equal_nan=True)
        }
        told = (f"{check}: {key}: is not looked at: {reason}" for key, reason in idle.items())
        console.result({"file": str(check), "good": True, "not_looked_at": idle}, *told, f"{check}: good")
        return
    text = dumps(machine)
    console.result({"machine": text}, text.rstrip())
