"""Command `apesim gap effects`."""

from apesim.studies.commands.options import Common


def list_effects(common: Common) -> None:
    """The library of effects: slot, parameters with their ranges, equation, source, where it is seen."""
    from apesim.studies.gap.search import library
    from apesim.studies.terminal.tables import table_of

    effects = library.list_effects(common.load_machine())
    rows = [
        [
            entry.name,
            f"{entry.layer}, {' and '.join(entry.slots)}" + f"\nfrom {entry.file}" * bool(entry.file),
            "\n".join(f"{parameter.name}: {parameter.range}" for parameter in entry.parameters),
            f"{entry.equation}\n{entry.source}",
            f"{entry.seen_in}\nisolated by {entry.isolated_by}\nbench: {', '.join(entry.benches)}",
        ]
        for entry in effects.values()
    ]
    header = ("effect", "slot", "parameters", "equation and source", "seen in")
    table = table_of("", header, rows, left=range(len(header)))
    table.columns[0].no_wrap, table.columns[0].min_width, table.leading = True, max(len(row[0]) for row in rows), 1
    common.console.result(effects.to_dict(), table)
