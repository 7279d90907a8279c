"""The conditions that a figure was made at, in words for its foot."""

import textwrap
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
MAX_LINE = 130
"""Characters on a line, for the width of the narrowest figure."""
MAX_VALUE = 40
"""Characters of a value that is written out; a longer one is a table or a curve."""
NO_BREAK = "\N{NO-BREAK SPACE}"
"""What stands for a space where a line must not break."""
SUPPLY = ("supply.pressure", "supply.temperature")
"""Keys of the supply, which every figure names or shows over a range."""
UNNAMED = ("effects", "effects.files")
"""Keys that are not named: a table of none has no keys; of effects from outside the parameters are named."""


def conditions_of(machine: str, shown: Collection[str] = (), more: str = "") -> str:
    """Conditions of a figure, in lines: the supply, and where the machine deviates from the default one.

    `machine` is TOML, as in an archive. `shown` are keys that the figure shows over a range, so that they have no one
    value, and `more` says what else was held constant, e.g. "75 ms pulse".
    """
    supply = tomllib.loads(machine)["supply"]
    values = [supply[key.split(".")[1]] for key in SUPPLY if key not in shown]
    rows = machine_differences(dumps(Machine()), machine)
    named = [row for row in rows if row.name not in (*shown, *SUPPLY, *UNNAMED)]
    others = [f"{row.name} = {_in_short(row.b)}".replace(" ", NO_BREAK) for row in named]
    if len(others) > MAX_KEYS:
        others[MAX_KEYS:] = [f"{len(others) - MAX_KEYS} more keys"]
    parts = [f"supply {', '.join(values)}"] * bool(values) + [more] * bool(more)
    parts.append(f"default machine but for {', '.join(others)}" if others else "default machine")
    return "\n".join(textwrap.wrap("; ".join(parts), MAX_LINE, break_on_hyphens=False)).replace(NO_BREAK, " ")


def supply_keys_of(archive: Archive) -> tuple[str, str]:
    """Name the keys of the supply that a grid varies: pressure of supply or control air, and temperature."""
    keys = dict(zip(PRESSURE_AXES, ("supply.pressure", "supply.control_pressure"), strict=True))
    return keys[find_pressure_axis(archive)], "supply.temperature"


def _in_short(value: Any) -> str:
    """A value of a machine file in words; a table or a curve by its kind only."""
    if value is None:
        return "not given"
    is_short = isinstance(value, str | int | float) and len(str(value)) < MAX_VALUE
    return str(value) if is_short else "a table of its own"
