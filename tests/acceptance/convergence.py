"""The solver's error against its tolerance, on the bench and over one cycle of the engine."""

import numpy as np

from apesim.engine.angles import DEGREE
from apesim.engine.cycle import state as cycle_state
from apesim.engine.cycle.operating_point import accuracy_at, cycle_of
from apesim.engine.steady import run_steady
from apesim.march.adaptive import LOG_HEAD, LOG_ROWS, NO_CARRY, Accuracy, march
from apesim.valve import actuator, bench
from apesim.valve.measures import closing_stroke, opening_stroke
from apesim.valve.motion import MET_CLOSED, MET_OPEN
from tests.machines import RPM, machine

TOLERANCES = 10.0 ** -np.arange(4.0, 11.25, 0.5)
FINEST = 1e-13
SPEEDS, PULSE = (800.0, 3000.0), 50e-3
"""Speeds of the engine [r/min]; pulse of the bench [s]."""


def marched(p, tables, y, mode, breakpoints, tolerance, longest_step, scale):
    """Log of a march; the state in y is the end's on return."""
    log = np.empty((LOG_ROWS, LOG_HEAD + len(scale)))
    accuracy = Accuracy(tolerance, longest_step, np.array(scale))
    outcome = march(p, tables, 0.0, y, mode, breakpoints, accuracy, log, np.empty(0), np.empty((0, 0)), NO_CARRY)
    assert outcome.status == 0
    return log[: outcome.logged]


def bench_measures(tolerance, longest_step):
    """Measures of the default valve with a pulse of 50 ms, by name."""
    p, tables = bench.bench_of(machine(), [0.0, PULSE])
    y, mode = bench.closed_at_start(p)
    log = marched(p, tables, y, mode, tables.breakpoints(0.0, 2.0 * PULSE), tolerance, longest_step, actuator.SCALE)
    strokes = {"opening": opening_stroke(log, 0.0, PULSE), "closing": closing_stroke(log, PULSE, 2.0 * PULSE)}
    return {
        f"{name} {field.replace('_', ' ')}": getattr(stroke, field)
        for name, stroke in strokes.items()
        for field in ("delay", "stroke_time", "seating_speed")
    }


def cycle_at(speed):
    """A function: results of one cycle of the default engine from its periodic state at a speed [rad/s], by name."""
    start = run_steady(machine(), speed, tolerance=1e-10).orbit
    p, tables, breakpoints = cycle_of(machine(), speed)

    def results(tolerance, longest_step):
        y, mode = start.y.copy(), start.mode.copy()
        log = marched(p, tables, y, mode, breakpoints, tolerance, longest_step, cycle_state.SCALE)
        time, code = log[:, :2].T
        angle = (p.start + speed * time) / DEGREE
        met = {name: angle[code == which] for name, which in (("open", MET_OPEN), ("closed", MET_CLOSED))}
        ledger = cycle_state.engine_ledger(y)
        return {"work of the cycle": ledger.work, "air of the cycle": ledger.groove.mass} | {
            f"angle of contact, {name}": angles[0] for name, angles in met.items() if len(angles)
        }

    return results


def convergence_table(longest_step=None):
    """Errors against the finest tolerance.

    Parameters
    ----------
    longest_step : float, optional
        In place of that of the runs [s].

    Returns
    -------
    tolerances : (n,) float array
    errors : dict
        By machine (bench, engine at a speed) and result: relative errors, (n,) float array.
    """
    errors = {}
    cases = {"bench": (bench_measures, bench.accuracy_of(bench.bench_of(machine(), [0.0, PULSE])[0]))}
    cases |= {
        f"engine, {rpm:g} r/min": (cycle_at(rpm * RPM), accuracy_at(cycle_of(machine(), rpm * RPM)[0]))
        for rpm in SPEEDS
    }
    for name, (results, usual) in cases.items():
        true = results(FINEST, usual.max_step)
        found = [results(tolerance, longest_step or usual.max_step) for tolerance in TOLERANCES]
        errors[name] = {key: np.array([abs(one[key] / true[key] - 1.0) for one in found]) for key in true}
    return TOLERANCES, errors
