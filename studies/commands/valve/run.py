"""Command `apesim valve run`."""

from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Pulse, Traces, as_options
from apesim.studies.terminal.console import DONE, INCOMPLETE


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
    import numpy as np

    from apesim.archive import find_target
    from apesim.results import NotConverged
    from apesim.studies.execution.output import write_traces
    from apesim.studies.run import valve_run
    from apesim.studies.terminal.tables import number, table_of
    from apesim.valve.bench import TRACE

    console, machine = common.console, common.load_machine()

    # A file that cannot be written is refused before anything is marched.
    if csv:
        find_target(csv)

    # A motion that does not repeat is shown all the same, as far as it was found.
    try:
        with as_options("run_valve"):
            run = console.run(
                "bench run",
                valve_run.run_valve,
                machine,
                supply=supply,
                temperature=temperature,
                pulse=pulse,
                until=until,
                repeat=repeat,
            )
    except NotConverged as error:
        run = error.result
    if csv:
        write_traces(csv, ("time [s]", *TRACE), np.column_stack((run.traces["time"], run.march.trace)))

    # Both strokes side by side, then the control air with the closures that say how far it can be trusted.
    rows = [
        (name, *(number(factor * run[f"{stroke}_{measure}"]) for stroke in ("opening", "closing")), unit)
        for name, measure, factor, unit in (
            ("delay time", "delay", 1e3, "ms"),
            ("full stroke time", "stroke_time", 1e3, "ms"),
            ("seating speed", "seating_speed", 1.0, "m/s"),
            ("fluctuation", "fluctuation", 1.0, "-"),
        )
    ]
    control = (
        f"control air {run['control_air'] * 1e3:.5g} g; closure of mass {run['mass_closure']:.1e}, of energy "
        f"{run['energy_closure']:.1e}; work by quadrature {run['work_closure']:.1e}; tolerance {run['tolerance']:g}"
    )
    console.result(run.to_dict(), table_of("One bench run", ("", "opening", "closing", "unit"), rows), control)
    for warning in run.warnings:
        console.message(f"warning: {warning}")
    return INCOMPLETE if run.converged is False else DONE
