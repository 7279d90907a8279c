"""Units of crank angles, which are radians inside."""

from math import pi

DEGREE = pi / 180.0
"""A degree [rad]."""
TURN = 2.0 * pi
"""A turn of the crank [rad]."""
