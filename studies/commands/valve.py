"""Commands of the valve's bench."""

import sys
import time

import numpy as np

from apesim.archive import command_line
from apesim.kernel import is_cold
from apesim.march import TOLERANCE, Status
from apesim.quantities import Pressure, Quantity, parse, parse_range
from studies.commands.machine import load_machine
from studies.commands.tables import COMPILING, table_of, write_traces
from studies.console import COMMAND_LINE, DONE, INCOMPLETE
from studies.output import publish, refuse_to_replace
from valve.bench import TRACE, run_bench

TIME = Quantity("ms", 0.01, 60000, "command line")
RATE = Quantity("Hz", 0.1, 1000, "command line")
PRESSURE = Pressure(0.02, 30, "command line")
TEMPERATURE = Quantity("K", 150, 600, "command line")
DUTY = Quantity("", 0.01, 0.99, "command line")


def bench_run(console, machine_file, settings, supply, temperature, pulse, until, repeat, csv):
    """One bench run; see `apesim valve run --help`.

    Returns
    -------
    int
        Exit code.
    """
    given = [("supply.pressure", supply), ("supply.temperature", temperature)]
    assignments = [f"{key}={value}" for key, value in given if value is not None]
    if supply is not None:
        assignments.append("supply.control_pressure=")  # the machine's own would stand against it
    machine = load_machine(machine_file, [*(settings or ()), *assignments])
    pulse = parse(pulse, TIME, where="--pulse", file=COMMAND_LINE)
    until = parse(until, TIME, where="--until", file=COMMAND_LINE) if until else None
    period = _period(repeat, pulse, until)
    if is_cold():
        console.message(COMPILING)
    run_bench(machine, pulse, until, period)  # compiles, or loads what is compiled
    start = time.perf_counter()
    run = run_bench(machine, pulse, until, period)
    wall = time.perf_counter() - start
    warnings = _warnings(run)
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
        (name, *(f"{factor * getattr(stroke, field):.5g}" for stroke in (run.opening, run.closing)), unit)
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


def _period(repeat, pulse, until):
    """Period of a repeated pulse, or infinity [s]."""
    from apesim.quantities import Culprit, InputError

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


def _warnings(run):
    """What a user should know of a bench run."""
    warnings = []
    if run.status != Status.DONE:
        warnings.append(f"the march ended early: {Status(run.status).remedy}")
    if run.orbit and not run.orbit.converged:
        warnings.append(f"not periodic after {run.orbit.cycles} cycles")
    if run.orbit and run.orbit.period == 2:
        warnings.append("the motion repeats only every second cycle")
    for name, stroke in (("opening", run.opening), ("closing", run.closing)):
        if np.isnan(stroke.contact):
            warnings.append(f"the {name} stroke is not completed")
    return warnings


def _supplies(machine, pressure, temperature):
    """Pressures [Pa abs] and temperatures [K] of a grid."""
    return (
        parse_range(pressure, PRESSURE, machine.ambient.pressure, where="--pressure", file=COMMAND_LINE),
        parse_range(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE),
    )


def map_command(console, machine_file, settings, pressure, temperature, pulse, out, overwrite, figures):
    """A map of the valve; see `apesim valve map --help`.

    Returns
    -------
    int
        Exit code.
    """
    from studies.figures.valve import map_figures
    from studies.valve_map import faults_of_map, map_valve

    machine = load_machine(machine_file, settings)
    pressures, temperatures = _supplies(machine, pressure, temperature)
    pulse = parse(pulse, TIME, where="--pulse", file=COMMAND_LINE)
    if not overwrite:
        refuse_to_replace(out)
    if is_cold():
        console.message(COMPILING)
    run_bench(machine, pulse)  # compiles, or loads what is compiled
    start = time.perf_counter()
    with console.progress("map") as report:
        archive = map_valve(machine, pressures, temperatures, pulse, command_line(["apesim", *sys.argv[1:]]), report)
    wall = time.perf_counter() - start
    publish(archive, out, overwrite)
    drawn = map_figures(archive, machine.ambient.pressure, out.with_suffix(".figures")) if figures else []
    faults = faults_of_map(archive)
    v = {name: variable.values for name, variable in archive.variables.items()}
    rows = [
        (
            f"{(p - machine.ambient.pressure) / 1e6:.3g}",
            f"{t:g}",
            *(f"{1e3 * v[name][run]:.4f}" for name in _TIMES),
            *(f"{v[name][run]:.4f}" for name in _SPEEDS),
        )
        for run, (p, t) in enumerate(zip(v["supply_pressure"], v["supply_temperature"], strict=True))
    ]
    header = (
        "MPa gauge",
        "K",
        "open t_d [ms]",
        "t_f [ms]",
        "close t_d [ms]",
        "t_f [ms]",
        "open v_e [m/s]",
        "close v_e",
    )
    data = {
        "archive": str(out),
        "figures": [str(path) for path in drawn],
        "runs": len(rows),
        "faults": faults,
        "wall_time_s": wall,
    }
    where = f"{out}: {len(rows)} runs in {wall:.2f} s" + (f"; figures in {drawn[0].parent}/" if drawn else "")
    console.result(data, table_of("The valve over pressure and temperature", header, rows, left=()), where)
    for fault in faults:
        console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE


_TIMES = ("opening_delay_s", "opening_stroke_time_s", "closing_delay_s", "closing_stroke_time_s")
_SPEEDS = ("opening_seating_speed_m_s", "closing_seating_speed_m_s")


def limit_command(console, machine_file, settings, pressure, temperature, duty, out, overwrite, figures):
    """Working limits of the valve; see `apesim valve limit --help`.

    Returns
    -------
    int
        Exit code.
    """
    from studies.figures.valve import limit_figures
    from studies.limit import CRITERION, is_complete, limit_map

    machine = load_machine(machine_file, settings)
    pressures, temperatures = _supplies(machine, pressure, temperature)
    duties = parse_range(duty, DUTY, where="--duty", file=COMMAND_LINE)
    if not overwrite:
        refuse_to_replace(out)
    if is_cold():
        console.message(COMPILING)
    is_complete(machine, 10.0, duties[0])  # compiles, or loads what is compiled
    start = time.perf_counter()
    with console.progress("limit") as report:
        command = command_line(["apesim", *sys.argv[1:]])
        archive = limit_map(machine, pressures, temperatures, duties, command, report)
    wall = time.perf_counter() - start
    publish(archive, out, overwrite)
    drawn = limit_figures(archive, machine.ambient.pressure, out.with_suffix(".figures")) if figures else []
    v = {name: variable.values for name, variable in archive.variables.items()}
    points = [
        {
            "supply_pressure_Pa": v["supply_pressure"][run],
            "supply_temperature_K": v["supply_temperature"][run],
            "duty": v["duty"][run],
            "limit_hz": v["limit_hz"][run],
            "limit_rpm": v["limit_rpm"][run],
        }
        for run in range(len(v["run"]))
    ]
    found = v["limit_hz"][~np.isnan(v["limit_hz"])]
    data = {
        "limit_hz": found.min() if len(found) == len(points) else None,
        "limit_rpm": 60.0 * found.min() if len(found) == len(points) else None,
        "criterion": CRITERION,
        "points": points,
        "archive": str(out),
        "figures": [str(path) for path in drawn],
        "wall_time_s": wall,
    }
    rows = [
        (
            f"{(point['supply_pressure_Pa'] - machine.ambient.pressure) / 1e6:.3g}",
            f"{point['supply_temperature_K']:g}",
            f"{point['duty']:g}",
            f"{point['limit_hz']:.2f}",
            f"{point['limit_rpm']:.0f}",
        )
        for point in points
    ]
    header = ("MPa gauge", "K", "duty", "limit [Hz]", "[r/min]")
    where = f"{out}: {len(rows)} limits in {wall:.1f} s" + (f"; figure in {drawn[0].parent}/" if drawn else "")
    console.result(data, table_of("Highest working rate", header, rows, left=()), f"criterion: {CRITERION}", where)
    missing = len(points) - len(found)
    if missing:
        console.message(f"warning: at {missing} points not even 1 Hz is complete: the supply cannot move the piston")
    return INCOMPLETE if missing else DONE
