"""Picture of a machine to scale that a script moves: engine and intake valve, the air coloured by its pressure.

It stands as one state where scripts are off. What moves has a ``data-part``, what has a colour by its pressure a
``data-air``, and a number that changes a ``data-value``; ``assets/motion.js`` knows these.
"""

from collections.abc import Iterable, Sequence
from html import escape
from math import asin, degrees, inf, isfinite, radians
from typing import Any, NamedTuple

from apesim.engine.angles import DEGREE
from apesim.engine.cam import raised_cosine
from apesim.engine.cylinder import CAM, EPV
from apesim.engine.machine import Machine
from apesim.studies.drawing.shapes import (
    CRANKCASE,
    EngineShape,
    IntakeShape,
    ValveShape,
    engine_shape,
    intake_shape,
    valve_shape,
)

ENGINE_ROOM, VALVE_ROOM = (420.0, 400.0), (388.0, 360.0)
"""Width and largest height of the pictures, in units of which letters are 12 high."""
MARGIN = 14.0
"""Room that is left at the edges of a picture."""
RULER = 122.0
"""Room beside the valve for the ruler of its lift, and on the other side for the control air."""
LETTER = 14.0
"""Smallest distance of two lines of letters."""
EXHAUST_LIFT = 0.09
"""Lift of the open exhaust valve over the bore; chosen, as no machine file knows it."""
COILS = 9
"""Corners of a spring."""
Point = tuple[float, float]


class Snapshot(NamedTuple):
    """State of a machine at one instant, as its picture shows it."""

    angle_deg: float = 0.0
    """Crank angle after TDC [deg]."""
    lift_m: float = 0.0
    """Lift of the intake [m]."""
    pressure_a_Pa: float = 0.0
    """Pressure of chamber A, which pushes to closed [Pa abs]."""
    pressure_b_Pa: float = 0.0
    """Pressure of chamber B, which pushes to open [Pa abs]."""
    cylinder_pressure_Pa: float = 0.0
    """Pressure of the cylinder [Pa abs]."""
    receiver_pressure_Pa: float = 0.0
    """Pressure of the receiver [Pa abs]."""


class Sheet(NamedTuple):
    """How lengths of a drawing [mm] become places in a picture, whose y points down."""

    scale: float
    """Units of the picture per millimetre."""
    x0: float
    """Place of x = 0."""
    y0: float
    """Place of y = 0."""
    height: float = 0.0
    """Height of the picture."""

    def x(self, x: float) -> float:
        """Place of an x [mm]."""
        return self.x0 + self.scale * x

    def y(self, y: float) -> float:
        """Place of a y [mm]."""
        return self.y0 - self.scale * y

    def box(self, left: float, bottom: float, width: float, height: float, **look: Any) -> str:
        """Draw a rectangle by its lower left corner, width and height [mm]."""
        s = self.scale
        x, y, width, height = self.x(left), self.y(bottom + height), s * max(width, 0.0), s * max(height, 0.0)
        return _tag("rect", x=x, y=y, width=width, height=height, **look)

    def circle(self, at: Point, radius: float, **look: Any) -> str:
        """Draw a circle [mm]."""
        return _tag("circle", cx=self.x(at[0]), cy=self.y(at[1]), r=self.scale * radius, **look)

    def line(self, points: Sequence[Point], **look: Any) -> str:
        """Draw a line through points [mm]."""
        return _tag("polyline", points=self._places(points), **look)

    def area(self, points: Sequence[Point], **look: Any) -> str:
        """Draw an area by its corners [mm]."""
        return _tag("polygon", points=self._places(points), **look)

    def _places(self, points: Sequence[Point]) -> str:
        return " ".join(f"{_short(self.x(x))},{_short(self.y(y))}" for x, y in points)


def fit_sheet(left: float, right: float, low: float, high: float, room: tuple[float, float], aside: float) -> Sheet:
    """Place a drawing of some extent [mm] in a picture of some width, as high as it needs, up to a largest height.

    `room` is that width and height, `aside` what is left free at each side.

    >>> sheet = fit_sheet(-1.0, 1.0, 0.0, 4.0, (128.0, 108.0), MARGIN)
    >>> sheet.scale, sheet.x(-1.0), sheet.y(0.0), sheet.height
    (20.0, 44.0, 94.0, 108.0)
    """
    width, height = room
    scale = min((width - 2.0 * aside) / (right - left), (height - 2.0 * MARGIN) / (high - low))
    return Sheet(
        scale, 0.5 * width - 0.5 * scale * (left + right), MARGIN + scale * high, scale * (high - low) + 2.0 * MARGIN
    )


def share_of_colour(pressure: float, lowest: float, highest: float) -> str:
    """Share that the colour of the highest pressure has in that of some pressure.

    >>> share_of_colour(3e5, 1e5, 5e5), share_of_colour(9e5, 1e5, 5e5)
    ('50%', '100%')
    """
    share = (pressure - lowest) / (highest - lowest)
    return f"{100.0 * min(max(share, 0.0), 1.0):.3g}%" if isfinite(share) else "0%"


class Shapes(NamedTuple):
    """Shapes of a machine, and the sheets that they are drawn on."""

    engine: EngineShape
    valve: ValveShape
    intake: IntakeShape
    engine_sheet: Sheet
    valve_sheet: Sheet


def shapes_of(machine: Machine) -> Shapes:
    """Lay out the pictures of a machine's engine and of its valve."""
    engine, valve = engine_shape(machine), valve_shape(machine)
    intake = intake_shape(machine, engine, valve)
    case, half = CRANKCASE * engine.crank, 0.5 * engine.bore + engine.wall
    top = max(
        intake.floor + valve.height + valve.wall if machine.engine.intake == EPV else 0.0,
        intake.port + max(intake.radius, 0.5 * intake.channel),
        engine.head + engine.thickness + 0.5 * engine.bore,
    )
    left, right = min(intake.end, engine.offset - half, -case), max(engine.offset + half, case)
    edge = 0.5 * valve.diameter + valve.wall
    return Shapes(
        engine,
        valve,
        intake,
        fit_sheet(left, right, -case, top, ENGINE_ROOM, MARGIN),
        fit_sheet(-edge, edge, -valve.wall, valve.height + valve.wall, VALVE_ROOM, RULER),
    )


def motion_geometry(machine: Machine, highest_Pa: float, has_engine: bool = True) -> dict[str, Any]:
    """Sizes that the script moves a picture by, in its units, as JSON knows them.

    `highest_Pa` is the pressure of the darkest colour, the ambient's that of the brightest one.
    """
    engine, valve, intake, sheet, large = shapes_of(machine)
    exhaust, s = machine.engine.exhaust, sheet.scale

    def own(scale: float, floor: float) -> dict[str, float]:
        """Sizes of the valve in one of the pictures."""
        sizes = {"scale": scale, "floor": floor, "closedA": scale * (valve.clearance + valve.stroke)}
        return _rounded(sizes | {"closedB": scale * valve.clearance})

    moved = {
        "origin": [sheet.x0, sheet.y0],
        "crank": s * engine.crank,
        "rod": s * engine.rod,
        "offset": s * engine.offset,
        "pin": s * (engine.top - engine.crown),
        "crown": s * engine.crown,
        "head": s * engine.head,
        "exhaust": [exhaust.opens / DEGREE, exhaust.closes / DEGREE, exhaust.flank / DEGREE],
        "exhaustLift": s * EXHAUST_LIFT * engine.bore,
        "command": [machine.command.energise / DEGREE, machine.command.release / DEGREE],
    }
    return {
        "engine": _rounded(moved) if has_engine else None,
        "valves": {"small": own(s, sheet.y(intake.floor)), "large": own(large.scale, large.y0)},
        "lap": valve.lap,
        "stroke": valve.stroke,
        "lowest": machine.ambient.pressure,
        "highest": highest_Pa,
    }


def render_motion(machine: Machine, at: Snapshot, highest_Pa: float, has_engine: bool = True) -> str:
    """Draw a machine at one instant as a fragment of HTML: pictures, legend, and controls that a script reveals."""
    shapes = shapes_of(machine)
    is_epv = machine.engine.intake == EPV or not has_engine
    air = _Airs(machine.ambient.pressure, highest_Pa, at)
    pictures = [_draw_valve(machine, shapes, at, air, is_epv)]
    if has_engine:
        pictures.insert(0, _draw_engine(machine, shapes, at, air))
    return (
        f'<div class="motion"><div class="motion-pictures">{"".join(pictures)}</div>'
        f"{_legend(machine.ambient.pressure, highest_Pa)}"
        '<div class="controls motion-controls" hidden>'
        '<button type="button" class="motion-play" aria-pressed="false">Play</button>'
        '<input type="range" class="motion-slider" min="0" max="1" step="any" value="0">'
        '<output class="motion-at"></output></div></div>'
    )


class _Airs(NamedTuple):
    """Air at an instant, and the pressures of the brightest and of the darkest colour."""

    lowest: float
    highest: float
    at: Snapshot

    def look(self, name: str) -> dict[str, str]:
        """Colour of the air in ``a``, ``b``, ``cylinder`` or ``receiver``, and the mark by which a script finds it."""
        share = share_of_colour(self._pressures()[name], self.lowest, self.highest)
        return {"data_air": name, "style": f"--high:{share}"}

    def number(self, name: str) -> str:
        """Pressure in that air, in words."""
        return f"{self._pressures()[name] / 1e6:.2f}"

    def _pressures(self) -> dict[str, float]:
        return dict(zip(("a", "b", "cylinder", "receiver"), self.at[2:], strict=True))


def _draw_engine(machine: Machine, shapes: Shapes, at: Snapshot, air: _Airs) -> str:
    """Draw cylinder, crank gear, exhaust, intake valve and receiver."""
    engine, sheet = shapes.engine, shapes.engine_sheet
    half, head, crank = 0.5 * engine.bore, engine.head, engine.crank
    centre, angle = engine.offset, radians(at.angle_deg)
    pin = engine.piston_pin(angle)

    # Crankcase and cylinder; the charge reaches down to the piston's face, which a script moves.
    parts = [sheet.circle((0.0, 0.0), CRANKCASE * crank, class_="case")]
    parts.append(sheet.circle((0.0, 0.0), crank, class_="path"))
    for side in (centre - half - engine.wall, centre + half):
        parts.append(sheet.box(side, engine.foot, engine.wall, head - engine.foot, class_="metal"))
    parts.append(_tag("g", parts=_draw_intake(machine, shapes, at, air)))
    face = pin + engine.crown
    parts.append(sheet.box(centre - half, face, engine.bore, head - face, data_part="charge", **air.look("cylinder")))
    thick = engine.thickness
    parts.append(sheet.box(centre - half - engine.wall, head, engine.bore + 2.0 * engine.wall, thick, class_="metal"))
    intake = shapes.intake
    channel = air.look("cylinder")
    parts.append(sheet.box(intake.x - 0.5 * intake.channel, head, intake.channel, thick, class_="duct", **channel))
    parts.append(_draw_exhaust(machine, shapes, at))

    # Rod and piston are drawn at the origin of what moves, the crank upwards.
    rod = degrees(asin((engine.crank_pin(angle)[0] - centre) / engine.rod))
    s, skirt = sheet.scale, engine.skirt
    top = Sheet(s, 0.0, 0.0)
    lift = sheet.y0 - s * (pin - engine.top + engine.crown)
    piston = [top.box(-half, engine.top - skirt, engine.bore, skirt, class_="part")]
    for ring in (0.1, 0.17, 0.24):
        y = engine.top - ring * engine.bore
        piston.append(top.line([(-half, y), (half, y)], class_="thin"))
    parts.append(_group("piston", piston, f"translate({_short(sheet.x(centre))} {_short(lift)})"))
    width = s * 0.09 * engine.bore
    bar = [top.line([(0.0, 0.0), (0.0, -engine.rod)], class_=look, stroke_width=w) for look, w in _bar(width)]
    place = f"translate({_short(sheet.x(centre))} {_short(sheet.y(pin))}) rotate({_short(-rod)})"
    parts.append(_group("rod", [*bar, top.circle((0.0, 0.0), 0.05 * engine.bore, class_="joint")], place))
    web = [top.line([(0.0, 0.0), (0.0, crank)], class_=look, stroke_width=w) for look, w in _bar(1.5 * width)]
    web.append(top.circle((0.0, crank), 0.05 * engine.bore, class_="joint"))
    turn = f"translate({_short(sheet.x0)} {_short(sheet.y0)}) rotate({_short(at.angle_deg)})"
    parts.append(_group("crank", web, turn))
    parts.append(sheet.circle((0.0, 0.0), 0.05 * engine.bore, class_="joint"))

    # Numbers: where there is air, and at the crank.
    beside = sheet.x(centre - half - engine.wall) - 8.0
    level = sheet.y(engine.top - 0.35 * engine.stroke)
    parts.append(_text((beside, level), "cylinder", "end"))
    parts.append(_value((beside, level + 15.0), "cylinder", air.number("cylinder"), " MPa", "end"))
    case = sheet.x0, sheet.y(-CRANKCASE * crank) - 5.0
    parts.append(_value(case, "angle", f"{at.angle_deg:.0f}", "°"))
    label = "engine to scale: receiver, intake valve, cylinder, piston, rod and crank"
    return _picture(ENGINE_ROOM[0], sheet.height, label, parts)


def _bar(width: float) -> Iterable[tuple[str, float]]:
    """Looks and widths by which a bar is drawn: its outline, then itself."""
    return ("outline", width + 2.0), ("bar", width)


def _draw_exhaust(machine: Machine, shapes: Shapes, at: Snapshot) -> str:
    """Draw the exhaust's channel with its valve, which opens into the cylinder."""
    engine, sheet = shapes.engine, shapes.engine_sheet
    width, bore, head = min(engine.exhaust, 0.9 * engine.bore), engine.bore, engine.head
    x = engine.offset + min(0.5 * bore - 0.5 * width, 0.27 * bore)
    rise = engine.thickness + 0.35 * bore
    window = machine.engine.exhaust
    share = raised_cosine(radians(at.angle_deg), window.opens, window.closes, window.flank)
    valve = [
        sheet.box(x - 0.5 * width, head - 0.03 * bore, width, 0.03 * bore, class_="part"),
        sheet.line([(x, head), (x, head + rise + 0.12 * bore)], class_="stem"),
    ]
    down = sheet.scale * EXHAUST_LIFT * bore * share
    duct = sheet.box(x - 0.5 * width, head, width, rise, class_="duct vent")
    return duct + _group("exhaust", valve, f"translate(0 {_short(down)})")


def _draw_intake(machine: Machine, shapes: Shapes, at: Snapshot, air: _Airs) -> list[str]:
    """Draw receiver, pipe, intake valve and channel beside the engine's head."""
    engine, valve, intake, sheet, _ = shapes
    low, pipe, port = engine.head + engine.thickness, 0.5 * intake.channel, intake.port
    cylinder, receiver = air.look("cylinder"), air.look("receiver")

    # Feed, receiver and pipe, then the channel down into the cylinder.
    feed = min(engine.feed, 2.0 * intake.radius)
    if engine.receiver < inf:
        parts = [sheet.box(intake.end, port - 0.5 * feed, intake.middle - intake.end, feed, class_="duct", **receiver)]
    else:
        parts = []
    parts.append(
        sheet.box(intake.middle, port - pipe, intake.outer - intake.middle, 2.0 * pipe, class_="duct", **receiver)
    )
    look = "duct" if intake.is_to_scale else "duct dashed"
    parts.append(sheet.circle((intake.middle, port), intake.radius, class_=look, **receiver))
    right = max(intake.x - pipe - intake.side, 0.0)
    parts.append(sheet.box(intake.side, port - pipe, right, 2.0 * pipe, class_="duct", **cylinder))
    parts.append(sheet.box(intake.x - pipe, low, 2.0 * pipe, port + pipe - low, class_="duct", **cylinder))

    # The valve small, without letters.
    if machine.engine.intake == EPV:
        own = Sheet(sheet.scale, sheet.x(intake.axis), sheet.y(intake.floor))
        parts += _valve_body(valve, own, at, air, is_epv=True, suffix="small")
    name = {EPV: "", CAM: "cam"}.get(machine.engine.intake, "ideal valve")
    if name:
        parts.append(_text((sheet.x(intake.side), sheet.y(port + pipe) - 6.0), name))
    not_to_scale = "" if intake.is_to_scale else "endless" if engine.receiver == inf else "not to scale"
    middle = sheet.x(intake.middle), sheet.y(port)
    parts.append(_text((middle[0], middle[1] - 12.0), "receiver"))
    parts.append(_value((middle[0], middle[1] + 4.0), "receiver", air.number("receiver"), " MPa"))
    if not_to_scale:
        parts.append(_text((middle[0], middle[1] + 19.0), not_to_scale, "small"))
    return parts


def _valve_body(
    valve: ValveShape, sheet: Sheet, at: Snapshot, air: _Airs, *, is_epv: bool, suffix: str, spring: bool = False
) -> list[str]:
    """Draw housing, chambers, ports and piston of the valve; parts that move bear the suffix."""
    half, wall, height, lift = 0.5 * valve.diameter, valve.wall, valve.height, 1e3 * at.lift_m
    top = valve.clearance + valve.length + lift
    chambers = (air.look("a"), air.look("b")) if is_epv else ({"class_": "vent"},) * 2
    parts = [
        sheet.box(-half - wall, -wall, 2.0 * (half + wall), height + 2.0 * wall, class_="metal"),
        sheet.box(-half, 0.0, 2.0 * half, height, class_="bore"),
        sheet.box(-half, top, 2.0 * half, height - top, data_part=f"chamber-a-{suffix}", **chambers[0]),
        sheet.box(-half, 0.0, 2.0 * half, valve.clearance + lift, data_part=f"chamber-b-{suffix}", **chambers[1]),
        sheet.box(-half - wall, valve.port, wall, valve.groove, class_="duct", **air.look("receiver")),
        sheet.box(half, valve.port, wall, valve.groove, class_="duct", **air.look("cylinder")),
    ]
    edge = valve.clearance + valve.land
    piston = [
        sheet.box(-half, edge, 2.0 * half, valve.groove, **air.look("cylinder")),
        sheet.area(valve.piston_outline(), class_="part"),
    ]
    if spring:  # drawn at full length, and pressed by what moves
        parts += [_spring(valve, sheet, "low", valve.clearance + lift), _spring(valve, sheet, "high", height - top)]
        share = (1e3 * at.lift_m - valve.lap) / valve.groove
        middle = sheet.y(edge + 0.5 * valve.groove)
        arrow = f"M{_short(sheet.x(-0.24 * valve.diameter))} {_short(middle)}H{_short(sheet.x(0.2 * valve.diameter))}"
        end = _short(sheet.x(0.24 * valve.diameter))
        tip = f"M{end} {_short(middle)}l-8 -5v10z"
        look = {"opacity": _short(min(max(share, 0.0), 1.0)), "class_": "flow", "data_part": "flow"}
        piston.append(_tag("path", d=arrow + tip, **look))
    parts.append(_group(f"valve-{suffix}", piston, f"translate(0 {_short(-sheet.scale * lift)})"))
    return parts


def _spring(valve: ValveShape, sheet: Sheet, which: str, length: float) -> str:
    """Draw a spring of a length [mm] between the piston and the end of its chamber as a zigzag of 1 unit height."""
    half = 0.13 * sheet.scale * valve.diameter
    corners = [(half * (0 if turn in (0, COILS - 1) else 1 if turn % 2 else -1), turn) for turn in range(COILS)]
    path = "M" + "L".join(f"{_short(x)} {turn / (COILS - 1):.3f}" for x, turn in corners)
    start = sheet.y(valve.height if which == "high" else length)
    place = f"translate({_short(sheet.x0)} {_short(start)}) scale(1 {_short(sheet.scale * length)})"
    return _tag("path", d=path, class_="spring", data_part=f"spring-{which}", transform=place)


def _draw_valve(machine: Machine, shapes: Shapes, at: Snapshot, air: _Airs, is_epv: bool) -> str:
    """Draw the intake valve enlarged, with letters, and a ruler of its lift."""
    valve, sheet = shapes.valve, shapes.valve_sheet
    half, wall, height = 0.5 * valve.diameter, valve.wall, valve.height
    parts = _valve_body(valve, sheet, at, air, is_epv=is_epv, suffix="large", spring=is_epv)
    left, right = sheet.x(-half - wall), sheet.x(half + wall)
    middle = sheet.y(valve.port + 0.5 * valve.groove)

    # Chambers, and where their air comes from.
    if is_epv:
        for name, y in (("a", height - 0.5 * valve.clearance), ("b", 0.5 * valve.clearance)):
            y = sheet.y(y)
            parts.append(_text((left - 8.0, y - 3.0), f"chamber {name.upper()}", "end"))
            parts.append(_value((left - 8.0, y + 12.0), name, air.number(name), " MPa", "end"))
            parts.append(_tag("path", d=f"M{_short(left - 6.0)} {_short(y)}h{_short(6.0 + 0.4 * wall)}", class_="thin"))
    parts.append(_text((left - 8.0, middle - 3.0), "receiver", "end"))
    parts.append(_value((left - 8.0, middle + 12.0), "receiver", air.number("receiver"), " MPa", "end"))
    parts.append(_tag("path", d=f"M{_short(left - 6.0)} {_short(middle)}h6", class_="thin"))

    # Ruler of the lift, at the upper edge of the groove; texts are kept apart where lengths are short.
    rim = valve.clearance + valve.land + valve.groove
    levels = [sheet.y(rim), sheet.y(rim + valve.lap), sheet.y(rim + valve.stroke)]
    texts = _apart(levels)
    names = "closed", f"lap {valve.lap:.3g} mm", f"stroke {valve.stroke:.3g} mm"
    ruler = right + 12.0
    parts.append(_tag("path", d=f"M{_short(ruler)} {_short(levels[0])}V{_short(levels[2])}", class_="thin"))
    for name, level, text in zip(names, levels, texts, strict=True):
        line = f"M{_short(ruler - 4.0)} {_short(level)}h8L{_short(ruler + 12.0)} {_short(text)}"
        parts.append(_tag("path", d=line, class_="thin"))
        parts.append(_text((ruler + 15.0, text + 4.0), name, "start"))
    pointer = f"M{_short(ruler - 1.0)} {_short(levels[0])}l-9 -5v10z"
    lift = f"translate(0 {_short(-sheet.scale * 1e3 * at.lift_m)})"
    parts.append(_group("pointer", [_tag("path", d=pointer, class_="pointer")], lift))
    below = ruler - 2.0, texts[0] + 24.0
    parts.append(_value(below, "lift", f"{1e3 * at.lift_m:.2f}", " mm", "start", "lift "))
    name = {EPV: "electro-pneumatic valve", CAM: "groove moved by a cam"}.get(machine.engine.intake, "ideal valve")
    label = f"{name if not is_epv else 'electro-pneumatic valve'} enlarged, to scale, with chambers A and B"
    if not is_epv:
        parts.append(_text((sheet.x0, sheet.y(height + wall) + 0.5 * sheet.scale * wall + 4.0), name))
    return _picture(VALVE_ROOM[0], sheet.height, label, parts)


def _apart(levels: Sequence[float]) -> list[float]:
    """Levels of letters beside lengths, from the lowest up: each `LETTER` above the one before it, or more."""
    found = [levels[0] + 2.0]
    for level in levels[1:]:
        found.append(min(level, found[-1] - LETTER))
    return found


def _legend(lowest: float, highest: float) -> str:
    """Draw the scale of the colours with its ends."""
    ends = (f"{pressure / 1e6:.2f}" for pressure in (lowest, highest))
    first, last = ends
    middle = f"{0.5e-6 * (lowest + highest):.2f}"
    return (
        '<div class="motion-legend"><span>air pressure [MPa abs]</span>'
        '<span class="motion-scale"><span class="motion-bar"></span>'
        f'<span class="motion-ticks"><span>{first}</span><span data-value="half">{middle}</span>'
        f'<span data-value="highest">{last}</span></span></span></div>'
    )


def _picture(width: float, height: float, label: str, parts: Iterable[str]) -> str:
    """Put parts together to a picture with a name that is read aloud."""
    box = f"0 0 {_short(width)} {_short(height)}"
    return f'<svg viewBox="{box}" role="img" aria-label="{escape(label)}">{"".join(parts)}</svg>'


def _value(at: Point, name: str, number: str, unit: str, anchor: str = "middle", before: str = "") -> str:
    """Write a number that changes, with its unit, and what it is of before it."""
    return (
        f'<text x="{_short(at[0])}" y="{_short(at[1])}" class="number {anchor}">{before}'
        f'<tspan data-value="{name}">{number}</tspan>{unit}</text>'
    )


def _text(at: Point, text: str, look: str = "middle") -> str:
    """Write what a part is."""
    return f'<text x="{_short(at[0])}" y="{_short(at[1])}" class="{look}">{escape(text)}</text>'


def _group(part: str, parts: Iterable[str], transform: str) -> str:
    """Put together what moves as one."""
    return f'<g data-part="{part}" transform="{transform}">{"".join(parts)}</g>'


def _tag(tag: str, parts: Iterable[str] = (), **look: Any) -> str:
    """Write an element of SVG; names of attributes have underscores for their hyphens."""
    pairs = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{_short(value) if isinstance(value, float) else value}"'
        for name, value in look.items()
    )
    return f"<{tag}{pairs}>{''.join(parts)}</{tag}>" if parts else f"<{tag}{pairs}/>"


def _short(number: float) -> str:
    """A number with as many digits as are seen."""
    return f"{round(number, 2) + 0.0:g}"


def _rounded(sizes: dict[str, Any]) -> dict[str, Any]:
    """Sizes with as many digits as are seen."""
    return {
        name: [round(each, 3) for each in size] if isinstance(size, list) else round(size, 4) + 0
        for name, size in sizes.items()
    }
