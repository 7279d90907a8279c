"""Command `apesim engine timing`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import (
    Common,
    ControlPressures,
    Figures,
    Jobs,
    Overwrite,
    Report,
    Speeds,
    SupplyPressures,
    SupplyTemperatures,
    as_options,
)
from apesim.studies.run.default_grids import TIMING_SPEEDS
from apesim.studies.terminal.console import DONE, INCOMPLETE


def correct_timing(
    common: Common,
    target: Annotated[
        str | None,
        typer.Option(metavar="ANGLES", help='Opening and closing, e.g. "-5 deg, 70 deg"; the machine\'s if left out.'),
    ] = None,
    speed: Speeds = TIMING_SPEEDS,
    pressure: SupplyPressures = None,
    control_pressure: ControlPressures = None,
    temperature: SupplyTemperatures = None,
    out: Annotated[
        Path, typer.Option(metavar="F.h5", help="Archive to write; CSV, JSON and C header stand beside it.")
    ] = Path("timing.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
    report: Report = None,
) -> int:
    """Command angles that make the valve really open and close at its targets."""
    import sys

    from apesim.archive import command_line
    from apesim.studies.execution.output import written_json, written_text
    from apesim.studies.report.writing import prepare_page
    from apesim.studies.timing import correction
    from apesim.studies.timing.export import exports_of
    from apesim.studies.timing.summary import error_line, law_lines, shortcut_line, timing_tables

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)

    # The map, with its exports beside the archive. Faults in its arguments are named as options.
    with as_options("correct_timing"), console.progress("timing") as show_progress:
        result = correction.correct_timing(
            machine,
            target=target,
            speed=speed,
            pressure=pressure,
            control_pressure=control_pressure,
            temperature=temperature,
            jobs=jobs,
            out=out,
            overwrite=overwrite,
            progress=show_progress,
            call=command_line(["apesim", *sys.argv[1:]]),
        )

    # Where everything lies: archive and figures, and the exports, whose names follow from that of the archive.
    drawn = result.draw(out.with_suffix(".figures")) if figures else []
    written = written_json(out, drawn, result["wall_time"]) | write_page(out)
    exports = exports_of(out)
    data = result.to_dict() | written | {"exports": [str(path) for path in exports], "faults": result.failed}
    where = written_text(written, f"{result['runs']} points") + "; " + ", ".join(path.name for path in exports)

    # Laws and tables, at the machine's own air: its pressure is that of the axis, of the supply or of the control air.
    laws = law_lines(result.map.laws, result.ambient_pressure)
    own = {"supply_pressure": machine.supply.pressure, "control_pressure": machine.supply.control().pressure}
    supply = own[result.map.pressure_axis], machine.supply.temperature
    tables = timing_tables(result.map, supply, result.ambient_pressure)
    console.result(data, *tables, shortcut_line(result.map), *laws, error_line(result.map), where)

    # A point whose targets are out of reach leaves the others valid; the exit code says that the map has gaps.
    for fault in result.failed:
        console.message(f"warning: {fault}")
    return INCOMPLETE if result.failed else DONE
