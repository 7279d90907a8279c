"""Command `apesim engine timing`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Figures, Jobs, Overwrite, Speeds, SupplyPressures, SupplyTemperatures


def correct_timing(
    common: Common,
    target: Annotated[
        str | None,
        typer.Option(metavar="ANGLES", help='Opening and closing, e.g. "-5 deg, 70 deg"; the machine\'s if left out.'),
    ] = None,
    speed: Speeds = "300:2400:150 rpm",
    pressure: SupplyPressures = "0.6:1.4:0.4 MPa gauge",
    temperature: SupplyTemperatures = "250 K, 287 K, 322 K",
    out: Annotated[
        Path, typer.Option(metavar="F.h5", help="Archive to write; CSV, JSON and C header stand beside it.")
    ] = Path("timing.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
) -> int:
    """Command angles that make the valve really open and close at its targets."""
    import numpy as np

    from apesim.archive import ArchiveError
    from apesim.quantities import parse_range
    from apesim.studies.figures.timing import timing_figures
    from apesim.studies.operating_conditions import SPEED, parse_supplies
    from apesim.studies.output import compute_archive, refuse_to_replace, written_text
    from apesim.studies.timing.export import as_json, export, exports_of
    from apesim.studies.timing.grid import faults_of_timing, map_timing
    from apesim.studies.timing.header import error_text
    from apesim.studies.timing.solve import corrected
    from apesim.studies.timing.summary import LEGEND, law_lines, timing_table
    from apesim.studies.timing.table import Axes
    from apesim.studies.timing.targets import with_targets

    machine = with_targets(common.load_machine(), target)
    speeds = parse_range(speed, SPEED, where="--speed", file=COMMAND_LINE)
    supplies = parse_supplies(machine, pressure=pressure, temperature=temperature)
    axes = Axes(*map(np.array, (speeds, *supplies)))
    if out in exports_of(out):
        raise ArchiveError(out, "is the name of an export beside the archive", "choose e.g. --out timing.h5")
    if not overwrite:
        for path in exports_of(out):
            refuse_to_replace(path)
    maps = []

    def compute(command, report):
        maps.append(map_timing(machine, axes, jobs, command=command, report=report))
        return maps[0].archive

    def draw(archive, folder):
        return timing_figures(maps[0], machine.ambient.pressure, folder) if figures else []

    _, written = compute_archive(
        common.console,
        task="timing",
        first_march=(corrected, machine, speeds[0]),
        compute=compute,
        out=out,
        overwrite=overwrite,
        draw=draw,
    )
    (found,) = maps
    exported = export(found, out)
    faults = faults_of_timing(found.archive)
    data = as_json(found) | written | {"exports": [str(path) for path in exported], "faults": faults}
    where = written_text(written, f"{len(data['points'])} points") + "; " + ", ".join(path.name for path in exported)
    error = f"error of the interpolated table: {error_text(found.error)}"
    common.console.result(data, timing_table(found, machine), LEGEND, *law_lines(found.laws, machine), error, where)
    for fault in faults:
        common.console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE
