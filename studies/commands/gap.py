"""Commands of the missing effect."""

from apesim.studies.commands.tables import table_of
from apesim.studies.gap.library import library


def effects_command(console, machine_file, settings):
    """List the library of effects.

    Parameters
    ----------
    console : apesim.studies.console.Console
    machine_file, settings
        Not looked at: the library is the same for every machine.
    """
    entries = library()
    data = [
        entry._asdict() | {"parameters": [parameter._asdict() for parameter in entry.parameters]} for entry in entries
    ]
    rows = [
        [
            entry.name,
            f"{entry.layer}, {' and '.join(entry.slots)}",
            "\n".join(f"{parameter.name}: {parameter.range}" for parameter in entry.parameters),
            f"{entry.equation}\n{entry.source}",
            f"{entry.seen_in}\nisolated by {entry.isolated_by}",
        ]
        for entry in entries
    ]
    header = ("effect", "slot", "parameters", "equation and source", "seen in")
    table = table_of("", header, rows, left=range(len(header)))
    table.columns[0].no_wrap, table.columns[0].min_width, table.leading = True, max(len(row[0]) for row in rows), 1
    console.result({"effects": data}, table)
