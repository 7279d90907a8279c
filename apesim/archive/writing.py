"""Writing files for users: complete or absent, and nothing but a regular file is ever replaced.

Links are followed: the file that a link names is replaced, and the link stays. A pipe, a socket, a device or a folder
is refused, whatever may be overwritten.
"""

from __future__ import annotations

import csv
import glob
import io
import os
import secrets
import stat
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from apesim.archive.errors import ArchiveError

__all__ = ["find_target", "format_csv", "remove_file", "remove_temporaries", "write_file"]


def find_target(path: str | os.PathLike[str]) -> Path:
    """Find the file that writing to a path makes or replaces, before anything is computed.

    It is the path itself, or where it is a link, the file that the link names. Raises ArchiveError where what is there
    is no regular file, or the path can name none.
    """
    path = Path(path)
    try:
        target = Path(os.path.realpath(path)) if path.is_symlink() else path
        with suppress(FileNotFoundError):
            os.lstat(_temporary(target))  # tells whether its name, the longest of those beside it, is too long
        with suppress(FileNotFoundError):
            mode = os.stat(path).st_mode
            if stat.S_ISDIR(mode):
                raise ArchiveError(path, "is a folder", "give the name of a file, e.g. sweep.h5")
            if not stat.S_ISREG(mode):
                what = "is a pipe, a socket or a device, no file, and is never replaced"
                raise ArchiveError(path, what, "give the name of a file")
    except (OSError, ValueError) as error:  # too long, links in a circle, a file where a folder is due, a NUL
        why = getattr(error, "strerror", None) or error
        raise ArchiveError(path, f"cannot be written ({why})", "choose another name or folder") from None
    return target


def write_file(path: str | os.PathLike[str], content: str | bytes | memoryview, *, durable: bool = True) -> None:
    """Write a file under another name and rename it: it is complete or absent, whatever ends the process.

    A text is written as UTF-8. `durable`: the file survives a power cut after the return, which takes long where many
    are written. Raises ArchiveError where the disk is full, the folder is missing or not writable, or what is there is
    no regular file.
    """
    target = find_target(path)
    temporary = _temporary(target)
    try:
        try:
            with open(temporary, "xb") as file:
                file.write(content.encode() if isinstance(content, str) else content)
                file.flush()
                if durable:
                    os.fsync(file.fileno())
            os.replace(temporary, target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        if durable and os.name == "posix":
            folder = os.open(target.parent, os.O_RDONLY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)
    except OSError as error:
        why = error.strerror or error
        raise ArchiveError(path, f"could not be written ({why})", "make room or choose another folder") from error


def _temporary(path: Path) -> Path:
    """Name beside a file under which it is written first."""
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp") if path.name else path


def format_csv(header: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Format a table as CSV, floats without loss.

    >>> print(format_csv(("time [s]", "lift [m]"), [[0.0, 0.0045]]), end="")
    time [s],lift [m]
    0.0,0.0045
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")  # writes floats by repr
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()


def remove_file(path: str | os.PathLike[str]) -> None:
    """Remove a file, where there is one; raises ArchiveError where it cannot be removed."""
    try:
        Path(path).unlink(missing_ok=True)
    except OSError as error:
        raise ArchiveError(path, f"could not be removed ({error.strerror or error})", "remove it") from error


def remove_temporaries(path: Path) -> None:
    """Remove what killed writers of a file have left beside it; for the holder of its `lock`.

    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "sweep.h5")
    ...     left = Path(folder, ".sweep.h5.0123abcd.tmp")
    ...     left.touch()
    ...     remove_temporaries(path)
    ...     left.exists()
    False
    """
    for left in path.parent.glob(f".{glob.escape(path.name)}.{'[0-9a-f]' * 8}.tmp"):
        with suppress(OSError):
            left.unlink()
