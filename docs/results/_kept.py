"""Folder in which work that takes hours keeps what is done."""

import tempfile
from pathlib import Path

from tests.folders import find_commit


def find_kept(name: str) -> Path:
    """Folder of some work by this commit, in which it goes on once interrupted; a new one where files are changed."""
    commit = find_commit()
    if commit.endswith("-dirty"):
        return Path(tempfile.mkdtemp(prefix=f"apesim_{name}_"))
    return Path(tempfile.gettempdir()) / f"apesim_{name}_{commit}"
