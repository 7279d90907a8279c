"""Command `apesim archive diff`."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.commands.options import ArchivePath, Common
from apesim.studies.terminal.console import DONE, INCOMPLETE

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.archive.comparison import Difference, Summary
    from apesim.studies.archives.comparison import ArchiveComparison

MAX_SHOWN = 16
"""Variables that are shown without ``--all``: the results that an archive begins with are those it was made for."""


def compare_archives(
    common: Common,
    path: ArchivePath,
    other: Annotated[Path, typer.Argument(metavar="G.h5", help="Archive to compare with.")],
    rtol: Annotated[
        float | None,
        typer.Option(min=0.0, help="Relative difference that counts as none; 1e-4, the solver's own error. 0: no bit."),
    ] = None,
    atol: Annotated[float, typer.Option(min=0.0, help="Absolute difference that counts as none, in SI.")] = 0.0,
    show_all: Annotated[bool, typer.Option("--all", help="Show all variables, and every difference.")] = False,
) -> int:
    """Compare two archives by the coordinates of their runs: the machines' keys, then a line for each variable.

    The exit code is 3 if they differ.
    """
    from apesim.archive.inspection import info
    from apesim.studies.archives import comparison
    from apesim.studies.commands.archive.machine_differences import difference_lines, given_machine

    rtol = comparison.SOLVER_TOLERANCE if rtol is None else rtol
    compared = comparison.compare_archives(path, other, rtol=rtol, atol=atol, machine=given_machine(common))
    names = (path.name, other.name) if path.name != other.name else (str(path), str(other))
    shown_lines: list[str | Table] = [_headline(compared, rtol)]
    if not compared.differences:
        shown_lines.append(f"no differences; {len(compared.provenance)} entries of provenance differ")
    keys = [row for row in compared.summary if row.kind == "machine"]
    results = [row for row in compared.summary if row.kind in ("axis", "variable")]
    if keys:
        shown_lines.append(_machine_table(keys, names))
    shown_lines += _missing_runs(compared.differences, names)
    if results:
        units = {v["name"]: v["unit"] for file in (other, path) for v in info(file)["variables"]}
        shown_lines.append(_summary_table(results if show_all else results[:MAX_SHOWN], units, names))
    if compared.differences and show_all:
        shown_lines.append(_difference_table(compared.differences, names))
    elif len(results) > MAX_SHOWN:
        more = f"{len(results) - MAX_SHOWN} more variables differ"
        shown_lines.append(f"{more}; --all shows them and every difference, --json holds them")
    common.console.result(compared.to_dict(), *shown_lines, *difference_lines(compared.machine_differences))
    return DONE if compared.is_same and not compared.machine_differences else INCOMPLETE


def _headline(compared: "ArchiveComparison", rtol: float) -> str:
    """How many variables are the same, how many differ, and the largest relative difference, in one line."""
    from apesim.terminal import visible

    same, different = compared["variables_same"], compared["variables_different"]
    beyond = f" by more than {rtol:g} of their size" if rtol else ""
    line = f"{compared['runs_compared']} runs compared: {same} variables the same, {different} differ{beyond}"
    numbers = [row for row in compared.summary if row.kind == "variable" and row.relative is not None]
    if not numbers:
        return line
    worst = max(numbers, key=lambda row: row.relative or 0.0)
    where = f" at {worst.where_relative}" if worst.where_relative else ""
    return visible(f"{line}; largest relative difference {worst.relative:.2g}: {worst.name}{where}")


def _machine_table(keys: Sequence["Summary"], names: Sequence[str]) -> "Table":
    """Keys in which the machines differ, with both values."""
    from apesim.studies.terminal.tables import table_of
    from apesim.terminal import visible

    shown = [[row.name, *(visible("not there" if v is None else str(v)) for v in (row.a, row.b))] for row in keys]
    return table_of("Machines", ("key", *names), shown, left=(0, 1, 2))


def _missing_runs(differences: Sequence["Difference"], names: Sequence[str]) -> list[str]:
    """A line for each archive that has runs which the other lacks."""
    from apesim.terminal import visible

    lines = []
    for name, only in zip(names, ("b", "a"), strict=True):
        rows = [row for row in differences if row.kind == "run" and getattr(row, only) is None]
        if rows:
            first = f", the first at {rows[0].where}" if rows[0].where else f", the first is run {rows[0].run}"
            lines.append(visible(f"{len(rows)} runs are in {name} only{first}"))
    return lines


def _summary_table(summary: Sequence["Summary"], units: dict[str, str], names: Sequence[str]) -> "Table":
    """A line for each variable, with both values where it differs most."""
    from apesim.studies.terminal.tables import table_of
    from apesim.terminal import visible

    header = ("variable", "unit", "runs", *names, "by [%]", "where it differs most")
    shown = [
        (
            visible(row.name),
            visible(units.get(row.name, "")),
            str(row.runs or ""),
            *(visible(_short(value)) for value in (row.a, row.b)),
            "" if row.largest is None else f"{100.0 * row.largest / max(abs(row.a), abs(row.b)):.2g}",
            visible(re.sub(r"\.0\b", "", row.where.replace(" = ", "="))),
        )
        for row in summary
    ]
    return table_of("Results", header, shown, left=(0, 1, 6))


def _short(value: object) -> str:
    """A value in few digits; "" where there is none."""
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _difference_table(rows: Sequence["Difference"], names: Sequence[str]) -> "Table":
    """Single differences, one a row."""
    from apesim.studies.terminal.tables import table_of
    from apesim.terminal import visible

    header = ("what", "name", "run", "where", *names, "samples")
    shown = [tuple("" if value is None else visible(str(value)) for value in row) for row in rows]
    return table_of("Differences", header, shown, left=(0, 1, 3))
