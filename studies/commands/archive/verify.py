"""Command `apesim archive verify`."""

from apesim.studies.commands.options import ArchivePath, Common
from apesim.studies.terminal.console import DONE, INCOMPLETE


def verify_archive(common: Common, path: ArchivePath) -> int:
    """Check every checksum, unit and axis; exit code 3 if anything is wrong."""
    from apesim.studies.archives import description
    from apesim.studies.commands.archive.machine_differences import difference_lines, given_machine
    from apesim.studies.execution.output import digest_line

    verified = description.verify_archive(path, machine=given_machine(common))
    digest, differences = verified.content_sha256, verified.machine_differences
    lines = verified.faults or difference_lines(differences) or [f"{path}: {verified.sentence}; {digest_line(digest)}"]
    common.console.result(verified.to_dict(), *lines)
    return DONE if verified.is_whole and not differences else INCOMPLETE
