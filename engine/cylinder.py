"""The gas in the cylinder: one zone, mass and energy balance over crank angle."""

from typing import Annotated, NamedTuple

from apesim.air import Ambient, Gas
from apesim.engine.breathing import Cam, Exhaust, Receiver
from apesim.engine.friction import Friction
from apesim.kernel import kernel
from apesim.quantities import Choice, Quantity

EPV, CAM, IDEAL_VALVE = 0, 1, 2
INTAKES = ("epv", "cam", "ideal")


class Engine(NamedTuple):
    """One cylinder, two-stroke: one intake event a revolution."""

    bore: Annotated[float, Quantity("mm", 5, 1000, "chosen")] = 85.0e-3
    stroke: Annotated[float, Quantity("mm", 5, 2000, "chosen")] = 88.0e-3
    rod_length: Annotated[float, Quantity("mm", 5, 5000, "chosen")] = 150.0e-3
    pin_offset: Annotated[
        float, Quantity("mm", -100, 100, "chosen; positive to the side to which the crank pin moves after 0 deg")
    ] = 0.0
    compression_ratio: Annotated[float, Quantity("", 1.5, 100, "chosen; (swept + clearance)/clearance")] = 18.0
    intake: Annotated[int, Choice(INTAKES, "chosen; ideal: full groove area between the targets, at once")] = EPV
    cam: Cam = Cam()
    exhaust: Exhaust = Exhaust()
    receiver: Receiver = Receiver()
    friction: Friction = Friction()

    def faults(self):
        """Faults that no single key shows."""
        if self.rod_length <= 0.5 * self.stroke + abs(self.pin_offset):
            least = (0.5 * self.stroke + abs(self.pin_offset)) * 1e3
            yield "rod_length", "the crank cannot turn", f"more than half the stroke plus the pin offset, {least:g} mm"


MASS, ENERGY, GROOVE_MASS, GROOVE_ENERGY, HEAT, WALL_EXERGY, BRANCH, TERMS = range(8)
"""Terms that effects add to: mass [kg/s] and energy [W] into the cylinder, from outside and past the groove; what of
the energy from outside is heat, and its exergy at the temperature of the wall that it comes from [W]; branches of the
laws, see `apesim.effect.note_branch`; how many there are."""


class CylinderState(NamedTuple):
    """State of the cylinder at an instant, as its effects see it."""

    gas: Gas
    ambient: Ambient
    engine: Engine
    speed: float
    """[rad/s]"""
    angle: float
    """[rad]"""
    volume: float
    """[m3]"""
    pressure: float
    """[Pa abs]"""
    temperature: float
    """[K]"""
    intake_pressure: float
    """Before the groove [Pa abs]."""
    intake_temperature: float
    """[K]"""


@kernel
def indicated_power(pressure, ambient_pressure, slope, speed):
    """(p - p_0) dV/dt [W]."""
    return (pressure - ambient_pressure) * slope * speed
