"""What an engine does with other command angles at one speed, in its periodic state."""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from math import inf, isnan, nan
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.indicators import indicators, valve_travel
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun, run_steady
from apesim.march.adaptive import Status
from apesim.march.periodic import PERIODIC_TOLERANCE, Known
from apesim.studies.timing.solve import SKETCH, SKETCH_ANGLE_STEP

ENERGISE = (-240.0 * DEGREE, 60.0 * DEGREE)
DURATION = (5.0 * DEGREE, 300.0 * DEGREE)
"""Ranges that are searched: crank angle of the energising after TDC, and from there to the release [rad]."""
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
    """Goal of a search: most brake torque, or least specific air."""

    TORQUE = 0
    AIR = 1


class Point(NamedTuple):
    """Commands at one speed, and what comes of them."""

    place: tuple[float, ...]
    """Energise, duration, and supply pressure if that is free, each as a share of its range."""
    energise: float
    """Command angle of the energising [rad]."""
    release: float
    """Command angle of the release [rad]."""
    pressure: float
    """Pressure of the supply [Pa abs]."""
    values: dict[str, float]
    """Indicators `RECORDED`, by name; NaN where the state does not repeat."""
    merit: tuple[float, float]
    """Brake torque [N m] and brake work over all air [J/kg]; -inf where the state does not repeat."""
    full_lift: bool
    """Whether the piston is on its open stop at any time."""


def point_of(
    machine: Machine, speed: float, place: tuple[float, ...] = (), periodic_tolerance: float = PERIODIC_TOLERANCE
) -> Point:
    """Compute a machine's point by its periodic state at a speed of the crankshaft [rad/s].

    `place` is that of the commands in the ranges that are searched, see `Point`; `periodic_tolerance` is the change
    over a cycle that counts as periodic, see `apesim.engine.steady.run_steady`.

    >>> point = point_of(Machine(), 94.0)
    >>> round(point.values["brake_torque_Nm"], 1), point.full_lift
    (37.3, True)
    """
    return judged(machine, _run(machine, speed, periodic_tolerance), place)


def _run(machine: Machine, speed: float, periodic_tolerance: float, start: Known | None = None) -> SteadyRun:
    """Periodic state with what the indicators `RECORDED` need."""
    return run_steady(
        machine,
        speed,
        periodic_tolerance=periodic_tolerance,
        angle_step=SKETCH_ANGLE_STEP,
        start=start,
        estimate_error=False,
    )


def judged(machine: Machine, run: SteadyRun, place: tuple[float, ...] = ()) -> Point:
    """Judge a machine's point by the last cycle of a run of it; NaN and -inf where the state does not repeat.

    Brake work over air stands for specific air: the more of the one, the less of the other, and it goes smoothly
    through zero where the specific air has a pole. `place` is that of the commands in the ranges that are searched, see
    `Point`.
    """
    values, merit, full_lift = dict.fromkeys(RECORDED, nan), (-inf, -inf), False
    if run.status == Status.DONE and run.orbit.converged:
        computed = indicators(machine, run)
        values = {name: float(computed[name]) for name in RECORDED}
        merit = merit_of(values)
        full_lift = valve_travel(machine, run).opens_fully
    command = machine.command
    return Point(place, command.energise, command.release, machine.supply.pressure, values, merit, full_lift)


def merit_of(values: Mapping[str, float]) -> tuple[float, float]:
    """Rate a point by its indicators `RECORDED`: brake torque [N m], and brake work over all air [J/kg].

    Both are -inf where the indicators are NaN, as the state does not repeat.
    """
    torque = values["brake_torque_Nm"]
    if isnan(torque):
        return -inf, -inf
    air = values["engine_air_kg_per_cycle"] + values["control_air_kg_per_cycle"]
    return torque, TURN * torque / air if air > 0.0 else -inf


class Landscape:
    """Points of a machine with an electro-pneumatic intake at one speed [rad/s]; each is computed once.

    The supply is free between `pressures` [Pa abs]; it is the machine's own if left out.
    """

    def __init__(self, machine: Machine, speed: float, pressures: tuple[float, float] | None = None) -> None:
        self.machine, self.speed = machine, speed
        self.low, self.high = np.array([ENERGISE, DURATION, *([pressures] if pressures else [])]).T
        self.sketched: dict[tuple[float, ...], Point] = {}
        self.settled: dict[tuple[float, ...], Point] = {}
        self._nearest: Known | None = None
        """Full periodic state of the last place, which is near the next: a search takes short steps."""

    def _machine_at(self, place: tuple[float, ...]) -> Machine:
        """Give the machine the commands, and the supply pressure, of a place."""
        energise, duration, *pressure = (self.low + (self.high - self.low) * np.array(place)).tolist()
        command = self.machine.command._replace(energise=energise, release=energise + duration)
        machine = self.machine._replace(command=command)
        return machine._replace(supply=machine.supply._replace(pressure=pressure[0])) if pressure else machine

    def at(self, x: Sequence[float], periodic_tolerance: float = PERIODIC_TOLERANCE) -> Point:
        """Compute the point of a place, each coordinate held between 0 and 1; it is computed once.

        `x` has energise, duration, and supply pressure if that is free, each as a share of its range.
        `periodic_tolerance` is the change over a cycle that counts as periodic; with `SKETCH` the point is not one of
        the landscape's own.
        """
        place = tuple(np.clip(x, 0.0, 1.0).tolist())
        known = self.sketched if periodic_tolerance == SKETCH else self.settled
        if place not in known:
            machine, is_sketch = self._machine_at(place), periodic_tolerance == SKETCH
            run = _run(machine, self.speed, periodic_tolerance, None if is_sketch else self._nearest)
            if not is_sketch:
                self._nearest = run.orbit.known
            known[place] = judged(machine, run, place)
        return known[place]

    def best(self, goal: Goal, min_torque: float = -inf) -> Point | None:
        """Find the best of the points so far with at least `min_torque` [N m].

        For least air at least 0 N m is asked, as air without brake work means nothing. None where no point whose state
        repeats has that torque.
        """
        min_torque = max(min_torque, 0.0) if goal == Goal.AIR else min_torque
        points = [p for p in self.settled.values() if p.merit[goal] > -inf and p.merit[Goal.TORQUE] >= min_torque]
        return max(points, key=lambda point: point.merit[goal], default=None)
