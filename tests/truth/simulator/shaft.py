"""The shaft: inertia, friction that is higher near rest, a load, and what holds the crank at rest; SI, angles in rad.

The direction of turning, 1, -1 or 0, is given rather than read off the speed: so friction is smooth up to the instant
at which the crank stops, and beyond.
"""

from math import pi
from typing import NamedTuple

import numpy as np

from .crank import TURN

BEYOND_ROUNDING = 1e-12
"""A torque beyond what holds the crank by less is none [N m], nor is a speed below it a motion [rad/s]."""


class Shaft(NamedTuple):
    """What turns, and how much harder it is to turn near rest."""

    inertia: float = 0.1
    """[kg m2]"""
    breakaway_factor: float = 2.0
    """Friction at rest over that of Chen and Flynn."""
    breakaway_speed: float = 60.0 * pi / 30.0
    """From which on friction is that of Chen and Flynn [rad/s]."""


class Load(NamedTuple):
    """A brake, which opposes motion, or a hoist, whose constant torque pulls backwards whatever the speed."""

    constant: float = 0.0
    """[N m]"""
    proportional: float = 0.0
    """[N m s]"""
    quadratic: float = 0.0
    """[N m s2]"""
    table: tuple = ()
    """Pairs of speed [rad/s] and further torque [N m], linear between them."""
    hoist: bool = False


def friction_torque(shaft, engines, peaks, speed):
    """Torque that opposes motion, of all cylinders with their peak pressures [Pa abs], at a speed [N m]."""
    share = min(1.0, abs(speed) / shaft.breakaway_speed) if shaft.breakaway_speed > 0.0 else 1.0
    higher = 1.0 + (shaft.breakaway_factor - 1.0) * (1.0 - share**2) ** 2
    total = 0.0
    for engine, peak in zip(engines, peaks, strict=True):
        constant, on_peak, on_speed, on_square = engine.friction
        piston_speed = engine.stroke * speed / pi
        pressure = constant + on_peak * peak + on_speed * piston_speed + on_square * piston_speed**2
        total += pressure * 0.25 * pi * engine.bore**2 * engine.stroke / TURN
    return higher * total


def from_table(load, speed):
    """Torque of the load's table at a speed [N m]."""
    return float(np.interp(speed, *zip(*load.table, strict=True))) if load.table else 0.0


def load_torque(load, direction, speed):
    """Torque against forward motion, at a speed in the direction of turning [N m]."""
    if load.hoist:
        return load.constant
    if not direction:
        return 0.0
    own = load.constant + load.proportional * speed + load.quadratic * speed**2
    return direction * (own + from_table(load, speed))


def pull_and_hold(shaft, load, engines, peaks, gas_torque):
    """Torque that would turn a crank at rest, and the most that friction and a brake hold [N m]."""
    hold = friction_torque(shaft, engines, peaks, 0.0)
    if load.hoist:
        return gas_torque - load.constant, hold
    return gas_torque, hold + load.constant + from_table(load, 0.0)
