"""Plausibility of a machine: one quick estimate for each thing that may be odd, with its numbers and what to change.

Nothing here is marched: an estimate is good to some ten percent, and says where to look.
"""

from collections.abc import Callable, Iterator
from math import pi, sqrt

from apesim.engine.angles import DEGREE, RPM, TURN
from apesim.engine.cylinder import EPV
from apesim.engine.machine import Machine
from apesim.studies.design.estimates import MIN_GAUGE, Point, lap_to_lap, solenoid_for, three

EDGE = 1.0 * DEGREE
"""Angle by which both ends of a window together may miss their targets, as `apesim engine limit` has it."""
MAX_PISTON_SPEED = 20.0
"""Mean piston speed that few engines exceed [m/s]: 8 to 15 m/s are usual (Heywood 1988, section 2.2)."""
SHAPES = 0.4, 2.5
"""Stroke over bore: 0.8 to 1.2 are usual, 0.5 for large ones (Heywood 1988, section 2.2); chosen: twice as far."""
MIN_CLEARANCE = 0.3e-3
"""Height of the clearance at top dead centre [m]; chosen: gaskets and bearings need as much."""
OPENING = 0.75
"""Effective over geometric area of the groove's opening, as `groove.ports.discharge_coefficient`; chosen."""
MAX_GIRTH = 0.8
"""Share of the piston's girth that can be open; chosen: the rest holds the ports' edges."""
MIN_GROOVE = 1.0 / 3.0
"""Area that the engine needs over that of its groove, below which the valve's stroke is too long; chosen: the default
machine has 0.92."""
MAX_LATENESS = 0.5
"""Share of the cycle that a solenoid's dead and ramp time may take at the rated speed; chosen."""
MIN_FORCE = 1.5
"""Pressure force over the spring's at the stop, below which the valve hesitates; chosen."""


def _limit(point: Point) -> Iterator[str]:
    time, allowed = lap_to_lap(point), (point.window + EDGE) / point.speed
    if point.machine.engine.intake != EPV or time <= allowed or _is_weak(point):
        return  # a valve that its control air hardly moves is said to be so
    area = solenoid_for(point, allowed)
    solenoid = point.machine.valve.solenoid._replace(effective_area=area)
    faster = point.machine._replace(valve=point.machine.valve._replace(solenoid=solenoid))
    helps = lap_to_lap(point._replace(machine=faster)) <= allowed * 1.001
    remedy = f"valve.solenoid.effective_area {three(1e6 * area)} mm2, " if helps else ""
    yield (
        f"the intake valve keeps its window of {three(point.window / DEGREE)} deg up to about "
        f"{three((point.window + EDGE) / time / RPM)} r/min, and the rated speed is {three(point.rpm)} r/min: to "
        f"open and close again takes {three(1e3 * time)} ms; give {remedy}a shorter stroke or a longer window, and see "
        "apesim engine limit"
    )


def _lateness(point: Point) -> Iterator[str]:
    solenoid = point.machine.valve.solenoid
    late = solenoid.dead_time + solenoid.ramp_time
    if len(solenoid.opening_curve):
        late = float(solenoid.opening_curve[-1, 0])
    share = late * point.speed / TURN
    if point.machine.engine.intake == EPV and share > MAX_LATENESS:
        yield (
            f"a solenoid needs {three(1e3 * late)} ms to open, which is {360 * share:.0f} deg of the crank at the "
            "rated speed: take a faster one, or a lower speed"
        )


def _choked_groove(point: Point) -> Iterator[str]:
    if point.needed_area > point.full_area:
        passed = point.full_area * point.choked_velocity
        yield (
            f"the groove chokes at the rated speed: the piston draws {three(1e3 * point.drawn)} L/s before the "
            f"intended closing, and {1e6 * point.full_area:.4g} mm2 pass {three(1e3 * passed)} L/s at most; give "
            f"groove.effective_area {1e6 * point.needed_area:.4g} mm2, or a lower speed"
        )


def _long_stroke(point: Point) -> Iterator[str]:
    valve, share = point.machine.valve, point.needed_area / point.full_area
    if point.machine.engine.intake == EPV and share < MIN_GROOVE:
        enough = 1e3 * (point.lap + (valve.stroke - point.lap) * share)
        yield (
            f"the valve's stroke of {three(1e3 * valve.stroke)} mm is longer than its groove needs: the engine draws "
            f"what {three(1e6 * point.needed_area)} of its {1e6 * point.full_area:.4g} mm2 pass; {enough:.2g} mm would "
            "do, and the valve would be faster and use less control air"
        )


def _girth(point: Point) -> Iterator[str]:
    valve, groove = point.machine.valve, point.machine.groove
    if point.machine.engine.intake != EPV or groove.has_ports or len(groove.area_curve):
        return
    girth, open_lift = sqrt(4.0 * pi * valve.piston_area), valve.stroke - point.lap
    width = groove.effective_area / (OPENING * open_lift)
    if width > MAX_GIRTH * girth:
        # The lap stays its part of the stroke.
        needed = groove.effective_area / (OPENING * MAX_GIRTH * girth) * valve.stroke / open_lift
        yield (
            f"the groove does not fit the valve: over {three(1e3 * open_lift)} mm of open lift "
            f"{1e6 * groove.effective_area:.4g} mm2 need an opening {three(1e3 * width)} mm wide, and the piston is "
            f"{three(1e3 * girth)} mm round; give a stroke of {three(1e3 * needed)} mm or more, or a larger piston"
        )


def _forces(point: Point) -> tuple[float, float]:
    """Pressure force on the valve's piston, and the springs' at a stop [N]."""
    valve = point.machine.valve
    return point.control_gauge * valve.piston_area, valve.spring_rate * valve.stroke


def _is_weak(point: Point) -> bool:
    """Whether the control air hardly moves the valve."""
    force, spring = _forces(point)
    return force < max(MIN_FORCE * spring, MIN_GAUGE * point.machine.valve.piston_area)


def _control_force(point: Point) -> Iterator[str]:
    force, spring = _forces(point)
    if point.machine.engine.intake == EPV and _is_weak(point):
        yield (
            f"the control air hardly moves the valve: {three(force)} N of pressure against {three(spring)} N of "
            "springs at the stop; raise supply.control_pressure, or take a softer spring or a larger piston"
        )


def _supply(point: Point) -> Iterator[str]:
    supply, ambient = point.machine.supply, point.machine.ambient
    if supply.pressure <= 1.05 * ambient.pressure:
        yield (
            f"the supply at {supply.pressure / 1e6:.4g} MPa abs is hardly above the surroundings at "
            f"{ambient.pressure / 1e6:.4g} MPa abs: the engine has nothing to work with; raise supply.pressure"
        )


def _piston_speed(point: Point) -> Iterator[str]:
    speed = point.machine.engine.stroke * point.speed / pi
    if speed > MAX_PISTON_SPEED:
        yield (
            f"the engine's piston moves at {three(speed)} m/s in the mean at {point.rpm:.0f} r/min, and few engines "
            f"exceed {MAX_PISTON_SPEED:g} m/s: lower the rated speed or the stroke"
        )


def _shape(point: Point) -> Iterator[str]:
    shape = point.machine.engine.stroke / point.machine.engine.bore
    if not SHAPES[0] <= shape <= SHAPES[1]:
        yield f"the engine's stroke is {three(shape)} of its bore, and 0.8 to 1.2 are usual: is one of them mistyped?"


def _clearance(point: Point) -> Iterator[str]:
    engine = point.machine.engine
    height = engine.stroke / (engine.compression_ratio - 1.0)
    if height < MIN_CLEARANCE:
        yield (
            f"a compression ratio of {engine.compression_ratio:g} leaves {1e3 * height:.2g} mm above the piston: give "
            f"{three(1.0 + engine.stroke / MIN_CLEARANCE)} at most"
        )


def _sizes(point: Point) -> Iterator[str]:
    diameter = sqrt(4.0 * point.machine.valve.piston_area / pi)
    if point.machine.engine.intake == EPV and diameter > point.machine.engine.bore:
        yield (
            f"the valve's piston, {three(1e3 * diameter)} mm, is larger than the cylinder's bore, "
            f"{three(1e3 * point.machine.engine.bore)} mm: its control air may cost more than the engine gives"
        )


CHECKS: tuple[Callable[[Point], Iterator[str]], ...] = (
    _supply,
    _control_force,
    _limit,
    _lateness,
    _choked_groove,
    _girth,
    _long_stroke,
    _sizes,
    _shape,
    _clearance,
    _piston_speed,
)
"""What may be odd, one check each, the gravest first."""


def find_oddities(machine: Machine, rated_speed: float) -> list[str]:
    """Find what is implausible about a machine at its rated speed [rad/s]: texts with numbers and what to change.

    >>> find_oddities(Machine(), 1000.0 * RPM)
    []
    >>> print(find_oddities(Machine(), 4500.0 * RPM)[0][:75])
    the intake valve keeps its window of 75 deg up to about 1070 r/min, and the
    """
    point = Point(machine, rated_speed)
    return [text for check in CHECKS for text in check(point)]
