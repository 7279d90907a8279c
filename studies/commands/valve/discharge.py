"""Command `apesim valve discharge`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Figures, Overwrite, as_options
from apesim.studies.terminal.console import DONE, INCOMPLETE


def evaluate_discharge(
    common: Common,
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="Discharge tests: CSV of time and pressure, or a folder with a measured.toml that names them.",
        ),
    ],
    volume: Annotated[str, typer.Option(metavar="V", help='Of the vessel, e.g. "50 cm^3".')],
    temperature: Annotated[
        str | None, typer.Option(metavar="T", help="Of the air at the start; ambient if left out.")
    ] = None,
    isothermal: Annotated[
        bool, typer.Option("--isothermal", help="The vessel is full of wire, and keeps its temperature (ISO 6358-2).")
    ] = False,
    out: Annotated[Path, typer.Option(metavar="F.csv", help="Curve to write.")] = Path("curve.csv"),
    overwrite: Overwrite = False,
    figures: Figures = True,
) -> int:
    """Effective area of a solenoid valve from discharge tests (Eq. 10), with its uncertainty."""
    from apesim.results import NotConverged
    from apesim.studies.discharge import effective_area
    from apesim.studies.discharge.summary import discharge_lines

    console, machine = common.console, common.load_machine()

    # The tests together give one curve. Faults in the arguments are named as options of the command line.
    with as_options("evaluate_discharge", files="FILE"), console.progress("discharge") as report:
        try:
            result = effective_area.evaluate_discharge(
                machine,
                files,
                volume=volume,
                temperature=temperature,
                isothermal=isothermal,
                out=out,
                overwrite=overwrite,
                progress=report,
            )
        except NotConverged as error:  # there is no curve, but figures that show why
            result = error.result

    # What was guessed of the records, or done to them, is told before the area that rests on it.
    console.notes(note for record in result.evaluation.records for note in record.notes)

    # Figures are drawn with or without a curve.
    has_curve = not result.evaluation.refusal
    drawn = result.draw(out.with_suffix(".figures")) if figures else []
    paths = [str(path) for path in drawn]
    curve = str(out) if has_curve else None
    data = result.to_dict() | {"curve": curve, "figures": paths, "wall_time_s": result["wall_time"]}
    console.result(data, *discharge_lines(result.evaluation, data))

    # A refusal is among the warnings, but stands in the lines of the result already.
    for warning in result.warnings:
        if warning != result.evaluation.refusal:
            console.message(f"warning: {warning}")
    return DONE if has_curve else INCOMPLETE
