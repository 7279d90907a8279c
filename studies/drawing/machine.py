"""Picture of a machine to scale: the engine with valve, receiver and exhaust, and the intake valve enlarged.

Lengths that a machine file does not know (walls, the length of pistons, solenoid housings) are drawn grey or as they
usually are, and bear no dimension. Areas that are only known as effective ones are drawn as circles of that area.
"""

from math import inf, pi, radians
from os import PathLike
from typing import Any, NamedTuple

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

from apesim.engine.cylinder import EPV, INTAKES
from apesim.engine.kinematics import swept_volume
from apesim.engine.machine import Machine
from apesim.studies.drawing.files import write_figure
from apesim.studies.drawing.panels import open_row
from apesim.studies.drawing.shapes import CRANKCASE, EngineShape, ValveShape, engine_shape, intake_shape, valve_shape
from apesim.studies.drawing.style import BLUE, RED, STYLE, Look

CRANK_ANGLE = radians(60.0)
"""Crank angle at which the engine is drawn: crank, rod and charge are all seen."""
METAL, DARK, AIR, SUPPLY_AIR, LINE = "0.82", "0.62", "#dcebf5", "#a9cce3", "0.25"
"""Colours of housings, moving parts, air at low and at supply pressure, and outlines."""
DIMENSION = 8.0
"""Size of the letters of dimensions [pt]."""
SIZE = (11.0, 7.6)
"""Width and height of the figure [inch]."""


class Box(NamedTuple):
    """Rectangle, by its lower left corner, width and height [mm]."""

    x: float
    y: float
    width: float
    height: float


def _block(ax: Axes, box: Box, colour: str, zorder: float = 2.0, **look: Any) -> None:
    usual: Look = {"fc": colour, "ec": LINE, "lw": 0.8, "zorder": zorder}
    ax.add_patch(Rectangle(box[:2], *box[2:], **usual | look))


def _number(length: float) -> str:
    """A length [mm] in three digits."""
    return f"{length:.0f}" if length >= 999.5 else f"{length:.3g}"


def _dimension(
    ax: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    text: str,
    away: tuple[float, float] = (0.0, 0.0),
    beside: tuple[float, float] | None = None,
) -> None:
    """Draw a dimension line from one point to another, both moved `away`, with lines to what is measured.

    The text stands on the line, or `beside` it, from the line's middle, where the line is too short for it.
    """
    moved = [(x + away[0], y + away[1]) for x, y in (start, end)]
    for point, at in zip((start, end), moved, strict=True):
        ax.plot(*zip(point, at, strict=True), color="0.55", lw=0.6, zorder=6)
    middle = tuple(0.5 * (a + b) for a, b in zip(*moved, strict=True))
    arrow = {"arrowstyle": "<|-|>", "color": LINE, "lw": 0.7, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 7}
    if beside is None:
        ax.annotate("", moved[0], moved[1], arrowprops=arrow, zorder=6)
        is_upright = abs(moved[1][1] - moved[0][1]) > abs(moved[1][0] - moved[0][0])
        look: Look = {"ha": "center", "va": "center", "rotation": 90 if is_upright else 0}
        white = {"fc": "white", "ec": "none", "pad": 1.2, "alpha": 0.92}
        ax.text(middle[0], middle[1], text, fontsize=DIMENSION, bbox=white, zorder=7, **look)
        return
    # A short length: a bold line for it, and a thin one that leads to its text.
    ax.plot(*zip(*moved, strict=True), color=RED, lw=1.8, zorder=6, solid_capstyle="butt")
    target = (middle[0] + beside[0], middle[1] + beside[1])
    side = "left" if beside[0] >= 0 else "right"
    ax.plot(*zip(middle, target, strict=True), color="0.45", lw=0.6, zorder=6)
    white = {"fc": "white", "ec": "none", "pad": 1.0, "alpha": 0.92}
    ax.text(*target, f" {text} ", fontsize=DIMENSION, ha=side, va="center", zorder=7, bbox=white)


def _label(ax: Axes, at: tuple[float, float], text: str, **look: Any) -> None:
    """Write what a part is."""
    usual: Look = {"fontsize": DIMENSION, "ha": "center", "va": "center", "zorder": 7, "color": BLUE}
    ax.text(*at, text, **usual | look)


def _draw_spring(ax: Axes, x: float, low: float, high: float, width: float) -> None:
    """Draw a spring as a zigzag."""
    turns = 9
    xs = [x + (0.5 * width if turn % 2 else -0.5 * width) for turn in range(turns)]
    ys = [low + (high - low) * turn / (turns - 1) for turn in range(turns)]
    ax.plot(xs, ys, color="0.35", lw=0.8, zorder=3.5)


def _draw_valve_body(ax: Axes, shape: ValveShape, at: tuple[float, float], springs: bool) -> None:
    """Draw the closed valve with housing, chambers, piston, groove and ports; `at` is the foot of its axis."""
    x, y = at
    d, wall = shape.diameter, shape.wall
    _block(ax, Box(x - 0.5 * d - wall, y - wall, d + 2.0 * wall, shape.height + 2.0 * wall), METAL)
    _block(ax, Box(x - 0.5 * d, y, d, shape.height), AIR, lw=0.6)
    top = y + shape.clearance + shape.length
    _block(ax, Box(x - 0.5 * d, top, d, y + shape.height - top), SUPPLY_AIR, lw=0.6)  # closed: A is pressurised
    # Ports in the housing on both sides, then the piston in front of them, with its groove cut out.
    for side in (x - 0.5 * d - wall, x + 0.5 * d):
        _block(ax, Box(side, y + shape.port, wall, shape.groove), SUPPLY_AIR if side < x else AIR, 2.5, lw=0.6)
    foot = y + shape.clearance
    outline = [(x + across, y + along) for across, along in shape.piston_outline()]
    ax.add_patch(Polygon(outline, closed=True, fc=DARK, ec=LINE, lw=0.8, zorder=3))
    if springs:
        _draw_spring(ax, x, y, foot, 0.25 * d)
        _draw_spring(ax, x, top, y + shape.height, 0.25 * d)


def draw_engine(ax: Axes, machine: Machine) -> None:
    """Draw cylinder, piston, crank, intake valve, receiver, solenoids and exhaust to scale, in millimetres."""
    shape = engine_shape(machine)
    bore, stroke, rod, offset, clearance = shape[:5]
    crank, wall, skirt, thickness = shape.crank, shape.wall, shape.skirt, shape.thickness
    pin, wrist = shape.crank_pin(CRANK_ANGLE), shape.piston_pin(CRANK_ANGLE)
    top, bottom, head, foot = shape.top, shape.bottom, shape.head, shape.foot
    face = wrist + shape.crown

    # Crankcase, cylinder and charge, from the back to the front.
    for side in (offset - 0.5 * bore - wall, offset + 0.5 * bore):
        _block(ax, Box(side, foot, wall, head - foot), METAL)
    ax.add_patch(Circle((0.0, 0.0), CRANKCASE * crank, fc="0.95", ec="0.75", lw=0.8, zorder=1))
    ax.add_patch(Circle((0.0, 0.0), crank, fc="none", ec="0.6", lw=0.7, ls=(0, (4, 3)), zorder=1.2))
    _block(ax, Box(offset - 0.5 * bore, face, bore, head - face), SUPPLY_AIR, 1.5, lw=0.0)
    _block(ax, Box(offset - 0.5 * bore - wall, head, bore + 2.0 * wall, thickness), METAL)

    # Crank, rod and piston.
    for start, end, width in (((0.0, 0.0), pin, 7.0), (pin, (offset, wrist), 4.5)):
        ax.plot(*zip(start, end, strict=True), color=LINE, lw=width + 1.4, solid_capstyle="round", zorder=3)
        ax.plot(*zip(start, end, strict=True), color=DARK, lw=width, solid_capstyle="round", zorder=3.1)
    _block(ax, Box(offset - 0.5 * bore, face - skirt, bore, skirt), DARK, 2.6)
    for ring in (0.1, 0.17, 0.24):
        ax.plot([offset - 0.5 * bore, offset + 0.5 * bore], 2 * [face - ring * bore], color="0.35", lw=1.2, zorder=2.8)
    for joint in ((0.0, 0.0), pin, (offset, wrist)):
        ax.add_patch(Circle(joint, 0.045 * bore, fc="white", ec=LINE, lw=0.9, zorder=3.6))
    ax.plot([offset, offset], [-CRANKCASE * crank, head], color="0.5", lw=0.6, ls=(0, (10, 3, 2, 3)), zorder=3.7)

    # Exhaust: a channel as wide as a circle of its effective area, with a valve on its seat.
    width = shape.exhaust
    x = offset + min(0.5 * bore - 0.5 * width, 0.27 * bore)
    rise = thickness + 0.35 * bore
    _block(ax, Box(x - 0.5 * width, head, width, rise), AIR, 2.5, lw=0.7)
    _block(ax, Box(x - 0.5 * width, head, width, 0.025 * bore), DARK, 2.7, lw=0.7)
    ax.plot([x, x], [head, head + rise + 0.12 * bore], color=LINE, lw=1.6, zorder=2.8)
    _dimension(
        ax,
        (x - 0.5 * width, head + rise),
        (x + 0.5 * width, head + rise),
        f"exhaust ⌀{_number(width)}",
        away=(0.0, 0.06 * bore),
        beside=(0.3 * bore, 0.14 * bore),
    )

    # Intake valve beside its channel into the head, then solenoids, pipe and receiver to the left.
    right = offset + 0.5 * bore + wall
    lowest = -CRANKCASE * crank
    left, highest = _draw_intake(ax, machine, shape)

    # Dimensions of the cylinder and of the crank gear.
    under = foot - 0.12 * bore
    _dimension(
        ax,
        (offset - 0.5 * bore, foot),
        (offset + 0.5 * bore, foot),
        f"bore {_number(bore)}",
        away=(0.0, under - foot) if under < -1.4 * crank else (0.0, -0.06 * bore),
    )
    gap = 0.22 * bore
    _dimension(ax, (right, bottom), (right, top), f"stroke {_number(stroke)}", away=(gap, 0.0))
    _dimension(
        ax,
        (right, top),
        (right, head),
        f"clearance {_number(clearance)}",
        away=(gap, 0.0),
        beside=(0.12 * bore, 0.1 * bore),
    )
    axis = offset - 0.5 * bore - wall
    if abs(offset) < 0.02 * bore:
        rod_x = min(axis, -CRANKCASE * crank) - 0.18 * bore
        shift = (rod_x, 0.0)
        _dimension(ax, (0.0, 0.0), (0.0, rod + crank), f"rod + crank {_number(rod)} + {_number(crank)}", away=shift)
    else:
        _label(ax, (axis - 0.3 * bore, 0.5 * rod), f"rod {_number(rod)}\npin offset {_number(offset)}")
    ax.plot([offset - 0.5 * bore, right + gap], 2 * [top], color=BLUE, lw=0.6, ls=":", zorder=3.8)
    ax.plot([offset - 0.5 * bore, right + gap], 2 * [bottom], color=BLUE, lw=0.6, ls=":", zorder=3.8)
    _label(ax, (right + gap + 0.05 * bore, bottom), "BDC", ha="left")
    across = min(left, -CRANKCASE * crank), max(right + 0.85 * bore, CRANKCASE * crank)
    _finish(ax, across, (lowest, highest), bore)


def _draw_intake(ax: Axes, machine: Machine, engine: EngineShape) -> tuple[float, float]:
    """Draw intake valve, receiver and pipes on the head; returns how far they reach to the left and upwards."""
    shape, is_epv, bore = valve_shape(machine), machine.engine.intake == EPV, engine.bore
    channel, x, axis, foot, port, side, outer, middle, drawn, is_to_scale, end = intake_shape(machine, engine, shape)
    d, wall, low = shape.diameter, shape.wall, engine.head

    # The channel down into the cylinder, as wide as a circle of the groove's effective area.
    pipe = 0.5 * channel
    elbow = port + pipe
    _block(ax, Box(x - pipe, low, channel, elbow - low), SUPPLY_AIR, 2.1, lw=0.6)
    _block(ax, Box(side, port - pipe, max(x - pipe - side, 0.0), channel), SUPPLY_AIR, 2.1, lw=0.6)
    _dimension(
        ax,
        (x - pipe, elbow),
        (x + pipe, elbow),
        f"intake ⌀{_number(channel)}",
        away=(0.0, 0.05 * bore),
        beside=(0.12 * bore, 0.3 * bore),
    )
    highest = elbow + 0.3 * bore
    if is_epv:
        _draw_valve_body(ax, shape, (axis, foot), springs=d > 0.15 * bore)
        upper = foot + shape.height + wall
        # Its label stands above that of the intake, however low the valve is.
        highest = max(upper + 0.22 * bore, elbow + 0.5 * bore)
        _dimension(
            ax,
            (axis - 0.5 * d, upper),
            (axis + 0.5 * d, upper),
            f"valve ⌀{_number(d)}, stroke {_number(shape.stroke)}",
            away=(0.0, 0.06 * bore),
            beside=(0.05 * bore, highest - upper - 0.06 * bore),
        )
    else:
        below = port - pipe - 0.03 * bore
        _label(ax, (0.5 * (outer + x - pipe), below), f"intake by {INTAKES[machine.engine.intake]}", va="top")

    # Receiver: a sphere of its volume, with the feed from the regulator.
    volume, radius, feed = machine.engine.receiver.volume, engine.receiver, engine.feed
    _block(ax, Box(middle, port - pipe, outer - middle, channel), SUPPLY_AIR, 1.9, lw=0.6)
    _block(ax, Box(end, port - 0.5 * feed, middle - end, feed), SUPPLY_AIR, 1.9, lw=0.6)
    ax.add_patch(
        Circle((middle, port), drawn, fc=SUPPLY_AIR, ec=LINE, lw=0.8, zorder=2.2, ls="-" if is_to_scale else "--")
    )
    text = "endless receiver" if volume == inf else f"receiver {1e3 * volume:.3g} L\n⌀{_number(2.0 * radius)}"
    _label(ax, (middle, port), text + ("" if is_to_scale else "\n(not to scale)"), color=LINE)
    pressure = (machine.supply.pressure - machine.ambient.pressure) / 1e6
    under = f"supply {pressure:.3g} MPa gauge" + (f"\nfeed ⌀{_number(feed)}" if volume < inf else "")
    _label(ax, (middle, port - max(drawn, 0.5 * feed) - 0.04 * bore), under, va="top")
    return min(end, middle - 0.5 * bore), max(highest + 0.1 * bore, port + drawn)


def draw_valve(ax: Axes, machine: Machine) -> None:
    """Draw the intake valve, closed, to scale and enlarged, with chambers, groove, springs and solenoids, in mm."""
    shape = valve_shape(machine)
    d, wall, height = shape.diameter, shape.wall, shape.height
    unit = max(d + 2.0 * wall, height + 2.0 * wall)
    _draw_valve_body(ax, shape, (0.0, 0.0), springs=True)
    top, edge = shape.clearance + shape.length, 0.5 * d + wall

    # A solenoid for each chamber on the left, its orifice to scale, with control air and vent.
    box = 0.2 * unit
    near, centre = -edge - 0.1 * unit, 0.5 * height
    feet = {
        "B": min(0.5 * shape.clearance, 0.5 * box - wall, centre - 0.75 * box),
        "A": max(0.5 * (top + height), height + wall - 0.5 * box, centre + 0.75 * box),
    }
    for name, low, high, pressurised in (("B", 0.0, shape.clearance, False), ("A", top, height, True)):
        middle, at, x = 0.5 * (low + high), feet[name], near - 0.5 * box
        pipe = min(shape.orifice, 0.9 * (high - low), 0.8 * box)
        colour = SUPPLY_AIR if pressurised else AIR
        _block(ax, Box(x - 0.5 * pipe, min(middle, at), pipe, abs(at - middle)), colour, 1.8, lw=0.6)
        _block(ax, Box(x - 0.5 * pipe, middle - 0.5 * pipe, -0.5 * d - x + 0.5 * pipe, pipe), colour, 2.05, lw=0.6)
        round_box = FancyBboxPatch((near - box, at - 0.5 * box), box, box, f"round,pad=0,rounding_size={0.03 * unit}")
        round_box.set(fc=METAL, ec=LINE, lw=0.8, zorder=2.2)
        ax.add_patch(round_box)
        ax.add_patch(Circle((x, at), 0.5 * shape.orifice, fc=colour, ec=LINE, lw=0.8, zorder=3))
        text = "control air" if pressurised else "vent"
        arrow = {"arrowstyle": "-|>" if pressurised else "<|-", "color": LINE, "lw": 0.9}
        begin = (near - box - 0.1 * unit, at)
        ax.annotate(text, (near - box, at), begin, arrowprops=arrow, fontsize=DIMENSION, ha="right", va="center")
        _label(ax, (x, at + (0.5 * box + 0.04 * unit) * (1 if pressurised else -1)), f"solenoid {name}")
        _label(ax, (0.33 * d, middle), name, color=LINE, weight="bold")
    start = (near - 0.5 * box - 0.5 * shape.orifice, feet["A"])
    end = (start[0] + shape.orifice, start[1])
    _dimension(ax, start, end, f"orifice ⌀{_number(shape.orifice)}", beside=(-0.1 * unit, -0.17 * unit))

    # Dimensions: above the diameter, on the right what lies along the axis, its texts far enough from one another.
    _dimension(ax, (-0.5 * d, height + wall), (0.5 * d, height + wall), f"piston ⌀{_number(d)}", away=(0.0, 0.1 * unit))
    port = shape.port
    lengths = [
        (height - shape.clearance, height, f"clearance {_number(shape.clearance)}", 0.06),
        (top, top + shape.stroke, f"stroke {_number(shape.stroke)}", 0.1),
        (port, port + shape.groove, f"port {_number(shape.groove)}", 0.06),
        (port - shape.lap, port, f"lap {_number(shape.lap)}", 0.1),
        (0.0, shape.clearance, f"clearance {_number(shape.clearance)}", 0.06),
    ]
    lengths = [length for length in lengths if length[1] > length[0]]
    levels = _spread([0.5 * (low + high) for low, high, _, _ in lengths], 0.085 * unit)
    far = edge + 0.22 * unit
    for (low, high, text, away), level in zip(lengths, levels, strict=True):
        beside = (far - edge - away * unit, level - 0.5 * (low + high))
        _dimension(ax, (edge, low), (edge, high), text, away=(away * unit, 0.0), beside=beside)
    _label(ax, (0.0, shape.clearance + shape.land + 0.5 * shape.groove), "groove", color="black")
    area = f"groove at full lift {_number(0.25 * pi * shape.opening**2)} mm²,\na circle of ⌀{_number(shape.opening)}"
    lowest = min(-wall, feet["B"] - 0.5 * box - 0.08 * unit, levels[-1] - 0.05 * unit)
    _label(ax, (0.0, lowest - 0.07 * unit), area)
    highest = max(height + wall, feet["A"] + 0.5 * box)
    _finish(ax, (-edge - 0.7 * unit, far + 0.36 * unit), (lowest - 0.12 * unit, highest + 0.16 * unit), unit)


def _spread(levels: list[float], gap: float) -> list[float]:
    """Move levels, from the highest to the lowest, apart so that no two are closer than a gap.

    >>> _spread([9.0, 4.0, 4.0], 1.0)
    [9.0, 4.5, 3.5]
    """
    found = list(levels)
    for _ in range(len(found) ** 2):
        for at in range(len(found) - 1):
            lack = gap - (found[at] - found[at + 1])
            if lack > 1e-9:
                found[at] += 0.5 * lack
                found[at + 1] -= 0.5 * lack
    return found


def _finish(ax: Axes, across: tuple[float, float], along: tuple[float, float], size: float) -> None:
    """Set the limits of a drawing [mm], and draw a scale of a round length, about a quarter of a `size`."""
    margin = 0.06 * size
    ax.set(xlim=(across[0] - margin, across[1] + margin), ylim=(along[0] - 3.0 * margin, along[1] + margin))
    ax.set(xlabel="width [mm]", ylabel="height [mm]")  # seen where a user switches the axes on
    ax.set_aspect("equal")
    ax.axis("off")
    decade = 10.0 ** len(str(int(0.4 * size))) / 10.0 if size >= 2.5 else 0.1
    length = max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= max(0.4 * size, decade))
    x, y = across[0], along[0] - 2.2 * margin
    ax.plot([x, x + length], [y, y], color="black", lw=3, solid_capstyle="butt", zorder=7)
    ax.text(x, y + 0.3 * margin, f"{length:g} mm", fontsize=DIMENSION, ha="left", va="bottom")


def machine_figure(machine: Machine) -> Figure:
    """Draw a machine to scale: the engine at 60 deg of the crank, and its intake valve enlarged."""
    is_epv = machine.engine.intake == EPV
    options = {"width_ratios": (1.25, 1.0)} if is_epv else {}
    figure, axes = open_row(2 if is_epv else 1, SIZE, gridspec_kw=options)
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        engine.set(rect=(0.0, 0.035, 1.0, 0.935))  # title and last line stand free
    draw_engine(axes[0], machine)
    count = "" if machine.engine.cylinders == 1.0 else f", one of {machine.engine.cylinders:g} cylinders"
    swept = 1e6 * swept_volume(machine.engine)
    axes[0].set_title(f"engine of {_number(swept)} cm³{count}, 60° after TDC")
    if is_epv:
        draw_valve(axes[1], machine)
        axes[1].set_title("intake valve, closed, enlarged")
    figure.text(
        0.01,
        0.008,
        "Lengths in mm, to scale. ⌀ of intake, exhaust, feed and orifice: circles of the effective area. Walls, "
        "lengths of pistons and housings are no part of the machine file.",
        fontsize=7.5,
        color="0.35",
    )
    return figure


def write_machine_figure(machine: Machine, path: str | PathLike[str], *, overwrite: bool = False) -> None:
    """Write the picture of a machine as PNG, SVG or PDF, by the ending of the file."""
    with matplotlib.rc_context(STYLE):
        write_figure(machine_figure(machine), path, overwrite=overwrite)
