"""The folders of what is worked out once for all later runs."""

import atexit
import contextlib
import os
from pathlib import Path

_temporary: list[tuple[Path, int]] = []
"""Roots that were made for a process alone, each with the process that made it."""


def cache_root() -> Path:
    """Parent of the folders: ``APESIM_CACHE_DIR``, else where the system keeps caches, such as ``~/.cache/apesim``.

    Returns
    -------
    pathlib.Path

    Raises
    ------
    RuntimeError
        The user has no home folder.
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
    """A folder of the cache, made with mode 0700 if need be.

    Parameters
    ----------
    name : str

    Returns
    -------
    pathlib.Path or None
        None where it cannot be written, or is not ours alone.
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


def temporary_folder(name: str) -> Path:
    """A folder for this process and those that it starts from now on, where the cache has none; removed at exit.

    Parameters
    ----------
    name : str

    Returns
    -------
    pathlib.Path
    """
    import tempfile

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
