"""Files: their text, and the columns of a CSV with units in its header."""

import csv
import errno
import os
import stat
from os import PathLike
from pathlib import Path

from apesim.quantities.input_errors import InvalidValue, quoted

MAX_BYTES = 10_000_000
"""Largest file that is read [bytes]; chosen, far above any machine file and curve."""


def split_header(text: str) -> tuple[str, str | None]:
    """Split a column header such as "lift [mm]" into name and unit; the unit is None where there is none."""
    text = text.strip()
    name, bracket, named = text.removesuffix("]").partition("[")
    name = name.rstrip()
    if not bracket or not text.endswith("]") or "\n" in name + named:
        return text, None
    return name, named.strip()


def path_below(folder: str | PathLike[str], name: str) -> Path:
    """Return the path of a file that another file names, from the folder of that file.

    Raises InvalidValue where, links followed, it lies outside of the folder, or is a folder itself. What a stranger's
    file names lies beside it: were any path read, a message could show a line of any file.

    >>> path_below("data", "curve.csv").as_posix()
    'data/curve.csv'
    >>> path_below("data", "../curve.csv")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    apesim.quantities.input_errors.InvalidValue: ("'../curve.csv' leads out of the folder", ...
    """
    path = Path(folder, name)
    try:
        is_below = path.resolve().is_relative_to(Path(folder).resolve())
    except (OSError, RuntimeError, ValueError):  # links in a circle, a name that no file can have
        is_below = False
    if not is_below:
        raise InvalidValue(
            f"{quoted(name)} leads out of the folder", "put the file into the folder, and give its path there"
        )
    if os.path.isdir(path):
        raise InvalidValue(f"{quoted(name)} is a folder", "give the path of a file")
    return path


def text_of(path: str | PathLike[str], smaller: str = "") -> str:
    """Return the text of a UTF-8 file; raises InvalidValue where it cannot be read, is no regular file or is too large.

    `smaller` is the remedy for one that is too large.
    """
    name = quoted(str(path))
    try:
        with open(path, "rb", opener=open_regular) as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        raise InvalidValue(f"{name} cannot be read: {getattr(error, 'strerror', error)}") from None
    if len(data) > MAX_BYTES:
        raise InvalidValue(f"{name} is larger than {MAX_BYTES // 10**6} MB, the most that is read", smaller)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InvalidValue(f"{name} is no text in line {line}", "save it as UTF-8") from None


def open_regular(path: str, flags: int) -> int:
    """Open a regular file; a pipe is not waited for, nor a device read that never ends.

    Takes flags of `os.open` and returns a descriptor, for the argument ``opener`` of `open`. Raises OSError where the
    file cannot be opened, or is no regular one.

    >>> open_regular(os.curdir, os.O_RDONLY)
    Traceback (most recent call last):
        ...
    IsADirectoryError: [Errno 21] Is a directory
    """
    descriptor = os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
    mode = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(mode):
        os.close(descriptor)
        is_folder = stat.S_ISDIR(mode)
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR) if is_folder else "it is a pipe or a device, no file")
    return descriptor


def require_file(path: Path, right: str = "") -> None:
    """Refuse what is no regular file, by InvalidValue: no such file, a folder, a pipe or a device.

    So it does where the system does not tell; `right` is the remedy where there is none.
    """
    name = quoted(str(path))
    try:
        is_file = path.is_file()
    except OSError as error:  # a name that is too long, a folder that may not be entered
        raise InvalidValue(f"{name} cannot be read: {error.strerror}", right) from None
    if not is_file:
        raise InvalidValue(f"there is no file {name}", right)


def csv_columns(path: Path) -> dict[tuple[str, str | None], tuple[str, ...]]:
    r"""Return the texts of each column of a CSV, by name and unit (None without one).

    Raises InvalidValue where the file cannot be read, or is no CSV with one header.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "curve.csv")
    ...     _ = path.write_text("time [ms],opening [-]\n0,0\n3,1\n")
    ...     csv_columns(path)
    {('time', 'ms'): ('0', '3'), ('opening', '-'): ('0', '1')}
    """
    require_file(path)
    lines = text_of(path, "keep fewer rows, of measured data one every 0.1 ms or 0.5 deg").splitlines()
    try:
        headers, *rows = [row for row in csv.reader(lines, strict=True) if row]
        columns = dict(zip(map(split_header, headers), zip(*rows, strict=True), strict=True))
        if len(columns) < len(headers):
            raise ValueError
    except (ValueError, csv.Error):
        form = "differing headers and rows as long as the header"
        raise InvalidValue(f"{quoted(str(path))} is no CSV with {form}") from None
    return columns
