"""The lock of an archive that is being made: no second program writes the same target."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

import filelock

from apesim.archive.file import ArchiveError, remove_temporaries

__all__ = ["lock"]


@contextmanager
def lock(path: str | os.PathLike[str]) -> Iterator[None]:
    """Hold F.h5.lock while an archive is being made, so that no second sweep writes the same target.

    The lock ends with the process, however it ends. Its file is removed while it is still held; filelock takes no lock
    on a file that was removed in the meantime. What killed writers have left of the archive is removed first.

    Parameters
    ----------
    path : path
        File of the archive; its folder has to exist.

    Yields
    ------
    None
        While the block runs, the lock is held.

    Raises
    ------
    ArchiveError
        Another process holds it, named in the message, or the folder is not writable.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder, lock(Path(folder, "sweep.h5")):
    ...     Path(folder, "sweep.h5.lock").exists()
    True
    """
    lock_file = Path(f"{os.fspath(path)}.lock")
    if not os.path.isdir(lock_file.parent):
        raise ArchiveError(path, "its folder does not exist", "make it or choose another one")
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
        with suppress(OSError):
            since = datetime.now(UTC).isoformat(timespec="seconds")
            lock_file.write_text(f"process {os.getpid()} since {since}", encoding="utf-8")
        remove_temporaries(Path(path))
        yield
    finally:
        with suppress(OSError):  # Windows lets go of no open file; there filelock removes it
            lock_file.unlink()
        guard.release()
