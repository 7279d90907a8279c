"""Reading HDF5 files from anyone: what is refused before anything is read, and what counts as damage.

HDF5 follows external links, external storage and virtual datasets to any file of the reader by absolute path,
loads filter plug-ins, and fills arrays of any declared size. None of these belongs in an archive.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
from h5py import h5d, h5g, h5l, h5o, h5s, h5t, h5z

from apesim.archive.errors import ArchiveError, DamagedError, TooLargeError
from apesim.archive.memory import available_memory

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


def refuse_unsafe(file: h5py.File, path: str | os.PathLike[str], limit: int = SIZE_LIMIT) -> None:
    """Refuse an open file that holds an unsafe object; all are looked at without reading data.

    Raises ArchiveError at the first object that is no plain group and no dataset of numbers or fixed-length text, and
    where the datasets, in memory when read, are larger than `limit` [bytes], than the file can hold, or than the memory
    that is available. `path` is for messages.
    """
    remedy = "ask for a file written by apesim"

    # Sizes in memory that the file may come to, besides `limit`: a small file can declare arrays of any size.
    by_file = max(ALWAYS_READ, MAX_EXPANSION * os.path.getsize(path))
    memory = available_memory()
    objects, total = 0, 0

    # Objects are known by their addresses: second links to a group could lead round in a circle for ever.
    seen = {h5o.get_info(file["/"].id).addr}
    groups = [("", file["/"].id)]
    while groups:
        prefix, group = groups.pop()
        names: list[bytes] = []

        # They are counted before their names are listed, which takes memory for each of them.
        objects += group.get_num_objs()
        if objects > OBJECT_LIMIT:
            raise ArchiveError(path, f"more than {OBJECT_LIMIT} objects", remedy)
        group.links.iterate(names.append)
        for raw in names:
            name = prefix + raw.decode(errors="replace")

            # The link comes before what it leads to: to ask for that would follow a soft or external link.
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

                # Each bound has its own remedy: `limit` can be raised, that of the file cannot, memory can be freed.
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
def damage_named(path: Path, item: str) -> Iterator[None]:
    """Turn what HDF5 reports about a broken file into an `ArchiveError` that names file and dataset.

    `item` is the dataset that is read; "" for the file. Raises DamagedError where HDF5 or a check of what was read has
    failed in the block, TooLargeError where there was not enough memory.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with damage_named(Path("sweep.h5"), "speed"):  # doctest: +ELLIPSIS
    ...     raise ValueError("carries no checksums")
    Traceback (most recent call last):
    ...
    apesim.archive.errors.DamagedError: sweep.h5: speed: carries no checksums; the file is damaged or foreign: ...
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
