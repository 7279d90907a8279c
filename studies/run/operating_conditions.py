"""Operating conditions that several studies take: speed, pulse, pressure and temperature of the supply."""

from math import isnan
from typing import Any, NamedTuple

from apesim.engine.cylinder import EPV, INTAKES
from apesim.engine.machine import Machine
from apesim.quantities import Arguments, Pressure, Quantity
from apesim.studies.archives.pressure_axes import PRESSURE_AXES
from apesim.studies.run.default_grids import SUPPLY_SHARES, pressures_around, temperatures_around

TIME = Quantity("ms", 0.01, 60000, "command line", typical="50 ms")
SHORT_TIME = Quantity("ms", 0.01, 100, "command line", typical="1 ms")
VOLUME = Quantity("cm^3", 1, 1e6, "command line", typical="500 cm^3")
JOBS = Quantity("", 1, 100_000, "a call", whole=True)
SPEED = Quantity("rpm", 1, 30000, "command line", typical="1000 rpm")
PRESSURE = Pressure(0.02, 30, "command line", typical="1 MPa gauge")
RATE = Quantity("Hz", 0.1, 1000, "command line", typical="10 Hz")
DUTY = Quantity("", 0.01, 0.99, "command line", typical="0.5")
DURATION = Quantity("deg", 0.1, 359, "command line", typical="75 deg")
ANGLE = Quantity("deg", -360, 720, "command line", typical="70 deg")
TEMPERATURE = Quantity("K", 150, 600, "command line", typical="287 K")


def require_epv(arguments: Arguments, machine: Machine) -> None:
    """Note a fault in `arguments` where the intake is no electro-pneumatic valve, which alone has commands."""
    if machine.engine.intake != EPV:
        name = INTAKES[machine.engine.intake]
        arguments.fault("engine.intake", f"is {name}, which has no commands to correct", 'write "epv"')


def require_one_command(arguments: Arguments, machine: Machine) -> None:
    """Note a fault in `arguments` where cylinders or stages differ, so that one table of commands is not for all."""
    if machine.stage_2.is_on:
        arguments.fault("stage_2.bore", "switches a second stage on, with commands of its own", 'write "0 mm"')
    for index, own in enumerate(machine.cylinder):
        if own:
            wrong, right = "has keys of its own, and one table of commands is for all", "leave [[cylinder]] out"
            arguments.fault(f"cylinder[{index + 1}]", wrong, right)


class Supplies(NamedTuple):
    """Supplies of a grid: pressures times temperatures."""

    pressures: list[float]
    """Pressures of the supply, or of the control air [Pa abs], ascending where they are by default."""
    temperatures: list[float]
    """Temperatures of the supply [K]."""
    base: Machine
    """Machine with the supply that all points share."""
    axis: str = PRESSURE_AXES[0]
    """Pressure that is varied, one of `PRESSURE_AXES`."""

    def machine_at(self, pressure: float, temperature: float) -> Machine:
        """Give the machine the supply of a point: the pressure that is varied [Pa abs] and its temperature [K]."""
        varied = "pressure" if self.axis == PRESSURE_AXES[0] else "control_pressure"
        return with_supply(self.base, **{varied: pressure}, temperature=temperature)


def read_supplies(
    arguments: Arguments, machine: Machine, pressure: Any, control_pressure: Any, temperature: Any
) -> Supplies:
    """Read the supplies of a grid from the arguments of a call; what is wrong is noted in `arguments`.

    Pressures of the supply, or its temperatures, that are None are taken around the machine's own. Those of the control
    air are varied at one pressure of the supply; None: as the machine has it. Returns pressures [Pa abs], temperatures
    [K], and what all points share.

    >>> arguments = Arguments("correct_timing", 101325.0)
    >>> read_supplies(arguments, Machine(), None, "0.5 MPa abs, 0.6 MPa abs", "287 K")[:2]
    ([500000.0, 600000.0], [287.0])
    """
    own = machine.supply.pressure
    default = [own] if control_pressure is not None else pressures_around(machine, own, SUPPLY_SHARES)
    pressures = default if pressure is None else arguments.range("pressure", pressure, PRESSURE)
    default = temperatures_around(machine)
    temperatures = default if temperature is None else arguments.range("temperature", temperature, TEMPERATURE)
    if control_pressure is None:
        return Supplies(pressures, temperatures, machine, PRESSURE_AXES[0])
    controls = arguments.range("control_pressure", control_pressure, PRESSURE)
    if len(pressures) > 1:
        arguments.fault("pressure", "varies beside control_pressure", "give one pressure of the supply")
    base = with_supply(machine, *pressures[:1])
    return Supplies(controls, temperatures, base, PRESSURE_AXES[1])


def with_supply(
    machine: Machine,
    pressure: float | None = None,
    temperature: float | None = None,
    control_pressure: float | None = None,
) -> Machine:
    """Give a machine another supply; what is left out stays as the machine has it, a stated control pressure too.

    Pressures are in Pa abs, that of the control air behind the regulator; the temperature is in K.
    """
    changes = {"pressure": pressure, "temperature": temperature, "control_pressure": control_pressure}
    given: dict[str, Any] = {name: value for name, value in changes.items() if value is not None}
    return machine._replace(supply=machine.supply._replace(**given))


def with_control_air(machine: Machine, pressure: float | None = None, temperature: float | None = None) -> Machine:
    """Give a machine other control air, which is all that the valve's bench has; what is left out stays.

    The pressure [Pa abs] is that of the supply, unless the machine states a control pressure; the temperature [K] is
    the supply's.

    >>> with_control_air(Machine(), 0.9e6).supply.control().pressure
    900000.0
    >>> machine = with_control_air(Machine().with_(supply_control_pressure="0.6 MPa abs"), 0.5e6)
    >>> machine.supply.control().pressure, machine.supply.pressure
    (500000.0, 1101325.0)
    """
    if isnan(machine.supply.control_pressure):
        return with_supply(machine, pressure, temperature)
    return with_supply(machine, temperature=temperature, control_pressure=pressure)
