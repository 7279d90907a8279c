"""Cams: the window in which a cam opens a valve, and the cam of the intake in place of the electro-pneumatic valve."""

from collections.abc import Iterator
from math import acos, cos, isnan, nan, pi
from typing import Annotated, NamedTuple, Protocol

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.kernel import kernel
from apesim.quantities import NO_CURVE, Curve, Quantity
from apesim.valve.groove import piece_line, piece_of

MAX_ROWS = 2000
"""Most rows of a cam's lift curve: every row ends a step of the march, so more rows cost time only."""
MAX_LIFT = 0.1
"""Highest lift of a cam [m]; the upper end of the range of `Cam.lift`."""


class Window(Protocol):
    """Angles between which a cam opens a valve, with a flank at each end."""

    @property
    def opens(self) -> float:
        """Angle at which the opening flank begins [rad]."""

    @property
    def closes(self) -> float:
        """Angle at which the closing flank ends [rad]."""

    @property
    def flank(self) -> float:
        """Angle that each flank takes [rad]."""


def window_faults(window: Window) -> Iterator[tuple[str, str, str]]:
    """Find what is wrong with a window that a cam opens, beyond the ranges of its single keys: key, wrong, right.

    >>> list(window_faults(Cam()))
    []
    >>> list(window_faults(Cam(opens=1.0, closes=1.0)))
    [('closes', 'is the angle at which it opens', 'an angle after it')]
    """
    duration = (window.closes - window.opens) % TURN
    if window.opens == window.closes:
        yield "closes", "is the angle at which it opens", "an angle after it"
    elif 2.0 * window.flank > duration * (1.0 + 1e-12):
        yield "flank", "two flanks are longer than the window", f"at most {duration / 2.0 / DEGREE:g} deg"


def lift_curve_faults(curve: np.ndarray) -> Iterator[tuple[str, str, str]]:
    """Find what is wrong with the lift curve of a cam, beyond the range of its single values: key, wrong, right.

    `curve` (n, 2) has crank angle [rad], ascending, and lift [m].

    >>> list(lift_curve_faults(np.array([[0.0, 0.0], [1.0, 9e-3], [2.0, 0.0]])))
    []
    >>> [(key, wrong, right)] = lift_curve_faults(np.array([[0.0, 0.0], [1.0, 9e-3], [2.0, 1e-3]]))
    >>> wrong
    'does not start and end closed'
    """
    angle, lift = curve.T
    if len(curve) > MAX_ROWS:
        yield "lift_curve", f"has {len(curve)} rows", f"at most {MAX_ROWS}"
    if angle[0] < -TURN or angle[-1] > 2.0 * TURN or angle[-1] - angle[0] > TURN * (1.0 + 1e-12):
        yield "lift_curve", "does not fit into a turn", "less than 360 deg from first to last row, from -360 to 720 deg"
    if lift[0] != 0.0 or lift[-1] != 0.0 or lift.min() < 0.0:
        yield "lift_curve", "does not start and end closed", "lift 0 in the first and in the last row, nowhere below 0"
    if not 0.0 < lift.max() <= MAX_LIFT:
        peak = f"lifts to {lift.max() * 1e3:g} mm"
        yield "lift_curve", peak, f"more than 0 and at most {MAX_LIFT * 1e3:g} mm"


class Cam(NamedTuple):
    """Cam of the intake, in place of the electro-pneumatic valve (intake = "cam"); it opens the same groove."""

    opens: Annotated[float, Quantity("deg", -360, 360, "chosen: the intended opening")] = -5.0 * DEGREE
    closes: Annotated[float, Quantity("deg", -360, 720, "chosen: the intended closing")] = 70.0 * DEGREE
    lift: Annotated[
        float, Quantity("mm", 0.01, 100, "of the cam's highest point", text="the valve's stroke", optional=True)
    ] = nan
    flank: Annotated[float, Quantity("deg", 0.1, 180, "chosen; raised cosine, inside the window")] = 25.0 * DEGREE
    lift_curve: Annotated[
        np.ndarray,
        Curve(
            ("crank_angle [deg]", "lift [mm]"),
            "measured, linear in between and closed outside, in place of all four above; not given: as they have it",
        ),
    ] = NO_CURVE

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the cam, beyond the ranges of its single keys: key, wrong, right."""
        return lift_curve_faults(self.lift_curve) if len(self.lift_curve) else window_faults(self)

    def overruled(self) -> Iterator[tuple[str, str]]:
        """Find the keys that another key makes void, and why they are not used.

        >>> list(Cam().overruled())
        []
        >>> cam = Cam(lift_curve=np.array([[0.0, 0.0], [1.0, 9e-3], [2.0, 0.0]]))
        >>> [key for key, reason in cam.overruled()]
        ['opens', 'closes', 'lift', 'flank']
        """
        if len(self.lift_curve):
            yield from ((key, ".lift_curve is given") for key in ("opens", "closes", "lift", "flank"))

    def resolve_lift(self, stroke: float) -> "Cam":
        """Return the cam with the lift that it has in a machine: its own, or else the valve's `stroke` [m]."""
        return self._replace(lift=stroke) if isnan(self.lift) else self


@kernel
def within_turn(angle: float) -> float:
    """Bring an angle [rad] into the turn from 0 to 2 pi, ``phi - 2 pi floor(phi/(2 pi))``."""
    # The remainder operator gives the same, and takes several times as long.
    return angle - np.floor(angle / TURN) * TURN


@kernel
def raised_cosine(angle: float, opens: float, closes: float, flank: float) -> float:
    """Share of the full opening that a cam's window gives at a crank angle.

    ``x = (1 - cos(pi d/f))/2`` on a flank, with the angle d from the near end of the window and the flank's angle f;
    1 between the flanks, 0 outside the window. This shape is chosen; lift and slope are continuous.

    Parameters
    ----------
    angle : float
        Crank angle [rad].
    opens, closes : float
        Ends of the window [rad]; the window repeats every turn.
    flank : float
        Angle that each flank takes, inside the window [rad]; at most half of the window.

    Returns
    -------
    float
        Share of the full opening, from 0 to 1.

    Examples
    --------
    Half of the lift is reached in the middle of a flank, the full lift at its end:

    >>> [round(raised_cosine(angle, 0.0, 2.0, 0.4), 9) for angle in (-0.1, 0.2, 0.4, 1.0, 1.8)]
    [0.0, 0.5, 1.0, 1.0, 0.5]
    """
    duration = within_turn(closes - opens)
    since = within_turn(angle - opens)
    if since >= duration:
        return 0.0
    near = min(since, duration - since)
    if near >= flank:
        return 1.0
    return 0.5 * (1.0 - cos(pi * near / flank))


def window_corners(window: Window) -> np.ndarray:
    """Find the angles [rad] at which the opening flank of a window begins and ends, then those of the closing flank."""
    return np.array([window.opens, window.opens + window.flank, window.closes - window.flank, window.closes])


def angle_to_lift(cam: Cam, lift: float) -> float:
    """Angle from the foot of a cam's flank to the point where the cam has a given lift.

    ``d = (f/pi) arccos(1 - 2 L/L_max)``, the inverse of `raised_cosine` on a flank of the angle f.

    L_max is the cam's highest lift. The shape is chosen.

    Parameters
    ----------
    cam : Cam
        Cam with raised-cosine flanks and a lift; a lift curve is not used.
    lift : float
        Lift L [m].

    Returns
    -------
    float
        Angle [rad]; NaN where the cam does not lift beyond the given lift, or the lift is below 0.

    Examples
    --------
    >>> round(angle_to_lift(Cam(lift=9e-3, flank=0.4), 4.5e-3), 9)
    0.2
    >>> angle_to_lift(Cam(lift=9e-3), 9e-3)
    nan
    """
    return cam.flank / pi * acos(1.0 - 2.0 * lift / cam.lift) if 0.0 <= lift < cam.lift else nan


@kernel
def lift_line(curve: np.ndarray, angle: float) -> tuple[float, float]:
    """Line of a cam's lift over the crank angle, on the piece of its curve that an angle [rad] lies in.

    Returns its lift at crank angle 0 [m] and its slope [m/rad]. `curve` (n, 2) has crank angle [rad] and lift [m], 0 in
    the first and last row; it repeats every turn. `angle` must not lie on a row of it.

    A cam that lifts 8 mm over the first radian, one turn later:

    >>> curve = np.array([[0.0, 0.0], [1.0, 8e-3], [2.0, 0.0]])
    >>> lift, slope = lift_line(curve, TURN + 0.25)
    >>> print(round((lift + slope * (TURN + 0.25)) * 1e3, 9), "mm,", round(slope * 1e3, 9), "mm/rad")
    2.0 mm, 8.0 mm/rad
    """
    since = angle - curve[0, 0]
    turns = since - within_turn(since)
    lift, slope, _, _ = piece_line(curve, piece_of(curve, angle - turns))
    return lift - slope * turns, slope


def lift_crossings(curve: np.ndarray, lift: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the angles [rad] at which a cam's curve rises through a lift [m], and those at which it falls through it.

    Both are ascending. `curve` (n, 2) has crank angle [rad], ascending, and lift [m]; it is linear between its rows.
    """
    above = curve[:, 1] > lift

    def crossings(pieces: np.ndarray) -> np.ndarray:
        (angle, low), (angle_after, high) = curve[:-1][pieces].T, curve[1:][pieces].T
        return angle + (lift - low) / (high - low) * (angle_after - angle)

    return crossings(above[1:] & ~above[:-1]), crossings(above[:-1] & ~above[1:])


def cam_angles(cam: Cam, lap: float) -> tuple[float, float, float, float, float]:
    """Find the angles [rad] at which a cam opens and closes the groove, and its highest lift [m].

    Returns where the lift rises and falls through the lap (NaN: never), where it reaches its peak and zero again, and
    the peak. `lap` is the lift at which the groove begins to open [m].
    """
    curve = cam.lift_curve
    if not len(curve):
        from_foot = angle_to_lift(cam, lap)
        return cam.opens + from_foot, cam.closes - from_foot, cam.opens + cam.flank, cam.closes, cam.lift
    rises, falls = lift_crossings(curve, lap)
    opens = rises[0] if len(rises) else nan
    closes = falls[falls > opens][0] if len(rises) else nan
    angle, lift = curve.T
    return opens, closes, angle[np.argmax(lift)], angle[np.flatnonzero(lift)[-1] + 1], lift.max()


def cam_corners(cam: Cam, knots: np.ndarray) -> np.ndarray:
    """Find the angles at which the groove's area under a cam has a corner, where a step of the march has to end.

    These (n,) [rad], in no order, are the ends of the window and of its flanks, or the rows of a lift curve, and the
    crossings of `knots` (j,): the lifts at which the groove's table of areas has a row [m].
    """
    if len(cam.lift_curve):
        return np.concatenate(
            (cam.lift_curve[:, 0], *(side for knot in knots for side in lift_crossings(cam.lift_curve, knot)))
        )
    passed = knots[(knots > 0.0) & (knots < cam.lift)]
    from_foot = np.array([angle_to_lift(cam, knot) for knot in passed])
    return np.concatenate((window_corners(cam), cam.opens + from_foot, cam.closes - from_foot))
