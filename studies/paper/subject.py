"""Whose valve the paper's claims are judged on: the paper's (Table 1), or another one of the user's."""

import numpy as np

from apesim.quantities.settings import schema

SECTIONS = ("air", "ambient", "valve", "effects")
"""Of the machine, that the valve's bench depends on; the supply is that of each claim."""
PAPERS = "the paper's valve"


def differences(machine):
    """By what a machine's valve is another one than the paper's.

    Parameters
    ----------
    machine : engine.machine.Machine

    Returns
    -------
    list of str
        ``valve.stroke = 8 mm instead of 9 mm``, one for each key.
    """
    cls, found = type(machine), []
    for own, papers in zip(schema(cls, machine), schema(cls), strict=True):
        if own.key.split(".")[0] not in SECTIONS or np.array_equal(own.default, papers.default, equal_nan=True):
            continue
        if isinstance(own.default, np.ndarray):
            found.append(f"{own.key} from a file of {len(own.default)} rows")
        else:
            ours, theirs = (leaf.declaration.render(leaf.default) or "not given" for leaf in (own, papers))
            found.append(f"{own.key} = {ours} instead of {theirs}")
    return found


def subject_of(machine):
    """Whose valve it is, in one line."""
    different = differences(machine)
    return f"another valve: {', '.join(different)}" if different else PAPERS
