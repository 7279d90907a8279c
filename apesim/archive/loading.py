"""Datasets of an archive as they are stored: read, and checked against their checksums and digests."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

from apesim.archive.conventions import variable_from
from apesim.archive.digests import DIGESTS, ROOT_DIGEST, Attribute, dataset_digest, root_digest
from apesim.archive.errors import ArchiveError, NoArchiveError
from apesim.archive.records import (
    ATTRIBUTE_BYTES,
    ATTRIBUTES,
    CODE_ATTRIBUTES,
    FIRST_WITH_DIGESTS,
    FLAG_ATTRIBUTES,
    FORMAT,
    FORMAT_VERSION,
    KIND,
    ROOT_ATTRIBUTES,
    Variable,
    sha256,
)
from apesim.archive.untrusted import SIZE_LIMIT, damage_named, refuse_unsafe


@contextmanager
def opened(path: str | os.PathLike[str], limit: int = SIZE_LIMIT) -> Iterator[h5py.File]:
    """Open an archive for reading after everything dangerous in it has been refused.

    `limit` is the largest size of all datasets together, in memory when read [bytes]. Raises ArchiveError where the
    file is missing, unsafe, too large, no archive or of a newer format, or HDF5 reports inside the `with` block that it
    is damaged.
    """
    path = Path(path)
    try:
        is_file = path.is_file()
    except OSError as error:  # a name that is too long, a folder that may not be entered
        raise ArchiveError(path, f"cannot be read: {error.strerror}", "check the name") from None
    if not is_file:
        raise NoArchiveError(path, "there is no such file", "check the name")
    with damage_named(path, ""), _file(path) as file:
        if not _is_ours(file):
            raise NoArchiveError(path, "is not an apesim archive", "give a file written by apesim")
        version = file.attrs.get_id("format_version")
        if version.shape != () or version.dtype != np.dtype("<i8"):
            raise ValueError("attribute format_version is no number")
        if not 1 <= (number := int(file.attrs["format_version"])) <= FORMAT_VERSION:
            raise NoArchiveError(
                path, f"has format version {number}, known is {FORMAT_VERSION}", "read it with a newer apesim"
            )
        refuse_unsafe(file, path, limit)
        yield file


@contextmanager
def _file(path: Path) -> Iterator[h5py.File]:
    """The file for reading; through Python's own file where HDF5 refuses as this process has it open otherwise."""
    with ExitStack() as stack:
        try:
            file = h5py.File(path, "r", locking=False)
        except OSError as error:
            if "flag values don't match" not in str(error):
                raise
            file = h5py.File(stack.enter_context(open(path, "rb")), "r")
        yield stack.enter_context(file)


def _is_ours(file: h5py.File) -> bool:
    """Whether a file says that it is an archive of apesim; others' attributes may be of any type."""
    try:
        return "format" in file.attrs and _text(file.attrs, "format") == FORMAT
    except ValueError:
        return False


class Stored(NamedTuple):
    """A dataset as it is stored."""

    path: str
    values: np.ndarray
    """Texts as bytes of fixed length."""
    attributes: dict[str, Attribute]
    """Those of `ATTRIBUTES` that are there."""


def load_digests(file: h5py.File, path: Path) -> dict[str, str] | None:
    """Read the digests of the datasets of an opened archive by their paths, checked against the root digest.

    None where the format is too old to have any; `path` is for messages. Raises DamagedError where they do not fit the
    root digest or the datasets that are there.
    """
    if file.attrs["format_version"] < FIRST_WITH_DIGESTS:
        return None
    with damage_named(path, DIGESTS):
        listed = str(_decoded(load_stored(file, DIGESTS).values).item())
        about: dict[str, Attribute] = {
            name: int(file.attrs[name]) if name == "format_version" else _text(file.attrs, name)
            for name in ROOT_ATTRIBUTES
            if name in file.attrs
        }
        if _text(file.attrs, ROOT_DIGEST) != root_digest(about, listed):
            raise ValueError(f"its hash is not the attribute {ROOT_DIGEST} of the root")
        digests = {dataset: digest for digest, dataset in (line.split("  ", 1) for line in listed.splitlines())}
        there = {f"/{name}" for name in file if name != "about"} | {f"/about/{name}" for name in file["about"]}
        if odd := sorted(digests.keys() ^ (there - {f"/{DIGESTS}"})):
            raise ValueError(f"{odd[0][1:]}: {'is missing' if odd[0] in digests else 'has no digest'}")
    return digests


def check_digest(stored: Stored, digests: dict[str, str] | None) -> None:
    """Refuse a dataset that is not what its digest says, with a ValueError; with None nothing is checked.

    `digests` by path are those of `load_digests`.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from apesim.archive import Archive, write
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> with TemporaryDirectory() as folder:
    ...     path = write(archive, Path(folder, "sweep.h5"))
    ...     with opened(path) as file:
    ...         stored = load_stored(file, "torque")
    ...         digests = load_digests(file, path)
    >>> check_digest(stored, digests)
    >>> check_digest(stored._replace(values=-stored.values), digests)
    Traceback (most recent call last):
    ...
    ValueError: its content is not what its SHA-256 digest says
    """
    if digests is not None and digests[stored.path] != dataset_digest(*stored):
        raise ValueError("its content is not what its SHA-256 digest says")


def load_about(file: h5py.File, path: Path, digests: dict[str, str] | None) -> tuple[str, dict[str, str]]:
    """Read the machine text (TOML) and the provenance of an opened archive, checked against the stored hashes.

    `path` is for messages, `digests` are those of `load_digests`. Raises DamagedError where a text is missing or not
    the one that was hashed.
    """
    with damage_named(path, "about/machine"):
        text = load_stored(file, "about/machine")
        machine = str(_decoded(text.values).item())
    with damage_named(path, "about/provenance"):
        table = load_stored(file, "about/provenance")
        provenance = json.loads(_decoded(table.values).item())
        if not isinstance(provenance, dict) or not all(isinstance(v, str) for v in provenance.values()):
            raise ValueError("is no table of texts")
        if provenance.get("machine_sha256") != sha256(machine):
            raise ValueError("its machine_sha256 is not the hash of the machine text")
        if provenance.get("format_version") != str(file.attrs["format_version"]):
            raise ValueError("its format_version is not that of the file")
        if KIND in file.attrs and _text(file.attrs, KIND) != provenance.get(KIND):
            raise ValueError("its kind is not that of the file")
        check_digest(table, digests)
    with damage_named(path, "about/machine"):
        check_digest(text, digests)
    return machine, provenance


def variable_of(stored: Stored) -> Variable:
    """Return a stored dataset (see `load_stored`) as a variable, its texts decoded.

    Raises ValueError where an attribute that says what it is, is missing.
    """
    return variable_from(_decoded(stored.values), stored.attributes)


def load_stored(file: h5py.File, name: str) -> Stored:
    """Read a dataset of an opened archive; chunks that were never written are an error, not zeros.

    Raises ValueError where a chunk is missing or an attribute is of a wrong type, OSError where a checksum is wrong,
    KeyError where there is no such dataset.
    """
    dataset = file[name]
    held = dataset.attrs
    attributes = {key: _attribute(held, key) for key in ATTRIBUTES if key in held}
    if dataset.chunks is not None:
        expected = math.prod(-(-n // c) for n, c in zip(dataset.shape, dataset.chunks, strict=True))
        if dataset.id.get_num_chunks() != expected:
            raise ValueError(f"{dataset.id.get_num_chunks()} of {expected} chunks are there")
    try:
        values = dataset[...]
    except OSError as error:
        raise OSError("a checksum is wrong or the data are broken") from error
    return Stored(dataset.name, values, attributes)


def _decoded(values: np.ndarray) -> np.ndarray:
    return np.char.decode(values, "utf-8") if values.dtype.kind == "S" else values


def _attribute(held: h5py.AttributeManager, name: str) -> Attribute:
    if name in FLAG_ATTRIBUTES:
        return int(held[name])
    if name not in CODE_ATTRIBUTES:
        return _text(held, name)
    attribute = held.get_id(name)
    if attribute.dtype != np.int8 or len(attribute.shape) != 1:
        raise ValueError(f"attribute {name} is no list of codes")
    return tuple(np.atleast_1d(held[name]).tolist())


def _text(held: h5py.AttributeManager, name: str) -> str:
    attribute = held.get_id(name)
    dtype = attribute.dtype  # made anew each time that it is asked for
    if dtype.kind != "S" or attribute.shape != () or dtype.itemsize > ATTRIBUTE_BYTES:
        raise ValueError(f"attribute {name} is not a text of fixed length")
    content = np.empty((), dtype)
    attribute.read(content)
    return content.item().decode()
