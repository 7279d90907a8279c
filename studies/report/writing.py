"""Writing the page of an archive into a file."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path

from apesim.archive import ArchiveError, find_target, read, read_digest, write_file
from apesim.quantities import Fault, InputError
from apesim.studies.archives.archive_result import ArchiveResult, result_of
from apesim.studies.execution.calls import public
from apesim.studies.measured import read_measured
from apesim.studies.report.machine import read_machine
from apesim.studies.report.page import render_page

ENDING = ".html"
"""Ending of a page, where none is named: that by which systems know what opens it."""


@public
def write_report(
    archive: str | PathLike[str] | ArchiveResult,
    out: str | PathLike[str] | None = None,
    *,
    measured: str | PathLike[str] | None = None,
    overwrite: bool = False,
) -> Path:
    """Write the results of a study as a page: one HTML file that stands alone, for any browser.

    The page asks for nothing outside, and works without scripts, too: they let curves and maps say their values. The
    same archive gives the same bytes.

    Parameters
    ----------
    archive : path or ArchiveResult
        Archive of a study, or its result, such as a `Sweep`.
    out : path, optional
        Page to write; beside the archive, with the ending ``.html``, if left out.
    measured : path, optional
        Folder of measured data, see `read_measured`: torque and air flow of an engine are drawn over the curves of a
        sweep.
    overwrite : bool
        Replace a page that is there.

    Returns
    -------
    Path
        Path of the page.

    Raises
    ------
    ArchiveError
        The archive cannot be read, or the page exists or cannot be written.
    InputError
        A result needs a page to be named; or the measured data are wrong, or nothing can be drawn over them.

    Examples
    --------
    >>> import tempfile
    >>> import apesim
    >>> delays = apesim.map_valve(apesim.Machine(), pressure="0.8 MPa gauge", temperature="280, 300 K")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     page = apesim.write_report(delays, f"{folder}/map.html")
    ...     page.name, page.read_text(encoding="utf-8")[:15]
    ('map.html', '<!doctype html>')
    """
    if out is None:
        if isinstance(archive, ArchiveResult):
            right = 'name the page to write, e.g. "sweep.html"'
            raise InputError([Fault("write_report()", "out", "is left out, and a result has no file", right)])
        out = Path(archive).with_suffix(ENDING)
    write_page = prepare_page(out, overwrite=overwrite, measured=measured)
    write_page(archive)
    return Path(out)


def prepare_page(
    path: str | PathLike[str] | None, *, overwrite: bool, measured: str | PathLike[str] | None = None
) -> Callable[[str | PathLike[str] | ArchiveResult], dict[str, str]]:
    """Refuse a page that exists or cannot be written, before anything is computed, and give what writes it.

    That takes the archive or the result, and gives the entry ``report`` for JSON; nothing where `path` is None.
    """
    if path is None:
        return lambda archive: {}
    if find_target(path).exists() and not overwrite:
        raise ArchiveError(path, "exists already", "give --overwrite to replace it, or choose another name")

    def write_page(archive: str | PathLike[str] | ArchiveResult) -> dict[str, str]:
        """Write the page of an archive, or of a result that has no file."""
        if isinstance(archive, ArchiveResult):
            result, digest = archive, ""
        else:
            result, digest = result_of(read(archive)), read_digest(archive) or ""
        shown = None if measured is None else read_measured(measured, read_machine(result.archive).ambient.pressure)
        write_file(path, render_page(result, digest=digest, measured=shown))
        return {"report": str(path)}

    return write_page
