"""Command `apesim engine optimise`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Figures, Jobs, Out, Overwrite, Speeds

if TYPE_CHECKING:
    from apesim.engine.machine import Machine

GOALS = ("torque", "air", "both")
FREE_KEY = "supply.pressure"


def optimise_commands(
    common: Common,
    goal: Annotated[
        str, typer.Option("--for", metavar="GOAL", help="torque: the most; air: the least specific air; or both.")
    ] = "both",
    speed: Speeds = "600:1800:300 rpm",
    free: Annotated[
        str | None,
        typer.Option(metavar="KEY=LOW:HIGH", help='Also "supply.pressure=0.5 MPa gauge:1.5 MPa gauge".'),
    ] = None,
    out: Out = Path("optimise.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
) -> int:
    """Command angles for most torque, least specific air, or the best of both.

    In the coupled periodic state. For both, the Pareto front stands beside the two optima: commands than which no
    others give more torque with no more air. Exit code 3 where no commands give brake work.
    """
    from apesim.engine.steady import run_steady
    from apesim.quantities import Choice, parse, parse_range
    from apesim.studies.figures.optimise import optimise_figures
    from apesim.studies.operating_conditions import SPEED
    from apesim.studies.optimise.landscape import Goal
    from apesim.studies.optimise.summary import end_lines, optimum_table, point_json
    from apesim.studies.optimise.table import archive_of, faults_of, optima_over_speed
    from apesim.studies.output import compute_archive, written_text
    from apesim.studies.timing.targets import require_epv

    machine = common.load_machine()
    require_epv(machine)
    goal = GOALS[parse(goal, Choice(GOALS, "command line"), where="--for", file=COMMAND_LINE)]
    goals = tuple(Goal) if goal == "both" else (Goal[goal.upper()],)
    speeds = parse_range(speed, SPEED, where="--speed", file=COMMAND_LINE)
    pressures = _pressures(machine, free)
    optima = []

    def compute(command, report):
        optima.extend(optima_over_speed(machine, speeds, goals, pressures, jobs, report))
        return archive_of(machine, optima, goals, pressures, command)

    def draw(archive, folder):
        return optimise_figures(archive, machine.ambient.pressure, folder) if figures else []

    archive, written = compute_archive(
        common.console,
        task="optimise",
        first_march=(run_steady, machine, speeds[0]),
        compute=compute,
        out=out,
        overwrite=overwrite,
        draw=draw,
    )
    faults = faults_of(optima)
    stated = {key: text for key, text in archive.provenance.items() if key.startswith(("criterion", "searched_"))}
    data = {"for": goal, **stated, "points": [point_json(one) for one in optima], "faults": faults}
    counted = ", ".join(f"{sum(getattr(one, name) for one in optima)} {name}" for name in ("sketches", "runs"))
    where = written_text(written, f"{len(optima)} speeds, {counted},")
    table = optimum_table(optima, machine.ambient.pressure)
    common.console.result(data | written, table, *end_lines(optima), where)
    for fault in faults:
        common.console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE


def _pressures(machine: "Machine", free: str | None) -> tuple[float, float] | None:
    """Both ends of a supply pressure set free, or None [Pa abs]."""
    from apesim.quantities import Culprit, InputError
    from apesim.studies.identify.free import free_parameters

    if free is None:
        return None
    form = f"write {FREE_KEY}=0.5 MPa gauge:1.5 MPa gauge"
    key, equals, _ = free.partition("=")
    if key.strip() != FREE_KEY or not equals:
        wrong = f"{free!r} is not the supply pressure with its bounds"
        raise InputError([Culprit(COMMAND_LINE, "--free", wrong, form)])
    (found,) = free_parameters(machine, [free])
    return found.low, found.high
