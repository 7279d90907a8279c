"""The folders of what is worked out once for all later runs."""

import contextlib
import os
from pathlib import Path


def cache_root():
    """Parent of the folders: ``APESIM_CACHE_DIR``, else that of ``XDG_CACHE_HOME``, else of ``~/.cache``."""
    given = os.environ.get("APESIM_CACHE_DIR")
    if given:
        return Path(given)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "apesim"


def private_folder(name):
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
