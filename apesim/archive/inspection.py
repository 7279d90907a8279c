"""Looking into archives: what is in them, whether they are sound, and CSV out of them."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from apesim.archive.completeness import gaps_in_words, missing_runs, runs_planned
from apesim.archive.digests import DIGESTS, ROOT_DIGEST
from apesim.archive.errors import NoArchiveError
from apesim.archive.file import Archive, ArchiveError, read, read_about, read_digest
from apesim.archive.loading import check_digest, load_digests, load_stored, opened, variable_of
from apesim.archive.migration import FIRST_WITH_COORDINATES
from apesim.archive.records import (
    ATTRIBUTES,
    FIRST_WITH_DIGESTS,
    KIND,
    ROOT_ATTRIBUTES,
    Variable,
    check_variable,
    codes_of,
    validate,
)
from apesim.archive.surroundings import PACKAGES
from apesim.archive.untrusted import damage_named
from apesim.archive.writing import format_csv, remove_file, write_file

__all__ = ["export", "info", "verify"]

ABOUT = ("about/machine", "about/provenance")
"""Datasets that every archive has, besides the run numbers."""
KNOWN = (*ABOUT, DIGESTS)
"""Datasets that the group ``about`` may hold."""
DATASET_ATTRIBUTES = (*ATTRIBUTES, "_Encoding", "CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST")
"""Attributes that a dataset of an archive may have: ours, and those of dimension scales."""


def info(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return what an archive holds, in a form that JSON can take.

    The keys: `path`, `bytes`, `format`, `format_version`, `content_sha256` (see `read_digest`), `created`, `versions`,
    `runs`, `runs_planned` (of the whole sweep, None where it is not known), `first_run`, `last_run`, `missing_runs`
    (first and last of each gap in its share of the sweep), `axes` (name, length, unit, first and last value),
    `variables` (name, dims, shape, dtype, unit, description, meanings), `machine`, `provenance`, `outside_effects`
    (``effect``, ``file``, ``sha256`` of each that the machine had; no code is loaded). Raises ArchiveError where the
    archive cannot be read.
    """
    archive = read(path)

    # Axes stand in both lists: with their ends in one, and as variables in the other.
    axes, variables = [], []
    for name, variable in archive.variables.items():
        if variable.dims == (name,):
            ends = variable.values[[0, -1]].tolist() if len(variable.values) else [None, None]
            axes.append(
                {
                    "name": name,
                    "length": len(variable.values),
                    "unit": variable.unit,
                    "first": ends[0],
                    "last": ends[1],
                }
            )
        variables.append(
            {
                "name": name,
                "dims": list(variable.dims),
                "shape": list(variable.values.shape),
                "dtype": variable.kind,
                "unit": variable.unit,
                "description": variable.description,
                "meanings": variable.meanings,
            }
        )

    # Entries of the provenance may be missing, and so may all runs: what is not known is empty or None.
    provenance = archive.provenance
    runs = archive.runs.tolist()
    return {
        "path": os.fspath(path),
        "bytes": os.path.getsize(path),
        "format": provenance.get("format", ""),
        "format_version": provenance.get("format_version", ""),
        "content_sha256": read_digest(path),
        "created": provenance.get("created", ""),
        "versions": {k: provenance[k] for k in ("python", *PACKAGES, "hdf5") if k in provenance},
        "runs": len(runs),
        "runs_planned": runs_planned(archive),
        "first_run": runs[0] if runs else None,
        "last_run": runs[-1] if runs else None,
        "missing_runs": [list(gap) for gap in missing_runs(archive)],
        "axes": axes,
        "variables": variables,
        "machine": archive.machine,
        "outside_effects": outside_effects(archive.machine),
        "provenance": provenance,
    }


def outside_effects(machine: str) -> list[dict[str, str]]:
    r"""Return the effects from outside that a machine's TOML text records; no file is looked for.

    Each has ``effect``, its name, ``file``, the name of its file, and ``sha256`` of the file's content; empty for a
    text that records none or is no TOML.
    """
    try:
        section = tomllib.loads(machine).get("effects")
    except ValueError:
        return []
    files = section.get("files") if isinstance(section, dict) else None
    if not isinstance(files, list):
        return []
    return [{key: str(text) for key, text in entry.items()} for entry in files if isinstance(entry, dict)]


def verify(path: str | os.PathLike[str]) -> list[str]:
    """Read every chunk and check every promise of the format, and that no planned run is missing.

    Returns one line for each fault, none when the archive is sound. Raises ArchiveError where there is no such file, or
    it is no archive that this version of apesim knows.
    """
    path = Path(path)
    faults: list[str] = []

    # The head, first: a file that is no archive raises, and where the head cannot be read, that is the one fault told.
    try:
        machine, provenance = read_about(path)
        tomllib.loads(machine)
    except NoArchiveError:
        raise
    except ArchiveError as error:
        return [str(error)]
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        faults.append(f"{path}: about/machine: is no TOML ({error})")
    try:
        with opened(path) as file:
            digests = load_digests(file, path)
            variables: dict[str, Variable] = {}
            users: dict[str, set[tuple[str, int]]] = {}
            results = [name for name in file if name != "about"]

            # The root and the groups: no digest covers what somebody has added to them.
            for item, known in _known_attributes(file).items():
                try:
                    with damage_named(path, item):
                        _check_attributes(file[item or "/"], known)
                except ArchiveError as error:
                    faults.append(str(error))

            # Every dataset by itself, as one fault may hide others. A file may lack those of `ABOUT`.
            for item in dict.fromkeys((*ABOUT, *(f"about/{name}" for name in file["about"]), *results)):
                try:
                    with damage_named(path, item):
                        if not isinstance(file[item], h5py.Dataset) or (item[:6] == "about/" and item not in KNOWN):
                            raise ValueError("is none of an archive's: whoever added it, no digest covers it")
                        if not file[item].fletcher32:
                            raise ValueError("carries no checksums")
                        _check_attributes(file[item], DATASET_ATTRIBUTES)
                        if item.startswith("about/"):
                            continue
                        stored = load_stored(file, item)
                        variables[item] = variable_of(stored)
                        check_variable(item, variables[item])
                        _check_scales(file, item, variables[item], users)
                        check_digest(stored, digests)
                except ArchiveError as error:
                    faults.append(str(error))

            # What holds between datasets, and which runs are missing: only sound ones can tell.
            if not faults:
                archive = Archive(machine, provenance, variables)
                validate(archive)
                if (planned := runs_planned(archive)) is not None and (gaps := missing_runs(archive)):
                    what = f"runs {gaps_in_words(gaps)} of {planned} planned are missing"
                    faults.append(str(ArchiveError(path, what, "go on with --resume, or compute it again")))
    except ArchiveError as error:
        faults.append(str(error))
    return faults


def _known_attributes(file: Any) -> dict[str, Sequence[str]]:
    """Attributes that the root and the groups of an archive may have, by name of the group, "" of the root."""
    version = int(file.attrs["format_version"])
    root = (*ROOT_ATTRIBUTES, KIND) if version >= FIRST_WITH_COORDINATES else ("format", "format_version")
    return {"": (*root, *[ROOT_DIGEST] * (version >= FIRST_WITH_DIGESTS)), "about": ()}


def _check_attributes(item: Any, known: Sequence[str]) -> None:
    """Refuse attributes that apesim does not write: no digest covers them, and a reader would take them for its own."""
    for name in item.attrs:
        if name not in known:
            raise ValueError(f"attribute {name} is none of an archive's: whoever added it, no digest covers it")


def _check_scales(file: Any, name: str, variable: Variable, users: dict[str, set[tuple[str, int]]]) -> None:
    """The axes as netCDF readers find them must be the ones that are named."""
    if variable.dims == (name,):
        if not file[name].is_scale:
            raise ValueError(f"axis {name} is no dimension scale")
        return
    for place, axis in enumerate(variable.dims):
        if axis not in users:
            users[axis] = set(_users(file, axis))
        if (f"/{name}", place) not in users[axis]:
            raise ValueError(f"axis {axis} is not attached as dimension {place}")


def _users(file: Any, axis: str) -> Iterator[tuple[str, int]]:
    """Variables that an axis is attached to, with the place of the axis in each.

    Asked of the axis, whose list of users is checksummed: the variables keep their lists of axes in the heap,
    where HDF5 2.0 loops for ever over damage.
    """
    if "REFERENCE_LIST" not in file[axis].attrs:
        return
    if file[axis].attrs.get_id("REFERENCE_LIST").dtype.names != ("dataset", "dimension"):
        raise ValueError(f"axis {axis} has a foreign list of users")
    for user, place in file[axis].attrs["REFERENCE_LIST"]:
        with suppress(ValueError, RuntimeError, KeyError, OSError):  # removed since it was attached
            yield file[user].name, int(place)


def export(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> list[Path]:
    """Write an archive as CSV, TOML and JSON; every float is written so that it reads back to the same bits.

    Into `folder`, made if need be, which has to be empty: machine.toml, provenance.json, variables.csv (what each
    variable means), runs.csv (one row a run) and traces/run_0007.csv for each run (with several axes run_0007_AXIS.csv
    for each). Codes are written as words; ``meanings`` of variables.csv says both. Raises ArchiveError where the
    archive cannot be read, or the folder is not empty or not writable; then nothing is left of what was made.
    """
    archive, folder = read(path), Path(folder)
    traces, written = folder / "traces", []
    try:
        is_new = not folder.exists()
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise ArchiveError(folder, "is not empty", "name a new folder")
        traces.mkdir()
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise ArchiveError(folder, f"cannot be written ({why})", "choose another folder") from error
    try:
        for file, content in _contents(archive, folder):
            write_file(file, content, durable=False)
            written.append(file)
    except BaseException:  # a full disk, an interrupt: a part of an archive could pass for the whole
        for file in written:
            remove_file(file)
        for made in (traces, *[folder] * is_new):
            made.rmdir()
        raise
    return written


def _contents(archive: Archive, folder: Path) -> Iterator[tuple[Path, str]]:
    """Files of an exported archive with their texts."""
    variables = archive.variables
    yield folder / "machine.toml", archive.machine
    yield folder / "provenance.json", json.dumps(archive.provenance, indent=1, ensure_ascii=False) + "\n"
    header = ["name", "unit", "type", "axes", "meanings", "description"]
    described = ((name, v.unit, v.kind, " ".join(v.dims), v.meanings, v.description) for name, v in variables.items())
    yield folder / "variables.csv", format_csv(header, described)
    columns = {"run": variables["run"]} | {n: v for n, v in variables.items() if v.dims == ("run",)}
    cells = zip(*(_cells(v, v.values) for v in columns.values()), strict=True)
    yield folder / "runs.csv", format_csv(_header(columns), cells)

    groups: dict[tuple[str, ...], dict[str, Variable]] = {}
    for name, variable in variables.items():
        if len(variable.dims) > 1:
            groups.setdefault(variable.dims[1:], {})[name] = variable
    for axes, members in groups.items():
        grid = np.meshgrid(*(variables[axis].values for axis in axes), indexing="ij")
        places = [points.ravel().tolist() for points in grid]
        suffix = "_" + "_".join(axes) if len(groups) > 1 else ""
        header = _header({axis: variables[axis] for axis in axes} | members)
        for i, run in enumerate(archive.runs.tolist()):
            samples = (_cells(v, v.values[i]) for v in members.values())
            rows = zip(*places, *samples, strict=True)
            yield folder / "traces" / f"run_{run:04d}{suffix}.csv", format_csv(header, rows)


def _header(columns: dict[str, Variable]) -> list[str]:
    return [name if variable.meanings else f"{name} [{variable.unit}]" for name, variable in columns.items()]


def _cells(variable: Variable, values: np.ndarray) -> list[Any]:
    """Cells of a column: numbers, or the words that codes stand for."""
    cells = values.ravel().tolist()
    if not variable.meanings:
        return cells
    words = codes_of(variable.meanings)
    return [words[code] for code in cells]
