"""Command `apesim valve run`."""

from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Pulse, Traces

if TYPE_CHECKING:
    from apesim.engine.machine import Machine
    from apesim.valve.measures import Stroke


def run_valve(
    common: Common,
    supply: Annotated[str | None, typer.Option(metavar="P", help='Control pressure, e.g. "0.49 MPa gauge".')] = None,
    temperature: Annotated[str | None, typer.Option(metavar="T", help='Of the supply, e.g. "287 K".')] = None,
    pulse: Pulse = "50 ms",
    until: Annotated[
        str | None, typer.Option(metavar="TIME", help="End of the run; twice the pulse if left out.")
    ] = None,
    repeat: Annotated[
        str | None, typer.Option(metavar="RATE", help='Repeat the pulse to the periodic state, e.g. "30 Hz".')
    ] = None,
    csv: Traces = None,
) -> int:
    """One bench run: delay time, full stroke time, seating speed, fluctuation, control air."""
    import time

    import numpy as np

    from apesim.march.adaptive import TOLERANCE, Status
    from apesim.quantities import parse
    from apesim.studies.operating_conditions import TIME
    from apesim.studies.output import write_traces
    from apesim.studies.tables import number, table_of
    from apesim.valve.bench import TRACE, run_bench
    from apesim.valve.warnings import judge_bench

    console, machine = common.console, _with_supply(common.load_machine(), supply, temperature)
    pulse = parse(pulse, TIME, where="--pulse", file=COMMAND_LINE)
    until = parse(until, TIME, where="--until", file=COMMAND_LINE) if until else None
    period = _period(repeat, pulse, until)
    console.warm_up(run_bench, machine, 10e-3)
    start = time.perf_counter()
    run = console.run("bench run", run_bench, machine, pulse, until, period)
    wall = time.perf_counter() - start
    warnings = [f"the march ended early: {Status(run.status).remedy}"]
    if run.status == Status.DONE:
        warnings = list(judge_bench(run).values())
    data = {
        "opening": _stroke_json(run.opening),
        "closing": _stroke_json(run.closing),
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


def _with_supply(machine: "Machine", supply: str | None, temperature: str | None) -> "Machine":
    """A machine with the supply of the command line; what is None stays as it is."""
    from math import nan

    from apesim.quantities import parse
    from apesim.studies.operating_conditions import PRESSURE, TEMPERATURE

    given = {}
    if supply is not None:
        pressure = parse(supply, PRESSURE, machine.ambient.pressure, where="--supply", file=COMMAND_LINE)
        given |= {"pressure": pressure, "control_pressure": nan}  # the machine's own would stand against it
    if temperature is not None:
        given["temperature"] = parse(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE)
    return machine._replace(supply=machine.supply._replace(**given))


def _period(repeat: str | None, pulse: float, until: float | None) -> float:
    """Period of a repeated pulse, or infinity [s]."""
    from apesim.quantities import Culprit, InputError, parse
    from apesim.studies.operating_conditions import RATE

    if repeat is None:
        return float("inf")
    period = 1.0 / parse(repeat, RATE, where="--repeat", file=COMMAND_LINE)
    if until is not None:
        raise InputError([Culprit(COMMAND_LINE, "--until", "does not go with --repeat", "leave one of them out")])
    if pulse >= period:
        right = f"less than the period, {period * 1e3:g} ms"
        raise InputError([Culprit(COMMAND_LINE, "--pulse", "is longer than the period of --repeat", right)])
    return period


def _stroke_json(stroke: "Stroke") -> dict:
    """What is reported of a stroke, for JSON."""
    return {
        "delay_s": stroke.delay,
        "stroke_time_s": stroke.stroke_time,
        "seating_speed_m_s": stroke.seating_speed,
        "fluctuation": stroke.fluctuation,
        "reverses": stroke.reverses,
    }
