"""Commands that look into archives.

Each takes a machine, like every command: it then says in which keys the archives were made with another one, and ends
with 3 if there are any; nothing is written then.
"""

from apesim.archive import read, read_about, read_digest
from apesim.archive.comparison import diff, machine_differences, provenance_differences, summarise
from apesim.archive.inspection import export, info, verify
from apesim.archive.migration import MIGRATED
from apesim.archive.shards import gaps_in_words, merge, missing_runs, runs_planned
from apesim.studies.commands.archived import digest_line
from apesim.studies.commands.tables import table_of
from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.output import publish
from apesim.terminal import visible

MAX_SHOWN = 20
"""Differences that are shown one by one: a screen of them."""


def other_machine(machine_file, settings, paths):
    """Keys in which archives were made with another machine than the one of the command line.

    Parameters
    ----------
    machine_file : path or None
    settings : list of str or None
        With neither, no machine is asked for.
    paths : sequence of path

    Returns
    -------
    list of dict
        ``file``, ``key``, and the texts ``archive`` and ``given``.
    """
    if not machine_file and not settings:
        return []
    from apesim.quantities.settings import dumps
    from apesim.studies.commands.machine import load_machine

    given = dumps(load_machine(machine_file, settings))
    return [
        {"file": str(path), "key": row.name, "archive": row.a, "given": row.b}
        for path in paths
        for row in machine_differences(read_about(path)[0], given)
    ]


def _lines(others):
    return [f"{row['file']}: machine: {row['key']} is {row['archive']!r}, given {row['given']!r}" for row in others]


def _refused(console, others):
    console.result({"machine_differences": others}, *_lines(others))
    return INCOMPLETE


def show_info(console, machine_file, settings, path):
    """Axes, variables and provenance of an archive; returns the exit code."""
    others = other_machine(machine_file, settings, [path])
    data = info(path) | {"machine_differences": others}
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
    ]
    lines = [f"{name:13} {visible(value)}" for name, value in facts]
    rows = [
        (variable["name"], " x ".join(variable["dims"]), variable["unit"], variable["description"])
        for variable in data["variables"]
    ]
    table = table_of("", ("variable", "axes", "unit", "what it is"), rows, left=(0, 1, 2, 3))
    console.result(data, "\n".join(lines), table, *_lines(others))
    is_whole = data["runs_planned"] is None or not data["missing_runs"]
    return DONE if is_whole and not others else INCOMPLETE


def show_faults(console, machine_file, settings, path):
    """Whether an archive is whole; returns the exit code."""
    faults = verify(path)
    others = [] if faults else other_machine(machine_file, settings, [path])
    digest = None if faults else read_digest(path)
    data = {"file": str(path), "content_sha256": digest, "faults": faults, "machine_differences": others}
    console.result(data, *(faults or _lines(others) or [f"{path}: whole; {digest_line(digest)}"]))
    return INCOMPLETE if faults or others else DONE


def show_differences(console, machine_file, settings, path, other, rtol, atol, show_all):
    """What differs between two archives: a summary, then single differences; returns the exit code."""
    others = other_machine(machine_file, settings, [path, other])
    rows = diff(path, other, rtol, atol)
    provenance, summary = provenance_differences(path, other), summarise(rows)
    data = {
        "summary": [row._asdict() for row in summary],
        "differences": [row._asdict() for row in rows],
        "provenance": [row._asdict() for row in provenance],
        "machine_differences": others,
    }
    told = [f"no differences; {len(provenance)} entries of provenance differ"]
    if rows:
        units = {v["name"]: v["unit"] for file in (other, path) for v in info(file)["variables"]}
        rows = sorted(rows, key=lambda row: row.kind == "run")  # which run is missing comes last
        told = [_summary_table(summary, units), _difference_table(rows if show_all else rows[:MAX_SHOWN], path, other)]
        if len(rows) > MAX_SHOWN and not show_all:
            told.append(f"{MAX_SHOWN} of {len(rows)} differences; --all shows every one, --json holds them")
    console.result(data, *told, *_lines(others))
    return INCOMPLETE if rows or others else DONE


def _summary_table(summary, units):
    """Differences by name, with units where they have one."""
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


def _difference_table(rows, path, other):
    """Single differences, one a row."""
    names = ("what", "name", "run", "where", str(path), str(other), "samples")
    shown = [tuple("" if value is None else visible(str(value)) for value in row) for row in rows]
    return table_of("Differences", names, shown, left=(0, 1, 3))


def export_archive(console, machine_file, settings, path, folder):
    """Write an archive as CSV, TOML and JSON files; returns the exit code."""
    others = other_machine(machine_file, settings, [path])
    if others:
        return _refused(console, others)
    paths = export(path, folder)
    console.result({"files": [str(p) for p in paths]}, f"{folder}: {len(paths)} files")
    return DONE


def merge_archives(console, machine_file, settings, paths, out, overwrite):
    """Join the archives of a sweep's shards; returns the exit code."""
    others = other_machine(machine_file, settings, paths)
    if others:
        return _refused(console, others)
    archive = merge([read(path) for path in paths], paths)
    publish(archive, out, overwrite)
    gaps, digest = missing_runs(archive, runs_planned(archive)), read_digest(out)
    console.result(
        {"archive": str(out), "content_sha256": digest, "runs": len(archive.runs), "missing_runs": gaps},
        f"{out}: {len(archive.runs)} runs",
        digest_line(digest),
    )
    for first, last in gaps:
        console.message(f"warning: runs {first} to {last} are missing")
    return INCOMPLETE if gaps else DONE
