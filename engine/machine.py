"""A machine: everything a machine file can say."""

from math import pi, sqrt
from typing import Annotated, NamedTuple

from apesim.air import Air, Ambient
from apesim.engine.angles import DEGREE
from apesim.engine.cylinder import Engine
from apesim.engine.effects import Effects, unserved_effects
from apesim.quantities import Quantity
from apesim.valve.groove import Groove
from apesim.valve.piston import Valve
from apesim.valve.supply import Supply


def window_fault(early, late, angles):
    """What is wrong with a window of the crank.

    Parameters
    ----------
    early, late : str
        Names of its ends.
    angles : pair of float
        [rad]

    Returns
    -------
    pair of str or None
        What is wrong, and what would be right.
    """
    duration = angles[1] - angles[0]
    if 0.0 < duration < 2.0 * pi:
        return None
    first, last = (f"{angle / DEGREE:g} deg" for angle in angles)
    side = f"{abs(duration) / DEGREE:g} deg {'after' if duration > 0.0 else 'before'}" if duration else "no later than"
    return f"{late} at {last} is {side} {early} at {first}", "give more than 0 and less than 360 deg after it"


class Command(NamedTuple):
    """When the solenoids are switched, and what is intended by it; crank angles."""

    energise: Annotated[float, Quantity("deg", -360, 360, "chosen: 5 deg before TDC")] = -5.0 * DEGREE
    release: Annotated[float, Quantity("deg", -360, 720, "chosen")] = 70.0 * DEGREE
    open_target: Annotated[float, Quantity("deg", -360, 360, "chosen: the intended opening")] = -5.0 * DEGREE
    close_target: Annotated[float, Quantity("deg", -360, 720, "chosen: the intended closing")] = 70.0 * DEGREE

    def faults(self):
        """Faults that no single key shows."""
        for early, late in (("energise", "release"), ("open_target", "close_target")):
            if fault := window_fault(early, late, (getattr(self, early), getattr(self, late))):
                yield late, *fault


class Machine(NamedTuple):
    """An air-powered engine and its electro-pneumatic valve; "the paper" is doi 10.1631/jzus.A0820373."""

    air: Air = Air()
    ambient: Ambient = Ambient()
    supply: Supply = Supply()
    valve: Valve = Valve()
    groove: Groove = Groove()
    engine: Engine = Engine()
    command: Command = Command()
    effects: Effects = Effects()

    def faults(self):
        """Faults that no single section shows."""
        if self.groove.lap >= self.valve.stroke:
            stroke = f"{self.valve.stroke * 1e3:g} mm"
            yield "groove.lap", "the groove never opens", f"less than the valve's stroke, {stroke}"
        ports, round_piston = self.groove.ports, sqrt(4.0 * pi * self.valve.piston_area)
        if self.groove.has_ports and ports.number * ports.diameter > round_piston:
            room = f"number times diameter at most {round_piston * 1e3:.4g} mm, the way round the valve's piston"
            yield "groove.ports.number", f"{ports.number:g} ports of {ports.diameter * 1e3:g} mm overlap", room
        for name in unserved_effects(self.effects):
            yield f"effects.{name}", "nothing that is computed knows it", "a file in valve/effects or engine/effects"
