"""Command `apesim archive verify`."""

from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.options import ArchivePath, Common


def verify_archive(common: Common, path: ArchivePath) -> int:
    """Check every checksum, unit and axis; exit code 3 if anything is wrong.

    Parameters
    ----------
    common : Common
        Console and machine of the command line; keys in which the archive was made with another machine are shown.
    path : path
        Archive.

    Returns
    -------
    int
        Exit code: 0 where it is whole, 3 where it is damaged or was made with another machine.

    Raises
    ------
    ArchiveError
        The file is no archive.

    Examples
    --------
    >>> import json, tempfile
    >>> from typer.testing import CliRunner
    >>> from apesim.archive import Archive, write
    >>> from apesim.archive.columns import column, run_axis
    >>> from apesim.studies.cli import app
    >>> variables = {"run": run_axis(1), "torque": column([20.0], "N m", "brake torque")}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = write(Archive("bore = 1", {}, variables), f"{folder}/a.h5")
    ...     output = CliRunner().invoke(app, ["archive", "verify", f"{folder}/a.h5", "--json"]).stdout
    >>> json.loads(output)["faults"]
    []
    """
    from apesim.studies.archives import description
    from apesim.studies.commands.archive.machine_differences import difference_lines, given_machine
    from apesim.studies.output import digest_line

    verified = description.verify_archive(path, machine=given_machine(common))
    digest, differences = verified.content_sha256, verified.machine_differences
    lines = verified.faults or difference_lines(differences) or [f"{path}: {verified.sentence}; {digest_line(digest)}"]
    common.console.result(verified.to_dict(), *lines)
    return DONE if verified.is_whole and not differences else INCOMPLETE
