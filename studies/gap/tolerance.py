"""The tolerance: a share of the noise, or how far the model may be off in the unit of a channel."""

from collections.abc import Iterator
from numbers import Real
from typing import Any

from apesim.quantities import Fault, InputError, Quantity, quoted
from apesim.quantities.declarations import InvalidValue
from apesim.studies.gap.thresholds import TOLERANCE
from apesim.studies.measured import Measured
from apesim.studies.measured.sensors import SENSORS

SIZE = Quantity("", 0, 1000, "a call")


def read_tolerance(raw: float | str, measured: Measured, place: tuple[str, str]) -> tuple[float, dict[str, float]]:
    """Read a tolerance: the size of a gap over the noise, and the discrepancies of channels that it states [SI].

    A number is the first, and states no discrepancy; a text with units, several with commas between them, is the second
    of each channel that is measured in that unit. `place` is where it stands, for the InputError that it may raise.

    >>> from apesim.studies.gap.example_bench import read_example
    >>> read_tolerance("0.02 mm", read_example(), ("explain()", "tolerance"))
    (0.15, {'lift': 2e-05})
    >>> read_tolerance(0.1, read_example(), ("explain()", "tolerance"))
    (0.1, {})
    """
    try:
        return SIZE.read(raw if isinstance(raw, str) else float(raw)), {}
    except InvalidValue as fault:
        if not isinstance(raw, str) or _is_number(raw):
            raise InputError([Fault(*place, fault.wrong, fault.right)]) from None
    sizes: dict[str, float] = {}
    for text in raw.split(","):
        found = dict(_read_sizes(text.strip(), measured))
        if not found:
            channels = ", ".join(f"{sensor} [{declared.unit}]" for sensor, declared in _list_sensors(measured).items())
            right = f"write a share of the noise ({TOLERANCE:g}), or a size in the unit of a channel: {channels}"
            raise InputError([Fault(*place, f"{text.strip()!r} is of no channel, or out of its range", right)])
        sizes |= found
    return TOLERANCE, sizes


def find_odd_type(raw: Any) -> list[tuple[str, str, str]]:
    """Faults of a tolerance that is neither a number nor a text: the argument, what is wrong, what would be right."""
    if isinstance(raw, Real | str) and not isinstance(raw, bool):
        return []
    return [("tolerance", f"{quoted(raw)} is no number and no text", f'write {TOLERANCE:g}, or "0.3 N"')]


def _is_number(text: str) -> bool:
    """Whether a text is a number without a unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _list_sensors(measured: Measured) -> dict[str, Quantity]:
    """The sensors that have measured something, with the declarations of their sizes."""
    known = SENSORS[measured.bench].traces | SENSORS[measured.bench].means
    names = dict.fromkeys(sensor for run in measured.runs for sensor in (*run.channels, *run.means))
    return {name: known[name] for name in names}


def _read_sizes(text: str, measured: Measured) -> Iterator[tuple[str, float]]:
    """The sensors whose unit a size has, with the size [SI]."""
    for sensor, declared in _list_sensors(measured).items():
        try:
            yield sensor, declared.read(text)
        except InvalidValue:
            continue
