"""What is wrong with a file that cannot be read or written."""

from __future__ import annotations

import os

from apesim.terminal import visible


class ArchiveError(Exception):
    """A file that cannot be read or written.

    Parameters
    ----------
    path : path
        The file.
    what : str
        What is wrong with it, and where.
    remedy : str
        What to do.
    """

    def __init__(self, path: str | os.PathLike[str], what: str, remedy: str) -> None:
        super().__init__(path, what, remedy)
        self.path, self.what, self.remedy = path, what, remedy

    def __str__(self) -> str:
        return visible(" ".join(f"{os.fspath(self.path)}: {self.what}; {self.remedy}".split()))


class NoArchiveError(ArchiveError):
    """A path where there is no archive that this version of apesim knows: no file, or somebody else's."""


class DamagedError(ArchiveError):
    """A file whose content cannot be trusted."""


class TooLargeError(ArchiveError):
    """A file that may be sound, but takes more memory than is available."""


class IncompleteError(ArchiveError):
    """A file that is not made, as none of its runs could be computed."""
