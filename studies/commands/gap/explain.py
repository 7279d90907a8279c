"""Command `apesim gap explain`."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from apesim.studies.commands.options import Common, Jobs, MeasuredFolder, Overwrite, Without
from apesim.studies.terminal.console import DONE, INCOMPLETE, StageReport

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.studies.gap.explanation import Explanation

MAX_SHOWN = 8
"""Effects whose scores are shown: those behind them have explained nothing."""
MAX_WARNINGS = 3
"""Warnings that are shown, as many as at the head of the report."""
MIN_SHOWN_PULL = 1.0
"""Prior standard deviations beyond which a calibrated number is shown: nearer, it is what the machine file said."""


def explain_gap(
    common: Common,
    folder: MeasuredFolder,
    out: Annotated[Path, typer.Option(metavar="OUT", help="Folder for verdict.json, machine.toml and report.html.")],
    without: Without = None,
    tolerance: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="Size of a gap that does not matter, over the noise (0.15), or in a channel's unit ('0.3 N').",
        ),
    ] = None,
    jobs: Jobs = None,
    overwrite: Overwrite = False,
) -> int:
    """Find where measurements and model disagree, name the effect that is missing, add it, show the gap shrink.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.commands.cli import app
    >>> error = CliRunner().invoke(app, ["gap", "explain", "no_folder", "--out", "report"]).exception
    >>> str(error).partition("; ")[2]
    'give a folder with measured.toml and the CSV files that it names'
    """
    from dataclasses import replace

    from apesim.studies.commands.gap.inputs import compile_march, read_inputs
    from apesim.studies.estimation.residuals import EndedEarly
    from apesim.studies.execution.output import make_folder
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.gap.thresholds import TOLERANCE
    from apesim.studies.gap.tolerance import read_tolerance
    from apesim.studies.gap.workflow import explain
    from apesim.studies.measured.lineage import read_parent

    console = common.console

    # What cannot be read or written is refused first; then the march is compiled, so that progress counts
    # the search alone.
    machine, measured = read_inputs(common, folder, without or ())
    threshold = TOLERANCE if tolerance is None else tolerance
    read_tolerance(threshold, measured, ("command line", "--tolerance"))
    make_folder(out, overwrite)
    compile_march(console, machine, measured)

    # The file that the search begins with is read now: the machine that is found may be written over it.
    parent_text = read_parent(machine, common.machine_file, common.settings)

    def explain_and_write(progress: StageReport) -> "tuple[Explanation, dict[str, Any]]":
        explanation = explain(
            machine, measured, without=without or (), tolerance=threshold, jobs=jobs, progress=progress
        )
        explanation = replace(explanation, parent_text=parent_text)
        return explanation, explanation.write(out, overwrite=overwrite, progress=progress)

    # Search and report in a thread of their own, so that Ctrl-C is heard at once.
    try:
        with console.stages("explaining") as progress:
            explanation, data = call_in_thread(explain_and_write, progress).result()
    except EndedEarly as error:
        console.message(f"{error}; nothing is concluded")
        return INCOMPLETE

    # There are readings of sensors only where the fit moved some.
    files = ["report.html", "machine.toml", "verdict.json"]
    files += ["sensors.toml"] * (out / "sensors.toml").exists()
    console.result(data, *_shown(data), f"{out}/{', '.join(files)}: {data['wall_time_s']:.1f} s")

    # The most important warnings stand first; the others are in the report.
    for warning in explanation.warnings[:MAX_WARNINGS]:
        console.message(f"warning: {warning}")
    if (more := len(explanation.warnings) - MAX_WARNINGS) > 0:
        console.message(f"{more} more warning{'s' * (more > 1)} in {out}/report.html")
    return DONE


def _shown(data: dict[str, Any]) -> "Iterator[str | Table]":
    """The verdict on a terminal: the most likely cause, the next test, and the scores of the effects."""
    from apesim.studies.gap.report.calibrated_numbers import format_after, format_before
    from apesim.studies.gap.report.chances import list_chances
    from apesim.studies.gap.report.curve_notes import write_trace
    from apesim.studies.gap.report.html import format_pull, write_as_sentence
    from apesim.studies.gap.report.likely_cause import describe_change, write_hint
    from apesim.studies.gap.report.rounding import format_sigmas
    from apesim.studies.gap.report.run_scatter import write_scatter
    from apesim.studies.gap.search.detection_limits import format_limit
    from apesim.studies.terminal.tables import table_of

    cause, test = data["likely_cause"], data["next_test"]["text"]

    # Where no effect is named, the most likely cause is told; as a hint with the reason, unless a record is to blame.
    if cause:
        yield f"{data['verdict']}: {data['sentence']}"
        yield from (f"Sure, whatever is with it: {_write_row(row)}" for row in data["sure"])
        hint = f" {write_hint(data)}" if cause["why_not"] else ""
        yield f"Most likely cause: {write_as_sentence(cause['text'])} {describe_change(cause)}{hint}"
        if cause["why_not"]:
            yield f"Not named, because: {write_as_sentence(cause['why_not'])}"
        yield f"Do this next: {test}"
    else:
        yield f"{data['verdict']}: {data['sentence']} ({data['reason']})"
        yield f"Next test: {test}"
    # Where experiments are ranked, the trace is one of them, and the best has been told.
    trace = [] if data["next_test"].get("experiments") else write_trace(data)
    yield from (*trace, *list_chances(data), *write_scatter(data))

    # Numbers near what the machine file said are no news.
    moved = [row for row in data["nuisances"] if abs(row["deviations"]) > MIN_SHOWN_PULL]
    if moved:
        cells = [[r["key"], format_before(r), format_after(r), format_pull(r)] for r in moved]
        header = ("calibrated number", "before", "after", "pull [prior sigmas]")
        yield table_of("", header, cells, left=(0,))
    else:
        yield f"No calibrated number was pulled by more than {MIN_SHOWN_PULL:g} sigma of its prior"

    # A score stands beside its detection limit: a low one says little of an effect that these data hardly show.
    if rows := data["scores"][:MAX_SHOWN]:
        limits = data["detection_limits"]
        cells = [[r["effect"], format_sigmas(r["deviations"]), format_limit(limits.get(r["effect"]))] for r in rows]
        yield table_of("", ("effect", "score [sigmas]", "visible from (5 sigmas)"), cells, left=(0,))


def _write_row(row: dict[str, Any]) -> str:
    """A parameter with its value, its interval and what may stand in its place, in words."""
    from apesim.studies.gap.report.effect_rows import format_interval, format_value
    from apesim.studies.gap.report.words import format_key

    others = "".join(f", or {format_key(name)} in its place" for name in row["class"])
    value = f"{format_key(row['key'])} {format_value(row)}".rstrip()
    return f"{value}, {format_interval(row)}{others}"
