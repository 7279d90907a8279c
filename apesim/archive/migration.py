"""Archives of older format versions, brought to what their variables mean today."""

from __future__ import annotations

from dataclasses import replace

from apesim.archive.records import Archive

__all__ = ["MIGRATED", "migrate"]

MIGRATED = "migrated"
"""Entry of the provenance that says what was changed on reading."""
FIRST_WITH_VELOCITY_OF_LIFT = 2
VELOCITY_TO_CLOSED = ("dL/dt, positive as the valve closes", "dL/dt, positive as it closes")
"""How format version 1 described the velocities of the valve alone; those of an engine were of the lift already."""
VELOCITY_OF_LIFT = "velocity of the lift, positive as it opens"


def migrate(archive: Archive) -> Archive:
    """Turn the velocities of the valve alone to d(lift)/dt, where an archive has them as dL/dt.

    Parameters
    ----------
    archive : Archive
        As it was read; its provenance names its format version.

    Returns
    -------
    Archive
        With an entry `MIGRATED` in its provenance, if anything was changed.
    """
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
