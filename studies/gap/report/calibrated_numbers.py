"""The numbers that were calibrated along with an explanation: those of the machine, and those of the laboratory."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities.declarations import Quantity
from apesim.studies.estimation.model import MAX_PULL, Model
from apesim.studies.estimation.parameters import DECLARED, SENSED, Parameter, corrections, value_at, value_of
from apesim.studies.gap.report.rounding import round_to_error
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import with_value

MIN_PULL = 1e-6
"""Prior standard deviations below which a number stays as it was: the data do not depend on it."""
STATED_SHARE = 100.0
"""Per cent in a share."""


class CalibratedNumber(NamedTuple):
    """A number of the machine or of the laboratory that was fitted within its prior."""

    key: str
    """Key of the machine file."""
    before: float
    """Value that the search began with [SI]."""
    after: float
    """Calibrated value [SI]."""
    pull: float
    """Shift in standard deviations of what is known of the number; positive where it grew."""

    @property
    def is_reading(self) -> bool:
        """Whether it belongs to a sensor of the laboratory, not to the machine."""
        section, _, rest = self.key.partition(".")
        return section == "effects" and rest.partition(".")[0] in SENSED

    def describe(self, machine: Machine) -> str:
        """What was done to the number, in words.

        >>> CalibratedNumber("valve.viscous_friction", 114.0, 117.0, 0.26).describe(Machine())
        'calibrated; before: 114 N s/m; pull +0.26 prior sigmas'
        """
        before = DECLARED[self.key].render(self.before, machine.ambient.pressure)  # type: ignore[attr-defined]
        return f"calibrated; before: {before}; pull {self.pull:+.2f} prior sigmas"


def find_calibrated_numbers(model: Model) -> list[CalibratedNumber]:
    """The numbers that a fit moved within their priors, as entries of a machine file; not those the verdict names.

    Supply pressure and temperature stand where the runs state them: what moves them is an error of the instrument, see
    `corrections`.
    """
    machine, runs = model.residuals.machine, model.residuals.runs
    return [
        CalibratedNumber(key, value_of(machine, key), float(np.clip(value, *DECLARED[key].ends)), _find_pull(p, key, x))
        for p, x in zip(model.residuals.parameters, model.fitted.x, strict=True)
        if p.prior and MIN_PULL < abs(x) <= MAX_PULL
        for key, value in corrections(machine, p, np.clip(x, *p.ends), runs).items()
    ]


def _find_pull(parameter: Parameter, key: str, x: float) -> float:
    """Shift of an entry; an instrument reads the less, the more there is of what the runs state by it."""
    return float(x if key == parameter.key else -x)


def apply_numbers(machine: Machine, numbers: Sequence[CalibratedNumber]) -> Machine:
    """The machine with calibrated numbers; readings of sensors stay as they are."""
    for number in numbers:
        if not number.is_reading:
            machine = with_value(machine, number.key, number.after)
    return machine


def write_readings(machine: Machine, numbers: Sequence[CalibratedNumber]) -> str:
    """The TOML tables of a machine file that the readings of the laboratory's sensors stand for; "" if none was moved.

    >>> print(write_readings(Machine(), [CalibratedNumber("effects.sensor_offset.lift", 0.0, 2e-5, 1.0)]))
    [effects.sensor_offset]
    # calibrated; before: 0 mm; pull +1.00 prior sigmas
    lift = "0.02 mm"
    """
    sections: dict[str, list[str]] = {}
    for number in numbers:
        if number.is_reading:
            section, _, name = number.key.rpartition(".")
            declared: Any = DECLARED[number.key]
            text = declared.render(number.after, machine.ambient.pressure)
            value = repr(float(text)) if isinstance(declared, Quantity) and not declared.unit else f'"{text}"'
            sections.setdefault(section, []).extend([f"# {number.describe(machine)}", f"{name} = {value}"])
    return "\n\n".join("\n".join([f"[{section}]", *lines]) for section, lines in sections.items())


def describe_value(
    machine: Machine, parameter: Parameter, x: float, runs: Sequence[MeasuredRun], deviation: float = 1.0
) -> dict[str, Any]:
    """A nuisance at scaled value `x` as data: before and after, or the shift of what the runs state themselves.

    `deviation` is the standard deviation of `x` that the data leave; 1 is what was known beforehand. ``before`` and
    ``value`` are None where every run states the number; ``shift`` in ``shift_unit`` is how much more it is than the
    runs state, None where none does. ``error`` is the standard deviation of ``value``, or of ``shift`` where there is
    no value.
    """
    keys = corrections(machine, parameter, x, runs)
    unit = parameter.declaration.unit  # type: ignore[attr-defined]
    row: dict[str, Any] = {
        "before": None,
        "value": None,
        "unit": unit,
        "shift": None,
        "shift_unit": None,
        "error": None,
    }
    if parameter.key in keys:
        row["before"] = parameter.shown(value_of(machine, parameter.key))
        row["value"] = parameter.shown(value_at(machine, parameter, x))
        row["error"] = abs(parameter.shown(value_at(machine, parameter, x + deviation)) - row["value"])
    if set(keys) != {parameter.key}:
        shift = parameter.scale * float(x)
        row["shift"] = STATED_SHARE * shift if parameter.relative else parameter.shown(shift)
        row["shift_unit"] = "%" if parameter.relative else unit
        if row["value"] is None:
            error = parameter.scale * deviation
            row["error"] = STATED_SHARE * error if parameter.relative else abs(parameter.shown(error))
    return row


def format_before(row: dict[str, Any]) -> str:
    """The value before calibration as text, from a row of `describe_value`."""
    return "as each run states" if row["before"] is None else _format(row["before"], row["unit"])


def format_after(row: dict[str, Any]) -> str:
    """The calibrated value as text, with the digits that its ``error`` leaves, from a row of `describe_value`.

    Where the runs state the number themselves, the text says how much more it is than that.

    >>> format_after({"before": 114.0, "value": 117.23, "unit": "N s/m", "shift": None, "error": 2.4})
    '117 N s/m'
    >>> format_after({"before": None, "value": None, "unit": "MPa", "shift": 0.81, "shift_unit": "%", "error": 0.2})
    'that +0.8 %'
    """
    if row["value"] is None:
        text = round_to_error(row["shift"], row["error"])
        return f"that {text if text.startswith('-') else '+' + text} {row['shift_unit']}"
    return f"{round_to_error(row['value'], row['error'])} {row['unit']}".strip()


def _format(value: float, unit: str) -> str:
    """A value as the machine file has it, with its unit."""
    return f"{value:.5g} {unit}".strip()
