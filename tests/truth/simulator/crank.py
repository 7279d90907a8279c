"""The engine's clockwork: slider and crank, cams, and the area of the groove; angles in rad, 0 is crank pin up."""

from math import acos, asin, cos, pi, sin, sqrt

TURN = 2.0 * pi


def cylinder_volume(engine, angle):
    """Volume [m3] and its slope [m3/rad], by way of the angle that the rod makes with the cylinder's axis."""
    radius, rod = 0.5 * engine.stroke, engine.rod_length
    face = 0.25 * pi * engine.bore**2
    tilt = asin((radius * sin(angle) - engine.pin_offset) / rod)
    depth = sqrt((rod + radius) ** 2 - engine.pin_offset**2) - radius * cos(angle) - rod * cos(tilt)
    clearance = (1.0 + engine.clearance_error) * engine.stroke / (engine.compression_ratio - 1.0)
    volume = face * (clearance + depth)
    return volume, face * radius * sin(angle + tilt) / cos(tilt)


def opened(angle, window):
    """Share of full opening of a window (opens, closes, flank) with raised-cosine flanks inside it."""
    opens, closes, flank = window
    half = 0.5 * ((closes - opens) % TURN)
    off_middle = abs((angle - opens - half + pi) % TURN - pi)
    return sin(0.5 * pi * min(1.0, max(0.0, (half - off_middle) / flank))) ** 2


def corners_of(window, shares=()):
    """Angles at which a window or a flank begins or ends, and where it is open by the shares [rad]."""
    opens, closes, flank = window
    sides = [0.0, flank] + [flank / pi * acos(1.0 - 2.0 * share) for share in shares if 0.0 < share < 1.0]
    return [opens + side for side in sides] + [closes - side for side in sides]


def groove_area(engine, lift):
    """Effective area [m2]: a line from the lap to the valve's full lift, constant above; a taper bends it."""
    share = min(1.0, max(0.0, (lift - engine.lap) / (engine.valve.stroke - engine.lap)))
    return engine.groove_area * share * (1.0 + engine.taper * 4.0 * share * (1.0 - share))
