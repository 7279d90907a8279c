"""State that the valve's effects see, and the terms of the balances that they add to."""

from typing import NamedTuple

from apesim.air import Gas, GasState
from apesim.valve.piston import Valve
from apesim.valve.solenoid_flow import FLOWS
from apesim.valve.supply import ValveSupply

FORCE, DRY, BREAKAWAY, MASS_A, ENERGY_A, MASS_B, ENERGY_B, HEAT_A, HEAT_B, WALL_EXERGY, BRANCH, FLOW_SHARE = range(12)
"""Elements of a balance: force on the piston [N], to closed; dry friction while moving and what holds at rest [N], both
without sign; mass [kg/s] and energy [W] into chamber A and chamber B; what of the energies is heat [W], and the exergy
of both heats at the temperature of the walls that they come from [W]; branches of the laws, see
`apesim.effect.note_branch`; from FLOW_SHARE on, the share by which each flow of `apesim.valve.solenoid_flow` is larger.
"""
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
