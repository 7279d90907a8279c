"""The engine's periodic state, by cycles from rest, and what is read off it."""

from math import inf, nan, pi
from typing import NamedTuple

import numpy as np

from .crank import TURN
from .engine import (
    CONTROL_AIR,
    CYLINDER_PRESSURE,
    ENGINE_AIR,
    STATES,
    WORK,
    Engine,
    corners_of_cycle,
    rates_of,
    resting,
)
from .march import RELATIVE, Contact, March, march
from .piston import CLOSED, OPEN
from .valve import LONGEST, POSITION

DISTANCE = 3e-7
"""To the periodic state, of a state that counts as periodic, relative to its size."""
SLOWEST = 0.99
"""Ratio of a change to the one before that is still believed; the solver's noise, too, stands at about one."""
USUAL = 0.9
"""Share where the start is near and the first changes say nothing of it."""
MAX_CYCLES = 400
PLAIN, MEMORY = 3, 5
"""Cycles at the start that are followed as they come, as the first two may change by chance in a ratio that tells
nothing; how many before the last ones then point the way."""
SAMPLES = 7201
"""Samples of the last cycle, for the highest pressure and lift."""


class Periodic(NamedTuple):
    """The last of a row of cycles."""

    engine: Engine
    speed: float
    """[rad/s]"""
    cycles: int
    change: float
    """Largest of a state over the last cycle, relative."""
    distance: float
    """Left to the periodic state, if changes go on shrinking as they did."""
    converged: bool
    march: March
    """Over crank angle, from the energising on."""


def periodic(engine, speed, max_cycles=MAX_CYCLES, start=None, near=DISTANCE, relative=RELATIVE):
    """Cycles from rest, each from where the last ones point to, until what is still to come adds up to nothing.

    Parameters
    ----------
    engine : Engine
    speed : float
        [rad/s]
    max_cycles : int
    start : Periodic, optional
        Of a like engine, to begin with in place of rest.
    near : float
        Distance to the periodic state that is let pass, see `DISTANCE`.
    relative : float
        The solver's tolerance.

    Returns
    -------
    Periodic
    """
    valve = engine.valve
    (y, tolerances), phase = resting(engine), CLOSED
    size = np.maximum(np.abs(y), 1.0)
    size[POSITION] = valve.stroke
    if start and len(start.march.y) == len(y):
        y, phase = start.march.y.copy(), start.march.phase
        y[WORK:STATES] = 0.0
    rates, push = rates_of(engine, speed)
    corners, levels = corners_of_cycle(engine, speed), (valve.stroke - engine.lap,)
    piston, longest = push if engine.intake == "epv" else None, LONGEST * speed
    tried, reached, before, ratio = [], [], 0.0, USUAL
    plain = 1 if start else PLAIN
    for cycle in range(1, max_cycles + 1):
        found = march(valve, rates, piston, corners, engine.energise, y, phase, tolerances, longest, levels, relative)
        end = found.y.copy()
        end[WORK:STATES] = 0.0
        change = float((np.abs(end - y) / size).max())
        if cycle <= plain + 1 and not start:
            ratio = change / before if change < SLOWEST * before else SLOWEST
        distance = change * ratio / (1.0 - ratio)  # the rest of a geometric series
        converged = distance < near and found.phase == phase and (cycle > plain or bool(start))
        run = Periodic(engine, speed, cycle, change, distance, converged, found)
        if run.converged:
            break
        if found.phase != phase or change > 2.0 * before:
            tried, reached = [], []
        tried, reached = [*tried[-MEMORY:], y / size], [*reached[-MEMORY:], end / size]
        before, phase = change, found.phase
        y = extrapolated(tried, reached) * size if cycle > plain and phase in (OPEN, CLOSED) else end
    return run


def extrapolated(tried, reached):
    """State to which a map leads that took the points tried to those reached: Anderson's mixing."""
    tried, reached = np.array(tried), np.array(reached)
    left = reached - tried
    shares = np.linalg.lstsq(np.diff(left, axis=0).T, left[-1], rcond=1e-6)[0] if len(left) > 1 else np.zeros(0)
    return reached[-1] - shares @ np.diff(reached, axis=0)


def results(run):
    """Work, air, valve angles and peaks of a periodic cycle; SI, angles in rad after the TDC of the same revolution.

    Returns
    -------
    dict
        ``opens`` and ``closes``: the lift rises and then falls through the lap; ``full_open`` and ``closed``: contacts.
        NaN: it never comes to it.
    """
    engine, found = run.engine, run.march
    angles = np.linspace(engine.energise, engine.energise + TURN, SAMPLES)
    states = found.states(np.union1d(angles, [start for start, _ in found.pieces]))
    peak = float(states[CYLINDER_PRESSURE].max())
    opening = first(found.contacts, engine.energise, lambda one: one.stop == OPEN)
    closing = first(found.contacts, engine.release, lambda one: one.stop == CLOSED)
    opens = first(found.crossings, engine.energise, lambda one: one.direction < 0).at
    piston_speed = engine.stroke * run.speed / pi
    constant, on_peak, on_speed, on_square = engine.friction
    lost = constant + on_peak * peak + on_speed * piston_speed + on_square * piston_speed**2
    work = float(found.y[WORK])
    return {
        "indicated_torque": work / TURN,
        "brake_torque": (work - lost * 0.25 * pi * engine.bore**2 * engine.stroke) / TURN,
        "engine_air": float(found.y[ENGINE_AIR]),
        "control_air": float(found.y[CONTROL_AIR]),
        "opens": opens,
        "closes": first(found.crossings, opens, lambda one: one.direction > 0).at,
        "full_open": opening.at,
        "closed": closing.at,
        "opening_seating_speed": opening.speed,
        "closing_seating_speed": closing.speed,
        "peak_lift": float(engine.valve.stroke - states[POSITION].min()),
        "peak_cylinder_pressure": peak,
    }


def first(noted, after, wanted):
    """The first of a periodic cycle's contacts or crossings that is wanted, at or after an angle."""
    turned = [one._replace(at=one.at + turn) for turn in (0.0, TURN) for one in noted if wanted(one)]
    return next((one for one in turned if one.at >= after), Contact(nan, "", nan))


def opening_and_closing(engine, speed, energise, release):
    """Angles at which the valve truly opens and closes at its periodic state.

    Parameters
    ----------
    engine : Engine
    speed : float
        [rad/s]
    energise, release : float
        Crank angles of the command [rad].

    Returns
    -------
    opens, closes : float
        Crank angles at which the lift rises and then falls through the lap [rad]; NaN: it never does, or the state
        does not repeat.
    """
    engine = engine._replace(energise=energise, release=release)
    if not (engine.control_from_receiver or engine.valve.terms):
        engine = engine._replace(receiver_volume=inf)  # it does not act on the valve, and settles slowly
    run = periodic(engine, speed)
    found = results(run)
    return (found["opens"], found["closes"]) if run.converged else (nan, nan)
