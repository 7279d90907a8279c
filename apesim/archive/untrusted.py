"""Reading HDF5 files from anyone: what is refused before anything is read, and what counts as damage.

HDF5 follows external links, external storage and virtual datasets to any file of the reader by absolute path,
loads filter plug-ins, and fills arrays of any declared size. None of these belongs in an archive.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from h5py import h5d, h5g, h5l, h5o, h5s, h5t, h5z

from apesim.archive.conventions import variable_from
from apesim.archive.digests import DIGESTS, ROOT_DIGEST, Attribute, dataset_digest, root_digest
from apesim.archive.memory import available_memory
from apesim.archive.records import (
    ATTRIBUTE_BYTES,
    ATTRIBUTES,
    CODE_ATTRIBUTES,
    FIRST_WITH_DIGESTS,
    FLAG_ATTRIBUTES,
    FORMAT,
    FORMAT_VERSION,
    ROOT_ATTRIBUTES,
    Variable,
    sha256,
)
from apesim.terminal import visible

SIZE_LIMIT = 4 * 2**30
MAX_EXPANSION = 20
"""Size in memory over that of the file. What we write is not compressed: numbers take what they take in the file, texts
five times that. A copy that is compressed takes a few times its size; one made to fill the memory a thousand times."""
ALWAYS_READ = 64 * 2**20
"""Bytes in memory that are read whatever the size of the file: they do no harm."""
OBJECT_LIMIT = 10_000

TEXT_OBJECT = 64
"""Bytes of a text of Python besides its characters: texts are checked one by one."""
FREE_MEMORY = "free some memory, or read it on a larger machine"

HDF5_WORDS = {
    "truncated file": "the file ends too early",
    "file signature not found": "is no HDF5 file",
    "checksum": "a checksum is wrong",
}
"""What HDF5 says of broken files, and what we say."""
_DAMAGE = (
    OSError,
    RuntimeError,
    KeyError,
    ValueError,
    TypeError,
    AttributeError,
    OverflowError,
    RecursionError,
)
_FILTERS = {h5z.FILTER_FLETCHER32, h5z.FILTER_SHUFFLE, h5z.FILTER_DEFLATE}
_LINKS = {h5l.TYPE_SOFT: "a soft link", h5l.TYPE_EXTERNAL: "an external link"}
_CLASSES = {
    h5t.VLEN: "variable length",
    h5t.REFERENCE: "reference",
    h5t.COMPOUND: "compound",
    h5t.OPAQUE: "opaque",
    h5t.ENUM: "enumeration",
    h5t.ARRAY: "array",
    h5t.BITFIELD: "bit field",
}


class ArchiveError(Exception):
    """A file that cannot be read or written.

    Parameters
    ----------
    path : path
        The file.
    what : str
        What is wrong with it, and where.
    remedy : str
        What to do.
    """

    def __init__(self, path: str | os.PathLike[str], what: str, remedy: str):
        super().__init__(path, what, remedy)
        self.path, self.what, self.remedy = path, what, remedy

    def __str__(self) -> str:
        return visible(" ".join(f"{os.fspath(self.path)}: {self.what}; {self.remedy}".split()))


class DamagedError(ArchiveError):
    """A file whose content cannot be trusted."""


class TooLargeError(ArchiveError):
    """A file that may be sound, but takes more memory than is available."""


class IncompleteError(ArchiveError):
    """A file that is not made, as none of its runs could be computed."""


def refuse_unsafe(file: h5py.File, path: str | os.PathLike[str], limit: int = SIZE_LIMIT) -> None:
    """Refuse an open file that holds an unsafe object; all are looked at without reading data.

    Parameters
    ----------
    file : h5py.File
        Open for reading.
    path : path
        Path of the file, for messages.
    limit : int
        Largest size of all datasets together, in memory when read [bytes].

    Raises
    ------
    ArchiveError
        At the first object that is no plain group and no dataset of numbers or fixed-length text; the datasets are
        larger than the limit, than the file can hold, or than the memory that is available.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "plain.h5")
    ...     with h5py.File(path, "w") as file:
    ...         file["speed"] = [600.0, 900.0]
    ...         refuse_unsafe(file, path)
    """
    remedy = "ask for a file written by apesim"
    by_file = max(ALWAYS_READ, MAX_EXPANSION * os.path.getsize(path))
    memory = available_memory()
    objects, total = 0, 0
    seen = {h5o.get_info(file["/"].id).addr}
    groups = [("", file["/"].id)]
    while groups:
        prefix, group = groups.pop()
        names: list[bytes] = []
        objects += group.get_num_objs()
        if objects > OBJECT_LIMIT:
            raise ArchiveError(path, f"more than {OBJECT_LIMIT} objects", remedy)
        group.links.iterate(names.append)
        for raw in names:
            name = prefix + raw.decode(errors="replace")
            if (link := group.links.get_info(raw).type) != h5l.TYPE_HARD:
                raise ArchiveError(path, f"{name} is {_LINKS.get(link, 'a foreign link')}", remedy)
            info = h5o.get_info(group, raw)
            if info.addr in seen:
                raise ArchiveError(path, f"{name} is a second link to the same object", remedy)
            seen.add(info.addr)
            if info.type == h5o.TYPE_GROUP:
                groups.append((f"{name}/", h5g.open(group, raw)))
            elif info.type == h5o.TYPE_DATASET:
                what, size = _inspect(h5d.open(group, raw))
                if what:
                    raise ArchiveError(path, f"{name} {what}", remedy)
                total += size
                if total > limit:
                    raise ArchiveError(
                        path,
                        f"{name}: the datasets are larger than {limit} bytes together",
                        "raise the limit if you trust the file",
                    )
                if total > by_file:
                    what = f"{name}: the datasets are larger than {MAX_EXPANSION} times the file together"
                    raise ArchiveError(path, what, remedy)
                if total > memory:
                    what = f"{name}: the datasets take {total} bytes together, more than the {memory:.0f} available"
                    raise TooLargeError(path, what, FREE_MEMORY)
            else:
                raise ArchiveError(path, f"{name} is neither group nor dataset", remedy)


def _inspect(dataset: h5d.DatasetID) -> tuple[str, int]:
    """What is unsafe about a dataset ("" if nothing), and its size in memory.

    The extent is asked for last, because asking a virtual dataset opens its sources.
    """
    creation = dataset.get_create_plist()
    if creation.get_external_count():
        return "is stored in another file", 0
    if creation.get_layout() == h5d.VIRTUAL:
        return "is a virtual dataset", 0
    for i in range(creation.get_nfilters()):
        if (code := creation.get_filter(i)[0]) not in _FILTERS:
            return f"needs the filter {code}", 0
    kind = dataset.get_type()
    text = kind.get_class() == h5t.STRING
    if text and kind.is_variable_str():
        return "holds text of variable length", 0
    if not text and kind.get_class() not in (h5t.INTEGER, h5t.FLOAT):
        return f"holds the type {_CLASSES.get(kind.get_class(), 'unknown')}", 0
    if not text and kind.dtype not in (np.dtype("<f8"), np.dtype("<i8"), np.dtype("i1")):
        return f"holds the type {kind.dtype}, not float64, int64 or int8", 0
    space = dataset.get_space()
    if space.get_simple_extent_type() != h5s.SIMPLE:
        return "has no extent", 0
    elements = math.prod(space.get_simple_extent_dims())
    if creation.get_layout() == h5d.CHUNKED:
        elements = max(elements, math.prod(creation.get_chunk()))
    size = kind.get_size()
    return "", elements * (5 * size + TEXT_OBJECT if text else size)  # decoded, a character takes four bytes more


@contextmanager
def opened(path: str | os.PathLike[str], limit: int = SIZE_LIMIT) -> Iterator[h5py.File]:
    """Open an archive for reading after everything dangerous in it has been refused.

    Parameters
    ----------
    path : path
        File of the archive.
    limit : int
        Largest size of all datasets together, in memory when read [bytes].

    Yields
    ------
    h5py.File
        File, open for reading.

    Raises
    ------
    ArchiveError
        The file is missing, unsafe, too large, no archive or of a newer format; or HDF5 reports inside the `with` block
        that it is damaged.

    Examples
    --------
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
    ...         sorted(file)
    ['about', 'run', 'speed', 'torque']
    """
    path = Path(path)
    try:
        is_file = path.is_file()
    except OSError as error:  # a name that is too long, a folder that may not be entered
        raise ArchiveError(path, f"cannot be read: {error.strerror}", "check the name") from None
    if not is_file:
        raise ArchiveError(path, "there is no such file", "check the name")
    with damage_named(path, ""), _file(path) as file:
        if "format" not in file.attrs or _text(file.attrs, "format") != FORMAT:
            raise ArchiveError(path, "is not an apesim archive", "give a file written by apesim")
        version = file.attrs.get_id("format_version")
        if version.shape != () or version.dtype != np.dtype("<i8"):
            raise ValueError("attribute format_version is no number")
        if not 1 <= (number := int(file.attrs["format_version"])) <= FORMAT_VERSION:
            raise ArchiveError(
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


@contextmanager
def damage_named(path: Path, item: str) -> Iterator[None]:
    """Turn what HDF5 reports about a broken file into an `ArchiveError` that names file and dataset.

    Parameters
    ----------
    path : Path
        Path of the file, for messages.
    item : str
        Dataset that is read, for messages; "" for the file.

    Yields
    ------
    None
        Errors of the block are turned.

    Raises
    ------
    DamagedError
        HDF5 or a check of what was read has failed in the block.
    TooLargeError
        There was not enough memory.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with damage_named(Path("sweep.h5"), "speed"):  # doctest: +ELLIPSIS
    ...     raise ValueError("carries no checksums")
    Traceback (most recent call last):
    ...
    apesim.archive.untrusted.DamagedError: sweep.h5: speed: carries no checksums; the file is damaged or foreign: ...
    """
    try:
        yield
    except ArchiveError:
        raise
    except MemoryError as error:
        raise TooLargeError(path, f"{item or 'the file'} takes more memory than is available", FREE_MEMORY) from error
    except _DAMAGE as error:
        text = _in_our_words(error)
        where = f"{item}: " if item and not text.startswith(f"{item}:") else ""
        remedy = "the file is damaged or foreign: restore a copy or compute it again"
        raise DamagedError(path, f"{where}{text}", remedy) from error


def _in_our_words(error: BaseException) -> str:
    """What an error of a broken file says, without the words of HDF5: these stay in the error that it comes from."""
    if isinstance(error, OSError) and error.errno:
        return f"cannot be read ({os.strerror(error.errno)})"
    text = str(error.args[0]) if error.args else str(error)
    if not re.match("(can't|cannot|unable to|couldn't|link iteration|.* failed \\()", text, re.IGNORECASE):
        return text
    return next((ours for theirs, ours in HDF5_WORDS.items() if theirs in text), "the data are broken")


class Stored(NamedTuple):
    """A dataset as it is stored."""

    path: str
    values: np.ndarray
    """Texts as bytes of fixed length."""
    attributes: dict[str, Attribute]
    """Those of `ATTRIBUTES` that are there."""


def load_digests(file: h5py.File, path: Path) -> dict[str, str] | None:
    """Read the digests of the datasets of an opened archive, checked against the root digest.

    Parameters
    ----------
    file : h5py.File
        Archive, see `opened`.
    path : Path
        Path of the file, for messages.

    Returns
    -------
    dict of str to str, or None
        Digests by path of the dataset; None where the format is too old to have any.

    Raises
    ------
    DamagedError
        The digests do not fit the root digest, or not the datasets that are there.

    Examples
    --------
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
    ...         sorted(load_digests(file, path))
    ['/about/machine', '/about/provenance', '/run', '/speed', '/torque']
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
    """Refuse a dataset that is not what its digest says.

    Parameters
    ----------
    stored : Stored
        Dataset as it is stored, see `load_stored`.
    digests : dict of str to str, or None
        Digests by path of the dataset, see `load_digests`; with None nothing is checked.

    Raises
    ------
    ValueError
        Its content is another than that of the digest.

    Examples
    --------
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
    """Read the machine text and the provenance of an opened archive, checked against the stored hashes.

    Parameters
    ----------
    file : h5py.File
        Archive, see `opened`.
    path : Path
        Path of the file, for messages.
    digests : dict of str to str, or None
        Digests by path of the dataset, see `load_digests`.

    Returns
    -------
    machine : str
        TOML text of the machine.
    provenance : dict of str to str
        Where the results come from.

    Raises
    ------
    DamagedError
        A text is missing or not the one that was hashed.

    Examples
    --------
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
    ...         load_about(file, path, load_digests(file, path))[0]
    'bore = 1'
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
        check_digest(table, digests)
    with damage_named(path, "about/machine"):
        check_digest(text, digests)
    return machine, provenance


def variable_of(stored: Stored) -> Variable:
    """Return a stored dataset as a variable.

    Parameters
    ----------
    stored : Stored
        Dataset as it is stored, see `load_stored`.

    Returns
    -------
    Variable
        Variable with its texts decoded.

    Raises
    ------
    ValueError
        An attribute that says what it is, is missing.

    Examples
    --------
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
    >>> variable_of(stored).unit
    'N m'
    """
    return variable_from(_decoded(stored.values), stored.attributes)


def load_stored(file: h5py.File, name: str) -> Stored:
    """Read a dataset of an opened archive; chunks that were never written are an error, not zeros.

    Parameters
    ----------
    file : h5py.File
        Archive, see `opened`.
    name : str
        Path of the dataset, such as "speed".

    Returns
    -------
    Stored
        Path, values and attributes.

    Raises
    ------
    ValueError
        A chunk is missing, or an attribute is of a wrong type.
    OSError
        A checksum is wrong.
    KeyError
        There is no such dataset.

    Examples
    --------
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
    >>> stored.path, stored.values.tolist(), stored.attributes["units"]
    ('/torque', [3.0, 2.5], 'N m')
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
