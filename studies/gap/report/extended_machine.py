"""The machine file that a verdict leads to, with where it comes from."""

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from apesim.quantities.settings import dumps
from apesim.studies.gap.reasons import Verdict
from apesim.studies.gap.report.calibrated_numbers import (
    apply_numbers,
    find_calibrated_numbers,
    write_readings,
)
from apesim.studies.gap.report.effect_rows import format_interval

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

SENSORS_HEAD = (
    "What the sensors of this laboratory read too much, and how far its angles are off, fitted with machine.toml.",
    "It belongs to the laboratory, not to the machine: no other command needs it, and it is fitted anew to other data.",
    "To explain further data of the same sensors with it, copy its keys into the machine file.",
)
"""First lines of the file of readings."""


def extend_machine(explanation: "Explanation", data: dict[str, Any], folder: Path) -> str:
    """The machine that was judged, as TOML: with the effects or the table added, and with its calibrated numbers.

    The numbers stay as they were where the verdict leaves the gap unexplained: a machine that lacks something puts it
    into them. `data` is the content of ``verdict.json`` with ``lineage``, which comments give, with each number's
    origin, too; files of effects from outside are named from `folder`, that of the machine file.
    """
    effects = data["effects"]
    changed = [*effects, *data["numbers"]] if effects else []

    # The head: the verdict, what it changed, how far the gap fell, and from which files it comes.
    lines = [
        _write_title(data),
        data["sentence"],
        *(f"{row['key']} = {row['text']}, {format_interval(row, 4)}" for row in changed),
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

    # Where a record is wrong, the numbers are those of the verdict on the other files.
    parent = explanation.calibrated.residuals.machine
    told, told_data = explanation.rest or explanation, data.get("rest") or data
    numbers = find_calibrated_numbers(told.best) if is_explained(told_data) else []
    if not is_explained(told_data):
        lines.append(
            "numbers as they were: calibrating does not explain the data, so calibrated numbers are not to be believed"
        )
    else:
        lines.append(
            "calibrated numbers of the machine are marked below; readings of sensors, where any was moved: sensors.toml"
        )

    # A calibrated number is marked where it stands, and says what it was; readings have a file of their own.
    machine = apply_numbers(told.best.machine() if is_added else parent, numbers)
    notes = {number.key: number.describe(parent) for number in numbers if not number.is_reading}
    return "".join(f"# {line}\n" for line in lines) + "\n" + dumps(machine, folder, notes)


def is_explained(data: Mapping[str, Any]) -> bool:
    """Whether a verdict, by ``verdict.json``, leaves no gap unexplained: its machine is the calibrated one."""
    return bool(data["verdict"] == Verdict.NO_GAP or data["effects"] or data.get("tabulated"))


def write_sensors(explanation: "Explanation", data: dict[str, Any]) -> str:
    """The readings of sensors that were calibrated along with the machine, as TOML tables; "" where none was moved.

    `data` is the content of ``verdict.json``.
    """
    told, told_data = explanation.rest or explanation, data.get("rest") or data
    numbers = find_calibrated_numbers(told.best) if is_explained(told_data) else []
    tables = write_readings(explanation.calibrated.residuals.machine, numbers)
    lines = (_write_title(data), *SENSORS_HEAD)
    return "".join(f"# {line}\n" for line in lines) + f"\n{tables}\n" if tables else ""


def _write_title(data: dict[str, Any]) -> str:
    """First line of a file that a verdict leads to."""
    return f"apesim {version('apesim')}, gap explain: {data['verdict']}"


def _format_change(gap: dict[str, float], *, is_added: bool) -> str:
    """A gap in words, before and after something was added."""
    return f"{gap['before']:.3f} before, {gap['after']:.3f} after" if is_added else f"{gap['before']:.3f}"
