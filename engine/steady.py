"""Periodic steady state of an operating point: a machine at a speed."""

from math import nan
from typing import NamedTuple

import numpy as np

import apesim.engine.cycle.rates  # noqa: F401  # registers the march of a cycle
from apesim.effect import library_for, volume_of
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.cylinder_laws import RECEIVER_EXTREMUM, TEMPERATURE_EXTREMUM, TRACE
from apesim.engine.cycle.operating_point import accuracy_at, charged_at_rest, cycle_of, with_exergy
from apesim.engine.cycle.state import LINE, PIPE, SIZE, STATES, Cycle, engine_ledger
from apesim.engine.effects import ENGINE_LIBRARY
from apesim.engine.exergy import RATES
from apesim.engine.machine import Machine
from apesim.march.adaptive import LOG_HEAD, LOG_ROWS, NO_CARRY, TOLERANCE, ZERO_CROSSING, Accuracy, Status, march
from apesim.march.periodic import (
    MAX_CYCLES,
    NO_RECORD,
    PERIODIC_TOLERANCE,
    Known,
    Orbit,
    Record,
    Recorded,
    known_orbit,
    periodic_orbit,
)
from apesim.quantities import Fault, InputError
from apesim.valve.effects import VALVE_LIBRARY
from apesim.valve.exergy import VALVE_IMPACTS, impact_loss
from apesim.valve.motion import put_at_rest


class SteadyRun(NamedTuple):
    """Last cycle of a march to the periodic state."""

    cycle: Cycle
    """Machine at its speed, as numbers for the kernels."""
    orbit: Orbit
    """Periodic state, and how it was found."""
    start: np.ndarray
    """State vector at the start of the cycle, (SIZE,)."""
    end: np.ndarray
    """State vector at the end of the cycle, (SIZE,); of a period of some cycles, their mean change added to the start.
    Its ledgers are those of the cycle, see `apesim.engine.cycle.state.engine_ledger`."""
    log: np.ndarray
    """Breakpoints, events and zero crossings of the cycle, see `apesim.march.adaptive.march`; without `extrema`."""
    extrema: np.ndarray
    """Rows of the log at extrema of the receiver's pressure and of the cylinder's temperature."""
    angles: np.ndarray
    """Crank angles of the trace [rad], (n,)."""
    trace: np.ndarray
    """Trace with the columns `apesim.engine.cycle.cylinder_laws.TRACE`, (n, 11)."""
    work_by_quadrature: float
    """Work of the cycle by quadrature of the power over the dense output [J]."""
    exergy_end: np.ndarray
    """`end`, with the terms of `apesim.engine.exergy` behind it [J], (SIZE + RATES,)."""
    work_change: float
    """Relative change of the cycle's work at tenfold tolerance, see `apesim.march.adaptive.Accuracy.tenfold`."""
    air_change: float
    """Relative change of the air through the groove at tenfold tolerance."""
    tolerance: float
    """Relative tolerance of a step."""
    status: int
    """How the march ended, `apesim.march.adaptive.Status`."""
    steps: int
    """Steps of the cycle."""


def run_steady(
    machine: Machine,
    speed: float,
    tolerance: float = TOLERANCE,
    angle_step: float = 0.5 * DEGREE,
    max_cycles: int = MAX_CYCLES,
    periodic_tolerance: float = PERIODIC_TOLERANCE,
    trace_start: float = 0.0,
    angles: np.ndarray | None = None,
    start: Known | None = None,
    estimate_error: bool = True,
) -> SteadyRun:
    """March an operating point to its periodic steady state, and through one more cycle that is recorded.

    `speed` of the crank [rad/s] is above 0, `tolerance` the relative one of a step, `periodic_tolerance` the largest
    relative change of a state over a cycle that counts as periodic. The rows of the trace are `angle_step` [rad] apart
    from `trace_start` [rad] on, counted from the energising, or at `angles` (n,) [rad], ascending within the turn from
    the energising. `start` is the periodic state of a similar machine, see `known_state`; else the engine starts at
    rest, charged. With `estimate_error` one more cycle is marched, at tenfold tolerance, for the changes of work and
    air, and the exergy ledger is taken with the recorded one, whose steps hold it to the tolerance, too; without it
    these are NaN. Whether the cycle is periodic stands in `orbit`, whether it came to its end in `status`.

    The first cycle of the default machine from rest:

    >>> run = run_steady(Machine(), speed=100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> run.orbit.cycles, run.orbit.converged
    (1, False)
    """
    refuse_several(machine)
    p, tables, breakpoints = cycle_of(machine, speed)
    accuracy = accuracy_at(p, tolerance)
    start = start and _within_its_stops(p, start)
    if angles is None:
        angles = p.start + np.arange(trace_start, 2.0 * np.pi + 0.5 * angle_step, angle_step)
    times = np.minimum((angles - p.start) / speed, breakpoints[-1])

    def new_record(times: np.ndarray = times[:0], log_rows: int = LOG_ROWS) -> Record:
        return Record(np.empty((log_rows, LOG_HEAD + STATES)), times, np.full((len(times), len(TRACE)), np.nan))

    def cycle(y: np.ndarray, mode: np.ndarray, accuracy: Accuracy, record: Record) -> Recorded:
        outcome = march(p, tables, 0.0, y, mode, breakpoints, accuracy, *record, NO_CARRY)
        return Recorded(record.log[: outcome.logged], record.trace, y, outcome)

    # To the periodic state. A cycle that is recorded on the way has no exergy ledger.
    rest, new = charged_at_rest(p), NO_RECORD if estimate_error else new_record(times)
    orbit = periodic_orbit(p, tables, *rest, breakpoints, accuracy, periodic_tolerance, max_cycles, start, new)
    estimate_error = estimate_error and orbit.status == Status.DONE

    # The recorded cycle, or cycles: to the tolerance of the exergy ledger where there is one.
    exact, before = accuracy, orbit.y
    if estimate_error:
        exact, before = with_exergy(p, accuracy), np.append(orbit.y, np.zeros(RATES))
    mode = orbit.mode.copy()
    log, trace, end, outcome = orbit.recorded or cycle(before.copy(), mode, exact, new_record(times))
    work, impacts = outcome.work, impact_loss(p.actuator, log)
    for _ in range(orbit.period - 1):
        later = cycle(end, mode, exact, new_record())
        work += later.outcome.work
        impacts += impact_loss(p.actuator, later.log)

    # The same at tenfold tolerance, for the error.
    coarse, coarse_mode = orbit.y.copy(), orbit.mode.copy()
    if estimate_error:
        for _ in range(max(orbit.period, 1)):
            cycle(coarse, coarse_mode, accuracy.tenfold(), new_record(log_rows=0))

    # The mean of a period of several cycles.
    if orbit.period > 1:
        work, impacts = work / orbit.period, impacts / orbit.period
        end, coarse = (first + (last - first) / orbit.period for first, last in ((before, end), (orbit.y, coarse)))
    exergy_end, end = (end, end[:SIZE]) if estimate_error else (np.full(SIZE + RATES, nan), end)
    if estimate_error:
        exergy_end[SIZE + VALVE_IMPACTS] = impacts
    coarse_ledger, ledger = engine_ledger(coarse), engine_ledger(end)
    is_extremum = np.isin(log[:, 1], (ZERO_CROSSING + RECEIVER_EXTREMUM, ZERO_CROSSING + TEMPERATURE_EXTREMUM))
    return SteadyRun(
        p,
        orbit,
        orbit.y,
        end,
        log[~is_extremum],
        log[is_extremum],
        angles,
        trace,
        work,
        exergy_end,
        relative_change(coarse_ledger.work, ledger.work) if estimate_error else nan,
        relative_change(coarse_ledger.groove.mass, ledger.groove.mass) if estimate_error else nan,
        tolerance,
        int(outcome.status if orbit.status == Status.DONE else orbit.status),
        outcome.steps,
    )


def is_of_one_cylinder(machine: Machine) -> bool:
    """Whether a machine is one cylinder, with no keys of its own beside those of the machine, and one stage.

    >>> is_of_one_cylinder(Machine()), is_of_one_cylinder(Machine().with_(engine_cylinders=2))
    (True, False)
    """
    return not (machine.engine.cylinders > 1.0 or any(machine.cylinder) or machine.stage_2.is_on)


def refuse_several(machine: Machine) -> None:
    """Refuse an engine of several cylinders or stages, where one cylinder is marched: raises InputError.

    >>> refuse_several(Machine().with_(engine_cylinders=2))
    Traceback (most recent call last):
    ...
    apesim.quantities.input_errors.InputError: machine: engine.cylinders: is 2, and one alone is marched; write 1
    """
    if is_of_one_cylinder(machine):
        return
    faults = []
    if machine.engine.cylinders > 1.0:
        wrong = f"is {machine.engine.cylinders:g}, and one alone is marched"
        faults.append(Fault("machine", "engine.cylinders", wrong, "write 1"))
    elif any(machine.cylinder):
        wrong, right = "has keys of its own for the only cylinder", "write them in [valve], [groove] and [command]"
        faults.append(Fault("machine", "cylinder[1]", wrong, right))
    if machine.stage_2.is_on:
        wrong = "switches a second stage on, and the first alone is marched"
        faults.append(Fault("machine", "stage_2.bore", wrong, 'leave [stage_2] out, or write "0 mm"'))
    raise InputError(faults)


def known_state(machine: Machine, speed: float) -> Known | None:
    """Find the periodic state of an operating point, from which those of similar machines take few cycles.

    `speed` of the crank [rad/s] is above 0. None where the machine does not settle to a period of one cycle.
    """
    refuse_several(machine)
    p, tables, breakpoints = cycle_of(machine, speed)
    accuracy = accuracy_at(p)
    orbit = periodic_orbit(p, tables, *charged_at_rest(p), breakpoints, accuracy)
    return known_orbit(p, tables, orbit, breakpoints, accuracy)


def carry_over(known: Known, machine: Machine, other: Machine) -> Known:
    """Move a known state to a machine with other volumes of gas before its flows, at the pressures that they have.

    `machine` is the one that the state is of, `other` has the same volumes on, in other sizes: piston and modes stay,
    the air is more or less in proportion. Its correction is rough where a volume differs: a step from it may grow as
    long as what a cycle gains falls.

    >>> from apesim.valve.effects.supply_droop import SupplyDroop
    >>> effects = Machine().effects
    >>> small, large = (
    ...     Machine(effects=effects._replace(supply_droop=SupplyDroop(feed_area=20e-6, volume=volume)))
    ...     for volume in (1e-4, 4e-4)
    ... )
    >>> known = Known(np.ones(SIZE), np.zeros(1), np.eye(1))
    >>> moved = carry_over(known, small, large)
    >>> moved.y[LINE : LINE + 4].tolist(), moved.rough
    ([4.0, 4.0, 1.0, 1.0], True)
    """
    y, rough = known.y.copy(), known.rough
    for place, before, after in zip((LINE, PIPE), _added_volumes(machine), _added_volumes(other), strict=True):
        if before != after and before:
            y[place : place + 2] *= after / before
            rough = True
    return known._replace(y=y, rough=rough)


def _added_volumes(machine: Machine) -> tuple[float, float]:
    """Gas volumes that effects add, of the supply line and of the intake pipe [m3]; 0 where there is none."""
    effects = machine.effects
    libraries = library_for(effects, VALVE_LIBRARY, "valve"), library_for(effects, ENGINE_LIBRARY, "engine")
    line, pipe = (volume_of(library.effects, effects).volume for library in libraries)
    return line, pipe


def _within_its_stops(p: Cycle, known: Known) -> Known:
    """Put a known state's piston, where it is at rest, on the stop of this machine or between its stops."""
    y = known.y.copy()
    put_at_rest(p.actuator, y, known.mode)
    return known._replace(y=y)


def relative_change(value: float, reference: float) -> float:
    """Relative change of a value against a reference; NaN where only the reference is 0."""
    if value == reference:
        return 0.0
    return abs(value / reference - 1.0) if reference else nan
