"""Where results go: nothing that is there is lost unasked."""

from pathlib import Path

from apesim.archive import ArchiveError, write
from apesim.archive.shards import lock


def refuse_to_replace(out):
    """Raise `ArchiveError` where a target exists."""
    if Path(out).exists():
        raise ArchiveError(out, "exists already", "choose another --out, or give --overwrite")


def publish(archive, out, overwrite=False):
    """Write an archive that was computed in one go.

    Parameters
    ----------
    archive : Archive
    out : path
    overwrite : bool
        Replace one that is there.

    Raises
    ------
    ArchiveError
        It exists, or another process writes it.
    """
    with lock(out):
        if not overwrite:
            refuse_to_replace(out)
        write(archive, out)
