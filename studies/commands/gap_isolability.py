"""The command that tells what sensors and operating points could show at all."""

from apesim.studies.commands.gap_explain import first_march, read_inputs
from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.gap.design.isolability import find_isolability, limit_text
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
    machine, measured = read_inputs(common, folder, without)
    first_march(console, machine, measured)
    try:
        with console.stages("isolability") as progress:
            found = call_in_thread(find_isolability, machine, measured, without=without, progress=progress).result()
    except EndedEarly as error:
        console.message(f"{error}; nothing is concluded")
        return INCOMPLETE
    console.result(found.to_dict(), *_shown(found))
    for warning in found.warnings:
        console.message(f"warning: {warning}")
    return DONE


def _shown(found):
    """A table, the effects that are seen first, and how many they are."""
    rows = found.effects
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
    yield repr(found).removeprefix("Isolability: ")


def _is_told(row):
    return row["limit"] is not None and not row["class"]
