"""What the valve's effects see, and the terms of the balances that they add to."""

from typing import NamedTuple

from apesim.air import Ambient, Gas
from apesim.valve.piston import Valve
from apesim.valve.solenoid_flow import FLOWS

FORCE, DRY, BREAKAWAY, MASS_A, ENERGY_A, MASS_B, ENERGY_B, HEAT_A, HEAT_B, WALL_EXERGY, BRANCH, FLOW_SHARE = range(12)
"""Force on the piston [N], to closed; dry friction while moving and what holds at rest [N], both without sign; mass
[kg/s] and energy [W] into chamber A and chamber B; what of the energies is heat [W], and the exergy of both heats at
the temperature of the walls that they come from [W]; branches of the laws, see `apesim.effect.note_branch`; from
FLOW_SHARE on, the share by which each flow of `apesim.valve.solenoid_flow` is larger."""
TERMS = FLOW_SHARE + FLOWS


class ValveState(NamedTuple):
    """State of the valve at an instant."""

    gas: Gas
    ambient: Ambient
    valve: Valve
    position: float
    """L [m]."""
    speed: float
    """[m/s]"""
    pressure_a: float
    """[Pa abs]"""
    temperature_a: float
    """[K]"""
    volume_a: float
    """[m3]"""
    pressure_b: float
    temperature_b: float
    volume_b: float
    supply_pressure: float
    supply_temperature: float
    intake_pressure: float
    """Of the air before the groove [Pa abs]."""
    vent_pressure: float
    """Behind the vents of the solenoids [Pa abs]."""
    stretch: float
    """See `apesim.valve.actuator.Actuator`."""
