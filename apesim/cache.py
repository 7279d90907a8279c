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
    """Return the parent of the cache's folders.

    It is ``APESIM_CACHE_DIR``, else it lies where the system keeps caches, such as ``~/.cache/apesim``.

    Returns
    -------
    pathlib.Path
        Folder; it need not exist.

    Raises
    ------
    RuntimeError
        The user has no home folder.

    Examples
    --------
    >>> from unittest.mock import patch
    >>> with patch.dict(os.environ, APESIM_CACHE_DIR="somewhere"):
    ...     print(cache_root())
    somewhere
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

    Parameters
    ----------
    name : str
        Name of the folder.

    Returns
    -------
    pathlib.Path or None
        None where it cannot be written, or is not ours alone.

    Examples
    --------
    >>> import tempfile
    >>> from unittest.mock import patch
    >>> with tempfile.TemporaryDirectory() as root, patch.dict(os.environ, APESIM_CACHE_DIR=root):
    ...     print(oct(private_folder("units").stat().st_mode & 0o777))
    0o700
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
    """Say in a line why nothing is kept for later runs, and what to do; "" unless this process has a temporary folder.

    Returns
    -------
    str

    Examples
    --------
    >>> from unittest.mock import patch
    >>> with patch.dict(os.environ):
    ...     folder = temporary_folder("units")
    >>> explain_temporary().partition("; ")[2]
    'set APESIM_CACHE_DIR to a folder of yours that can be written'
    """
    return _explanation if any(process == os.getpid() for _, process in _temporary) else ""


def warn_of_temporary() -> None:
    """Warn by `CacheWarning` that nothing is kept for later runs, in the words of `explain_temporary`.

    Examples
    --------
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     warn_of_temporary()
    >>> caught[0].category.__name__
    'CacheWarning'
    """
    warnings.warn(explain_temporary(), CacheWarning, stacklevel=3)


def temporary_folder(name: str) -> Path:
    """Make a folder for this process and those that it starts from now on, where the cache has none; removed at exit.

    Parameters
    ----------
    name : str
        Name of the folder.

    Returns
    -------
    pathlib.Path
        Folder; ``APESIM_CACHE_DIR`` is set to its parent.

    Examples
    --------
    >>> from unittest.mock import patch
    >>> with patch.dict(os.environ):
    ...     folder = temporary_folder("units")
    ...     print(folder.is_dir(), cache_root() == folder.parent)
    True True
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
    """Remove what `temporary_folder` has made in this process.

    Examples
    --------
    >>> from unittest.mock import patch
    >>> with patch.dict(os.environ):
    ...     folder = temporary_folder("units")
    >>> remove_temporary_folders()
    >>> folder.exists()
    False
    """
    import shutil

    for root, process in _temporary:
        if process == os.getpid():
            shutil.rmtree(root, ignore_errors=True)
