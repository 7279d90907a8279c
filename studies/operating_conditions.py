"""Operating conditions that several studies take: speed, pulse, pressure and temperature of the supply."""

from apesim.engine.cylinder import EPV, INTAKES
from apesim.engine.machine import Machine
from apesim.quantities import Arguments, Pressure, Quantity

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
    """Note a fault where the intake is no electro-pneumatic valve, which alone has commands.

    Parameters
    ----------
    arguments : Arguments
        Arguments of the call, in which the fault is noted.
    machine : Machine
        Machine whose intake is checked.

    Examples
    --------
    >>> arguments = Arguments("correct_timing", 101325.0)
    >>> require_epv(arguments, Machine().with_(engine_intake="cam"))
    >>> [fault.wrong for fault in arguments.faults]
    ['is cam, which has no commands to correct']
    """
    if machine.engine.intake != EPV:
        name = INTAKES[machine.engine.intake]
        arguments.fault("engine.intake", f"is {name}, which has no commands to correct", 'write "epv"')


def with_supply(machine: Machine, pressure: float, temperature: float) -> Machine:
    """Give a machine other control air.

    Parameters
    ----------
    machine : Machine
        Machine whose supply is replaced; a control pressure of its own falls back to the supply's.
    pressure : float
        Pressure of the supply [Pa abs].
    temperature : float
        Temperature of the supply [K].

    Returns
    -------
    Machine
        Machine with this supply.

    Examples
    --------
    >>> machine = with_supply(Machine(), 0.9e6, 300.0)
    >>> machine.supply.pressure, machine.supply.temperature
    (900000.0, 300.0)
    """
    supply = machine.supply._replace(pressure=pressure, temperature=temperature, control_pressure=float("nan"))
    return machine._replace(supply=supply)
