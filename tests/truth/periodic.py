"""The engine's periodic state, by plain cycles from rest, and what is read off it."""

from math import inf, nan, pi
from typing import NamedTuple

import numpy as np

from truth.crank import TURN
from truth.engine import (
    CONTROL_AIR,
    CYLINDER_PRESSURE,
    ENGINE_AIR,
    TOLERANCES,
    WORK,
    Engine,
    corners_of_cycle,
    engine_supply,
    now_of,
    rates_of,
)
from truth.march import Contact, March, march
from truth.piston import CLOSED, OPEN
from truth.valve import LONGEST, POSITION, closed_at_rest, net_force, sums_of

DISTANCE = 3e-7
"""To the periodic state, of a state that counts as periodic, relative to its size."""
SLOWEST = 0.99
"""Ratio of a change to the one before that is still believed; the solver's noise, too, stands at about one."""
CYCLES_MOST = 400
SAMPLES = 7201
"""Of the last cycle, for the highest pressure and lift."""


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


def periodic(engine, speed, cycles_most=CYCLES_MOST):
    """Plain cycles from rest, until the changes that are still to come add up to nothing.

    Parameters
    ----------
    engine : Engine
    speed : float
        [rad/s]
    cycles_most : int

    Returns
    -------
    Periodic
    """
    valve, supply = engine.valve, engine_supply(engine)
    ambient = valve.ambient_pressure, valve.ambient_temperature
    control = supply if engine.control_from_receiver else (valve.supply_pressure, valve.supply_temperature)
    y, phase = np.array([*closed_at_rest(valve, control), *ambient, *supply, 0.0, 0.0, 0.0]), CLOSED
    size = np.array([valve.stroke, 1.0, *control, *control, *supply, *supply])
    rates, corners = rates_of(engine, speed), corners_of_cycle(engine, speed)

    def force(angle, y):
        now = now_of(engine, angle, y)
        return net_force(valve, now, sums_of(valve.terms, now))

    piston = force if engine.intake == "epv" else None
    levels = (valve.stroke - engine.lap,)
    before = 0.0
    for cycle in range(1, cycles_most + 1):
        found = march(valve, rates, piston, corners, engine.energise, y, phase, TOLERANCES, LONGEST * speed, levels)
        change = float((np.abs(found.y - y)[:WORK] / size).max())
        ratio = change / before if change < SLOWEST * before else SLOWEST
        distance = change * ratio / (1.0 - ratio)  # the rest of a geometric series
        run = Periodic(engine, speed, cycle, change, distance, distance < DISTANCE and found.phase == phase, found)
        if run.converged:
            break
        before = change
        y, phase = found.y.copy(), found.phase
        y[WORK:] = 0.0
    return run


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
    """Where the valve truly opens and closes at its periodic state.

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
