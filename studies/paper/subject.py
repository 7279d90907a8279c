"""Whose valve the paper's claims are judged on: the paper's (Table 1), or another one of the user's."""

import numpy as np

from apesim.quantities.settings import schema

SECTIONS = ("air", "ambient", "valve", "effects")
"""Sections of the machine that the valve's bench depends on; the supply is that of each claim."""
ENGINE_SECTIONS = (*SECTIONS, "supply", "groove", "engine", "command")
"""Sections of the machine that its valve in the engine depends on."""
PAPERS = "the paper's valve"


def differences(machine, sections=SECTIONS):
    """Find what makes a machine's valve another one than the paper's.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    sections : sequence of str
        Compared with the default machine's.

    Returns
    -------
    list of str
        ``valve.stroke = 8 mm instead of 9 mm``, one for each key.
    """
    cls, found = type(machine), []
    for own, papers in zip(schema(cls, machine), schema(cls), strict=True):
        if own.key.split(".")[0] not in sections or np.array_equal(own.default, papers.default, equal_nan=True):
            continue
        if isinstance(own.default, np.ndarray):
            found.append(f"{own.key} from a file of {len(own.default)} rows")
        else:
            ours, theirs = (leaf.declaration.render(leaf.default) or "not given" for leaf in (own, papers))
            found.append(f"{own.key} = {ours} instead of {theirs}")
    return found


def engine_subject_of(machine):
    """Whose valve it is and in which engine, in one line; the paper prints no engine."""
    different = differences(machine, ENGINE_SECTIONS)
    return f"another engine: {', '.join(different)}" if different else f"{PAPERS} in the default engine"


def subject_of(machine):
    """Whose valve it is, in one line."""
    different = differences(machine)
    return f"another valve: {', '.join(different)}" if different else PAPERS
