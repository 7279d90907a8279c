"""Folder in which work that takes hours keeps what is done."""

import tempfile
from pathlib import Path


def find_kept(name: str, code: str) -> Path:
    """Folder of some work by some code: what was interrupted goes on, and nothing of other code is taken for its own.

    Parameters
    ----------
    name : str
        Name of the work.
    code : str
        Hash of the code, see `docs.results.hash_files`.
    """
    return Path(tempfile.gettempdir()) / f"apesim_{name}_{code[:12]}"
