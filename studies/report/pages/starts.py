"""The page of starts over keys: from which angles each engine starts, or how fast."""

import numpy as np

from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.report.figures.rings import Rings
from apesim.studies.report.grid import Cubes
from apesim.studies.report.pages.tables import list_runs
from apesim.studies.report.sections import Content, Fact, Section
from apesim.studies.transient.start_archive import intervals_of
from apesim.studies.transient.start_map import StartMap

NUMBERS = "starting_share", "time_s", "turns", "engine_air_kg", "control_air_kg", "highest_speed_rpm"
"""Variables that are drawn over the keys."""


def write_starts(result: ArchiveResult) -> Content:
    """Say from which angles engines start, or how fast, over keys."""
    assert isinstance(result, StartMap)
    archive, cubes = result.archive, Cubes(result.archive)
    sections = []
    shares = archive.variables["starting_share"].values
    if result.is_of_all_angles:
        runs, names = result.rings()
        rows = [(name, intervals_of(archive, run)) for run, name in zip(runs, names, strict=True)]
        said = f"; {len(runs)} of {len(archive.runs)} machines" if len(runs) < len(archive.runs) else ""
        note = f"Angle of the shaft at rest, 0 at top dead centre of the first cylinder{said}"
        sections.append(Section("Angles from which it starts", [Rings("Starting angles", rows, note)]))
    figures = [figure for name in NUMBERS if (figure := cubes.draw(name))]
    if figures:
        sections.append(Section("Over what was varied", figures))
    keys = [axis.name for axis in cubes.run_axes]
    table = list_runs(archive, (*keys, "starts", *NUMBERS))
    if table:
        sections.append(Section("All machines", tables=[table]))
    starting = int(np.count_nonzero(archive.variables["starts"].values))
    count = len(archive.runs)
    summary = f"{count} machines were started from rest; {starting} of them start"
    if result.is_of_all_angles:
        best = int(np.argmax(shares))
        summary += f" from some angle, the best ({cubes.name_run(best)}) from {100.0 * shares[best]:.0f} % of all"
    facts = [
        Fact(f"{100.0 * share:.0f}", "%", f"of all angles, {cubes.name_run(run)}")
        for run, share in enumerate(shares[:6])
    ]
    said = "; ".join(f"{name.replace('_', ' ')} {text}" for name, text in result.conditions.items())
    return Content(
        "Starts from rest",
        f"{summary}. {said[:1].upper()}{said[1:]}.",
        facts if result.is_of_all_angles else [],
        sections,
    )
