"""Shapes of a machine's parts [mm], for every picture to scale.

Lengths that a machine file does not know (walls, the length of pistons) are as they usually are. Areas that are only
known as effective ones are drawn as circles of that area.
"""

from math import cos, inf, pi, sin, sqrt
from typing import NamedTuple

from apesim.engine.cylinder import EPV
from apesim.engine.machine import Machine
from apesim.valve.groove import area_table, lap_of

MAX_RECEIVER = 0.45
"""Radius of the receiver, over the height of the engine, up to which it is drawn to scale."""
CRANKCASE = 1.3
"""Radius of the crankcase over that of the crank."""


class ValveShape(NamedTuple):
    """Intake valve as it is drawn, closed, its axis at x = 0 and the floor of its lower chamber at y = 0 [mm]."""

    diameter: float
    stroke: float
    lap: float
    clearance: float
    """Height of the clearance volume of each chamber."""
    land: float
    """Height of the piston's land below and above its groove; chosen, as no machine file knows it."""
    orifice: float
    """Diameter of a circle of the solenoid's effective area."""
    opening: float
    """Diameter of a circle of the groove's effective area at full lift."""

    @property
    def groove(self) -> float:
        """Height of the groove, as the part of the lift that opens it."""
        return self.stroke - self.lap

    @property
    def length(self) -> float:
        """Length of the piston."""
        return 2.0 * self.land + self.groove

    @property
    def height(self) -> float:
        """Height of the bore that the piston moves in."""
        return 2.0 * self.clearance + self.stroke + self.length

    @property
    def port(self) -> float:
        """Height of the lower edge of the ports, which the groove meets once it has risen by the lap."""
        return self.clearance + self.land + self.groove + self.lap

    @property
    def wall(self) -> float:
        """Thickness of the housing."""
        return 0.14 * self.diameter + 0.1 * self.stroke

    def piston_outline(self) -> list[tuple[float, float]]:
        """Corners of the closed piston with its groove cut out."""
        side, depth = 0.5 * self.diameter, 0.16 * self.diameter
        foot, edge = self.clearance, self.clearance + self.land
        rim, top = edge + self.groove, foot + self.length
        right = [(side, foot), (side, edge), (side - depth, edge), (side - depth, rim), (side, rim), (side, top)]
        return right + [(-x, y) for x, y in reversed(right)]


class EngineShape(NamedTuple):
    """Cylinder and crank gear as they are drawn, the crank's axis at the origin [mm]."""

    bore: float
    stroke: float
    rod: float
    offset: float
    clearance: float
    """Height of the clearance volume."""
    exhaust: float
    """Diameter of a circle of the exhaust's effective area."""
    receiver: float
    """Radius of a sphere of the receiver's volume; infinite where it is endless."""
    feed: float
    """Diameter of a circle of the receiver's feed."""

    @property
    def crank(self) -> float:
        """Radius of the crank."""
        return 0.5 * self.stroke

    @property
    def wall(self) -> float:
        """Thickness of the cylinder's wall."""
        return 0.08 * self.bore

    @property
    def crown(self) -> float:
        """Height of the piston above its pin."""
        return 0.42 * self.bore

    @property
    def skirt(self) -> float:
        """Length of the piston."""
        return 0.72 * self.bore

    @property
    def thickness(self) -> float:
        """Thickness of the cylinder's head."""
        return 0.2 * self.bore

    @property
    def top(self) -> float:
        """Height of the piston's face at top dead centre."""
        return sqrt((self.rod + self.crank) ** 2 - self.offset**2) + self.crown

    @property
    def bottom(self) -> float:
        """Height of the piston's face one stroke below."""
        return self.top - self.stroke

    @property
    def head(self) -> float:
        """Height of the cylinder's head."""
        return self.top + self.clearance

    @property
    def foot(self) -> float:
        """Height of the cylinder's lower end."""
        return self.bottom - 0.75 * self.skirt

    def crank_pin(self, angle: float) -> tuple[float, float]:
        """Place of the crank pin at a crank angle [rad]."""
        return self.crank * sin(angle), self.crank * cos(angle)

    def piston_pin(self, angle: float) -> float:
        """Height of the piston's pin at a crank angle [rad]."""
        x, y = self.crank_pin(angle)
        return y + sqrt(self.rod**2 - (x - self.offset) ** 2)


class IntakeShape(NamedTuple):
    """Channel into the cylinder, intake valve and receiver as they are drawn beside the engine's head [mm]."""

    channel: float
    """Diameter of the channel, a circle of the groove's effective area at full lift."""
    x: float
    """Axis of the channel down into the cylinder."""
    axis: float
    """Axis of the valve."""
    floor: float
    """Height of the floor of the valve's lower chamber."""
    port: float
    """Height of the middle of the ports, and of the receiver."""
    side: float
    """Place of the channel's start, at the valve's right side."""
    outer: float
    """Place of the end of the receiver's pipe, at the valve's left side."""
    middle: float
    """Middle of the receiver."""
    radius: float
    """Radius of the receiver as it is drawn."""
    is_to_scale: bool
    """Whether that is its own radius."""
    end: float
    """Outer end of the receiver's feed."""


def valve_shape(machine: Machine) -> ValveShape:
    """Return the shape of the intake valve of a machine [mm]."""
    valve = machine.valve
    table = area_table(machine.groove, valve.stroke)
    diameter, stroke = 1e3 * diameter_of(valve.piston_area), 1e3 * valve.stroke
    return ValveShape(
        diameter,
        stroke,
        1e3 * lap_of(table),
        1e3 * valve.clearance_volume / valve.piston_area,
        max(1.15 * stroke, 0.12 * diameter),
        1e3 * diameter_of(valve.solenoid.effective_area),
        1e3 * diameter_of(float(table[:, 1].max())),
    )


def engine_shape(machine: Machine) -> EngineShape:
    """Return the shape of the cylinder, crank gear, exhaust and receiver of a machine [mm]."""
    engine = machine.engine
    volume = engine.receiver.volume
    return EngineShape(
        1e3 * engine.bore,
        1e3 * engine.stroke,
        1e3 * engine.rod_length,
        1e3 * engine.pin_offset,
        1e3 * engine.stroke / (engine.compression_ratio - 1.0),
        1e3 * diameter_of(sum(valve.effective_area for valve in engine.exhausts)),
        inf if volume == inf else 1e3 * (0.75 * volume / pi) ** (1.0 / 3.0),
        1e3 * diameter_of(engine.receiver.feed_area),
    )


def intake_shape(machine: Machine, engine: EngineShape, valve: ValveShape) -> IntakeShape:
    """Return where channel, valve and receiver of a machine are drawn; of another intake the channel is bent."""
    bore, channel, above = engine.bore, valve.opening, engine.head + engine.thickness
    x = engine.offset - min(0.5 * bore - 0.5 * channel, 0.25 * bore)
    if machine.engine.intake == EPV:
        half, floor = 0.5 * valve.diameter + valve.wall, above + valve.wall + 0.05 * bore
        axis = x - 0.5 * channel - 0.04 * bore - half
        port, side, outer = floor + valve.port + 0.5 * valve.groove, axis + half, axis - half
    else:
        axis, floor, port = x, above, above + 0.5 * bore
        side = outer = x - 0.5 * channel - 0.75 * bore

    # A receiver that is larger than the engine is drawn smaller.
    largest, gap = MAX_RECEIVER * (engine.top + CRANKCASE * engine.crank), 0.22 * bore
    is_to_scale = engine.receiver <= largest
    radius = engine.receiver if is_to_scale else (0.5 if engine.receiver == inf else 1.0) * largest
    middle = outer - gap - radius
    return IntakeShape(channel, x, axis, floor, port, side, outer, middle, radius, is_to_scale, middle - radius - gap)


def diameter_of(area: float) -> float:
    """Diameter of a circle of an area."""
    return sqrt(4.0 * area / pi)
