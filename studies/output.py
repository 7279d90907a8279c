"""Where results go: nothing that is there is lost unasked."""

from pathlib import Path

from apesim.archive import ArchiveError, read_about, write
from apesim.archive.shards import lock


def refuse_to_replace(out):
    """Raise `ArchiveError` where a target exists."""
    refuse_folder(out)
    if Path(out).exists():
        raise ArchiveError(
            out, f"exists already{_made(out)}", "give --overwrite to compute it again, or choose another --out"
        )


def _made(out):
    """When an archive was finished and of how many runs, in words; "" for a file that is none."""
    try:
        about = read_about(out)[1]
    except ArchiveError:
        return ""
    finished = about.get("created", "")[:16].replace("T", " at ")  # 2024-01-01T00:00:00+00:00
    runs = f", {about['runs_planned']} runs" if "runs_planned" in about else ""
    return (f", finished on {finished} UTC" if finished else "") + runs


def refuse_folder(out):
    """Raise `ArchiveError` where a target is a folder, which no archive can replace."""
    if Path(out).is_dir():
        raise ArchiveError(out, "is a folder", "give the name of a file, e.g. sweep.h5")


def make_folder(folder, overwrite):
    """Make a folder; raise `ArchiveError` where it holds something that is not to be replaced."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(folder, f"cannot be made: {error.strerror}", "choose another folder") from None
    if any(folder.iterdir()) and not overwrite:
        raise ArchiveError(folder, "is not empty", "choose another --out, or give --overwrite")


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
    refuse_folder(out)
    with lock(out):
        if not overwrite:
            refuse_to_replace(out)
        write(archive, out)
