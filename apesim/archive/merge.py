"""Parts of one sweep, joined to one archive."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from apesim.archive.comparison import machine_differences
from apesim.archive.file import Archive, ArchiveError

__all__ = ["merge"]


def merge(parts: Sequence[Archive], names: Sequence[str | os.PathLike[str]] | None = None) -> Archive:
    """Join parts of one sweep, at least one, sorted by run number; `missing_runs` says whether it is complete.

    Machine, plan_hash, variables, units and all axes but "run" must agree; runs that occur twice collapse if they agree
    bit for bit. Provenance entries that differ are listed one after the other, except "created", which `write` sets
    anew. `names` of the files are for messages. Raises ArchiveError where the parts do not belong together, or
    contradict each other on a run.
    """
    labels = [os.fspath(name) for name in names] if names else [f"part {i + 1}" for i in range(len(parts))]
    if not parts:
        raise ArchiveError("merge", "no parts were given", "name at least one archive")

    # Parts of different sweeps may contradict each other on any run: that they do not fit is told first.
    for label, part in zip(labels, parts, strict=True):
        if conflict := _conflict(parts[0], part):
            raise ArchiveError(label, f"does not fit {labels[0]}: {conflict}", "merge parts of one sweep only")

    # One order for all variables. The sort is stable: of a run that occurs twice, the earlier part's is kept.
    runs = np.concatenate([part.runs for part in parts])
    owner = np.repeat(np.arange(len(parts)), [len(part.runs) for part in parts])
    order = np.argsort(runs, kind="stable")
    again = np.flatnonzero(np.diff(runs[order]) == 0)  # positions whose successor is the same run
    keep = np.delete(order, again + 1)
    in_order = np.array_equal(keep, np.arange(len(runs)))

    # Each variable in that order; runs that occur twice are compared before one of them is left out.
    variables = {}
    for name, variable in parts[0].variables.items():
        if variable.dims[0] == "run":
            values = np.concatenate([part.variables[name].values for part in parts])
            for left, right in zip(order[again], order[again + 1], strict=True):
                if not _same(values[left], values[right]):
                    raise ArchiveError(
                        labels[owner[right]],
                        f"run {runs[right]} contradicts {labels[owner[left]]} in {name}",
                        "find out which one is right and leave the other out",
                    )
            variable = replace(variable, values=values if in_order else values[keep])
        variables[name] = variable
    return Archive(parts[0].machine, _joined_provenance(parts), variables)


def _conflict(a: Archive, b: Archive) -> str:
    if a.machine != b.machine:
        keys = ", ".join(row.name for row in machine_differences(a.machine, b.machine)[:3])
        return f"another machine ({keys or 'in its comments'})"
    if a.provenance.get("plan_hash") != b.provenance.get("plan_hash"):
        return "other settings (plan_hash)"
    if only := sorted(a.variables.keys() ^ b.variables.keys()):
        return f"only one of them has {only[0]}"
    for name, mine in a.variables.items():
        other = b.variables[name]
        for field in ("kind", "dims", "unit", "description", "meanings", "finite"):
            if getattr(mine, field) != getattr(other, field):
                return f"{name} has {field} {getattr(other, field)!r}, not {getattr(mine, field)!r}"
        if mine.dims[0] != "run" and not _same(mine.values, other.values):
            return f"the axis {name} differs"
        if mine.values.shape[1:] != other.values.shape[1:]:
            return f"{name} has another shape"
    return ""


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    a, b = np.asarray(a), np.asarray(b)
    if a.dtype.kind == "U":
        return bool(np.array_equal(a, b))
    return a.shape == b.shape and a.tobytes() == b.tobytes()


def _joined_provenance(parts: Sequence[Archive]) -> dict[str, str]:
    joined: dict[str, list[str]] = {}
    for part in parts:
        for key, value in part.provenance.items():
            if key != "created" and value not in joined.setdefault(key, []):
                joined[key].append(value)
    return {key: "; ".join(values) for key, values in joined.items()}
