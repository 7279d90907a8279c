"""What the cylinder breathes through: the intake's cam, the exhaust valve, and the receiver before the groove."""

from math import acos, cos, inf, nan, pi
from typing import Annotated, NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.kernel import kernel
from apesim.quantities import NO_CURVE, Curve, Quantity
from apesim.valve.groove import piece_line, piece_of

VOLUME_MOST = 1.0
"""Largest finite receiver; up to here a periodic state is found within 2e-6 [m3]."""
ROWS_MOST = 2000
"""Of a cam's lift curve: every row ends a step of the march."""
LIFT_MOST = 0.1
"""Of a cam [m]."""


def window_faults(window):
    """Faults of a window with flanks."""
    duration = (window.closes - window.opens) % TURN
    if window.opens == window.closes:
        yield "closes", "is the angle at which it opens", "an angle after it"
    elif 2.0 * window.flank > duration * (1.0 + 1e-12):
        yield "flank", "two flanks are longer than the window", f"at most {duration / 2.0 / DEGREE:g} deg"


def lift_curve_faults(curve):
    """Faults of a cam's lift curve."""
    angle, lift = curve.T
    if len(curve) > ROWS_MOST:
        yield "lift_curve", f"has {len(curve)} rows", f"at most {ROWS_MOST}"
    if angle[0] < -TURN or angle[-1] > 2.0 * TURN or angle[-1] - angle[0] > TURN * (1.0 + 1e-12):
        yield "lift_curve", "does not fit into a turn", "less than 360 deg from first to last row, from -360 to 720 deg"
    if lift[0] != 0.0 or lift[-1] != 0.0 or lift.min() < 0.0:
        yield "lift_curve", "does not start and end closed", "lift 0 in the first and in the last row, nowhere below 0"
    if not 0.0 < lift.max() <= LIFT_MOST:
        peak = f"lifts to {lift.max() * 1e3:g} mm"
        yield "lift_curve", peak, f"more than 0 and at most {LIFT_MOST * 1e3:g} mm"


class Cam(NamedTuple):
    """A cam in place of the electro-pneumatic valve (intake = "cam"), through the same groove."""

    opens: Annotated[float, Quantity("deg", -360, 360, "chosen: the intended opening")] = -5.0 * DEGREE
    closes: Annotated[float, Quantity("deg", -360, 720, "chosen: the intended closing")] = 70.0 * DEGREE
    lift: Annotated[float, Quantity("mm", 0.01, 100, "chosen: the valve's stroke")] = 9.0e-3
    flank: Annotated[float, Quantity("deg", 0.1, 180, "chosen; raised cosine, inside the window")] = 25.0 * DEGREE
    lift_curve: Annotated[
        np.ndarray,
        Curve(
            ("crank_angle [deg]", "lift [mm]"),
            "measured, linear in between and closed outside, in place of all four above; not given: as they have it",
        ),
    ] = NO_CURVE

    def faults(self):
        """Faults that no single key shows."""
        return lift_curve_faults(self.lift_curve) if len(self.lift_curve) else window_faults(self)

    def overruled(self):
        """Keys that are not looked at, and by what."""
        if len(self.lift_curve):
            yield from ((key, "engine.cam.lift_curve is given") for key in ("opens", "closes", "lift", "flank"))


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


@kernel
def lift_line(curve, angle):
    """Lift on the piece of a cam's curve that an angle lies in, as a line over the angle.

    Parameters
    ----------
    curve : (n, 2) float array
        Crank angle [rad] and lift [m], 0 in the first and last row; it repeats every turn.
    angle : float
        [rad]

    Returns
    -------
    lift, slope : float
        At angle 0 [m], and per angle [m/rad].
    """
    since = angle - curve[0, 0]
    turns = since - within_turn(since)
    lift, slope, _, _ = piece_line(curve, piece_of(curve, angle - turns))
    return lift - slope * turns, slope


def lift_crossings(curve, lift):
    """Angles at which a cam's curve rises through a lift, and at which it falls through it [rad], ascending."""
    above = curve[:, 1] > lift

    def passing(pieces):
        (angle, low), (angle_after, high) = curve[:-1][pieces].T, curve[1:][pieces].T
        return angle + (lift - low) / (high - low) * (angle_after - angle)

    return passing(above[1:] & ~above[:-1]), passing(above[:-1] & ~above[1:])


def cam_angles(cam, lap):
    """Where a cam opens and closes.

    Parameters
    ----------
    cam : Cam
    lap : float
        Lift at which the groove begins to open [m].

    Returns
    -------
    opens, closes : float
        Angles at which the lift rises and falls through the lap [rad]; NaN where it never does.
    full_open, closed : float
        Angles at which the lift reaches its peak, and zero again [rad].
    peak : float
        [m]
    """
    curve = cam.lift_curve
    if not len(curve):
        aside = angle_to_lift(cam, lap)
        return cam.opens + aside, cam.closes - aside, cam.opens + cam.flank, cam.closes, cam.lift
    rises, falls = lift_crossings(curve, lap)
    opens = rises[0] if len(rises) else nan
    closes = falls[falls > opens][0] if len(rises) else nan
    angle, lift = curve.T
    return opens, closes, angle[np.argmax(lift)], angle[np.flatnonzero(lift)[-1] + 1], lift.max()


def cam_corners(cam, knots):
    """Angles at which a cam's window, flank or piece of its curve, or the lift's passing a knot of the groove's table
    begins or ends.

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
    if len(cam.lift_curve):
        return np.concatenate(
            (cam.lift_curve[:, 0], *(side for knot in knots for side in lift_crossings(cam.lift_curve, knot)))
        )
    passed = knots[(knots > 0.0) & (knots < cam.lift)]
    sides = np.array([angle_to_lift(cam, knot) for knot in passed])
    return np.concatenate((window_corners(cam), cam.opens + sides, cam.closes - sides))
