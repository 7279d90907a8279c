"""Command `apesim archive info`."""

from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.options import ArchivePath, Common


def show_info(common: Common, path: ArchivePath) -> int:
    """What an archive holds and where it comes from."""
    from apesim.archive.inspection import info
    from apesim.archive.migration import MIGRATED
    from apesim.archive.shards import gaps_in_words
    from apesim.studies.commands.archive.machine_differences import difference_lines, differences_from_given
    from apesim.studies.output import digest_line
    from apesim.studies.tables import table_of
    from apesim.terminal import visible

    differences = differences_from_given(common, [path])
    data = info(path) | {"machine_differences": differences}
    planned = "" if data["runs_planned"] is None else f" of {data['runs_planned']} planned"
    if "shard" in data["provenance"] and data["provenance"]["shard"] != "1/1":
        planned += f", share {data['provenance']['shard']}"
    facts = [
        ("format", f"{data['format']} {data['format_version']}"),
        ("content", digest_line(data["content_sha256"])),
        ("created", data["created"]),
        ("size", f"{data['bytes']:,} bytes"),
        ("runs", f"{data['runs']}{planned}"),
        ("missing runs", gaps_in_words(data["missing_runs"]) or "none"),
        ("versions", ", ".join(f"{name} {version}" for name, version in data["versions"].items())),
        ("command", data["provenance"].get("command", "")),
        *[(name, value) for name, value in data["provenance"].items() if name == MIGRATED],
        *[
            ("needed", f"effect {one.get('effect')} of {one.get('file')}, sha256 {one.get('sha256')}")
            for one in data["outside_effects"]
        ],
    ]
    lines = [f"{name:13} {visible(value)}" for name, value in facts]
    rows = [
        (variable["name"], " x ".join(variable["dims"]), variable["unit"], variable["description"])
        for variable in data["variables"]
    ]
    table = table_of("", ("variable", "axes", "unit", "what it is"), rows, left=(0, 1, 2, 3))
    common.console.result(data, "\n".join(lines), table, *difference_lines(differences))
    is_whole = data["runs_planned"] is None or not data["missing_runs"]
    return DONE if is_whole and not differences else INCOMPLETE
