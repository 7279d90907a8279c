"""Several cylinders on one shaft and one receiver: what they are, how their states are ordered, and what comes out.

The states of each cylinder follow one another, those of shaft and receiver stand behind them; SI, angles in rad.
"""

from enum import StrEnum
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .crank import cylinder_volume
from .engine import CYLINDER_PRESSURE, RECEIVER_PRESSURE, RECEIVER_TEMPERATURE, Engine, resting
from .shaft import Load, Shaft

WORK, ENGINE_AIR, CONTROL_AIR = range(8, 11)
"""Last states of a cylinder's block, which is that of `truth.simulator.engine` without the receiver's two states."""
ANGLE, SPEED, PRESSURE, TEMPERATURE, FRICTION_WORK, LOAD_WORK = range(-6, 0)
"""Shared states, behind those of all cylinders: shaft, receiver, and the work that friction and load have taken."""
TOLERANCES = [1e-11, 1e-10, 1e-3, 1e-7, 1e-7, 1e-7]
"""Absolute tolerances of the shared states."""


class Assembly(NamedTuple):
    """Cylinders, shaft and load; receiver and feed are those of the first cylinder."""

    engines: tuple = (Engine(),)
    phases: tuple = (0.0,)
    """Shaft angles at which the cylinders are at their own 0 [rad]."""
    shaft: Shaft = Shaft()
    loads: tuple = ((0.0, Load()),)
    """Pairs of the instant from which on a load holds [s], 0 the first, and the load."""


def own_resting(engine):
    """States of a cylinder at rest, without the receiver's, and their tolerances."""
    both = resting(engine)
    return [np.delete(values, [RECEIVER_PRESSURE, RECEIVER_TEMPERATURE]) for values in both]


def blocks_of(assembly):
    """Indices at which each cylinder's states begin and end."""
    ends = np.cumsum([0, *(len(own_resting(engine)[0]) for engine in assembly.engines)]).tolist()
    return list(pairwise(ends))


class Kind(StrEnum):
    """What happens."""

    FIRST_MOTION = "first motion"
    MOTION = "motion"
    SPEED_ZERO = "speed zero"
    AT_REST = "at rest"
    OPENS = "lift rises through the lap"
    CLOSES = "lift falls through the lap"
    PASSAGE = "own 0"
    TARGET = "target speed"
    TURNED = "all turns made"
    HELD = "held"
    TIME = "time is up"


ENDINGS = {Kind.TARGET, Kind.TURNED, Kind.HELD, Kind.TIME}


class Event(NamedTuple):
    """Something that happens at an instant."""

    kind: Kind
    time: float
    """[s]"""
    cylinder: int | None
    """None: the whole engine."""
    states: np.ndarray
    """States at that instant."""

    @property
    def angle(self):
        """Angle of the shaft [rad]."""
        return float(self.states[ANGLE])


class Totals(NamedTuple):
    """What is read off states; floats, or arrays where the states are those of several instants."""

    angle: float
    """[rad]"""
    speed: float
    """[rad/s]"""
    work: float
    """Work of the gas on all pistons, above the ambient's [J]; so are those that friction and load have taken."""
    friction_work: float
    load_work: float
    engine_air: float
    """Mass through all grooves [kg]."""
    control_air: float
    """[kg]"""


class Revolution(NamedTuple):
    """A revolution, and what has passed in it."""

    begins: float
    """[s]"""
    duration: float
    """[s]"""
    totals: Totals


class Transient(NamedTuple):
    """A march."""

    assembly: Assembly
    events: tuple
    """Ascending in time; the last is the ending."""
    pieces: tuple
    """Start and dense solution of each smooth stretch."""

    @property
    def ending(self):
        """Why the march ended, and when."""
        return self.events[-1]

    def of_kind(self, *kinds):
        """Events of some kinds."""
        return [one for one in self.events if one.kind in kinds]

    def states(self, times):
        """States at times [s]; shape (states, n)."""
        starts = [start for start, _ in self.pieces]
        which = np.searchsorted(starts, times, side="right") - 1
        found = np.empty((len(self.ending.states), len(times)))
        for i in np.unique(which):
            found[:, which == i] = self.pieces[i][1](np.asarray(times)[which == i])
        return found

    def revolutions(self, cylinder=0):
        """Revolutions from one passage of a cylinder's own 0 to the next."""
        passages = [one for one in self.of_kind(Kind.PASSAGE) if one.cylinder == cylinder]
        for first, last in pairwise(passages):
            totals = zip(self.totals(first.states), self.totals(last.states), strict=True)
            yield Revolution(first.time, last.time - first.time, Totals(*(b - a for a, b in totals)))

    def gas_torque(self, states):
        """Torque of the gas on all pistons, above the ambient's, from states of several instants [N m]."""
        torque = np.zeros(states.shape[1])
        blocks, engines, phases, *_ = blocks_of(self.assembly), *self.assembly
        for (start, _), engine, phase in zip(blocks, engines, phases, strict=True):
            slopes = [cylinder_volume(engine, angle - phase)[1] for angle in states[ANGLE].tolist()]
            torque += (states[start + CYLINDER_PRESSURE] - engine.valve.ambient_pressure) * slopes
        return torque

    def totals(self, states):
        """What is read off states."""
        blocks = blocks_of(self.assembly)
        work, engine_air, control_air = (
            sum(states[start + name] for start, _ in blocks) for name in (WORK, ENGINE_AIR, CONTROL_AIR)
        )
        shaft = states[ANGLE], states[SPEED]
        return Totals(*shaft, work, states[FRICTION_WORK], states[LOAD_WORK], engine_air, control_air)
