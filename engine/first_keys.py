"""First keys: the numbers of a machine that a user fills in first."""

from typing import Any

from apesim.quantities.settings import differences

FIRST_KEYS = (
    "supply.pressure",
    "valve.stroke",
    "valve.moving_mass",
    "valve.piston_area",
    "valve.clearance_volume",
    "valve.spring_rate",
    "valve.solenoid.effective_area",
    "valve.solenoid.dead_time",
    "groove.effective_area",
    "groove.lap",
    "engine.bore",
    "engine.stroke",
    "engine.rod_length",
    "engine.compression_ratio",
    "engine.exhaust.effective_area",
)
"""What one reads from a drawing or a data sheet, and what results depend on most: the sizes of engine, valve and ports.

Left out is what is rarely known and has a usual value (friction, ramps, flanks), and what is set from run to run.
"""


def select_first_keys(machine: Any) -> list[str]:
    """Select the keys of a short machine file: the first ones, and all others that are not as by default.

    >>> from apesim.engine.machine import Machine
    >>> keys = select_first_keys(Machine().with_(engine_intake="cam"))
    >>> len(keys), keys[-1]
    (16, 'engine.intake')
    """
    return list(dict.fromkeys((*FIRST_KEYS, *(key for key, _ in differences(machine)))))
