"""Sensors: what can be measured on a bench, and what the file says of a run."""

from math import pi
from typing import Any, NamedTuple

from apesim.quantities import Choice, Pressure, Quantity
from apesim.studies.measured.dialect import ANGLE, TIME
from apesim.studies.measured.runs import CYLINDER, ENGINE, ROLES, VALVE

FILE = "measured.toml"
"""Name of the file that describes a folder."""
LIFT = Quantity("mm", 1e-9, 100, FILE, typical="0.03 mm")
SPEED = Quantity("m/s", 1e-9, 1000, FILE, typical="0.02 m/s")
PRESSURE = Quantity("kPa", 1e-9, 30000, FILE, typical="2 kPa")
TEMPERATURE = Quantity("K", 1e-9, 100, FILE, typical="1 K")
SUPPLY_KEYS = {"supply": Pressure(0.02, 30, FILE, show="gauge"), "temperature": Quantity("K", 150, 600, FILE)}
ROLE_KEY = {"role": Choice(ROLES, FILE)}
EXAMPLES = {
    "data": "p040.csv",
    "supply": 0.40e6 + 101325.0,
    "control_supply": 0.60e6 + 101325.0,
    "temperature": 287.0,
    "role": 0,
    "pulse": 50e-3,
    "speed": 100.0 * pi / 3.0,
    "energise": -pi / 36.0,
    "release": 7.0 * pi / 18.0,
    "torque": 31.2,
    "air_flow": 12.3e-3,
}
"""Right values of the keys of a run, SI, to show where one is wrong."""
NO_COLUMNS: dict[str, str] = {}
"""Columns that the model of the valve or the engine is given."""


class Sensors(NamedTuple):
    """What a bench can measure."""

    axis: str
    """Column over which the traces stand."""
    axis_unit: str
    """Unit of that column."""
    traces: dict[str, Quantity]
    """Declarations of the noise of the sensors that give traces, by name."""
    means: dict[str, Quantity]
    """Declarations of the noise of the sensors that give means, by name."""
    computed: tuple[str, ...]
    """Columns that `apesim` writes, too, but that no sensor measures: they are let pass."""
    keys: dict[str, Any]
    """Declarations of the keys of a run."""
    due: tuple[str, ...]
    """Keys of a run that must be there."""
    given: dict[str, str] = NO_COLUMNS
    """Units of the columns that the model is given, by name; they must be there, and nothing is judged by them."""

    @property
    def columns(self) -> dict[str, str]:
        """Units of the columns that are read, by name; that of a pressure ends in " abs"."""
        pressures = {name: " abs" for name in self.traces if "pressure" in name}
        units = {name: sensor.unit + pressures.get(name, "") for name, sensor in self.traces.items()}
        return {self.axis: self.axis_unit} | self.given | units


SENSORS = {
    VALVE: Sensors(
        TIME,
        "ms",
        {
            "lift": LIFT,
            "velocity": SPEED,
            "pressure_a": PRESSURE,
            "pressure_b": PRESSURE,
            "temperature_a": TEMPERATURE,
            "temperature_b": TEMPERATURE,
        },
        {},
        (),
        SUPPLY_KEYS | {"pulse": Quantity("ms", 0.01, 60000, FILE)} | ROLE_KEY,
        ("data", "supply", "pulse"),
    ),
    ENGINE: Sensors(
        ANGLE,
        "deg",
        {
            "cylinder_pressure": PRESSURE,
            "cylinder_temperature": TEMPERATURE,
            "lift": LIFT,
            "velocity": SPEED,
            "pressure_a": PRESSURE,
            "pressure_b": PRESSURE,
            "receiver_pressure": PRESSURE,
        },
        {
            "torque": Quantity("N m", 1e-9, 10000, FILE, typical="0.3 N m"),
            "air_flow": Quantity("g/s", 1e-9, 10000, FILE, typical="0.1 g/s"),
        },
        ("groove_flow", "torque", "exhaust_flow", "cylinder_volume"),
        SUPPLY_KEYS
        | {
            "speed": Quantity("rpm", 1, 30000, FILE),
            "energise": Quantity("deg", -360, 360, FILE),
            "release": Quantity("deg", -360, 720, FILE),
            "torque": Quantity("N m", -10000, 10000, FILE),
            "air_flow": Quantity("g/s", -10000, 10000, FILE),
            "control_supply": Pressure(0.02, 30, FILE, show="gauge"),
        }
        | ROLE_KEY,
        ("supply", "speed", "energise", "release"),
    ),
    CYLINDER: Sensors(
        TIME,
        "ms",
        {"force": Quantity("N", 1e-9, 1e6, FILE, typical="0.2 N")},
        {},
        ("velocity",),
        SUPPLY_KEYS | ROLE_KEY,
        ("data", "supply"),
        given={"stroke": "mm", "pressure": "kPa abs"},
    ),
}
"""Sensors of each bench."""
