"""Quantities that several commands take on the command line."""

from apesim.quantities import Pressure, Quantity, parse_range
from apesim.studies.console import COMMAND_LINE

TIME = Quantity("ms", 0.01, 60000, "command line", typical="50 ms")
SPEED = Quantity("rpm", 1, 30000, "command line", typical="1000 rpm")
PRESSURE = Pressure(0.02, 30, "command line", typical="1 MPa gauge")
TEMPERATURE = Quantity("K", 150, 600, "command line", typical="287 K")


def supplies_of(machine, pressure, temperature):
    """Pressures [Pa abs] and temperatures [K] of a grid."""
    return (
        parse_range(pressure, PRESSURE, machine.ambient.pressure, where="--pressure", file=COMMAND_LINE),
        parse_range(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE),
    )
