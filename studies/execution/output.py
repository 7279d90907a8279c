"""Output of results: nothing that is there is lost unasked."""

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from apesim.archive import Archive, ArchiveError, find_target, read_about, read_digest, write, write_file
from apesim.archive.lock import lock
from apesim.archive.writing import format_csv


def refuse_to_replace(out: str | os.PathLike[str], *, overwrite: bool = False) -> None:
    """Refuse a target that exists, or that no file can replace.

    Parameters
    ----------
    out : path
        File that is to be written.
    overwrite : bool
        Whether a regular file that is there may be replaced.

    Raises
    ------
    ArchiveError
        It exists, or cannot be one, see `apesim.archive.find_target`.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     refuse_to_replace(f"{folder}/sweep.h5")
    ...     _ = Path(folder, "sweep.h5").write_text("mine")
    ...     try:
    ...         refuse_to_replace(f"{folder}/sweep.h5")
    ...     except ArchiveError as error:
    ...         print(str(error).partition(": ")[2])
    exists already; give --overwrite to compute it again, or choose another --out
    """
    find_target(out)
    if not overwrite and os.path.exists(out):
        raise ArchiveError(
            out, f"exists already{_made(out)}", "give --overwrite to compute it again, or choose another --out"
        )


def _made(out: str | os.PathLike[str]) -> str:
    """When an archive was finished and of how many runs, in words; "" for a file that is none."""
    try:
        about = read_about(out)[1]
    except ArchiveError:
        return ""
    finished = about.get("created", "")[:16].replace("T", " at ")  # 2024-01-01T00:00:00+00:00
    runs = f", {about['runs_planned']} runs" if "runs_planned" in about else ""
    return (f", finished on {finished} UTC" if finished else "") + runs


def make_folder(folder: str | os.PathLike[str], overwrite: bool) -> None:
    """Make a folder for results.

    Parameters
    ----------
    folder : path
        Folder, and those above it.
    overwrite : bool
        Whether what it holds may be replaced.

    Raises
    ------
    ArchiveError
        It cannot be made, or holds something that is not to be replaced.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     make_folder(f"{folder}/paper/figures", overwrite=False)
    ...     Path(folder, "paper", "figures").is_dir()
    True
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        is_empty = not any(folder.iterdir())
    except OSError as error:
        raise ArchiveError(folder, f"cannot be made: {error.strerror}", "choose another folder") from None
    if not is_empty and not overwrite:
        raise ArchiveError(folder, "is not empty", "choose another --out, or give --overwrite")


def publish(archive: Archive, out: str | os.PathLike[str], overwrite: bool = False) -> None:
    """Write an archive that was computed in one go.

    Parameters
    ----------
    archive : Archive
        What is written.
    out : path
        File to write.
    overwrite : bool
        Whether to replace one that is there.

    Raises
    ------
    ArchiveError
        It exists, or another process writes it.

    Examples
    --------
    >>> import tempfile
    >>> from apesim.archive.columns import run_axis
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     publish(Archive("bore = 1", {}, {"run": run_axis(3)}), f"{folder}/sweep.h5")
    ...     len(read_digest(f"{folder}/sweep.h5"))
    64
    """
    with lock(out):
        refuse_to_replace(out, overwrite=overwrite)
        write(archive, out)


def written_json(out: Path, drawn: Iterable[Path], wall_time: float) -> dict:
    """Say where an archive and its figures lie, and how long they took, for JSON.

    Parameters
    ----------
    out : path
        Archive, which was written.
    drawn : iterable of path
        Figures.
    wall_time : float
        Computing time [s].

    Returns
    -------
    dict
        ``archive``, ``content_sha256``, ``figures`` and ``wall_time_s``.

    Examples
    --------
    >>> import tempfile
    >>> from apesim.archive.columns import run_axis
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     out = Path(folder, "sweep.h5")
    ...     publish(Archive("bore = 1", {}, {"run": run_axis(3)}), out)
    ...     written = written_json(out, [], 0.5)
    >>> written["figures"], written["wall_time_s"]
    ([], 0.5)
    """
    written = {"archive": str(out), "content_sha256": read_digest(out), "figures": [str(path) for path in drawn]}
    return written | {"wall_time_s": wall_time}


def written_text(written: dict, count: str) -> str:
    """Say what was computed, in which time, where it lies, and by which digest it is known.

    Parameters
    ----------
    written : dict
        Result of `written_json`.
    count : str
        What was computed, e.g. "40 runs".

    Returns
    -------
    str
        Two lines.

    Examples
    --------
    >>> written = {"archive": "a.h5", "content_sha256": "6e40e2ad", "figures": [], "wall_time_s": 0.5}
    >>> print(written_text(written, "40 runs"))
    a.h5: 40 runs in 0.50 s
    SHA-256 of its content: 6e40e2ad
    """
    line = f"{written['archive']}: {count} in {written['wall_time_s']:.2f} s"
    if written["figures"]:
        line += f"; figures in {Path(written['figures'][0]).parent}/"
    return f"{line}\n{digest_line(written['content_sha256'])}"


def digest_line(digest: str | None) -> str:
    """Make the line with the root digest of an archive.

    Parameters
    ----------
    digest : str or None
        64 hexadecimal digits; None for an archive of format version 1.

    Returns
    -------
    str
        Line for the terminal.

    Examples
    --------
    >>> digest_line(None)
    'SHA-256 of its content: none, format version 1 has no digests'
    """
    return f"SHA-256 of its content: {digest or 'none, format version 1 has no digests'}"


def write_traces(path: str | os.PathLike[str], header: Iterable[str], rows: np.ndarray) -> None:
    """Write traces as CSV, floats without loss; the file is complete or absent.

    Parameters
    ----------
    path : path
        CSV to write; one that is there is replaced.
    header : sequence of str
        Names with units, ``name [unit]``, m of them.
    rows : (n, m) float array
        Values in these units.

    Raises
    ------
    ArchiveError
        The file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "traces.csv")
    ...     write_traces(path, ("time [s]", "lift [m]"), np.array([[0.0, 0.0], [1e-3, 4.5e-3]]))
    ...     path.read_text().splitlines()
    ['time [s],lift [m]', '0.0,0.0', '0.001,0.0045']
    """
    write_file(path, format_csv(header, rows.tolist()))
