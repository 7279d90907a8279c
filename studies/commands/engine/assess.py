"""Command `apesim engine assess`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Figures, Out, Overwrite, Speeds


def assess_valve(
    common: Common,
    speed: Speeds = "300:2400:100 rpm",
    timing: Annotated[
        str,
        typer.Option(metavar="NAME", help="fixed: the machine's commands; corrected: those that meet its targets."),
    ] = "fixed",
    out: Out = Path("assessment.h5"),
    overwrite: Overwrite = False,
    figures: Figures = True,
) -> int:
    """What the valve's lateness, finite speed, fluctuation and control air cost in torque and air.

    What lateness and finite speed cost depends on which of them comes first: both orders, and their mean.
    """
    from apesim.engine.steady import run_steady
    from apesim.quantities import Culprit, InputError, parse_range
    from apesim.studies.assessment.grid import TIMINGS, assess_speeds, faults_of_assessment, undefined_ratios
    from apesim.studies.assessment.summary import EXPLAINED, points_of, tables_of
    from apesim.studies.figures.assessment import assessment_figures
    from apesim.studies.operating_conditions import SPEED
    from apesim.studies.output import compute_archive, written_text
    from apesim.studies.timing.targets import require_epv

    machine = common.load_machine()
    require_epv(machine)
    speeds = parse_range(speed, SPEED, where="--speed", file=COMMAND_LINE)
    if timing not in TIMINGS:
        right = f"write {' or '.join(TIMINGS)}"
        raise InputError([Culprit(COMMAND_LINE, "--timing", f"{timing!r} is no timing", right)])

    def compute(**options):
        return assess_speeds(machine, speeds, timing, **options)

    def draw(archive, folder):
        return assessment_figures(archive, folder) if figures else []

    archive, written = compute_archive(
        common.console,
        task="assessment",
        first_march=(run_steady, machine, speeds[0]),
        compute=compute,
        out=out,
        overwrite=overwrite,
        draw=draw,
    )
    faults, warnings = faults_of_assessment(archive), undefined_ratios(archive)
    data = {"points": points_of(archive), "faults": faults, "warnings": warnings} | written
    common.console.result(data, *tables_of(archive), EXPLAINED, written_text(written, f"{len(speeds)} points"))
    for line in faults + warnings:
        common.console.message(f"warning: {line}")
    return INCOMPLETE if faults else DONE
