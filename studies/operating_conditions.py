"""Operating conditions that several studies take: speed, pulse, pressure and temperature of the supply."""

from apesim.engine.machine import Machine
from apesim.quantities import Pressure, Quantity, parse_range
from apesim.studies.console import COMMAND_LINE

TIME = Quantity("ms", 0.01, 60000, "command line", typical="50 ms")
SHORT_TIME = Quantity("ms", 0.01, 100, "command line", typical="1 ms")
VOLUME = Quantity("cm^3", 1, 1e6, "command line", typical="500 cm^3")
SPEED = Quantity("rpm", 1, 30000, "command line", typical="1000 rpm")
PRESSURE = Pressure(0.02, 30, "command line", typical="1 MPa gauge")
RATE = Quantity("Hz", 0.1, 1000, "command line", typical="10 Hz")
DUTY = Quantity("", 0.01, 0.99, "command line", typical="0.5")
DURATION = Quantity("deg", 0.1, 359, "command line", typical="75 deg")
TEMPERATURE = Quantity("K", 150, 600, "command line", typical="287 K")


def parse_supplies(machine: Machine, *, pressure: str, temperature: str) -> tuple[list[float], list[float]]:
    """Pressures [Pa abs] and temperatures [K] of a grid, from the command line."""
    return (
        parse_range(pressure, PRESSURE, machine.ambient.pressure, where="--pressure", file=COMMAND_LINE),
        parse_range(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE),
    )
