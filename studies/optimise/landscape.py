"""What an engine does with other command angles at one speed, in its periodic state."""

from enum import IntEnum
from math import inf, nan
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.indicators import indicators, valve_travel
from apesim.engine.steady import run_steady
from apesim.march.adaptive import Status
from apesim.march.periodic import PERIODIC_TOLERANCE
from apesim.studies.timing.solve import SKETCH, SKETCH_ANGLE_STEP

ENERGISE = (-240.0 * DEGREE, 60.0 * DEGREE)
DURATION = (5.0 * DEGREE, 300.0 * DEGREE)
"""Range that commands are looked for in: energising after TDC, and the time from there to the release [rad]."""
RECORDED = (
    "brake_torque_Nm",
    "specific_air_kg_per_kWh",
    "engine_air_kg_per_cycle",
    "control_air_kg_per_cycle",
    "valve_open_deg",
    "valve_close_deg",
    "full_open_deg",
    "peak_lift_m",
    "period_cycles",
)
"""Indicators that are kept of every point, see `apesim.engine.indicators.INDICATORS`."""


class Goal(IntEnum):
    """What is wanted."""

    TORQUE = 0
    AIR = 1


class Point(NamedTuple):
    """Commands at one speed, and what comes of them."""

    place: tuple
    """Energise, duration, and supply pressure if that is free, each as a share of its range."""
    energise: float
    """[rad]"""
    release: float
    """[rad]"""
    pressure: float
    """Pressure of the supply [Pa abs]."""
    values: dict
    """`RECORDED`; NaN where the state does not repeat."""
    merit: tuple
    """Brake torque [N m] and brake work over all air [J/kg]; -inf where the state does not repeat."""
    full_lift: bool
    """Whether the piston is on its open stop at any time."""


def point_of(machine, speed, place=(), periodic_tolerance=PERIODIC_TOLERANCE):
    """A machine's point, by its periodic state.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    speed : float
        [rad/s]
    place : tuple of float
        See `Point`.
    periodic_tolerance : float
        See `apesim.engine.steady.run_steady`.

    Returns
    -------
    Point
    """
    return judged(
        machine, run_steady(machine, speed, periodic_tolerance=periodic_tolerance, angle_step=SKETCH_ANGLE_STEP), place
    )


def judged(machine, run, place=()):
    """A machine's point by a run of it.

    Brake work over air stands for specific air: the more of the one, the less of the other, and it goes smoothly
    through zero where the specific air has a pole.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    run : apesim.engine.steady.SteadyRun
    place : tuple of float
        See `Point`.

    Returns
    -------
    Point
    """
    values, merit, full_lift = dict.fromkeys(RECORDED, nan), (-inf, -inf), False
    if run.status == Status.DONE and run.orbit.converged:
        found = indicators(machine, run)
        values = {name: float(found[name]) for name in RECORDED}
        air = values["engine_air_kg_per_cycle"] + values["control_air_kg_per_cycle"]
        work = TURN * values["brake_torque_Nm"]
        merit = values["brake_torque_Nm"], work / air if air > 0.0 else -inf
        full_lift = valve_travel(machine, run).opens_fully
    command = machine.command
    return Point(place, command.energise, command.release, machine.supply.pressure, values, merit, full_lift)


class Landscape:
    """Points of a machine at one speed; each is computed once.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
        With an electro-pneumatic intake.
    speed : float
        [rad/s]
    pressures : pair of float, optional
        Between which the supply pressure is free [Pa abs].
    """

    def __init__(self, machine, speed, pressures=None):
        self.machine, self.speed = machine, speed
        self.low, self.high = np.array([ENERGISE, DURATION, *([pressures] if pressures else [])]).T
        self.sketched, self.settled = {}, {}

    def machine_at(self, place):
        """The machine with the commands, and the supply pressure, of a place."""
        energise, duration, *pressure = (self.low + (self.high - self.low) * np.array(place)).tolist()
        command = self.machine.command._replace(energise=energise, release=energise + duration)
        machine = self.machine._replace(command=command)
        return machine._replace(supply=machine.supply._replace(pressure=pressure[0])) if pressure else machine

    def at(self, x, periodic_tolerance=PERIODIC_TOLERANCE):
        """The point of a place, each coordinate held between 0 and 1; a sketch does not count as one of the points."""
        place = tuple(np.clip(x, 0.0, 1.0).tolist())
        known = self.sketched if periodic_tolerance == SKETCH else self.settled
        if place not in known:
            known[place] = point_of(self.machine_at(place), self.speed, place, periodic_tolerance)
        return known[place]

    def best(self, goal, min_torque=-inf):
        """The best of the points so far; None where none repeats, or, for least air, none gives brake work."""
        min_torque = max(min_torque, 0.0) if goal == Goal.AIR else min_torque
        points = [p for p in self.settled.values() if p.merit[goal] > -inf and p.merit[Goal.TORQUE] >= min_torque]
        return max(points, key=lambda point: point.merit[goal], default=None)
