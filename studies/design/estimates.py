"""Quick estimates of a machine at its rated speed, without a march: what its valve and its engine need."""

from math import sqrt
from typing import NamedTuple

from apesim.air import gas_of
from apesim.engine.angles import RPM
from apesim.engine.kinematics import crank_of, cylinder_volume
from apesim.engine.machine import Machine
from apesim.flow_function import choked_flow_function
from apesim.valve.groove import area_table, lap_of

ANGLES = 40
"""Angles at which the volume that the piston draws is looked at."""
MIN_GAUGE = 1e3
"""Control pressure above that of the vents with which a valve is at least reckoned [Pa]; chosen: it hardly moves."""
MIN_FILLING = 0.25
"""Least share of a valve's time that fills its chambers; chosen: with less, a larger solenoid hardly helps."""


class Point(NamedTuple):
    """Machine at its rated speed."""

    machine: Machine
    speed: float
    """Rated speed [rad/s]."""

    @property
    def rpm(self) -> float:
        """Rated speed [r/min]."""
        return self.speed / RPM

    @property
    def window(self) -> float:
        """Crank angle from the intended opening to the intended closing [rad]."""
        command = self.machine.command
        return command.close_target - command.open_target

    @property
    def lap(self) -> float:
        """Lift at which the groove begins to open [m]."""
        return lap_of(area_table(self.machine.groove, self.machine.valve.stroke))

    @property
    def full_area(self) -> float:
        """Effective area of the groove at full lift [m2]."""
        return float(area_table(self.machine.groove, self.machine.valve.stroke)[-1, 1])

    @property
    def control_gauge(self) -> float:
        """Control pressure above that of the vents [Pa]."""
        return self.machine.supply.control().pressure - self.machine.ambient.pressure

    @property
    def choked_velocity(self) -> float:
        """Volume flow over effective area of choked flow from the supply [m/s]: the flow function times sqrt(R T)."""
        gas = gas_of(self.machine.air)
        return choked_flow_function(gas.heat_capacity_ratio) * sqrt(gas.gas_constant * self.machine.supply.temperature)

    @property
    def drawn(self) -> float:
        """Largest volume flow that the engine's piston draws before the intended closing [m3/s]."""
        crank, close = crank_of(self.machine.engine), self.machine.command.close_target
        return self.speed * max(cylinder_volume(crank, close * share / ANGLES)[1] for share in range(1, ANGLES + 1))

    @property
    def needed_area(self) -> float:
        """Effective area of a groove that just passes what is drawn, choked [m2]."""
        return self.drawn / self.choked_velocity


def lap_to_lap(point: Point) -> float:
    """Estimate the shortest time for which the lift is above the lap, with a full stroke [s].

    ``2 (L_max - L_lap)(A/(S psi sqrt(R T)) + beta/(p A))``, chosen: choked filling of a chamber through a solenoid of
    the effective area S moves the piston of the area A at one speed, and viscous friction beta at the control pressure
    p takes its time beside it. Measured against `apesim engine limit` for nine machines of 20 to 150 mm bore: the
    limit that follows is 12 % too low to 13 % too high.
    """
    valve = point.machine.valve
    filling = valve.piston_area / (valve.solenoid.effective_area * point.choked_velocity)
    return 2.0 * (valve.stroke - point.lap) * (filling + _friction(point))


def _friction(point: Point) -> float:
    """Estimate the time that viscous friction takes of the valve's piston, over its way [s/m]."""
    valve = point.machine.valve
    return valve.viscous_friction / (max(point.control_gauge, MIN_GAUGE) * valve.piston_area)


def solenoid_for(point: Point, time: float) -> float:
    """Estimate the effective area of a solenoid [m2] that gives a time from lap to lap [s], see `lap_to_lap`.

    Where friction leaves less than `MIN_FILLING` of that time to fill the chambers, the area is that of this share.
    """
    valve = point.machine.valve
    per_metre = time / (2.0 * (valve.stroke - point.lap))
    filling = max(per_metre - _friction(point), MIN_FILLING * per_metre)
    return valve.piston_area / (filling * point.choked_velocity)


def three(number: float) -> str:
    """A number in three digits, without a power of ten."""
    return f"{float(f'{number:.3g}'):g}"
