"""Output of results: nothing that is there is lost unasked."""

import csv
import io
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

import numpy as np

from apesim.archive import Archive, ArchiveError, read_about, read_digest, replace_file, write
from apesim.archive.shards import lock


def refuse_to_replace(out: str | PathLike[str]) -> None:
    """Refuse a target that exists.

    Parameters
    ----------
    out : path

    Raises
    ------
    ArchiveError
        It exists, or is a folder.
    """
    refuse_folder(out)
    if Path(out).exists():
        raise ArchiveError(
            out, f"exists already{_made(out)}", "give --overwrite to compute it again, or choose another --out"
        )


def _made(out: str | PathLike[str]) -> str:
    """When an archive was finished and of how many runs, in words; "" for a file that is none."""
    try:
        about = read_about(out)[1]
    except ArchiveError:
        return ""
    finished = about.get("created", "")[:16].replace("T", " at ")  # 2024-01-01T00:00:00+00:00
    runs = f", {about['runs_planned']} runs" if "runs_planned" in about else ""
    return (f", finished on {finished} UTC" if finished else "") + runs


def refuse_folder(out: str | PathLike[str]) -> None:
    """Refuse a target that is a folder, which no archive can replace.

    Parameters
    ----------
    out : path

    Raises
    ------
    ArchiveError
        It is a folder.
    """
    if Path(out).is_dir():
        raise ArchiveError(out, "is a folder", "give the name of a file, e.g. sweep.h5")


def make_folder(folder: str | PathLike[str], overwrite: bool) -> None:
    """Make a folder for results.

    Parameters
    ----------
    folder : path
    overwrite : bool
        Whether what it holds may be replaced.

    Raises
    ------
    ArchiveError
        It cannot be made, or holds something that is not to be replaced.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(folder, f"cannot be made: {error.strerror}", "choose another folder") from None
    if any(folder.iterdir()) and not overwrite:
        raise ArchiveError(folder, "is not empty", "choose another --out, or give --overwrite")


def publish(archive: Archive, out: str | PathLike[str], overwrite: bool = False) -> None:
    """Write an archive that was computed in one go.

    Parameters
    ----------
    archive : Archive
    out : path
    overwrite : bool
        Whether to replace one that is there.

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


def written_json(out: Path, drawn: Iterable[Path], wall_time: float) -> dict:
    """Place of an archive and its figures, and the time it took, for JSON."""
    written = {"archive": str(out), "content_sha256": read_digest(out), "figures": [str(path) for path in drawn]}
    return written | {"wall_time_s": wall_time}


def written_text(written: dict, count: str) -> str:
    """Lines that say what was computed, in which time, where it lies, and by which digest it is known.

    Parameters
    ----------
    written : dict
        What `compute_archive` returns of it.
    count : str
        What was computed, e.g. "40 runs".

    Returns
    -------
    str
    """
    line = f"{written['archive']}: {count} in {written['wall_time_s']:.2f} s"
    if written["figures"]:
        line += f"; figures in {Path(written['figures'][0]).parent}/"
    return f"{line}\n{digest_line(written['content_sha256'])}"


def digest_line(digest: str | None) -> str:
    """A line with the root digest of an archive.

    Parameters
    ----------
    digest : str or None
        64 hexadecimal digits; None for an archive of format version 1.

    Returns
    -------
    str

    Examples
    --------
    >>> digest_line(None)
    'SHA-256 of its content: none, format version 1 has no digests'
    """
    return f"SHA-256 of its content: {digest or 'none, format version 1 has no digests'}"


def write_traces(path: str | PathLike[str], header: Iterable[str], rows: np.ndarray) -> None:
    """Write traces as CSV, floats without loss; the file is complete or absent.

    Parameters
    ----------
    path : path
    header : sequence of str
        Names with units, ``name [unit]``.
    rows : (n, m) float array
        Values in these units.

    Raises
    ------
    ArchiveError
        The file cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows.tolist())
    path, content = Path(path), text.getvalue().encode()
    try:
        if path.exists() and (path.is_symlink() or not path.is_file()):  # /dev/stdout, a pipe: no name to take over
            path.write_bytes(content)
        else:
            replace_file(path, content)
    except OSError as error:
        raise ArchiveError(path, f"cannot be written: {error.strerror}", "choose another file") from None
