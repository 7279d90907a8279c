"""The conditions that a figure was made at, in words for its foot."""

import re
import tomllib
from collections.abc import Collection
from typing import Any

from apesim.archive import Archive
from apesim.archive.comparison import machine_differences
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps
from apesim.studies.archives.pressure_axes import PRESSURE_AXES, find_pressure_axis

MAX_KEYS = 8
"""Keys that are named one by one: two lines of a figure."""
MAX_VALUE = 40
"""Characters of a value that is written out; a longer one is a table or a curve."""
DIGITS = 6
"""Digits of a number: one that was fitted has more than a reader wants."""
CONTROL = "supply.control_pressure"
"""Key of the pressure of the control air, where it is not the supply's."""
SUPPLY = ("supply.pressure", "supply.temperature")
"""Keys of the supply, which every figure names or shows over a range."""
CONTROL_AIR = (*SUPPLY, CONTROL)
"""Keys of the control air of a valve alone."""
VALVE_SECTIONS = ("air", "ambient", "supply", "valve", "effects")
"""Sections of a machine that matter to its valve alone."""
UNNAMED = ("effects", "effects.files")
"""Keys that are not named: a table of none has no keys; of effects from outside the parameters are named."""


def conditions_of(
    machine: str, shown: Collection[str] = (), more: str = "", sections: Collection[str] | None = None
) -> str:
    """Conditions of a figure, in one line: the supply, and where the machine deviates from the default one.

    `machine` is TOML, as in an archive. `shown` are keys that the figure shows over a range, so that they have no one
    value, and `more` says what else was held constant, e.g. "75 ms pulse". `sections` are those of the machine that
    matter to the figure, all if left out.
    """
    supply = tomllib.loads(machine)["supply"]
    values = [supply[key.split(".")[1]] for key in SUPPLY if key not in shown]
    if CONTROL not in shown and supply.get("control_pressure"):
        values.append(f"control air {supply['control_pressure']}")
    rows = machine_differences(dumps(Machine()), machine)
    named = [row for row in rows if row.name not in (*shown, *CONTROL_AIR, *UNNAMED)]
    counted = [row for row in named if sections is None or row.name.split(".")[0] in sections]
    others = [f"{row.name} = {_in_short(row.b)}" for row in counted]
    if len(others) > MAX_KEYS:
        others[MAX_KEYS:] = [f"{len(others) - MAX_KEYS} more keys"]
    default = "default machine" if sections is None else "default valve"
    parts = [f"supply {', '.join(values)}"] * bool(values) + [more] * bool(more)
    parts.append(f"{default} but for {', '.join(others)}" if others else default)
    return "; ".join(parts)


def supply_keys_of(archive: Archive) -> tuple[str, str]:
    """Name the keys of the supply that a grid varies: pressure of supply or control air, and temperature."""
    keys = dict(zip(PRESSURE_AXES, ("supply.pressure", "supply.control_pressure"), strict=True))
    return keys[find_pressure_axis(archive)], "supply.temperature"


def _in_short(value: Any) -> str:
    """A value of a machine file in words; a table or a curve by its kind only."""
    if value is None:
        return "not given"
    if not isinstance(value, str | int | float) or len(str(value)) >= MAX_VALUE:
        return "a table of its own"
    return re.sub(r"(?<![\w.])\d+\.\d+", lambda number: f"{float(number[0]):.{DIGITS}g}", str(value))
