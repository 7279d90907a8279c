"""The machine file that a verdict leads to, with where it comes from."""

from importlib.metadata import version
from pathlib import Path
from typing import Any

from apesim.archive import sha256
from apesim.engine.machine import Machine
from apesim.engine.outside_machine import outside_effects_of
from apesim.quantities.settings import dumps
from apesim.studies.gap.report.effect_rows import interval_text
from apesim.studies.measured.sensors import FILE


def lineage_of(measured: Any, parent_text: str, machine: Machine) -> dict[str, str]:
    """Digests of what a verdict comes from.

    Parameters
    ----------
    measured : apesim.studies.measured.Measured
    parent_text : str
        The machine file that the search began with.
    machine : Machine
        What it says, with its effects from outside.
    """
    files = {f"effect_{one.name}_sha256": one.sha256 for one in outside_effects_of(machine)}
    return {"parent_machine_sha256": sha256(parent_text), "measured_data_sha256": data_hash(measured)} | files


def extend_machine(explanation: Any, data: dict, folder: Path) -> str:
    """A machine file with what was found: the effects or the table added, or what was wrong; else the parent's machine.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation
    data : dict
        Content of ``verdict.json``, see `apesim.studies.gap.report.verdict_json`, with ``lineage``.
    folder : path
        Folder of the machine file: files of effects from outside are named from there.

    Returns
    -------
    str
        TOML; what it comes from stands in comments.
    """
    found = data["effects"]
    lines = [
        f"apesim {version('apesim')}, gap explain: {data['verdict']}",
        data["sentence"],
        *(f"{row['key']} = {row['text']}, {interval_text(row, 4)}" for row in found),
    ]
    if explanation.tabulated:
        lines.append(f"{data['tabulated']['kind']} added, no name")
        lines.append(f"form that the table suggests: {data['tabulated']['suggestion'] or 'none'}")
    is_added = bool(found or explanation.tabulated)
    lines.append(f"gap over noise on the fitted runs: {_change(data['gap'], is_added)}")
    if data["held_out"]:
        lines.append(f"on runs opened once: {_change(data['held_out'], is_added)}")
    lines += [
        f"chance of noise alone {data['p_value']:.2g}",
        *(f"{name.replace('_', ' ')} {digest}" for name, digest in data["lineage"].items()),
    ]
    machine = explanation.best.machine() if is_added else explanation.calibrated.residuals.machine
    return "".join(f"# {line}\n" for line in lines) + "\n" + dumps(machine, folder)


def _change(gap, is_added):
    """A gap in words, before and after something was added."""
    return f"{gap['before']:.3f} before, {gap['after']:.3f} after" if is_added else f"{gap['before']:.3f}"


def data_hash(measured):
    """Digest of a folder's measured.toml and of the data files that it names, in their order."""
    folder = Path(measured.folder)
    names = [FILE, *(run.data for run in measured.runs if run.data)]
    return sha256("".join(sha256((folder / name).read_text(encoding="utf-8")) for name in names))
