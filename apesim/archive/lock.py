"""The lock of an archive that is being made: no second program writes the same target."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

import filelock

from apesim.archive.errors import ArchiveError
from apesim.archive.writing import find_target, remove_temporaries

__all__ = ["lock"]

HOLDER = "process "
"""Begin of what a lock says of its holder."""


@contextmanager
def lock(path: str | os.PathLike[str]) -> Iterator[None]:
    """Hold F.h5.lock while an archive is being made, so that no second sweep writes the same target.

    The lock ends with the process, however it ends; its file is removed while it is still held, as filelock takes no
    lock on a file that was removed in the meantime. What killed writers have left of the archive is removed first.
    Raises ArchiveError where another process holds it (named in the message), the folder is not writable, what is there
    is no regular file, or what has the name of the lock is no lock.
    """
    target = find_target(path)
    lock_file = Path(f"{target}.lock")

    # Refused before locking: that would make a folder that is missing, and empty a file that is no lock.
    if not os.path.isdir(lock_file.parent):
        raise ArchiveError(path, "its folder does not exist", "make it or choose another one")
    _refuse_foreign(lock_file)

    # It does not wait: another sweep may take hours, and its process is named, as far as its lock can be read.
    guard = filelock.FileLock(lock_file, blocking=False)
    try:
        guard.acquire()
    except filelock.Timeout:
        holder = "another process"
        with suppress(OSError, UnicodeDecodeError):
            holder = lock_file.read_text(encoding="utf-8")[:200] or holder
        raise ArchiveError(
            path,
            f"is being written by {holder} (lock {lock_file.name})",
            "wait for it or choose another file",
        ) from None
    except (OSError, NotImplementedError) as error:
        raise ArchiveError(lock_file, f"cannot be locked ({error})", "choose another folder") from error
    try:
        # The name of its holder is for messages alone: where it cannot be written, the lock holds all the same.
        with suppress(OSError):
            since = datetime.now(UTC).isoformat(timespec="seconds")
            lock_file.write_text(f"{HOLDER}{os.getpid()} since {since}", encoding="utf-8")

        # Only the holder of the lock knows that no other writer is at work on what lies there.
        remove_temporaries(target)
        yield
    finally:
        with suppress(OSError):  # Windows lets go of no open file; there filelock removes it
            lock_file.unlink()
        guard.release()


def _refuse_foreign(lock_file: Path) -> None:
    """Refuse what has the name of a lock and is none: locking would empty it, and remove it at the end."""
    try:
        if not stat.S_ISREG(os.lstat(lock_file).st_mode):
            raise ArchiveError(lock_file, "cannot be locked: is no regular file", "choose another name or folder")
        with open(lock_file, "rb") as file:
            begin = file.read(len(HOLDER))
    except OSError:  # there is none, or it is another user's
        return
    if not HOLDER.encode().startswith(begin):
        what = "has the name of a lock, but its content is another's"
        raise ArchiveError(lock_file, what, "move it away, or choose another name")
