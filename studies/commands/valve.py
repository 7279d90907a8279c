"""The command of one bench run."""

import time
from math import nan

import numpy as np

from apesim.march.adaptive import TOLERANCE, Status
from apesim.quantities import Culprit, InputError, Quantity, parse
from apesim.studies.commands.given import PRESSURE, TEMPERATURE, TIME
from apesim.studies.commands.machine import load_machine
from apesim.studies.commands.tables import number, table_of, warm_up, write_traces
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.valve.bench import TRACE, run_bench
from apesim.valve.warnings import judge_bench

RATE = Quantity("Hz", 0.1, 1000, "command line", typical="10 Hz")


def bench_run(console, machine_file, settings, supply, temperature, pulse, until, repeat, csv):
    """One bench run; see `apesim valve run --help`.

    Returns
    -------
    int
        Exit code.
    """
    machine = _with_supply(load_machine(machine_file, settings), supply, temperature)
    pulse = parse(pulse, TIME, where="--pulse", file=COMMAND_LINE)
    until = parse(until, TIME, where="--until", file=COMMAND_LINE) if until else None
    period = _period(repeat, pulse, until)
    warm_up(console, run_bench, machine, 10e-3)
    start = time.perf_counter()
    run = console.run("bench run", run_bench, machine, pulse, until, period)
    wall = time.perf_counter() - start
    warnings = [f"the march ended early: {Status(run.status).remedy}"]
    if run.status == Status.DONE:
        warnings = list(judge_bench(run).values())
    data = {
        "opening": _stroke(run.opening),
        "closing": _stroke(run.closing),
        "control_air_kg": run.control_air,
        "closure": run.closure,
        "tolerance": TOLERANCE,
        "converged": run.orbit.converged if run.orbit else None,
        "period_cycles": run.orbit.period if run.orbit else None,
        "cycles": run.orbit.cycles if run.orbit else None,
        "wall_time_s": wall,
        "warnings": warnings,
    }
    if csv:
        write_traces(csv, ("time [s]", *TRACE), np.column_stack((run.times, run.trace)))
    rows = [
        (name, *(number(factor * getattr(stroke, field)) for stroke in (run.opening, run.closing)), unit)
        for name, field, factor, unit in (
            ("delay time", "delay", 1e3, "ms"),
            ("full stroke time", "stroke_time", 1e3, "ms"),
            ("seating speed", "seating_speed", 1.0, "m/s"),
            ("fluctuation", "fluctuation", 1.0, "-"),
        )
    ]
    control = (
        f"control air {run.control_air * 1e3:.5g} g; closure of mass {run.closure['mass']:.1e}, of energy "
        f"{run.closure['energy']:.1e}; work by quadrature {run.closure['work']:.1e}; tolerance {TOLERANCE:g}"
    )
    console.result(data, table_of("One bench run", ("", "opening", "closing", "unit"), rows), control)
    for warning in warnings:
        console.message(f"warning: {warning}")
    failed = run.status != Status.DONE or (run.orbit is not None and not run.orbit.converged)
    return INCOMPLETE if failed else DONE


def _with_supply(machine, supply, temperature):
    """A machine with the supply of the command line; what is None stays as it is."""
    given = {}
    if supply is not None:
        pressure = parse(supply, PRESSURE, machine.ambient.pressure, where="--supply", file=COMMAND_LINE)
        given |= {"pressure": pressure, "control_pressure": nan}  # the machine's own would stand against it
    if temperature is not None:
        given["temperature"] = parse(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE)
    return machine._replace(supply=machine.supply._replace(**given))


def _period(repeat, pulse, until):
    """Period of a repeated pulse, or infinity [s]."""
    if repeat is None:
        return float("inf")
    period = 1.0 / parse(repeat, RATE, where="--repeat", file=COMMAND_LINE)
    if until is not None:
        raise InputError([Culprit(COMMAND_LINE, "--until", "does not go with --repeat", "leave one of them out")])
    if pulse >= period:
        right = f"less than the period, {period * 1e3:g} ms"
        raise InputError([Culprit(COMMAND_LINE, "--pulse", "is longer than the period of --repeat", right)])
    return period


def _stroke(stroke):
    return {
        "delay_s": stroke.delay,
        "stroke_time_s": stroke.stroke_time,
        "seating_speed_m_s": stroke.seating_speed,
        "fluctuation": stroke.fluctuation,
        "reverses": stroke.reverses,
    }
