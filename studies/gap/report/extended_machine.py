"""The machine file that a verdict leads to, with where it comes from."""

from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from apesim.archive import sha256
from apesim.engine.machine import Machine
from apesim.engine.outside_machine import outside_effects_of
from apesim.quantities.settings import dumps
from apesim.studies.gap.report.effect_rows import format_interval
from apesim.studies.measured import Measured
from apesim.studies.measured.sensors import FILE

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation


def find_lineage(measured: Measured, parent_text: str, machine: Machine) -> dict[str, str]:
    """Digests of what a verdict comes from.

    Parameters
    ----------
    measured : apesim.studies.measured.Measured
    parent_text : str
        The machine file that the search began with.
    machine : Machine
        Machine that the file describes, with its effects from outside.

    Returns
    -------
    dict of str
        SHA-256 by ``parent_machine_sha256``, ``measured_data_sha256`` and one key for each effect from outside.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from apesim.studies.gap.example_bench import write_example
    >>> from apesim.studies.measured import read_measured
    >>> with TemporaryDirectory() as folder:
    ...     write_example(Path(folder))
    ...     lineage = find_lineage(read_measured(folder), dumps(Machine()), Machine())
    >>> {name: len(digest) for name, digest in lineage.items()}
    {'parent_machine_sha256': 64, 'measured_data_sha256': 64}
    """
    files = {f"effect_{outside.name}_sha256": outside.sha256 for outside in outside_effects_of(machine)}
    return {"parent_machine_sha256": sha256(parent_text), "measured_data_sha256": _hash_data(measured)} | files


def extend_machine(explanation: "Explanation", data: dict[str, Any], folder: Path) -> str:
    """A machine file with the effects or the table added, or the wrong number corrected; else the parent's machine.

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

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> text = extend_machine(explain_example(), explain_example().to_dict(), Path("."))
    >>> [line for line in text.splitlines() if line.startswith("[effects.")]
    ['[effects.side_force]']
    """
    effects = data["effects"]
    lines = [
        f"apesim {version('apesim')}, gap explain: {data['verdict']}",
        data["sentence"],
        *(f"{row['key']} = {row['text']}, {format_interval(row, 4)}" for row in effects),
    ]
    if explanation.tabulated:
        lines.append(f"{data['tabulated']['kind']} added, no name")
        lines.append(f"form that the table suggests: {data['tabulated']['suggestion'] or 'none'}")
    is_added = bool(effects or explanation.tabulated)
    lines.append(f"gap over noise on the fitted runs: {_format_change(data['gap'], is_added=is_added)}")
    if data["held_out"]:
        lines.append(f"on runs opened once: {_format_change(data['held_out'], is_added=is_added)}")
    lines += [
        f"chance of noise alone {data['p_value']:.2g}",
        *(f"{name.replace('_', ' ')} {digest}" for name, digest in data["lineage"].items()),
    ]
    machine = explanation.best.machine() if is_added else explanation.calibrated.residuals.machine
    return "".join(f"# {line}\n" for line in lines) + "\n" + dumps(machine, folder)


def _format_change(gap: dict[str, float], *, is_added: bool) -> str:
    """A gap in words, before and after something was added."""
    return f"{gap['before']:.3f} before, {gap['after']:.3f} after" if is_added else f"{gap['before']:.3f}"


def _hash_data(measured: Measured) -> str:
    """Digest of a folder's measured.toml and of the data files that it names, in their order."""
    folder = Path(measured.folder)
    names = [FILE, *(run.data for run in measured.runs if run.data)]
    return sha256("".join(sha256((folder / name).read_text(encoding="utf-8")) for name in names))
