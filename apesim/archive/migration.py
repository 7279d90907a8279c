"""Archives of older format versions, brought to what their variables mean today.

Units need no migration: those of older versions are our names, see `apesim.archive.conventions`.
"""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import replace

from apesim.archive.records import Archive, Variable

__all__ = ["MIGRATED", "migrate"]

MIGRATED = "migrated"
"""Entry of the provenance that says what was changed on reading."""
FIRST_WITH_VELOCITY_OF_LIFT = 2
VELOCITY_TO_CLOSED = ("dL/dt, positive as the valve closes", "dL/dt, positive as it closes")
"""How format version 1 described the velocities of the valve alone; those of an engine were of the lift already."""
FIRST_WITH_COORDINATES = 3
VELOCITY_OF_LIFT = "velocity of the lift, positive as it opens"
RENAMED = {"uncorrected_": "fixed_"}
"""Beginnings of names that a map of timing or an optimum once had, by today's: ``--timing fixed`` is the word."""


def migrate(archive: Archive) -> Archive:
    """Bring an archive of an older format version to what its variables mean today.

    The velocities of the valve alone are turned to d(lift)/dt, where an archive has them as dL/dt; what its grid names
    as axes become coordinates; names with another beginning have today's, see `RENAMED`. If values were changed, its
    provenance has an entry `MIGRATED`.
    """
    if any(name.startswith(tuple(RENAMED)) for name in archive.variables):
        archive = replace(archive, variables={_rename(name): each for name, each in archive.variables.items()})
    if int(archive.provenance["format_version"]) < FIRST_WITH_COORDINATES:
        archive = replace(archive, variables=archive.variables | _coordinates(archive))
    if int(archive.provenance["format_version"]) >= FIRST_WITH_VELOCITY_OF_LIFT:
        return archive
    turned = {
        name: replace(variable, values=0.0 - variable.values, description=VELOCITY_OF_LIFT)
        for name, variable in archive.variables.items()
        if variable.description in VELOCITY_TO_CLOSED
    }
    if not turned:
        return archive
    told = f"{', '.join(turned)}: turned from dL/dt, as format version 1 has it, to d(lift)/dt"
    return replace(archive, variables=archive.variables | turned, provenance=archive.provenance | {MIGRATED: told})


def _rename(name: str) -> str:
    """Name of a variable today."""
    for before, today in RENAMED.items():
        if name.startswith(before):
            return today + name.removeprefix(before)
    return name


def _coordinates(archive: Archive) -> dict[str, Variable]:
    """Variables that the provenance names as axes of a grid, marked as coordinates."""
    with suppress(ValueError, TypeError):
        names = [name for name in json.loads(archive.provenance.get("axes", "{}")) if name in archive.variables]
        return {name: replace(archive.variables[name], coordinate=True) for name in names}
    return {}
