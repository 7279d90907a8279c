"""The command that tells what sensors and operating points could show at all."""

import time

from apesim.studies.commands.gap_explain import first_march, given, limit_text
from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.gap.design.isolability import isolability
from apesim.studies.gap.report.verdict_json import noise_told
from apesim.studies.tables import table_of

HEADER = ("effect", "seen from (5 deviations)", "kept", "hardly told from", "what would help")


def isolability_command(common, *, folder, without):
    """What the sensors and runs of a folder could show; see `apesim gap isolability --help`.

    Parameters
    ----------
    common : apesim.studies.options.Common
    folder : path
        Of the measured data.
    without : list of str
        Effects that are not to be considered.

    Returns
    -------
    int
        Exit code.
    """
    console = common.console
    machine, measured, warnings = given(common, folder, without)
    first_march(console, machine, measured)
    start = time.perf_counter()
    try:
        with console.stages("isolability") as report:
            rows, noise, more = call_in_thread(isolability, machine, measured, without, report).result()
    except EndedEarly as error:
        console.message(f"{error}; nothing is concluded")
        return INCOMPLETE
    warnings += more
    data = {"effects": rows, "noise": noise_told(noise), "warnings": warnings}
    console.result(data | {"wall_time_s": time.perf_counter() - start}, *_shown(rows))
    for warning in warnings:
        console.message(f"warning: {warning}")
    return DONE


def _shown(rows):
    """A table, the effects that are seen first, and how many they are."""
    ordered = sorted(rows, key=lambda row: row["limit"] is None)
    table = table_of(
        "",
        HEADER,
        [
            (
                row["effect"],
                limit_text(row),
                f"{100.0 * row['kept']:.0f} %",
                ", ".join(row["class"]) or "-",
                row["helped_by"]["text"] if row["helped_by"] else ("-" if _is_told(row) else "nothing of the list"),
            )
            for row in ordered
        ],
        left=(0, 3, 4),
    )
    table.columns[0].no_wrap, table.columns[0].min_width = True, max(len(row["effect"]) for row in rows)
    yield table
    seen = [row for row in rows if row["limit"] is not None]
    alone = [row for row in seen if not row["class"]]
    yield f"{len(seen)} of {len(rows)} effects could be seen, {len(alone)} of them told from all others"


def _is_told(row):
    return row["limit"] is not None and not row["class"]
