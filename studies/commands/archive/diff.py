"""Command `apesim archive diff`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.options import ArchivePath, Common

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.archive.comparison import Comparison, Summary

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
    from apesim.archive.comparison import diff, provenance_differences, summarise
    from apesim.archive.inspection import info
    from apesim.studies.commands.archive.machine_differences import difference_lines, differences_from_given

    others = differences_from_given(common, [path, other])
    compared = diff(path, other, rtol, atol)
    rows = compared.differences
    provenance, summary = provenance_differences(path, other), summarise(rows)
    data = {
        "runs_compared": compared.runs,
        "variables_same": compared.same,
        "variables_different": compared.different,
        "summary": [row._asdict() for row in summary],
        "differences": [row._asdict() for row in rows],
        "provenance": [row._asdict() for row in provenance],
        "machine_differences": others,
    }
    shown_lines: list[str | Table] = [
        _headline(compared, summary),
        f"no differences; {len(provenance)} entries of provenance differ",
    ]
    if rows:
        units = {v["name"]: v["unit"] for file in (other, path) for v in info(file)["variables"]}
        rows = sorted(rows, key=lambda row: row.kind == "run")  # which run is missing comes last
        shown = rows if show_all else rows[:MAX_SHOWN]
        shown_lines[1:] = [_summary_table(summary, units), _difference_table(shown, path, other)]
        if len(rows) > MAX_SHOWN and not show_all:
            shown_lines.append(f"{MAX_SHOWN} of {len(rows)} differences; --all shows every one, --json holds them")
    common.console.result(data, *shown_lines, *difference_lines(others))
    return INCOMPLETE if rows or others else DONE


def _headline(compared: "Comparison", summary: "Sequence[Summary]") -> str:
    """How many variables are the same, how many differ, and the largest relative difference, in one line."""
    from apesim.terminal import visible

    line = f"{compared.runs} runs compared: {compared.same} variables the same, {compared.different} differ"
    numbers = [row for row in summary if row.kind == "variable" and row.relative is not None]
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
