"""Folders for what is worked out once for all later runs."""

import atexit
import contextlib
import os
import warnings
from pathlib import Path

_temporary: list[tuple[Path, int]] = []
"""Roots that were made for a process alone, each with the process that made it."""

_explanation = ""
"""Why the last of them was made, see `explain_temporary`."""


class CacheWarning(UserWarning):
    """What is worked out cannot be kept for later runs."""


def cache_root() -> Path:
    """Return the parent of the cache's folders, which need not exist.

    It is ``APESIM_CACHE_DIR``, else it lies where the system keeps caches, such as ``~/.cache/apesim``. Raises
    RuntimeError where the user has no home folder.
    """
    given = os.environ.get("APESIM_CACHE_DIR")
    if given:
        return Path(given)
    from platformdirs import user_cache_path

    root = user_cache_path("apesim", appauthor=False)
    if not root.is_absolute():  # older versions of platformdirs do not raise
        raise RuntimeError("the user has no home folder")
    return root


def private_folder(name: str) -> Path | None:
    """Return a folder of the cache, made with mode 0700 if need be.

    None if it cannot be written or is not ours alone.
    """
    with contextlib.suppress(OSError, RuntimeError):  # RuntimeError: there is no home
        folder = cache_root() / name
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = folder.lstat()
        own = status.st_uid == getattr(os, "getuid", lambda: status.st_uid)()
        private = own and not folder.is_symlink() and not status.st_mode & 0o022
        if private and os.access(folder, os.W_OK):
            return folder
    return None


def explain_temporary() -> str:
    """Say in a line why nothing is kept for later runs and what to do; "" unless this process has a temporary folder.

    >>> from unittest.mock import patch
    >>> with patch.dict(os.environ):
    ...     folder = temporary_folder("units")
    >>> explain_temporary().partition("; ")[2]
    'set APESIM_CACHE_DIR to a folder of yours that can be written'
    """
    return _explanation if any(process == os.getpid() for _, process in _temporary) else ""


def warn_of_temporary() -> None:
    """Warn by `CacheWarning` that nothing is kept for later runs, in the words of `explain_temporary`."""
    warnings.warn(explain_temporary(), CacheWarning, stacklevel=3)


def temporary_folder(name: str) -> Path:
    """Make a folder for this process and those that it starts from now on, where the cache has none; removed at exit.

    Sets ``APESIM_CACHE_DIR`` to its parent.
    """
    import tempfile

    global _explanation
    try:
        where = f"in {cache_root()}, which cannot be written or is not yours alone"
    except RuntimeError:
        where = "as the user has no home folder"
    _explanation = (
        f"compiled code cannot be kept {where}: each call compiles anew; "
        "set APESIM_CACHE_DIR to a folder of yours that can be written"
    )
    root = Path(tempfile.mkdtemp(prefix="apesim-kernels-"))
    _temporary.append((root, os.getpid()))
    atexit.register(remove_temporary_folders)
    os.environ["APESIM_CACHE_DIR"] = str(root)
    folder = root / name
    folder.mkdir(mode=0o700)
    return folder


def remove_temporary_folders() -> None:
    """Remove what `temporary_folder` has made in this process."""
    import shutil

    for root, process in _temporary:
        if process == os.getpid():
            shutil.rmtree(root, ignore_errors=True)
