"""Archives whose computing may be interrupted: what is there of one, what may be replaced, and what is left over."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from apesim.archive import Archive, ArchiveError, DamagedError, read
from apesim.archive.shards import remove_shards, shards_folder
from apesim.studies.execution.output import refuse_to_replace


def read_own_archive(out: Path, provenance: Mapping[str, str], *, overwrite: bool) -> Archive | None:
    """Read the archive that is there, if all the entries of a provenance are its own; None where it is another's.

    Raises DamagedError where it is damaged and is not to be replaced.
    """
    if not os.path.exists(out):
        return None
    try:
        archive = read(out)
    except DamagedError as error:
        if overwrite:
            return None
        raise DamagedError(out, f"is there, but damaged ({error.what})", "give --overwrite to replace it") from None
    except ArchiveError:
        return None
    return archive if all(archive.provenance.get(key) == text for key, text in provenance.items()) else None


def make_room(out: Path, *, resume: bool, overwrite: bool, unfinished: str) -> None:
    """Make room for a new archive; raises ArchiveError where something would be lost that is not to be replaced.

    `unfinished` says what the shards beside it hold, such as "the points of an unfinished sweep".
    """
    folder = shards_folder(out)
    if not overwrite:
        refuse_to_replace(out)
    if os.path.exists(folder) and not resume:
        if not overwrite:
            raise ArchiveError(folder, f"holds {unfinished}", "go on with --resume, or give --overwrite")
        remove_shards(folder)


def remove_what_is_done(out: Path) -> list[str]:
    """Remove the shards of an archive that is written; a line where that cannot be done."""
    try:
        remove_shards(shards_folder(out))
    except ArchiveError as error:
        return [f"all runs are in {out.name}, but {error}"]
    return []


def keep(archive: Archive, save: Callable[[Archive], Path]) -> Path:
    """Save an archive; where that fails, the error says that all finished shards are kept.

    `save` writes the archive and returns its path. Raises ArchiveError, whose remedy names ``--resume``, where it
    cannot.
    """
    try:
        return save(archive)
    except ArchiveError as error:
        remedy = f"{error.remedy}; what is done is kept, go on with --resume"
        raise type(error)(error.path, error.what, remedy) from error
