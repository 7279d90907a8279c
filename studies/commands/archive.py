"""Commands that look into archives."""

from apesim.archive import read
from apesim.archive.comparison import diff, provenance_differences
from apesim.archive.inspection import export, info, verify
from apesim.archive.shards import merge, missing_runs
from studies.commands.tables import table_of
from studies.console import DONE, INCOMPLETE
from studies.output import publish


def show_info(console, path):
    """Axes, variables and provenance of an archive."""
    data = info(path)
    facts = [
        ("format", f"{data['format']} {data['format_version']}"),
        ("created", data["created"]),
        ("size", f"{data['bytes']:,} bytes"),
        ("runs", f"{data['runs']}"),
        ("missing runs", ", ".join(f"{first}-{last}" for first, last in data["missing_runs"]) or "none"),
        ("versions", ", ".join(f"{name} {version}" for name, version in data["versions"].items())),
        ("command", data["provenance"].get("command", "")),
    ]
    lines = [f"{name:13} {value}" for name, value in facts]
    rows = [
        (variable["name"], " x ".join(variable["dims"]), variable["unit"], variable["description"])
        for variable in data["variables"]
    ]
    table = table_of("", ("variable", "axes", "unit", "what it is"), rows, left=(0, 1, 2, 3))
    console.result(data, "\n".join(lines), table)


def show_faults(console, path):
    """Whether an archive is whole; returns the exit code."""
    faults = verify(path)
    console.result({"file": str(path), "faults": faults}, *(faults or [f"{path}: whole"]))
    return INCOMPLETE if faults else DONE


def show_differences(console, path, other, rtol, atol):
    """What differs between two archives; returns the exit code."""
    rows = diff(path, other, rtol, atol)
    provenance = provenance_differences(path, other)
    data = {
        "differences": [row._asdict() for row in rows],
        "provenance": [row._asdict() for row in provenance],
    }
    names = ("what", "name", "run", "where", str(path), str(other), "samples")
    shown = [tuple("" if value is None else str(value) for value in row) for row in rows]
    if rows:
        console.result(data, table_of("", names, shown, left=(0, 1)))
    else:
        console.result(data, f"no differences; {len(provenance)} entries of provenance differ")
    return INCOMPLETE if rows else DONE


def export_archive(console, path, folder):
    """Write an archive as CSV, TOML and JSON files."""
    paths = export(path, folder)
    console.result({"files": [str(p) for p in paths]}, f"{folder}: {len(paths)} files")


def merge_archives(console, paths, out, overwrite):
    """Join the archives of a sweep's shards; returns the exit code."""
    archive = merge([read(path) for path in paths], paths)
    publish(archive, out, overwrite)
    gaps = missing_runs(archive)
    console.result(
        {"archive": str(out), "runs": len(archive.runs), "missing_runs": gaps},
        f"{out}: {len(archive.runs)} runs",
    )
    for first, last in gaps:
        console.message(f"warning: runs {first} to {last} are missing")
    return INCOMPLETE if gaps else DONE
