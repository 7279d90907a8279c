"""A machine: everything a machine file can say."""

from math import pi, sqrt
from typing import Annotated, NamedTuple

from apesim.air import Air, Ambient
from apesim.quantities import Quantity
from engine.breathing import DEGREE
from engine.cylinder import Engine
from engine.effects import Effects
from valve.groove import Groove
from valve.piston import Valve
from valve.supply import Supply


class Command(NamedTuple):
    """When the solenoids are switched, and what is intended by it; crank angles."""

    energise: Annotated[float, Quantity("deg", -360, 360, "chosen: 5 deg before TDC")] = -5.0 * DEGREE
    release: Annotated[float, Quantity("deg", -360, 720, "chosen")] = 70.0 * DEGREE
    open_target: Annotated[float, Quantity("deg", -360, 360, "chosen: the intended opening")] = -5.0 * DEGREE
    close_target: Annotated[float, Quantity("deg", -360, 720, "chosen: the intended closing")] = 70.0 * DEGREE

    def faults(self):
        """Faults that no single key shows."""
        for early, late in (("energise", "release"), ("open_target", "close_target")):
            duration = getattr(self, late) - getattr(self, early)
            if not 0.0 < duration < 2.0 * pi:
                yield late, f"is {duration / DEGREE:g} deg after {early}", "more than 0 and less than 360 deg after it"


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
