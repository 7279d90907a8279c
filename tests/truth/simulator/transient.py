"""Several cylinders on one shaft and one receiver, over time: the speed is a state, or is imposed.

Each cylinder is that of `truth.simulator.engine`. The solver is LSODA with root finding, which restarts at each corner
in time and wherever an end of a smooth stretch is met: a contact or start of a valve's piston, a lift that passes the
lap, a corner over the angle in either direction, speed zero, or a crank that breaks away. SI, angles in rad from crank
pin up. Imports nothing from the packages it judges.
"""

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from math import inf
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from . import valve as solenoids
from .assembly import (
    ANGLE,
    ENDINGS,
    PRESSURE,
    SPEED,
    TEMPERATURE,
    TOLERANCES,
    Event,
    Kind,
    Transient,
    blocks_of,
    own_resting,
)
from .crank import TURN, cylinder_volume
from .engine import CYLINDER_PRESSURE, RECEIVER_PRESSURE, breathe, engine_supply, now_of, receiver_rates
from .march import RELATIVE, event
from .piston import CLOSED, CLOSING, OPENING, POSITION, after, exits
from .shaft import BEYOND_ROUNDING, friction_torque, load_torque, pull_and_hold
from .turning import begins, is_energised, middle, passed_at, sector_of, turn_of

LONGEST = 0.5e-3
"""Step [s]."""
HELD_FOR = 0.25
"""A crank that is held for longer stays at rest [s]."""
GIVEN_UP = 60.0
"""[s]"""
MAX_AT_ONCE = 100
"""Stretches that may begin at one instant, to rounding: more go on for ever."""


class End(NamedTuple):
    """What ends a smooth stretch: a function of time and state that passes zero with a sign of its slope."""

    function: Callable
    slope: int
    follow: Callable
    """What follows, of time and state."""
    at_zero: bool = False
    """Whether it is past already where it is zero at the beginning."""

    def is_past(self, time, y):
        """Whether the stretch would begin beyond this end."""
        beyond = self.slope * self.function(time, y)
        return beyond > 0.0 or (self.at_zero and beyond == 0.0)


def zeros_of(imposed):
    """Times at which an imposed speed changes its sign between two of its pairs [s]."""
    return [a[0] - a[1] * (b[0] - a[0]) / (b[1] - a[1]) for a, b in pairwise(imposed) if a[1] * b[1] < 0.0]


def imposed_after(imposed, time):
    """Sign of an imposed speed just after an instant, the speed [rad/s], and its slope [rad/s2]."""
    times = sorted([*(at for at, _ in imposed), *zeros_of(imposed)])
    late = next((at for at in times if at > time + solenoids.APART), times[-1])
    times, speeds = zip(*imposed, strict=True)
    now, half, then = np.interp([time, 0.5 * (time + late), late], times, speeds).tolist()
    return int(np.sign(half)), now, (then - now) / (late - time)


class Marching:
    """A march under way: all that stays as it is through a smooth stretch, and changes at its end."""

    def __init__(self, assembly, angle, speed, imposed):
        self.assembly, self.imposed = assembly, imposed
        self.engines, self.phases = assembly.engines, assembly.phases
        self.blocks, self.turn = blocks_of(assembly), turn_of(assembly.engines, assembly.phases)
        self.sector, angle = sector_of(self.turn, angle)
        own = [own_resting(engine) for engine in self.engines]
        shaft = [angle, imposed[0][1] if imposed else speed, *engine_supply(self.engines[0]), 0.0, 0.0]
        self.y = np.concatenate([*(states for states, _ in own), shaft])
        self.tolerances = np.concatenate([*(tolerances for _, tolerances in own), TOLERANCES])
        self.time, self.direction, self.acceleration = 0.0, int(np.sign(speed)), 0.0
        self.load = assembly.loads[0][1]
        self.valve_phases = [CLOSED] * len(self.engines)
        self.lapped = [True] * len(self.engines)  # its lift is below the lap
        self.peaks = [float(self.y[start + CYLINDER_PRESSURE]) for start, _ in self.blocks]
        self.highest = list(self.peaks)  # since the last passage of its own 0
        self.energised = [False] * len(self.engines)
        self.edges = [[] for _ in self.engines]
        self.events, self.pieces = [], []
        self.switch(0.0)

    def note(self, kind, time, y, cylinder=None):
        """Keep an event."""
        self.events.append(Event(kind, time, cylinder, y.copy()))

    # what the equations say

    def here(self, number, time, own, shaft):
        """A cylinder's `Now`, its control air, the receiver's and the supply's, from lists of its and shared states."""
        engine = self.engines[number]
        fixed = engine.valve.supply_pressure, engine.valve.supply_temperature
        regulated = solenoids.supply_at(engine.valve, fixed, self.edges[number], time)
        y = [*own[:RECEIVER_PRESSURE], shaft[PRESSURE], shaft[TEMPERATURE], *own[RECEIVER_PRESSURE:]]
        return now_of(engine, shaft[ANGLE] - self.phases[number], y, regulated)

    def rates(self, time, y):
        """Rates of all states."""
        y = y.tolist()
        shaft, found, torque, taken = y[ANGLE:], [], 0.0, [0.0, 0.0]
        speed = shaft[SPEED]
        for number, (engine, (start, end)) in enumerate(zip(self.engines, self.blocks, strict=True)):
            now, control, before, supply = self.here(number, time, y[start:end], shaft)
            edges, valve = self.edges[number], engine.valve
            fractions = [solenoids.energised(valve, edges, delay, time) for delay in (valve.delay_a, valve.delay_b)]
            phase, position = self.valve_phases[number], self.intake_position(number, now.position)
            breath = breathe(engine, now, control, before, phase, fractions, speed, position)
            found += [*breath.motion, *breath.cylinder, breath.power, breath.groove, breath.drawn, *breath.added]
            torque += (now.cylinder[0] - valve.ambient_pressure) * now.slope
            taken[0] += breath.taken[0]
            taken[1] += breath.taken[1]
        forward = self.direction * speed
        lost = self.direction * friction_torque(self.assembly.shaft, self.engines, self.peaks, forward)
        braked = load_torque(self.load, self.direction, forward)
        acceleration = self.acceleration
        if self.direction and not self.imposed:
            acceleration = (torque - lost - braked) / self.assembly.shaft.inertia
        receiver = receiver_rates(self.engines[0], before, supply, taken)
        return [*found, speed, acceleration, *receiver, lost * speed, braked * speed]

    def intake_position(self, number, position):
        """Position by which the groove goes: closed up to the end of the stretch, and where the solver looks beyond."""
        return max(position, self.lap_position(number)) if self.lapped[number] else position

    def lap_position(self, number):
        """Position of a valve's piston where its lift is the lap [m]."""
        return self.engines[number].valve.stroke - self.engines[number].lap

    def push(self, number, time, view):
        """Push on a valve's piston, see `truth.simulator.piston.exits`; of the states from the cylinder's first on."""
        start, end = self.blocks[number]
        states = view.tolist()
        now = self.here(number, time, states[: end - start], states[ANGLE:])[0]
        return solenoids.push_of(self.engines[number].valve, now)

    def pull(self, y):
        """Torque that would turn the crank at rest, and the most that holds it [N m]."""
        torque = 0.0
        for engine, phase, (start, _) in zip(self.engines, self.phases, self.blocks, strict=True):
            over = y[start + CYLINDER_PRESSURE] - engine.valve.ambient_pressure
            torque += over * cylinder_volume(engine, y[ANGLE] - phase)[1]
        return pull_and_hold(self.assembly.shaft, self.load, self.engines, self.peaks, float(torque))

    # what ends a smooth stretch

    def ends(self, target, limit):
        """All that may end the stretch to come."""
        ends = []
        for number, phase in enumerate(self.valve_phases):
            if self.engines[number].intake == "epv":
                ends += self.valve_ends(number, phase)
        ahead = self.sector + (self.direction > 0)
        if self.direction:
            past = self.past(begins(self.turn, ahead), self.direction)
            ends.append(End(past, 1, partial(self.pass_corner, ahead), at_zero=True))
        if not self.imposed:
            ends += self.crank_ends()
        if target is not None:
            ends.append(End(lambda time, y: y[SPEED] - target, 1, partial(self.note, Kind.TARGET)))
        if limit is not None:
            ends.append(End(self.past(limit, 1), 1, partial(self.note, Kind.TURNED)))
        return ends

    @staticmethod
    def past(angle, direction):
        """A function that is positive once the shaft is past an angle in a direction."""
        return lambda time, y: direction * (y[ANGLE] - angle)

    def valve_ends(self, number, phase):
        """Stops, starts and the lap of one valve."""
        start, valve = self.blocks[number][0], self.engines[number].valve
        push = partial(self.push, number)
        for which, (function, slope) in enumerate(exits(valve, push, phase)):
            yield End(
                lambda time, y, function=function: function(time, y[start:]),  # `exits` finds its valve in front
                slope,
                partial(self.change_phase, number, which),
            )
        lap, ahead = self.lap_position(number), OPENING if self.lapped[number] else CLOSING
        if phase == ahead:
            slope = -1 if phase == OPENING else 1
            yield End(lambda time, y: y[start] - lap, slope, partial(self.pass_lap, number))

    def crank_ends(self):
        """Speed zero, or a crank that breaks away in the one direction or the other."""
        if self.direction:
            turning = self.direction
            yield End(lambda time, y: turning * y[SPEED] + BEYOND_ROUNDING, -1, self.stop)
            return
        for sign in (1, -1):

            def excess(time, y, sign=sign):
                torque, hold = self.pull(y)
                return sign * torque - hold - BEYOND_ROUNDING

            yield End(excess, 1, partial(self.break_away, sign))

    # what follows an end

    def change_phase(self, number, which, time, y):
        """A valve's piston meets or leaves a stop, or turns."""
        valve, view, phase = self.engines[number].valve, y[self.blocks[number][0] :], self.valve_phases[number]
        self.valve_phases[number] = after(valve, partial(self.push, number), phase, which, time, view)

    def pass_lap(self, number, time, y):
        """The lift passes the lap."""
        y[self.blocks[number][0] + POSITION] = self.lap_position(number)
        self.note(Kind.OPENS if self.lapped[number] else Kind.CLOSES, time, y, number)
        self.lapped[number] = not self.lapped[number]

    def pass_corner(self, ahead, time, y):
        """The shaft passes a corner."""
        y[ANGLE] = begins(self.turn, ahead)
        self.sector += self.direction
        for number in passed_at(self.turn, ahead):
            self.note(Kind.PASSAGE, time, y, number)
            self.peaks[number] = self.highest[number]
            self.highest[number] = float(y[self.blocks[number][0] + CYLINDER_PRESSURE])
        self.switch(time)

    def switch(self, time):
        """Issue an edge to each valve whose command has changed, and forget pairs of edges that are long done."""
        angle = middle(self.turn, self.sector)
        for number, (engine, phase) in enumerate(zip(self.engines, self.phases, strict=True)):
            command = is_energised(engine, angle - phase)
            if command != self.energised[number]:
                self.energised[number] = command
                self.edges[number].append((time, 1.0 if command else -1.0))
            edges = self.edges[number]
            for_ever = engine.valve.swing or engine.valve.rise
            while len(edges) > 2 and not for_ever and max(self.edge_corners(number, edges[1])) < time:
                del edges[:2]

    def edge_corners(self, number, edge):
        """Times at which the solenoids of a valve begin and end to follow an edge, whichever it is [s]."""
        return solenoids.corners_after(self.engines[number].valve, edge[0])

    def stop(self, time, y):
        """The speed is zero: the crank is held, or turns back."""
        y[SPEED] = 0.0
        self.note(Kind.SPEED_ZERO, time, y)
        torque, hold = self.pull(y)
        if abs(torque) > hold + BEYOND_ROUNDING:
            self.direction = 1 if torque > 0.0 else -1
            return
        self.direction = 0
        self.note(Kind.AT_REST, time, y)

    def break_away(self, sign, time, y):
        """The crank begins to turn."""
        first = not self.of_kind(Kind.FIRST_MOTION)
        self.note(Kind.FIRST_MOTION if first else Kind.MOTION, time, y)
        self.direction = sign

    def of_kind(self, kind):
        """Events of a kind so far."""
        return [one for one in self.events if one.kind == kind]

    # the march

    def held_until(self):
        """When a crank that is held now counts as at rest for good [s]."""
        if self.imposed or self.direction:
            return inf
        return HELD_FOR + max([0.0, *(one.time for one in self.of_kind(Kind.AT_REST))])

    def next_corner(self, until):
        """Time at which the next stretch ends at the latest [s]."""
        corners = [start for start, _ in self.assembly.loads]
        corners += [time for time, _ in self.imposed] + zeros_of(self.imposed)
        for number, edges in enumerate(self.edges):
            if self.engines[number].intake == "epv":
                corners += [corner for edge in edges for corner in self.edge_corners(number, edge)]
        return min([until, self.held_until(), *(at for at in corners if at > self.time + solenoids.APART)])

    def begin_stretch(self):
        """Take load and imposed speed as they are from now on."""
        now = self.time + solenoids.APART
        self.load = [load for start, load in self.assembly.loads if start <= now][-1]
        if self.imposed:
            self.direction, self.y[SPEED], self.acceleration = imposed_after(self.imposed, self.time)

    def step(self, until, target, limit, relative):
        """March to the end of one smooth stretch."""
        self.begin_stretch()
        ends = self.ends(target, limit)
        # Of two ends met at once the solver sees one; and a step of the load may let the crank go.
        passed = next((end for end in ends if end.is_past(self.time, self.y)), None)
        if passed:
            passed.follow(self.time, self.y)
            return
        piece = solve_ivp(
            self.rates,
            (self.time, self.next_corner(until)),
            self.y,
            method="LSODA",
            rtol=relative,
            atol=self.tolerances,
            max_step=LONGEST,
            dense_output=True,
            events=[event(end.function, end.slope, True) for end in ends],
        )
        if piece.status < 0:
            raise ArithmeticError(piece.message)
        self.pieces.append((self.time, piece.sol))
        self.update_highest(piece)
        self.time, self.y = float(piece.t[-1]), piece.y[:, -1].copy()
        if piece.status == 1:
            which = next(i for i, at in enumerate(piece.t_events) if len(at) and at[-1] == self.time)
            ends[which].follow(self.time, self.y)

    def update_highest(self, piece):
        """Take the highest pressures of a stretch into account, located between the steps."""
        for number, (start, _) in enumerate(self.blocks):
            name = start + CYLINDER_PRESSURE
            at = int(np.argmax(piece.y[name]))
            highest = float(piece.y[name, at])
            if 1.001 * highest > self.highest[number]:
                around = piece.t[max(at - 1, 0)], piece.t[min(at + 1, len(piece.t) - 1)]
                best = minimize_scalar(lambda t, name=name: -piece.sol(t)[name], bounds=around, method="bounded")
                highest = max(highest, -float(best.fun))
            self.highest[number] = max(self.highest[number], highest)


def march(assembly, angle, until, *, speed=0.0, imposed=(), target=None, limit=None, relative=RELATIVE):
    """March from the start: receiver and chambers A full, cylinders and chambers B at the ambient's state.

    Parameters
    ----------
    assembly : Assembly
    angle : float
        Of the shaft at the start [rad].
    until : float
        [s]
    speed : float
        At the start, of a free shaft [rad/s].
    imposed : tuple of pairs of float
        Times [s] and speeds [rad/s], linear in between; from 0 on to `until` at least. (): the shaft is free.
    target : float, optional
        Speed that ends the march once it is reached [rad/s].
    limit : float, optional
        Angle that does [rad].
    relative : float
        Tolerance.

    Returns
    -------
    Transient
    """
    marching = Marching(assembly, angle, speed, imposed)
    reached, at_once = 0.0, 0
    while not (marching.events and marching.events[-1].kind in ENDINGS):
        if marching.time >= marching.held_until():
            marching.note(Kind.HELD, marching.time, marching.y)
        elif marching.time >= until:
            marching.note(Kind.TIME, marching.time, marching.y)
        else:
            marching.step(until, target, limit, relative)
        if marching.time > reached + solenoids.APART:
            reached, at_once = marching.time, 0
        at_once += 1
        if at_once > MAX_AT_ONCE:
            raise ArithmeticError(f"it does not get beyond {marching.time} s")
    return Transient(assembly, tuple(marching.events), tuple(marching.pieces))


def start(assembly, angle, target=None, turns=3.0, relative=RELATIVE):
    """A start from rest, until a target speed [rad/s] if there is one, else some turns; or until the crank is held."""
    limit = None if target is not None else angle + turns * TURN
    return march(assembly, angle, GIVEN_UP, target=target, limit=limit, relative=relative)


def impose(assembly, angle, profile, relative=RELATIVE):
    """An imposed speed, pairs of time [s] and speed [rad/s], to the last of them."""
    return march(assembly, angle, profile[-1][0], imposed=tuple(profile), relative=relative)
