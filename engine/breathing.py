"""What the cylinder breathes through: the intake's cam, the exhaust valve, and the receiver before the groove."""

from math import acos, cos, inf, nan, pi
from typing import Annotated, NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.quantities import Quantity

VOLUME_MOST = 1.0
"""Largest finite receiver; up to here a periodic state is found within 2e-6 [m3]."""
DEGREE = pi / 180.0
TURN = 2.0 * pi


def window_faults(window):
    """Faults of a window with flanks."""
    duration = (window.closes - window.opens) % TURN
    if window.opens == window.closes:
        yield "closes", "is the angle at which it opens", "an angle after it"
    elif 2.0 * window.flank > duration * (1.0 + 1e-12):
        yield "flank", "two flanks are longer than the window", f"at most {duration / 2.0 / DEGREE:g} deg"


class Cam(NamedTuple):
    """A cam in place of the electro-pneumatic valve (intake = "cam"), through the same groove."""

    opens: Annotated[float, Quantity("deg", -360, 360, "chosen: the intended opening")] = -5.0 * DEGREE
    closes: Annotated[float, Quantity("deg", -360, 720, "chosen: the intended closing")] = 70.0 * DEGREE
    lift: Annotated[float, Quantity("mm", 0.01, 100, "chosen: the valve's stroke")] = 9.0e-3
    flank: Annotated[float, Quantity("deg", 0.1, 180, "chosen; raised cosine, inside the window")] = 25.0 * DEGREE

    faults = window_faults


class Exhaust(NamedTuple):
    """The exhaust valve, driven by a cam."""

    effective_area: Annotated[float, Quantity("mm^2", 0.1, 10000, "chosen")] = 500.0e-6
    opens: Annotated[float, Quantity("deg", -360, 720, "chosen")] = 165.0 * DEGREE
    closes: Annotated[float, Quantity("deg", -360, 720, "chosen")] = 340.0 * DEGREE
    flank: Annotated[float, Quantity("deg", 0.1, 180, "chosen; raised cosine, inside the window")] = 25.0 * DEGREE

    faults = window_faults


class Receiver(NamedTuple):
    """The vessel between regulator and groove."""

    volume: Annotated[
        float, Quantity("L", 0.01, inf, 'chosen; "inf": intake pressure is constant, there is no receiver')
    ] = 1.0e-3
    feed_area: Annotated[float, Quantity("mm^2", 0.1, 10000, "chosen; from the regulator, effective")] = 200.0e-6

    def faults(self):
        """Faults that the range does not show."""
        if VOLUME_MOST < self.volume < inf:
            wrong = "is so large that its pressure takes millions of cycles to settle"
            yield "volume", wrong, f'at most {VOLUME_MOST * 1e3:g} L, or "inf"'


@kernel
def within_turn(angle):
    """An angle brought into 0...2 pi [rad]; the remainder operator is several times slower."""
    return angle - np.floor(angle / TURN) * TURN


@kernel
def raised_cosine(angle, opens, closes, flank):
    """Share of the full opening, 0...1, of a window with raised-cosine flanks inside it.

    Parameters
    ----------
    angle, opens, closes, flank : float
        [rad]; the window repeats every turn.

    Returns
    -------
    float
    """
    duration = within_turn(closes - opens)
    since = within_turn(angle - opens)
    if since >= duration:
        return 0.0
    near = min(since, duration - since)
    if near >= flank:
        return 1.0
    return 0.5 * (1.0 - cos(pi * near / flank))


def window_corners(window):
    """Angles at which a window or a flank of it begins or ends [rad]."""
    return np.array([window.opens, window.opens + window.flank, window.closes - window.flank, window.closes])


def angle_to_lift(cam, lift):
    """Angle from the foot of a cam's flank to a lift [rad]; NaN where the cam does not lift beyond it."""
    return cam.flank / pi * acos(1.0 - 2.0 * lift / cam.lift) if 0.0 <= lift < cam.lift else nan


def cam_corners(cam, knots):
    """Angles at which a cam's window, a flank, or the lift's passing a knot of the groove's table begins or ends.

    Parameters
    ----------
    cam : Cam
    knots : (j,) float array
        Lifts [m].

    Returns
    -------
    float array
        [rad]
    """
    passed = knots[(knots > 0.0) & (knots < cam.lift)]
    sides = np.array([angle_to_lift(cam, knot) for knot in passed])
    return np.concatenate((window_corners(cam), cam.opens + sides, cam.closes - sides))
