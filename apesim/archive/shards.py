"""Parts of a running sweep, safe against crashes, and how parts become one archive.

A sweep into F.h5 holds F.h5.lock, puts finished runs into F.h5.shards/ every few seconds, each shard by temporary
file and rename, and merges them at the end. Killed at any time, it loses at most the shard in work.

The provenance of an archive says how many runs were planned ("runs_planned"), and which share of them it was to hold
("shard": "1/4" is every fourth from the first; a merge lists several), so that what it lacks can be told from it alone.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import filelock
import numpy as np

from apesim.archive.comparison import machine_differences
from apesim.archive.file import Archive, ArchiveError, read, remove_file, remove_temporaries, write
from apesim.archive.records import validate
from apesim.archive.untrusted import TooLargeError

__all__ = [
    "Shards",
    "gaps_in_words",
    "lock",
    "merge",
    "missing_runs",
    "plan_hash",
    "read_shards",
    "remove_shards",
    "runs_planned",
    "shards_folder",
    "write_shard",
]


MAX_GAPS_NAMED = 10
"""Most gaps that a message names: people still read a line of ten."""


class Shards(NamedTuple):
    """What a killed sweep left behind."""

    parts: list[Archive]
    done: list[int]  # run numbers in the parts, increasing
    damaged: list[str]  # one line for each shard that could not be read; its runs must be computed again


def plan_hash(machine: str, settings: Mapping[str, Any]) -> str:
    """Return the hash that identifies a sweep: shards and parts with equal hashes belong together.

    Parameters
    ----------
    machine : str
        TOML text of the machine.
    settings : mapping
        Everything else that decides the results and the numbering of the runs, as JSON knows it.

    Returns
    -------
    str
        64 hexadecimal digits.

    Examples
    --------
    >>> plan_hash("bore = 1", {"speed": [600, 900]})[:8]
    '79183516'
    """
    content = json.dumps([machine, settings], sort_keys=True, ensure_ascii=True, allow_nan=True)
    return hashlib.sha256(content.encode()).hexdigest()


def shards_folder(path: str | os.PathLike[str]) -> Path:
    """Return the folder of the shards of an archive: F.h5.shards for F.h5.

    Parameters
    ----------
    path : path
        File of the archive.

    Returns
    -------
    Path
        Folder; it need not exist.

    Examples
    --------
    >>> shards_folder("sweep.h5").name
    'sweep.h5.shards'
    """
    return Path(f"{os.fspath(path)}.shards")


@contextmanager
def lock(path: str | os.PathLike[str]) -> Iterator[None]:
    """Hold F.h5.lock while an archive is being made, so that no second sweep writes the same target.

    The lock ends with the process, however it ends. Its file is removed while it is still held; filelock takes no lock
    on a file that was removed in the meantime. What killed writers have left of the archive is removed first.

    Parameters
    ----------
    path : path
        File of the archive; its folder has to exist.

    Yields
    ------
    None
        While the block runs, the lock is held.

    Raises
    ------
    ArchiveError
        Another process holds it, named in the message, or the folder is not writable.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder, lock(Path(folder, "sweep.h5")):
    ...     Path(folder, "sweep.h5.lock").exists()
    True
    """
    lock_file = Path(f"{os.fspath(path)}.lock")
    if not os.path.isdir(lock_file.parent):
        raise ArchiveError(path, "its folder does not exist", "make it or choose another one")
    guard = filelock.FileLock(lock_file, blocking=False)
    try:
        guard.acquire()
    except filelock.Timeout:
        holder = "another process"
        with suppress(OSError, UnicodeDecodeError):
            holder = lock_file.read_text(encoding="utf-8")[:200] or holder
        raise ArchiveError(
            path,
            f"is being written by {holder} (lock {lock_file.name})",
            "wait for it or choose another file",
        ) from None
    except (OSError, NotImplementedError) as error:
        raise ArchiveError(lock_file, f"cannot be locked ({error})", "choose another folder") from error
    try:
        with suppress(OSError):
            since = datetime.now(UTC).isoformat(timespec="seconds")
            lock_file.write_text(f"process {os.getpid()} since {since}", encoding="utf-8")
        remove_temporaries(Path(path))
        yield
    finally:
        with suppress(OSError):  # Windows lets go of no open file; there filelock removes it
            lock_file.unlink()
        guard.release()


def write_shard(folder: str | os.PathLike[str], part: Archive) -> Path:
    """Write finished runs beside the target; after the return they survive a kill or a power cut.

    Parameters
    ----------
    folder : path
        Folder of the shards, see `shards_folder`; made if it does not exist.
    part : Archive
        Finished runs. Its "run" holds the run numbers of the whole sweep, its provenance the plan_hash.

    Returns
    -------
    Path
        The shard, named by its run numbers.

    Raises
    ------
    ValueError
        The part breaks the data model, holds no runs or has no plan_hash.
    ArchiveError
        It could not be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {"plan_hash": "12ab"}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> with TemporaryDirectory() as folder:
    ...     write_shard(folder, archive).name
    'runs_000000-000001.h5'
    """
    folder = Path(folder)
    validate(part)
    if not part.provenance.get("plan_hash") or not len(part.runs):
        raise ValueError("a shard needs at least one run and a provenance entry 'plan_hash'")
    first, last = int(part.runs[0]), int(part.runs[-1])
    name = f"runs_{first:06d}-{last:06d}"
    if len(part.runs) != last - first + 1:
        name += f"_{hashlib.sha256(part.runs.tobytes()).hexdigest()[:12]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(folder, f"cannot be made ({error.strerror})", "choose another folder") from error
    return write(part, folder / f"{name}.h5")


def read_shards(folder: str | os.PathLike[str], plan_hash: str) -> Shards:
    """Read what a sweep has finished so far.

    Parameters
    ----------
    folder : path
        Folder of the shards, see `shards_folder`; need not exist.
    plan_hash : str
        Hash of the sweep that wants to go on.

    Returns
    -------
    Shards
        Parts, run numbers that are done, and a line for each damaged shard.

    Raises
    ------
    ArchiveError
        A shard belongs to another sweep, or takes more memory than is available.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {"plan_hash": "12ab"}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> with TemporaryDirectory() as folder:
    ...     _ = write_shard(folder, archive)
    ...     read_shards(folder, "12ab").done
    [0, 1]
    """
    shards = Shards([], [], [])
    texts: dict[str, str] = {}
    for path in sorted(Path(folder).glob("runs_*.h5")):
        try:
            part = read(path)
        except TooLargeError:
            raise
        except ArchiveError as error:
            shards.damaged.append(str(error))
            continue
        if part.provenance.get("plan_hash") != plan_hash:
            raise ArchiveError(
                path,
                "is part of another sweep: machine, settings or program differ",
                "resume with the settings it was started with, or remove the folder",
            )
        shards.parts.append(_with_shared_texts(part, texts))
    shards.done.extend(sorted({int(run) for part in shards.parts for run in part.runs}))
    return shards


def _with_shared_texts(part: Archive, texts: dict[str, str]) -> Archive:
    """Use texts that were read before, in place of equal ones: they took a sixth of the memory of 300 shards."""

    def shared(text: str) -> str:
        return texts.setdefault(text, text)

    return Archive(
        shared(part.machine),
        {shared(key): shared(value) for key, value in part.provenance.items()},
        {
            shared(name): replace(
                variable,
                unit=shared(variable.unit),
                description=shared(variable.description),
                meanings=shared(variable.meanings),
            )
            for name, variable in part.variables.items()
        },
    )


def remove_shards(folder: str | os.PathLike[str]) -> None:
    """Remove the shards of a sweep, and the temporary files of killed writers; other files stay.

    Parameters
    ----------
    folder : path
        Folder of the shards; nothing happens where it is a link or does not exist.

    Raises
    ------
    ArchiveError
        One of them cannot be removed.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {"plan_hash": "12ab"}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> with TemporaryDirectory() as parent:
    ...     folder = shards_folder(Path(parent, "sweep.h5"))
    ...     _ = write_shard(folder, archive)
    ...     remove_shards(folder)
    ...     folder.exists()
    False
    """
    folder = Path(folder)
    if os.path.islink(folder) or not os.path.isdir(folder):
        return
    for pattern in ("runs_*.h5", ".runs_*.h5.*.tmp"):
        for path in sorted(folder.glob(pattern)):
            remove_file(path)
    with suppress(OSError):
        folder.rmdir()


def merge(parts: Sequence[Archive], names: Sequence[str | os.PathLike[str]] | None = None) -> Archive:
    """Join parts of one sweep, sorted by run number.

    Runs that occur twice collapse if they agree bit for bit. Provenance entries that differ are listed one
    after the other, except "created", which `write` sets anew.

    Parameters
    ----------
    parts : sequence of Archive
        At least one; machine, plan_hash, variables, units and all axes but "run" must agree.
    names : sequence of path, optional
        File names of the parts for messages.

    Returns
    -------
    Archive
        All runs of the parts; `missing_runs` says whether it is complete.

    Raises
    ------
    ArchiveError
        The parts do not belong together, or contradict each other on a run.

    Examples
    --------
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> merge([archive, archive]).runs.tolist()
    [0, 1]
    """
    labels = [os.fspath(name) for name in names] if names else [f"part {i + 1}" for i in range(len(parts))]
    if not parts:
        raise ArchiveError("merge", "no parts were given", "name at least one archive")
    for label, part in zip(labels, parts, strict=True):
        if conflict := _conflict(parts[0], part):
            raise ArchiveError(label, f"does not fit {labels[0]}: {conflict}", "merge parts of one sweep only")
    runs = np.concatenate([part.runs for part in parts])
    owner = np.repeat(np.arange(len(parts)), [len(part.runs) for part in parts])
    order = np.argsort(runs, kind="stable")
    again = np.flatnonzero(np.diff(runs[order]) == 0)  # positions whose successor is the same run
    keep = np.delete(order, again + 1)
    in_order = np.array_equal(keep, np.arange(len(runs)))
    variables = {}
    for name, variable in parts[0].variables.items():
        if variable.dims[0] == "run":
            values = np.concatenate([part.variables[name].values for part in parts])
            for left, right in zip(order[again], order[again + 1], strict=True):
                if not _same(values[left], values[right]):
                    raise ArchiveError(
                        labels[owner[right]],
                        f"run {runs[right]} contradicts {labels[owner[left]]} in {name}",
                        "find out which one is right and leave the other out",
                    )
            variable = replace(variable, values=values if in_order else values[keep])
        variables[name] = variable
    return Archive(parts[0].machine, _joined_provenance(parts), variables)


def runs_planned(archive: Archive) -> int | None:
    """Return the number of runs of the whole sweep that an archive holds or is a share of.

    Parameters
    ----------
    archive : Archive
        Archive of a sweep, whole or partial.

    Returns
    -------
    int or None
        Number of runs; None where the provenance does not say.

    Examples
    --------
    >>> runs_planned(Archive("", {"runs_planned": "24"}, {}))
    24
    """
    planned = archive.provenance.get("runs_planned", "")
    return int(planned) if planned.isdecimal() and len(planned) < 19 else None


def missing_runs(archive: Archive, total: int | None = None) -> list[tuple[int, int]]:
    """Find the runs that an archive lacks.

    Parameters
    ----------
    archive : Archive
        Whole or partial archive of a sweep.
    total : int, optional
        Number of runs that the archive should hold, numbered from 0. If left out, the archive itself says what it
        should hold: of the planned runs (`runs_planned`) those in its share of the sweep ("shard" of its provenance).
        An archive without a plan should hold all runs up to its highest run number that are in its share.

    Returns
    -------
    list of (int, int)
        First and last run number of each gap, in increasing order. Between these two a gap may also span runs that
        are in another share.

    Examples
    --------
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> missing_runs(archive), missing_runs(archive, total=5)
    ([], [(2, 4)])
    """
    shares = [(1, 1)] if total is not None else _shares(archive)
    total = runs_planned(archive) if total is None else total
    runs = archive.runs.tolist()
    end = (runs[-1] + 1 if runs else 0) if total is None else total
    edges = [-1, *(run for run in runs if run < end), end]
    gaps = [(a + 1, b - 1) for a, b in itertools.pairwise(edges) if b - a > 1]
    return [trimmed for gap in gaps if (trimmed := _trimmed(*gap, shares))]


def gaps_in_words(gaps: Sequence[Sequence[int]]) -> str:
    """Return gaps between runs in words; of many only the first `MAX_GAPS_NAMED`.

    Parameters
    ----------
    gaps : sequence of (int, int)
        First and last missing number of each gap.

    Returns
    -------
    str
        Numbers and spans of numbers.

    Examples
    --------
    >>> gaps_in_words([(3, 3), (5, 7)])
    '3, 5-7'
    """
    words = [f"{first}-{last}" if last > first else f"{first}" for first, last in gaps[:MAX_GAPS_NAMED]]
    if len(gaps) > MAX_GAPS_NAMED:
        words.append(f"{len(gaps) - MAX_GAPS_NAMED} more gaps")
    return ", ".join(words)


def _shares(archive: Archive) -> list[tuple[int, int]]:
    """Shares of a sweep that an archive was to hold, (i, N) for every N-th run from the i-th."""
    told = re.findall(r"(\d{1,18})/(\d{1,18})", archive.provenance.get("shard", ""))
    if not told:  # the provenance of format version 1 has the command only
        told = re.findall(r"--shard[ =](\d{1,18})/(\d{1,18})", archive.provenance.get("command", ""))
    return [(int(i), int(n)) for i, n in told if int(n)] or [(1, 1)]


def _trimmed(first: int, last: int, shares: Sequence[tuple[int, int]]) -> tuple[int, int] | None:
    """Narrow a gap until its first and its last run are in some share, (i, N); None if no run of the gap is in any."""
    ends = [(first + (i - 1 - first) % n, last - (last - i + 1) % n) for i, n in shares]
    ends = [(a, b) for a, b in ends if a <= b]
    return (min(a for a, _ in ends), max(b for _, b in ends)) if ends else None


def _conflict(a: Archive, b: Archive) -> str:
    if a.machine != b.machine:
        keys = ", ".join(row.name for row in machine_differences(a.machine, b.machine)[:3])
        return f"another machine ({keys or 'in its comments'})"
    if a.provenance.get("plan_hash") != b.provenance.get("plan_hash"):
        return "other settings (plan_hash)"
    if only := sorted(a.variables.keys() ^ b.variables.keys()):
        return f"only one of them has {only[0]}"
    for name, mine in a.variables.items():
        other = b.variables[name]
        for field in ("kind", "dims", "unit", "description", "meanings", "finite"):
            if getattr(mine, field) != getattr(other, field):
                return f"{name} has {field} {getattr(other, field)!r}, not {getattr(mine, field)!r}"
        if mine.dims[0] != "run" and not _same(mine.values, other.values):
            return f"the axis {name} differs"
        if mine.values.shape[1:] != other.values.shape[1:]:
            return f"{name} has another shape"
    return ""


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    a, b = np.asarray(a), np.asarray(b)
    if a.dtype.kind == "U":
        return bool(np.array_equal(a, b))
    return a.shape == b.shape and a.tobytes() == b.tobytes()


def _joined_provenance(parts: Sequence[Archive]) -> dict[str, str]:
    joined: dict[str, list[str]] = {}
    for part in parts:
        for key, value in part.provenance.items():
            if key != "created" and value not in joined.setdefault(key, []):
                joined[key].append(value)
    return {key: "; ".join(values) for key, values in joined.items()}
