"""Units of crank angles: angles are in radians inside, in degrees at the border."""

from math import pi

DEGREE = pi / 180.0
"""One degree [rad]."""
TURN = 2.0 * pi
"""One turn of the crank [rad]."""
RPM = TURN / 60.0
"""One revolution per minute [rad/s]."""
