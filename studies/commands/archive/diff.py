"""Command `apesim archive diff`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.options import ArchivePath, Common

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.archive.comparison import Difference
    from apesim.studies.archives.comparison import ArchiveComparison

MAX_SHOWN = 20
"""Differences that are shown one by one: a screen of them."""


def compare_archives(
    common: Common,
    path: ArchivePath,
    other: Annotated[Path, typer.Argument(metavar="G.h5", help="Archive to compare with.")],
    rtol: Annotated[float, typer.Option(min=0.0, help="Relative difference that counts as none.")] = 0.0,
    atol: Annotated[float, typer.Option(min=0.0, help="Absolute difference that counts as none, in SI.")] = 0.0,
    show_all: Annotated[bool, typer.Option("--all", help="Show every difference, not only the first 20.")] = False,
) -> int:
    """Compare two archives by the coordinates of their runs, a summary first; exit code 3 if they differ.

    Parameters
    ----------
    common : Common
        Console and machine of the command line; keys in which the archives were made with another machine are shown.
    path, other : path
        Archives to compare.
    rtol : float
        Relative difference that counts as none [-].
    atol : float
        Absolute difference that counts as none [SI].
    show_all : bool
        Show every difference, not only the first `MAX_SHOWN`.

    Returns
    -------
    int
        Exit code: 0 where they are the same, 3 where they differ.

    Raises
    ------
    ArchiveError
        One of them cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> from typer.testing import CliRunner
    >>> from apesim.archive import Archive, write
    >>> from apesim.archive.columns import column, run_axis
    >>> from apesim.studies.cli import app
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     paths = [f"{folder}/{name}.h5" for name in "ab"]
    ...     for path, torque in zip(paths, (20.0, 21.0)):
    ...         variables = {"run": run_axis(1), "torque": column([torque], "N m", "brake torque")}
    ...         _ = write(Archive("bore = 1", {}, variables), path)
    ...     output = CliRunner().invoke(app, ["archive", "diff", *paths]).stdout
    >>> print(output.splitlines()[0])
    1 runs compared: 0 variables the same, 1 differ; largest relative difference 0.048: torque
    """
    from apesim.archive.inspection import info
    from apesim.studies.archives import comparison
    from apesim.studies.commands.archive.machine_differences import difference_lines, given_machine

    compared = comparison.compare_archives(path, other, rtol=rtol, atol=atol, machine=given_machine(common))
    rows: Sequence[Difference] = compared.differences
    shown_lines: list[str | Table] = [
        _headline(compared),
        f"no differences; {len(compared.provenance)} entries of provenance differ",
    ]
    if rows:
        units = {v["name"]: v["unit"] for file in (other, path) for v in info(file)["variables"]}
        rows = sorted(rows, key=lambda row: row.kind == "run")  # which run is missing comes last
        shown = rows if show_all else rows[:MAX_SHOWN]
        shown_lines[1:] = [_summary_table(compared.summary, units), _difference_table(shown, path, other)]
        if len(rows) > MAX_SHOWN and not show_all:
            shown_lines.append(f"{MAX_SHOWN} of {len(rows)} differences; --all shows every one, --json holds them")
    common.console.result(compared.to_dict(), *shown_lines, *difference_lines(compared.machine_differences))
    return DONE if compared.is_same and not compared.machine_differences else INCOMPLETE


def _headline(compared: "ArchiveComparison") -> str:
    """How many variables are the same, how many differ, and the largest relative difference, in one line."""
    from apesim.terminal import visible

    same, different = compared["variables_same"], compared["variables_different"]
    line = f"{compared['runs_compared']} runs compared: {same} variables the same, {different} differ"
    numbers = [row for row in compared.summary if row.kind == "variable" and row.relative is not None]
    if not numbers:
        return line
    worst = max(numbers, key=lambda row: row.relative or 0.0)
    where = f" at {worst.where_relative}" if worst.where_relative else ""
    return visible(f"{line}; largest relative difference {worst.relative:.2g}: {worst.name}{where}")


def _summary_table(summary: Sequence, units: dict[str, str]) -> "Table":
    """Differences by name, with units where they have one."""
    from apesim.studies.tables import table_of
    from apesim.terminal import visible

    header = ("what", "name", "unit", "runs that differ", "largest difference", "relative [%]", "the largest at")
    shown = [
        (
            row.kind,
            visible(row.name),
            visible(units.get(row.name, "")) if row.kind == "variable" else "",
            str(row.runs or ""),
            "" if row.largest is None else f"{row.largest:.3g}",
            "" if row.relative is None else f"{100.0 * row.relative:.3g}",
            visible(row.where),
        )
        for row in summary
    ]
    return table_of("Summary", header, shown, left=(0, 1, 2, 6))


def _difference_table(rows: Sequence, path: Path, other: Path) -> "Table":
    """Single differences, one a row."""
    from apesim.studies.tables import table_of
    from apesim.terminal import visible

    names = ("what", "name", "run", "where", str(path), str(other), "samples")
    shown = [tuple("" if value is None else visible(str(value)) for value in row) for row in rows]
    return table_of("Differences", names, shown, left=(0, 1, 3))
