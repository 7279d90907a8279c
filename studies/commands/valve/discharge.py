"""Command `apesim valve discharge`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import DONE
from apesim.studies.options import Common, Figures, Overwrite, as_options


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
    from apesim.studies.discharge import effective_area
    from apesim.studies.discharge.summary import discharge_lines

    console, machine = common.console, common.load_machine()
    with as_options("evaluate_discharge", files="FILE"), console.progress("discharge") as report:
        found = effective_area.evaluate_discharge(
            machine,
            files,
            volume=volume,
            temperature=temperature,
            out=out,
            overwrite=overwrite,
            progress=report,
        )
    drawn = found.draw(out.with_suffix(".figures")) if figures else []
    paths = [str(path) for path in drawn]
    data = found.to_dict() | {"curve": str(out), "figures": paths, "wall_time_s": found["wall_time"]}
    console.result(data, *discharge_lines(found.evaluation, data))
    for warning in found.warnings:
        console.message(f"warning: {warning}")
    return DONE
