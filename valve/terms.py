"""State that the valve's effects see, and the terms of the balances that they add to."""

from typing import NamedTuple

from apesim.air import Gas, GasState
from apesim.valve.piston import Valve
from apesim.valve.solenoid_flow import FLOWS
from apesim.valve.supply import ValveSupply

FORCE = 0
"""Element of a balance: force on the piston, to closed [N]."""
DRY = 1
"""Element of a balance: dry friction of the moving piston, without sign [N]."""
BREAKAWAY = 2
"""Element of a balance: dry friction that holds the piston at rest, without sign [N]."""
MASS_A = 3
"""Element of a balance: mass into chamber A [kg/s]."""
ENERGY_A = 4
"""Element of a balance: energy into chamber A [W]."""
MASS_B = 5
"""Element of a balance: mass into chamber B [kg/s]."""
ENERGY_B = 6
"""Element of a balance: energy into chamber B [W]."""
HEAT_A = 7
"""Element of a balance: the part of ENERGY_A that is heat [W]."""
HEAT_B = 8
"""Element of a balance: the part of ENERGY_B that is heat [W]."""
WALL_EXERGY = 9
"""Element of a balance: exergy of both heats at the temperature of the walls that they come from [W]."""
BRANCH = 10
"""Element of a balance: branches of the laws, see `apesim.effect.note_branch`."""
FLOW_SHARE = 11
"""Element of a balance from which on stands the share by which each flow of `apesim.valve.solenoid_flow` is larger."""
TERM_NAMES = (
    *("FORCE", "DRY", "BREAKAWAY", "MASS_A", "ENERGY_A", "MASS_B", "ENERGY_B", "HEAT_A", "HEAT_B", "WALL_EXERGY"),
    *("BRANCH", "FLOW_SHARE + SUPPLY_A", "FLOW_SHARE + VENT_A", "FLOW_SHARE + SUPPLY_B", "FLOW_SHARE + VENT_B"),
)
"""Names of the elements of a balance, for messages."""
TERMS = FLOW_SHARE + FLOWS
"""Length of a balance."""


class ValveState(NamedTuple):
    """State of the valve at an instant."""

    gas: Gas
    """Working gas."""
    ambient: GasState
    """State of the surroundings."""
    valve: Valve
    """Dimensions of the valve."""
    position: float
    """Position L of the piston, 0 at fully open [m]."""
    speed: float
    """Speed dL/dt, positive to closed [m/s]."""
    chamber_a: GasState
    """State of the air in chamber A."""
    volume_a: float
    """Volume of chamber A [m3]."""
    chamber_b: GasState
    """State of the air in chamber B."""
    volume_b: float
    """Volume of chamber B [m3]."""
    supply: ValveSupply
    """Control air before the solenoids, and pressure before the groove."""
    vent_pressure: float
    """Pressure behind the vents of the solenoids [Pa abs]."""
    stretch: float
    """Factor on the pressure difference of the solenoids' flows, see `apesim.valve.actuator.Actuator`."""
