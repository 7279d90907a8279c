"""How two archives differ: in machine, axes and results, run by run."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from apesim.archive.file import Archive, read, read_about

__all__ = ["Difference", "diff", "machine_differences", "provenance_differences"]

Path = str | os.PathLike[str]


class Difference(NamedTuple):
    """One difference between two archives; what one of them lacks is None."""

    kind: str  # "machine", "axis", "run", "variable" or "provenance"
    name: str  # TOML key, variable, or provenance entry
    run: int | None
    where: str  # place of the largest deviation, such as "crank_angle = 12.0"
    a: Any
    b: Any
    samples: int  # values that differ


def diff(path_a: Path, path_b: Path, rtol: float = 0.0, atol: float = 0.0) -> list[Difference]:
    """Compare two archives in machine, axes and results; runs are matched by number, NaN equals NaN.

    Parameters
    ----------
    path_a, path_b : path
        The archives.
    rtol, atol : float
        float64 values are equal within atol + rtol times the larger magnitude; others must be the same.

    Returns
    -------
    list of Difference
        Empty when equal; for results one row for each variable and run. A variable over an axis of another
        length is not compared, the axis is reported. Provenance: see `provenance_differences`.

    Raises
    ------
    ArchiveError
        One of them cannot be read.
    """
    a, b = read(path_a), read(path_b)
    rows = machine_differences(a.machine, b.machine)
    _, at_a, at_b = np.intersect1d(a.runs, b.runs, assume_unique=True, return_indices=True)
    for run in np.setdiff1d(a.runs, b.runs).tolist():
        rows.append(Difference("run", "run", run, "", run, None, 1))
    for run in np.setdiff1d(b.runs, a.runs).tolist():
        rows.append(Difference("run", "run", run, "", None, run, 1))
    for name in {**a.variables, **b.variables}:
        mine, other = a.variables.get(name), b.variables.get(name)
        kind = "axis" if name in (mine or other).dims else "variable"  # type: ignore[union-attr]
        if mine is None or other is None:
            rows.append(Difference(kind, name, None, "", mine and mine.unit, other and other.unit, 1))
            continue
        left, right = ((v.dims, v.kind, v.unit, v.meanings) for v in (mine, other))
        if left != right:
            rows.append(Difference(kind, name, None, "axes, type, unit, meanings", left, right, 1))
        if mine.dims != other.dims or mine.kind != other.kind or name == "run":
            continue
        if mine.dims[0] != "run":
            rows += _compared(kind, name, None, mine.values, other.values, a, mine.dims, rtol, atol)
        elif mine.values.shape[1:] == other.values.shape[1:]:
            ours, theirs = mine.values[at_a], other.values[at_b]
            differs = ~_equal(ours, theirs, rtol, atol).all(axis=tuple(range(1, ours.ndim)))
            for i in np.flatnonzero(differs):
                run = int(a.runs[at_a[i]])
                rows += _compared(kind, name, run, ours[i], theirs[i], a, mine.dims[1:], rtol, atol)
    return rows


def machine_differences(a: str, b: str) -> list[Difference]:
    """Keys in which two machine texts differ, dotted as in "engine.bore"; comments and order do not count."""
    try:
        left, right = dict(_leaves(tomllib.loads(a))), dict(_leaves(tomllib.loads(b)))
    except (tomllib.TOMLDecodeError, RecursionError):
        left, right = {"(text)": a}, {"(text)": b}
    return _changed("machine", left, right)


def provenance_differences(path_a: Path, path_b: Path) -> list[Difference]:
    """Entries of the provenance that differ: time, versions, command. They do not make archives different."""
    return _changed("provenance", read_about(path_a)[1], read_about(path_b)[1])


def _changed(kind: str, left: dict[str, Any], right: dict[str, Any]) -> list[Difference]:
    absent = object()
    return [
        Difference(kind, key, None, "", left.get(key), right.get(key), 1)
        for key in {**left, **right}
        if repr(left.get(key, absent)) != repr(right.get(key, absent))
    ]


def _leaves(table: dict[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, dict) and value:
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _equal(a: np.ndarray, b: np.ndarray, rtol: float, atol: float) -> np.ndarray:
    equal = a == b
    if a.dtype.kind == "f":
        equal |= np.isnan(a) & np.isnan(b)
        finite = np.isfinite(a) & np.isfinite(b)
        with np.errstate(invalid="ignore", over="ignore"):
            equal |= finite & (np.abs(a - b) <= atol + rtol * np.maximum(np.abs(a), np.abs(b)))
    return equal


def _compared(
    kind: str,
    name: str,
    run: int | None,
    a: np.ndarray,
    b: np.ndarray,
    archive: Archive,
    axes: tuple[str, ...],
    rtol: float,
    atol: float,
) -> list[Difference]:
    a, b = np.asarray(a), np.asarray(b)
    if a.shape != b.shape:
        return [Difference(kind, name, run, "length", len(a), len(b), 1)]
    differs = ~np.asarray(_equal(a, b, rtol, atol))
    if not differs.any():
        return []
    size = differs.astype(float)
    if a.dtype.kind == "f":
        with np.errstate(invalid="ignore", over="ignore"):
            size *= np.nan_to_num(np.abs(a - b), nan=np.inf)
    at = np.unravel_index(int(np.argmax(np.where(differs, size, -1.0))), differs.shape)
    places = (f"{axis} = {archive.variables[axis].values[i]}" for axis, i in zip(axes, at, strict=True))
    return [Difference(kind, name, run, ", ".join(places), a[at].item(), b[at].item(), int(differs.sum()))]
