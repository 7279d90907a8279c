"""The conditions that a figure was made at, in words for its foot."""

import textwrap
import tomllib

from apesim.archive.comparison import machine_differences
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps

MAX_KEYS = 8
"""Keys that are told one by one: two lines of a figure."""
MAX_LINE = 130
"""Characters on a line, for the width of the narrowest figure."""
HELD = "\N{NO-BREAK SPACE}"
SUPPLY = ("supply.pressure", "supply.temperature")
UNTOLD = ("effects", "effects.files")
"""A table of none has no keys; of effects from outside their parameters are told, not the files."""


def conditions_of(machine, shown=(), more=""):
    """Supply, and where the machine deviates from the default one.

    Parameters
    ----------
    machine : str
        TOML, as in an archive.
    shown : sequence of str
        Keys that the figure shows over a range, of no one value.
    more : str
        What else was held constant, e.g. "75 ms pulse".

    Returns
    -------
    str
        One or more lines.
    """
    supply = tomllib.loads(machine)["supply"]
    values = [supply[key.split(".")[1]] for key in SUPPLY if key not in shown]
    rows = machine_differences(dumps(Machine()), machine)
    told = [row for row in rows if row.name not in (*shown, *SUPPLY, *UNTOLD)]
    others = [f"{row.name} = {_short(row.b)}".replace(" ", HELD) for row in told]
    if len(others) > MAX_KEYS:
        others[MAX_KEYS:] = [f"{len(others) - MAX_KEYS} more keys"]
    parts = [f"supply {', '.join(values)}"] * bool(values) + [more] * bool(more)
    parts.append(f"default machine but for {', '.join(others)}" if others else "default machine")
    return "\n".join(textwrap.wrap("; ".join(parts), MAX_LINE, break_on_hyphens=False)).replace(HELD, " ")


def conditions_of_vessel(vessel):
    """What emptied in discharge tests, and into what.

    Parameters
    ----------
    vessel : apesim.studies.discharge.Vessel

    Returns
    -------
    str
    """
    volume, ambient = vessel.volume * 1e6, vessel.ambient_pressure / 1e3
    return f"vessel of {volume:.4g} cm³, {vessel.temperature:g} K at the switch, into {ambient:.4g} kPa abs"


def _short(value):
    """A value of a machine file in words; a table or a curve by its kind only."""
    if value is None:
        return "not given"
    return str(value) if isinstance(value, str | int | float) and len(str(value)) < 40 else "a table of its own"
