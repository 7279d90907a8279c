"""Whose valve the paper's claims are judged on: the paper's (Table 1), or another one of the user's."""

from collections.abc import Sequence

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities import Curve
from apesim.quantities.settings import schema

SECTIONS = ("air", "ambient", "valve", "effects")
"""Sections of the machine that the valve's bench depends on; the supply is that of each claim."""
ENGINE_SECTIONS = (*SECTIONS, "supply", "groove", "engine", "command")
"""Sections of the machine that its valve in the engine depends on."""
PAPERS = "the paper's valve"


def differences(machine: Machine, sections: Sequence[str] = SECTIONS) -> list[str]:
    """Find what makes a machine's valve another one than the paper's, e.g. ``valve.stroke = 8 mm instead of 9 mm``.

    There is one text for each key; `sections` are those compared with the default machine's.
    """
    cls, texts = type(machine), []
    for leaf, default in zip(schema(cls, machine), schema(cls), strict=True):
        if leaf.key.split(".")[0] not in sections or np.array_equal(leaf.default, default.default, equal_nan=True):
            continue
        if isinstance(leaf.declaration, Curve):
            texts.append(f"{leaf.key} from a file of {len(leaf.default)} rows")
        else:
            ours, theirs = (each.declaration.render(each.default) or "not given" for each in (leaf, default))
            texts.append(f"{leaf.key} = {ours} instead of {theirs}")
    return texts


def engine_subject_of(machine: Machine) -> str:
    """Say whose valve it is and in which engine, in one line; the paper prints no engine."""
    different = differences(machine, ENGINE_SECTIONS)
    return f"another engine: {', '.join(different)}" if different else f"{PAPERS} in the default engine"


def subject_of(machine: Machine) -> str:
    """Say whose valve it is, in one line.

    >>> subject_of(Machine().with_(valve_stroke="8 mm"))
    'another valve: valve.stroke = 8 mm instead of 9 mm'
    """
    different = differences(machine)
    return f"another valve: {', '.join(different)}" if different else PAPERS
