"""Requests of the page: which machine at which speed, with the number that its answer bears."""

import json
from typing import Any, NamedTuple

from apesim.engine.machine import Machine
from apesim.quantities import Arguments, Fault, InputError, quoted
from apesim.quantities.trees import leaves_of
from apesim.studies.explore.sliders import SPEED_KEY, is_movable
from apesim.studies.run.operating_conditions import SPEED

MAX_VALUES = 100
"""Most values of a request: more than there are sliders is no page of ours."""
MAX_BYTES = 65536
"""Most bytes of a request, twice what all sliders take."""
MAX_LENGTH = 200
"""Most characters of a value."""
PAGE = "page"
"""What stands for a file in what is wrong with a value."""


class Request(NamedTuple):
    """What the page asks for."""

    number: int
    machine: Machine
    speed: float
    """Speed of the crank [rad/s]."""
    speed_text: str
    """Speed as the page gave it."""


class Asked(NamedTuple):
    """A request as it came: its number, and values by key, texts with their units."""

    number: int
    values: dict[str, str]


def parse_request(text: str) -> Asked | None:
    """Take a request of the page apart; None where it is none of ours."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(data, dict):
        return None
    number, values = data.get("number"), data.get("values")
    if not isinstance(number, int) or isinstance(number, bool) or number < 0:
        return None
    if not isinstance(values, dict) or len(values) > MAX_VALUES:
        return None
    return Asked(number, values)


def read_request(base: Machine, asked: Asked) -> Request:
    """Read a request against the machine of the page; raises InputError with every fault."""
    values: dict[str, Any] = dict(asked.values)
    long = [key for key, value in values.items() if not isinstance(value, str) or len(value) > MAX_LENGTH]
    strange = [key for key in values if key != SPEED_KEY and not is_movable(base, key)]
    right = "write a number with its unit"
    faults = [Fault(PAGE, key, f"{quoted(values[key])} is no text of a value", right) for key in long]
    faults += [Fault(PAGE, key, "has no slider", "change it in the machine file") for key in strange]
    if faults:
        raise InputError(faults)

    # Faults of speed and machine are told together.
    speed_text = values.pop(SPEED_KEY, "")
    arguments = Arguments("explore", base.ambient.pressure)
    speed = arguments.quantity("speed", speed_text, SPEED)
    try:
        machine = base.with_(**{key: _number_of(base, key, value) for key, value in values.items()})
    except InputError as error:
        arguments.faults.extend(error.faults)
        machine = base
    arguments.refuse()
    return Request(asked.number, machine, speed, speed_text)


def _number_of(base: Machine, key: str, text: str) -> str | float:
    """Number of a text where the key has no unit, so that it is written bare; else the text."""
    if getattr(leaves_of(type(base))[key].declaration, "unit", ""):
        return text
    try:
        return float(text)
    except ValueError:
        return text


def as_faults(error: InputError) -> list[dict[str, str]]:
    """Say what is wrong in the words of a page: key, what is wrong, and what would be right."""
    return [{"key": fault.key, "wrong": fault.wrong, "right": fault.right} for fault in error.faults]
