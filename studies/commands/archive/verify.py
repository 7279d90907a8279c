"""Command `apesim archive verify`."""

from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.options import ArchivePath, Common


def verify_archive(common: Common, path: ArchivePath) -> int:
    """Check every checksum, unit and axis; exit code 3 if anything is wrong."""
    from apesim.archive import read_digest
    from apesim.archive.inspection import verify
    from apesim.studies.commands.archive.machine_differences import difference_lines, differences_from_given
    from apesim.studies.output import digest_line

    faults = verify(path)
    differences = [] if faults else differences_from_given(common, [path])
    digest = None if faults else read_digest(path)
    data = {"file": str(path), "content_sha256": digest, "faults": faults, "machine_differences": differences}
    lines = faults or difference_lines(differences) or [f"{path}: whole; {digest_line(digest)}"]
    common.console.result(data, *lines)
    return INCOMPLETE if faults or differences else DONE
