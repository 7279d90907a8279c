"""Whose valve the paper's claims are judged on: the paper's (Table 1), or another one of the user's."""

from collections.abc import Sequence

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities.settings import schema

SECTIONS = ("air", "ambient", "valve", "effects")
"""Sections of the machine that the valve's bench depends on; the supply is that of each claim."""
ENGINE_SECTIONS = (*SECTIONS, "supply", "groove", "engine", "command")
"""Sections of the machine that its valve in the engine depends on."""
PAPERS = "the paper's valve"


def differences(machine: Machine, sections: Sequence[str] = SECTIONS) -> list[str]:
    """Find what makes a machine's valve another one than the paper's.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    sections : sequence of str
        Sections that are compared with the default machine's.

    Returns
    -------
    list of str
        ``valve.stroke = 8 mm instead of 9 mm``, one for each key.

    Examples
    --------
    >>> differences(Machine().with_(valve_stroke="8 mm"))
    ['valve.stroke = 8 mm instead of 9 mm']
    """
    cls, texts = type(machine), []
    for leaf, default in zip(schema(cls, machine), schema(cls), strict=True):
        if leaf.key.split(".")[0] not in sections or np.array_equal(leaf.default, default.default, equal_nan=True):
            continue
        if isinstance(leaf.default, np.ndarray):
            texts.append(f"{leaf.key} from a file of {len(leaf.default)} rows")
        else:
            ours, theirs = (each.declaration.render(each.default) or "not given" for each in (leaf, default))
            texts.append(f"{leaf.key} = {ours} instead of {theirs}")
    return texts


def engine_subject_of(machine: Machine) -> str:
    """Say whose valve it is and in which engine, in one line; the paper prints no engine.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine

    Returns
    -------
    str

    Examples
    --------
    >>> engine_subject_of(Machine())
    "the paper's valve in the default engine"
    """
    different = differences(machine, ENGINE_SECTIONS)
    return f"another engine: {', '.join(different)}" if different else f"{PAPERS} in the default engine"


def subject_of(machine: Machine) -> str:
    """Say whose valve it is, in one line.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine

    Returns
    -------
    str

    Examples
    --------
    >>> subject_of(Machine().with_(valve_stroke="8 mm"))
    'another valve: valve.stroke = 8 mm instead of 9 mm'
    """
    different = differences(machine)
    return f"another valve: {', '.join(different)}" if different else PAPERS
