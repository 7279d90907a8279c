"""Grids that studies cover where none are given, from the command line as from Python."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:  # what shows the help of a command loads no model
    from apesim.engine.machine import Machine

SUPPLY_SHARES = 0.6, 1.0, 1.4
LANDING_SHARES = 0.4, 1.0, 1.6
"""Pressures of a default grid, as shares of the machine's own gauge pressure; the default machine's is 1.0 MPa."""
COLD, WARM = 250.0, 322.0
"""Temperatures of a default grid beside the machine's own [K]: the ends of that of doi 10.1631/jzus.A0820373."""
SPEEDS = "300:2400:100 rpm"
TIMING_SPEEDS = "300:2400:150 rpm"
"""Fewer than in a sweep: each is solved at every pressure and temperature."""
OPTIMUM_SPEEDS = "600:1800:300 rpm"
"""Few, as each takes some hundred operating points."""
DURATIONS = "60 deg, 75 deg, 120 deg"
PULSE = "50 ms"


def pressures_around(machine: "Machine", own: float, shares: tuple[float, ...]) -> list[float]:
    """List pressures [Pa abs], ascending, at shares of the gauge pressure of one of a machine's own [Pa abs].

    It is the machine's own alone where that does not stand above the ambient pressure.

    >>> import apesim
    >>> machine = apesim.Machine()
    >>> pressures_around(machine, machine.supply.pressure, SUPPLY_SHARES)
    [701325.0, 1101325.0, 1501325.0]
    """
    gauge = own - machine.ambient.pressure
    if gauge <= 0.0:
        return [own]
    return [own if share == 1.0 else float(f"{own + (share - 1.0) * gauge:.12g}") for share in shares]


def temperatures_around(machine: "Machine") -> list[float]:
    """List a cold, the machine's own and a warm temperature of the supply [K], ascending."""
    return sorted({COLD, machine.supply.temperature, WARM})
