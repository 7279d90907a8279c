"""Parts of a running sweep, safe against crashes.

A sweep into F.h5 holds F.h5.lock, puts finished runs into F.h5.shards/ every few seconds, each shard by temporary
file and rename, and merges all runs at the end. Killed at any time, it loses at most the shard in work.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from apesim.archive.errors import TooLargeError
from apesim.archive.file import Archive, ArchiveError, read, write
from apesim.archive.records import validate
from apesim.archive.writing import remove_file

__all__ = [
    "Shards",
    "plan_hash",
    "read_shards",
    "remove_shards",
    "shards_folder",
    "write_shard",
]


class Shards(NamedTuple):
    """What a killed sweep left behind."""

    parts: list[Archive]
    done: list[int]  # run numbers in the parts, increasing
    damaged: list[str]  # one line for each shard that could not be read; its runs must be computed again


def plan_hash(machine: str, settings: Mapping[str, Any]) -> str:
    """Return the hash that identifies a sweep: shards and parts with equal hashes belong together.

    `machine` is a TOML text, `settings` all else that decides the results and the numbering of the runs, as JSON knows
    it; the hash is hexadecimal.
    """
    content = json.dumps([machine, settings], sort_keys=True, ensure_ascii=True, allow_nan=True)
    return hashlib.sha256(content.encode()).hexdigest()


def shards_folder(path: str | os.PathLike[str]) -> Path:
    """Return the folder of the shards of an archive, F.h5.shards for F.h5; it need not exist."""
    return Path(f"{os.fspath(path)}.shards")


def write_shard(folder: str | os.PathLike[str], part: Archive) -> Path:
    """Write finished runs beside the target; after the return they survive a kill or a power cut.

    The folder is made if it does not exist; the "run" of `part` holds the run numbers of the whole sweep, its
    provenance the plan_hash. Raises ValueError where the part breaks the data model, holds no runs or has no plan_hash,
    ArchiveError where it cannot be written.
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
    """Read what a sweep has finished so far, and a line for each damaged shard; the folder need not exist.

    Raises ArchiveError where a shard has another `plan_hash`, or takes more memory than is available.
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
                "is part of another sweep or run: machine, settings or program differ",
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

    Nothing happens where the folder is a link or does not exist. Raises ArchiveError where a file cannot be removed.
    """
    folder = Path(folder)
    if os.path.islink(folder) or not os.path.isdir(folder):
        return
    for pattern in ("runs_*.h5", ".runs_*.h5.*.tmp"):
        for path in sorted(folder.glob(pattern)):
            remove_file(path)
    with suppress(OSError):
        folder.rmdir()
