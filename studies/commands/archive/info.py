"""Command `apesim archive info`."""

from apesim.studies.commands.options import ArchivePath, Common
from apesim.studies.terminal.console import DONE, INCOMPLETE


def show_info(common: Common, path: ArchivePath) -> int:
    """What an archive holds and where it comes from.

    Examples
    --------
    >>> import tempfile
    >>> from typer.testing import CliRunner
    >>> from apesim.archive import Archive, write
    >>> from apesim.archive.columns import column, run_axis
    >>> from apesim.studies.commands.cli import app
    >>> variables = {"run": run_axis(1), "torque": column([20.0], "N m", "brake torque")}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = write(Archive("bore = 1", {}, variables), f"{folder}/a.h5")
    ...     output = CliRunner().invoke(app, ["archive", "info", f"{folder}/a.h5"]).stdout
    >>> next(line for line in output.splitlines() if line.startswith("runs"))
    'runs          1'
    """
    from apesim.archive.completeness import gaps_in_words
    from apesim.archive.migration import MIGRATED
    from apesim.studies.archives.description import describe_archive
    from apesim.studies.commands.archive.machine_differences import difference_lines, given_machine
    from apesim.studies.execution.output import digest_line
    from apesim.studies.terminal.tables import table_of
    from apesim.terminal import visible

    described = describe_archive(path, machine=given_machine(common))
    data, differences = described.to_dict(), described.machine_differences

    # The number of planned runs is that of the whole sweep, so a share is named: it holds fewer, and may lack none.
    planned = "" if data["runs_planned"] is None else f" of {data['runs_planned']} planned"
    if "shard" in data["provenance"] and data["provenance"]["shard"] != "1/1":
        planned += f", share {data['provenance']['shard']}"
    facts = [
        *[("kind", data["kind"])] * bool(data["kind"]),
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
            ("needed", f"effect {effect.get('effect')} of {effect.get('file')}, sha256 {effect.get('sha256')}")
            for effect in data["outside_effects"]
        ],
    ]

    # Facts are texts from a file, which may hold characters of control: these are shown as escapes.
    lines = [f"{name:13} {visible(value)}" for name, value in facts]
    rows = [
        (variable["name"], " x ".join(variable["dims"]), variable["unit"], variable["description"])
        for variable in data["variables"]
    ]
    table = table_of("", ("variable", "axes", "unit", "what it is"), rows, left=(0, 1, 2, 3))

    # A run that is missing or a key that differs is a finding, not an error: the exit code tells it to scripts.
    common.console.result(data, "\n".join(lines), table, *difference_lines(differences))
    return DONE if described.is_whole and not differences else INCOMPLETE
