"""One operating point at its periodic steady state."""

from math import nan
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE
from apesim.engine.cycle.operating_point import accuracy_at, charged_at_rest, cycle_of, with_exergy
from apesim.engine.cycle.rates import RECEIVER_EXTREMUM, TEMPERATURE_EXTREMUM, TRACE
from apesim.engine.cycle.state import SIZE, STATES, Cycle, engine_ledger
from apesim.engine.exergy import RATES
from apesim.march.adaptive import LOG_HEAD, LOG_ROWS, TOLERANCE, ZERO_CROSSING, Status, march
from apesim.march.periodic import MAX_CYCLES, PERIODIC_TOLERANCE, Orbit, known_orbit, periodic_orbit
from apesim.valve.actuator import PHASE
from apesim.valve.exergy import VALVE_IMPACTS, impact_loss
from apesim.valve.piston import HELD_CLOSED


class SteadyRun(NamedTuple):
    """The last cycle of a march to the periodic state."""

    p: Cycle
    orbit: Orbit
    start: np.ndarray
    """State at the start of the cycle, (SIZE,)."""
    end: np.ndarray
    """State at its end, and the cycle's ledger; with a period of 2 cycles, their mean change added to the start."""
    log: np.ndarray
    """See `apesim.march.adaptive.march`; without the extrema below."""
    extrema: np.ndarray
    """Rows of the log at extrema of the receiver's pressure and of the cylinder's temperature."""
    angles: np.ndarray
    """Crank angles of the trace [rad], (n,)."""
    trace: np.ndarray
    """Columns `apesim.engine.cycle.rates.TRACE`, (n, 11)."""
    work_by_quadrature: float
    """[J]"""
    exergy_end: np.ndarray
    """The same as `end` of a march of the cycle that holds the exergy ledger to the tolerance, too, with the rates of
    `apesim.engine.exergy` integrated behind it [J], (SIZE + RATES,)."""
    work_change: float
    """Of the cycle's work at tenfold tolerance, see `apesim.march.adaptive.Accuracy.tenfold`; relative."""
    air_change: float
    """The same of the air through the groove."""
    tolerance: float
    status: int
    steps: int


def run_steady(
    machine,
    speed,
    tolerance=TOLERANCE,
    angle_step=0.5 * DEGREE,
    max_cycles=MAX_CYCLES,
    periodic_tolerance=PERIODIC_TOLERANCE,
    trace_start=0.0,
    angles=None,
    start=None,
    estimate_error=True,
):
    """March an operating point to its periodic steady state, and through one more cycle that is noted.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    speed : float
        [rad/s]
    tolerance : float
    angle_step : float
        Between two rows of the trace [rad].
    max_cycles : int
        Cycles at most.
    periodic_tolerance : float
        Largest change of a state over a cycle that counts as periodic, relative.
    trace_start : float
        Of the first row of the trace, from the energising [rad].
    angles : (n,) float array, optional
        Of the rows of the trace, ascending within the turn from the energising on [rad]; they go before a step.
    start : apesim.march.periodic.Known, optional
        See `known_state`.
    estimate_error : bool
        Whether to march two more cycles, one at tenfold tolerance for the changes of work and air, and one for the
        exergy ledger; else these are NaN.

    Returns
    -------
    SteadyRun
    """
    p, tables, breakpoints = cycle_of(machine, speed)
    accuracy = accuracy_at(p, tolerance)
    start = start and _at_its_stop(p, start)
    orbit = periodic_orbit(p, tables, *charged_at_rest(p), breakpoints, accuracy, periodic_tolerance, max_cycles, start)
    if angles is None:
        angles = p.start + np.arange(trace_start, 2.0 * np.pi + 0.5 * angle_step, angle_step)
    times = np.minimum((angles - p.start) / speed, breakpoints[-1])

    def cycle(y, mode, accuracy, times=times[:0], log_rows=LOG_ROWS):
        log, trace = np.empty((log_rows, LOG_HEAD + STATES)), np.full((len(times), len(TRACE)), np.nan)
        outcome = march(p, tables, 0.0, y, mode, breakpoints, accuracy, log, times, trace)
        return log[: outcome.logged], trace, outcome

    end, mode = orbit.y.copy(), orbit.mode.copy()
    log, trace, outcome = cycle(end, mode, accuracy, times)
    work, impacts = outcome.work, impact_loss(p.actuator, log)
    coarse, coarse_mode = orbit.y.copy(), orbit.mode.copy()
    before, exergy_mode = np.append(orbit.y, np.zeros(RATES)), orbit.mode.copy()
    exergy_end, exergy_accuracy = before.copy(), with_exergy(p, accuracy)
    if estimate_error:
        cycle(coarse, coarse_mode, accuracy.tenfold(), log_rows=0)
        cycle(exergy_end, exergy_mode, exergy_accuracy, log_rows=0)
    if orbit.period == 2:
        second, _, other = cycle(end, mode, accuracy)
        work, impacts = 0.5 * (work + other.work), 0.5 * (impacts + impact_loss(p.actuator, second))
        if estimate_error:
            cycle(coarse, coarse_mode, accuracy.tenfold(), log_rows=0)
            cycle(exergy_end, exergy_mode, exergy_accuracy, log_rows=0)
        end, coarse, exergy_end = 0.5 * (orbit.y + end), 0.5 * (orbit.y + coarse), 0.5 * (before + exergy_end)
    exergy_end[SIZE + VALVE_IMPACTS] = impacts
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
        exergy_end if estimate_error else np.full_like(exergy_end, nan),
        _change(engine_ledger(coarse).work, engine_ledger(end).work) if estimate_error else nan,
        _change(engine_ledger(coarse).groove, engine_ledger(end).groove) if estimate_error else nan,
        tolerance,
        int(outcome.status if orbit.status == Status.DONE else orbit.status),
        outcome.steps,
    )


def known_state(machine, speed):
    """The periodic state of an operating point, from which those of a little different machines take few cycles.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    speed : float
        [rad/s]

    Returns
    -------
    apesim.march.periodic.Known or None
        None where it does not settle to a period of one cycle.
    """
    p, tables, breakpoints = cycle_of(machine, speed)
    accuracy = accuracy_at(p)
    orbit = periodic_orbit(p, tables, *charged_at_rest(p), breakpoints, accuracy)
    return known_orbit(p, tables, orbit, breakpoints, accuracy)


def _at_its_stop(p, known):
    """A known state whose piston, held closed, is so at this machine's stroke."""
    y = known.y.copy()
    if known.mode[PHASE] == HELD_CLOSED:
        y[0] = p.actuator.valve.stroke
    return known._replace(y=y)


def _change(value, reference):
    if value == reference:
        return 0.0
    return abs(value / reference - 1.0) if reference else nan
