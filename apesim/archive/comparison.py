"""How two archives differ: in machine, axes and results, run by run, those at the same coordinates side by side."""

from __future__ import annotations

import os
import tomllib
from collections import Counter
from collections.abc import Iterable
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from apesim.archive.file import Archive, read, read_about
from apesim.archive.grid import axes_of, words_of

__all__ = ["Comparison", "Difference", "Summary", "diff", "machine_differences", "provenance_differences", "summarise"]

Path = str | os.PathLike[str]


class Difference(NamedTuple):
    """One difference between two archives; what one of them lacks is None."""

    kind: str  # "machine", "axis", "run", "variable" or "provenance"
    name: str  # TOML key, variable, or provenance entry
    run: int | None  # number of the run in the first archive, or in the only one that has it
    where: str  # coordinates of the run and place of the largest deviation: "speed_rpm = 900.0, crank_angle = 12.0"
    a: Any
    b: Any
    samples: int  # values that differ


class Comparison(NamedTuple):
    """What comparing two archives came to."""

    differences: list[Difference]
    """Empty when equal."""
    runs: int
    """Runs compared side by side."""
    same: int
    """Variables and axes that agree in all runs compared; the run numbers do not count."""
    different: int
    """Variables and axes that do not, or that only one of them has."""


class Summary(NamedTuple):
    """All differences of one name."""

    kind: str
    name: str
    runs: int
    """In which it differs; 0: it does not belong to runs."""
    largest: float | None
    """Largest absolute difference of a number; None: there are no two numbers."""
    relative: float | None
    """Largest difference over the larger of both magnitudes, taken where each run differs most."""
    where: str
    """Place of the largest."""
    where_relative: str
    """Place of the largest relative one."""
    a: Any
    """What the first archive has there, or in the first difference where there are no two numbers."""
    b: Any
    """What the second one has there."""


def diff(path_a: Path, path_b: Path, rtol: float = 0.0, atol: float = 0.0, floor: float = 0.0) -> Comparison:
    """Compare two archives in machine, axes and results; NaN equals NaN.

    Runs are matched by the coordinates that both have; by number where one has none, or where coordinates do not tell
    its runs from each other. float64 values are equal within atol + rtol times the larger magnitude, others must be the
    same; `floor`, a share of the largest magnitude of a variable (or of 1 for smaller numbers without a unit), is added
    to `atol`: what is nearly zero may differ by rounding alone. A variable over an axis of another length is not
    compared, the axis is reported; provenance: see `provenance_differences`. Raises ArchiveError where one cannot be
    read.
    """
    a, b = read(path_a), read(path_b)
    rows = machine_differences(a.machine, b.machine)

    # Which runs belong together: in a grid of other points the same coordinates have another number.
    names = _common_axes(a, b, rows)
    keys_a, keys_b = _keys_of(a, names), _keys_of(b, names)
    at_a = [i for key, i in keys_a.items() if key in keys_b]
    at_b = [keys_b[key] for key in keys_a if key in keys_b]

    # Runs without a partner are told here: values are compared for pairs alone.
    for key, i in keys_a.items():
        if key not in keys_b:
            rows.append(Difference("run", "run", int(a.runs[i]), _place(names, key), int(a.runs[i]), None, 1))
    for key, i in keys_b.items():
        if key not in keys_a:
            rows.append(Difference("run", "run", int(b.runs[i]), _place(names, key), None, int(b.runs[i]), 1))

    # Variable by variable. Where axes or type differ, there are no values to set side by side. The run numbers may
    # differ, as coordinates have matched the runs.
    places = {i: _place(names, key) for key, i in keys_a.items()}
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
            # All runs in one operation: only those that differ are looked at one by one, for the place.
            ours, theirs = mine.values[at_a], other.values[at_b]
            absolute = atol + floor * _size(mine.unit, ours, theirs)
            differs = ~_equal(ours, theirs, rtol, absolute).all(axis=tuple(range(1, ours.ndim)))
            for i in np.flatnonzero(differs).tolist():
                run, place = int(a.runs[at_a[i]]), places[at_a[i]]
                found = _compared(kind, name, run, ours[i], theirs[i], a, mine.dims[1:], rtol, absolute)
                rows += [row._replace(where=", ".join(filter(None, (place, row.where)))) for row in found]

    # What the counts are of: each variable once, however many runs it differs in.
    compared = (a.variables.keys() | b.variables.keys()) - {"run"}
    different = compared & {row.name for row in rows if row.kind in ("axis", "variable")}
    return Comparison(rows, len(at_a), len(compared) - len(different), len(different))


def _size(unit: str, *sides: np.ndarray) -> float:
    """Largest finite magnitude of floats, at least 1 where they have no unit; 0.0 for all else."""
    sizes = [np.abs(values[np.isfinite(values)]).max(initial=0.0) for values in sides if values.dtype.kind == "f"]
    return max([float(unit == "1"), *map(float, sizes)]) if sizes else 0.0


def _common_axes(a: Archive, b: Archive, rows: list[Difference]) -> list[str] | None:
    """Names of the coordinates by which the runs of two archives are matched; None: by number.

    One that only one of them has is added to `rows`, and runs are matched by the others, where these suffice.
    """
    axes_a, axes_b = _coordinates(a), _coordinates(b)
    if not axes_a or not axes_b:
        return None
    if axes_a.keys() == axes_b.keys() and any(len(_keys_of(one, list(axes_a))) < len(one.runs) for one in (a, b)):
        return None
    for name in {**axes_a, **axes_b}:
        if name not in axes_a or name not in axes_b:
            mine, other = (", ".join(axes[name]) if name in axes else None for axes in (axes_a, axes_b))
            rows.append(Difference("axis", name, None, "in one of them only", mine, other, 1))
    return [name for name in axes_a if name in axes_b]


def _coordinates(archive: Archive) -> dict[str, list[str]]:
    """Texts of the values of each coordinate over the runs, by its name."""
    try:
        return axes_of(archive)
    except ValueError:
        columns = {name: v for name, v in archive.variables.items() if v.coordinate and v.dims == ("run",)}
        return {name: [str(value) for value in dict.fromkeys(words_of(v).tolist())] for name, v in columns.items()}


def _keys_of(archive: Archive, names: list[str] | None) -> dict[tuple[Any, ...], int]:
    """Index of each run by its coordinates, or by its number without names; none of those that share coordinates."""
    if names is None:
        return {(run,): i for i, run in enumerate(archive.runs.tolist())}
    columns = [words_of(archive.variables[name]).tolist() for name in names]
    keys = list(zip(*columns, strict=True)) if names else [()] * len(archive.runs)
    count = Counter(keys)
    return {key: i for i, key in enumerate(keys) if count[key] == 1}


def _place(names: list[str] | None, key: tuple[Any, ...]) -> str:
    """Coordinates of a run in words; "" for a number, which has a column of its own."""
    return ", ".join(f"{name} = {value}" for name, value in zip(names, key, strict=True)) if names else ""


def summarise(rows: Iterable[Difference]) -> list[Summary]:
    """Sum up differences by kind and name, in the order in which the names come first."""
    groups: dict[tuple[str, str], list[Difference]] = {}
    for row in rows:
        groups.setdefault((row.kind, row.name), []).append(row)
    found = []
    for (kind, name), group in groups.items():
        apart = [(_apart(row.a, row.b), row) for row in group]
        numbers = [(size, row) for size, row in apart if size is not None]
        runs = len({(row.run, row.a is None) for row in group if row.run is not None})
        if not numbers:
            found.append(Summary(kind, name, runs, None, None, group[0].where, "", group[0].a, group[0].b))
            continue
        size, row = max(numbers, key=lambda pair: pair[0])
        shares = [(number / max(abs(row.a), abs(row.b)), row) for number, row in numbers]
        relative, relative_row = max(shares, key=lambda pair: pair[0])
        found.append(Summary(kind, name, runs, size, relative, row.where, relative_row.where, row.a, row.b))
    return found


def _apart(a: Any, b: Any) -> float | None:
    """Absolute difference of two different finite numbers; None of anything else."""
    if not isinstance(a, float) or not isinstance(b, float) or not isfinite(a) or not isfinite(b):
        return None
    return abs(a - b)


def machine_differences(a: str, b: str) -> list[Difference]:
    r"""Find the keys in which two machine texts (TOML) differ; comments and order do not count.

    Keys are dotted as in "engine.bore"; where one text is no TOML, both are compared as they stand.
    """
    try:
        left, right = dict(_leaves(tomllib.loads(a))), dict(_leaves(tomllib.loads(b)))
    except (tomllib.TOMLDecodeError, RecursionError):
        left, right = {"(text)": a}, {"(text)": b}
    return _changed("machine", left, right)


def provenance_differences(path_a: Path, path_b: Path) -> list[Difference]:
    """Find the entries of the provenance in which two archives differ: time, versions, command.

    They do not make archives different. Raises ArchiveError where one cannot be read.
    """
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
