"""Command `apesim gap isolability`."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from apesim.studies.commands.options import Common, MeasuredFolder, Without
from apesim.studies.terminal.console import DONE, INCOMPLETE

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.studies.gap.design.isolability import Isolability

HEADER = ("effect", "visible from (5 sigmas)", "retained", "hardly distinguishable from", "what would help")


def show_isolability(common: Common, folder: MeasuredFolder, without: Without = None) -> int:
    """Tell which effects the sensors and runs of a folder could show, from which size on, and what would help.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.commands.cli import app
    >>> print(CliRunner().invoke(app, ["gap", "isolability", "no_folder", "--without", "ring_leak"]).exception)
    command line: --without: 'ring_leak' is no effect; see apesim gap effects, or give the key of a number
    """
    from apesim.studies.commands.gap.inputs import compile_march, read_inputs
    from apesim.studies.estimation.residuals import EndedEarly
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.gap.design.isolability import find_isolability

    console, ignored = common.console, without or ()
    machine, measured = read_inputs(common, folder, ignored)
    compile_march(console, machine, measured)
    try:
        with console.stages("isolability") as progress:
            call = call_in_thread(find_isolability, machine, measured, without=ignored, progress=progress)
            isolability = call.result()
    except EndedEarly as error:
        console.message(f"{error}; nothing is concluded")
        return INCOMPLETE
    console.result(isolability.to_dict(), *_shown(isolability))
    for warning in isolability.warnings:
        console.message(f"warning: {warning}")
    return DONE


def _shown(isolability: "Isolability") -> "Iterator[Table | str]":
    """A table of effects, those that are seen first, a table of what is known of the rig, and a count."""
    from apesim.studies.gap.design.isolability import PRIORS_HEADER, format_prior
    from apesim.studies.gap.search.detection_limits import format_limit
    from apesim.studies.terminal.tables import table_of

    rows = isolability.effects

    # Effects that could be seen come first; the sort is stable, so that each half keeps its order.
    ordered = sorted(rows, key=lambda row: row["limit"] is None)
    table = table_of(
        "",
        HEADER,
        [
            (
                row["effect"],
                format_limit(row),
                f"{100.0 * row['kept']:.0f} %",
                ", ".join(row["class"]) or "-",
                row["helped_by"]["text"] if row["helped_by"] else _without_help(row),
            )
            for row in ordered
        ],
        left=(0, 3, 4),
    )

    # Names and keys stay in one piece, as they are what the user writes in a command or a file.
    table.columns[0].no_wrap, table.columns[0].min_width = True, max(len(row["effect"]) for row in rows)
    yield table

    # What is known of the rig stands below: how much of an effect is retained depends on it.
    priors = table_of("", PRIORS_HEADER, [format_prior(prior) for prior in isolability.priors], left=(0, 3))
    priors.columns[0].no_wrap = priors.columns[1].no_wrap = True
    yield priors
    yield repr(isolability).removeprefix("Isolability: ")


def _without_help(row: dict[str, Any]) -> str:
    """Text for an effect that no experiment of the list helps: "-" where it needs none."""
    return "-" if row["limit"] is not None and not row["class"] else "nothing of the list"
