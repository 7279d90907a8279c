"""Archives of runs: one HDF5 file that outlives the program which wrote it.

Runs are the leading axis of every result. The layout needs no apesim to be understood::

    /                    attributes Conventions, title, source, history, kind, format, format_version, content_sha256
    /run                 run numbers, the leading axis
    /NAME                one dataset for each variable or axis; attributes units, long_name, axes and others of
                         `apesim.archive.conventions`
    /about/machine       the machine as TOML text
    /about/provenance    JSON text: the call, versions, commit, processor, time, hashes
    /about/digests       SHA-256 of every other dataset; how they are computed stands in `apesim.archive.digests`

Every dataset is chunked and carries Fletcher-32 checksums, texts included; nothing is pickled. A file
is built in memory and published by rename: a finished archive is complete or absent, and never changed.
Archives of format version 1 have no digests, and velocities of the valve alone that are positive as it closes; those of
version 2 have units by our names, "Pa abs" and "r/min", and no attributes of the CF conventions.
"""

from __future__ import annotations

import io
import json
import math
import os
import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath, PureWindowsPath

import h5py
import numpy as np

from apesim.archive.conventions import dataset_attributes, global_attributes
from apesim.archive.digests import DIGESTS, ROOT_DIGEST, Attribute, dataset_digest, digest_list, root_digest
from apesim.archive.errors import ArchiveError, DamagedError, IncompleteError
from apesim.archive.loading import check_digest, load_about, load_digests, load_stored, opened, variable_of
from apesim.archive.migration import migrate
from apesim.archive.records import FLAG_ATTRIBUTES, FORMAT, FORMAT_VERSION, KIND, Archive, Variable, sha256, validate
from apesim.archive.surroundings import surroundings
from apesim.archive.untrusted import SIZE_LIMIT, damage_named
from apesim.archive.writing import write_file

__all__ = [
    "Archive",
    "ArchiveError",
    "DamagedError",
    "IncompleteError",
    "Variable",
    "command_line",
    "complete_provenance",
    "read",
    "read_about",
    "read_digest",
    "sha256",
    "validate",
    "write",
]

CHUNK_BYTES = 2**20


def command_line(arguments: Sequence[str]) -> str:
    """Return the command line for the provenance, from `sys.argv`, as a shell takes it.

    >>> command_line(["/home/me/bin/apesim", "sweep", "--out=/home/me/sweep.h5"])
    'apesim sweep --out=sweep.h5'
    """
    return shlex.join(map(shorten_paths, arguments))


def shorten_paths(argument: str) -> str:
    """Shrink absolute paths of an argument to their last part, because they name users.

    >>> shorten_paths("--out=/home/me/sweep.h5")
    '--out=sweep.h5'
    """

    def short(text: str) -> str:
        for flavour in (PurePosixPath, PureWindowsPath):
            if flavour(text).is_absolute() or text.startswith("~"):
                return flavour(text).name
        return text

    return "=".join(map(short, argument.split("=")))


def write(archive: Archive, path: str | os.PathLike[str]) -> Path:
    """Write an archive, completely or not at all; an older file of that name is replaced.

    Entries of its provenance win over those added here (created, versions, platform), but for format and
    machine_sha256; the same archive with all of these given makes the same bytes. Raises ValueError where it breaks the
    data model; ArchiveError where the disk is full, the folder is missing or not writable, or what is there is no
    regular file.
    """
    validate(archive)
    path = Path(path)
    write_file(path, _image(complete_provenance(archive)))
    return path


def complete_provenance(archive: Archive) -> Archive:
    """Return an archive with the provenance that it is written with: with what, where and in which format.

    Entries that it has win over those added here, see `write`.
    """
    provenance = (
        surroundings()
        | archive.provenance
        | {"format": FORMAT, "format_version": str(FORMAT_VERSION), "machine_sha256": sha256(archive.machine)}
    )
    return replace(archive, provenance=provenance)


def _image(archive: Archive) -> memoryview:
    # In memory, because HDF5 writing to a full disk ends in a segmentation fault; and without the caches of the
    # datasets, which would hold all of it once more until the file is closed.
    content = io.BytesIO()
    datasets, digests = {}, {}
    with h5py.File(content, "w", libver=("v110", "v110"), track_order=True, rdcc_nbytes=0) as file:
        about: dict[str, Attribute] = {"format": FORMAT, "format_version": FORMAT_VERSION}
        about |= global_attributes(archive.provenance)
        # A group of its own, so that readers of netCDF-4 see only variables with named axes.
        file.create_group("about", track_order=True)
        provenance = json.dumps(archive.provenance, ensure_ascii=False, indent=1, sort_keys=True)
        for name, text in (("about/machine", archive.machine), ("about/provenance", provenance)):
            _, digests[f"/{name}"] = _add(file, name, np.array([text]), {})
        for name, variable in archive.variables.items():
            datasets[name], digests[f"/{name}"] = _add(
                file, name, variable.values, dataset_attributes(name, archive.variables)
            )
        listed = digest_list(digests)
        _add(file, DIGESTS, np.array([listed]), {})
        digest = {ROOT_DIGEST: root_digest(about, listed)}
        kind = {KIND: archive.provenance[KIND]} if KIND in archive.provenance else {}  # its digest is the provenance's
        for key, value in (about | kind | digest).items():
            _set_attribute(file, key, value)
        for name, variable in archive.variables.items():
            if variable.dims == (name,):
                datasets[name].make_scale(name)
        for name, variable in archive.variables.items():
            if variable.dims != (name,):
                for dimension, axis in zip(datasets[name].dims, variable.dims, strict=True):
                    dimension.attach_scale(datasets[axis])
    return content.getbuffer()


def _add(file: h5py.File, name: str, values: np.ndarray, attributes: dict[str, Attribute]) -> tuple[h5py.Dataset, str]:
    """Add a dataset; return it and its digest."""
    if values.dtype.kind == "U":
        encoded = np.char.encode(values, "utf-8")
        # Bytes of UTF-8 under HDF5's label of ASCII, as netCDF has them, whose attribute _Encoding says so: Octave
        # reads nothing of a file with a text of fixed length under the other label.
        stored = encoded.astype(h5py.string_dtype("ascii", max(1, encoded.dtype.itemsize)))
    else:
        stored = values.astype(values.dtype.newbyteorder("<"), copy=False)
    dtype = stored.dtype
    rows = CHUNK_BYTES // max(1, math.prod(values.shape[1:]) * dtype.itemsize)
    chunks = (max(1, min(rows, len(values))), *(max(1, n) for n in values.shape[1:]))
    dataset = file.create_dataset(
        name,
        shape=values.shape,
        dtype=dtype,
        data=stored,
        chunks=chunks,
        fletcher32=True,
        # An axis of length 0 must be able to grow, else no chunk fits in.
        maxshape=tuple(n or None for n in values.shape),
        track_times=False,
    )
    for key, value in attributes.items():
        _set_attribute(dataset, key, value)
    if values.dtype.kind == "U":
        _set_attribute(dataset, "_Encoding", "utf-8")  # xarray then shows text instead of bytes
    return dataset, dataset_digest(f"/{name}", stored, attributes)


def _set_attribute(item: h5py.Group | h5py.Dataset, name: str, value: Attribute) -> None:
    if not isinstance(value, str):
        item.attrs.create(name, value, dtype="i1" if name in FLAG_ATTRIBUTES or isinstance(value, tuple) else "<i8")
        return
    # Fixed length keeps the text in the checksummed object header; the heap of variable texts has none.
    raw = value.encode()
    dtype = h5py.string_dtype("utf-8", max(1, len(raw)))
    # Not by item.attrs.create: it makes room to replace an attribute that is there, which takes twice the time.
    attribute = h5py.h5a.create(item.id, name.encode(), h5py.h5t.py_create(dtype), h5py.h5s.create(h5py.h5s.SCALAR))
    attribute.write(np.array(raw, dtype))


def read(path: str | os.PathLike[str], limit: int = SIZE_LIMIT) -> Archive:
    """Read an archive, from whomever: checksums and digests are verified, links and foreign types are refused.

    Older format versions are brought to today's meaning, see `apesim.archive.migration`; `limit` is the largest size of
    all datasets together [bytes]. Raises ArchiveError where the file is missing, damaged, unsafe, too large, no archive
    or of a newer format.
    """
    path = Path(path)
    with opened(path, limit) as file:
        digests = load_digests(file, path)
        machine, provenance = load_about(file, path, digests)
        variables = {}
        for name in file:
            if name != "about":
                with damage_named(path, name):
                    stored = load_stored(file, name)
                    variables[name] = variable_of(stored)
                    check_digest(stored, digests)
        archive = Archive(machine, provenance, variables)
        validate(archive)
    return migrate(archive)


def read_about(path: str | os.PathLike[str]) -> tuple[str, dict[str, str]]:
    """Read only the machine text (TOML) and the provenance of an archive.

    Raises ArchiveError where the file is missing, damaged, unsafe, too large, no archive or of a newer format.
    """
    path = Path(path)
    with opened(path) as file:
        return load_about(file, path, load_digests(file, path))


def read_digest(path: str | os.PathLike[str]) -> str | None:
    """Read the SHA-256 digest over all that an archive holds, in hexadecimal, see `apesim.archive.digests`.

    None for format version 1, which has none; only `read` compares the values with it. Raises ArchiveError where the
    file is missing, damaged, unsafe, too large, no archive or of a newer format.
    """
    path = Path(path)
    with opened(path) as file:
        return None if load_digests(file, path) is None else str(file.attrs[ROOT_DIGEST].decode())
