"""Command `apesim valve discharge`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE
from apesim.studies.options import Common, Figures, Overwrite


def evaluate_discharge(
    common: Common,
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Discharge tests: CSV of time and pressure.")],
    volume: Annotated[str, typer.Option(metavar="V", help='Of the vessel, e.g. "50 cm^3".')],
    temperature: Annotated[
        str | None, typer.Option(metavar="T", help="Of the air at the start; ambient if left out.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="F.csv", help="Curve to write.")] = Path("curve.csv"),
    overwrite: Overwrite = False,
    figures: Figures = True,
) -> int:
    """Effective area of a solenoid valve from discharge tests (Eq. 10), with its uncertainty."""
    import time

    import numpy as np

    from apesim.air import gas_of
    from apesim.quantities import parse
    from apesim.studies.discharge import Vessel, discharge, read_tests
    from apesim.studies.discharge.evaluation import HEADER
    from apesim.studies.discharge.summary import discharge_json, discharge_lines
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.figures.discharge import discharge_figures
    from apesim.studies.operating_conditions import TEMPERATURE, VOLUME
    from apesim.studies.output import refuse_to_replace, write_traces

    console, machine = common.console, common.load_machine()
    cubic_metres = parse(volume, VOLUME, where="--volume", file=COMMAND_LINE)
    kelvins = machine.ambient.temperature
    if temperature:
        kelvins = parse(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE)
    records = read_tests(files, machine.ambient.pressure)
    if not overwrite:
        refuse_to_replace(out)
    start = time.perf_counter()
    vessel = Vessel(cubic_metres, kelvins, machine.ambient.pressure, gas_of(machine.air))
    found = call_in_thread(discharge, vessel, records).result()
    wall = time.perf_counter() - start
    write_traces(out, HEADER, found.curve * np.array([1e3, 1.0, 1e6, 1e6, 1e6]))
    drawn = discharge_figures(vessel, found, out.with_suffix(".figures")) if figures else []
    data = discharge_json(found, vessel) | {
        "curve": str(out),
        "figures": [str(path) for path in drawn],
        "wall_time_s": wall,
        "warnings": found.warnings,
    }
    console.result(data, *discharge_lines(found, data))
    for warning in found.warnings:
        console.message(f"warning: {warning}")
    return DONE
