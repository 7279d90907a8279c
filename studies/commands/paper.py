"""Command `apesim paper`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.options import Common, Overwrite


def repeat_paper(
    common: Common,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder to make.")],
    overwrite: Overwrite = False,
) -> int:
    """Repeat the paper, doi 10.1631/jzus.A0820373: its figures and a table of its claims."""
    import json
    import sys
    import time
    from functools import partial

    from apesim.archive import command_line, read_digest
    from apesim.quantities import parse_range
    from apesim.quantities.settings import dumps
    from apesim.studies.console import DONE, INCOMPLETE, plain
    from apesim.studies.discharge import discharge
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.figures.paper import captions_of, paper_figures
    from apesim.studies.operating_conditions import PRESSURE, TEMPERATURE
    from apesim.studies.output import digest_line, make_folder, publish, write_traces
    from apesim.studies.paper.area import claims_by_area
    from apesim.studies.paper.claim import range_in_words
    from apesim.studies.paper.claims import all_claims
    from apesim.studies.paper.discharge import discharge_tests
    from apesim.studies.paper.friction import friction_table, map_friction
    from apesim.studies.paper.page import write_page
    from apesim.studies.paper.subject import differences
    from apesim.studies.tables import table_of
    from apesim.studies.valve_map import PRESSURES, PULSE, TEMPERATURES, compute_map, faults_of_map
    from apesim.valve.bench import run_bench

    console, machine, folder = common.console, common.load_machine(), out
    make_folder(folder, overwrite)
    console.warm_up(run_bench, machine, PULSE)
    start = time.perf_counter()
    grid = parse_range(PRESSURES, PRESSURE, machine.ambient.pressure), parse_range(TEMPERATURES, TEMPERATURE)

    def compute(report):
        command = command_line(["apesim", *sys.argv[1:]])
        archive = compute_map(machine, *grid, PULSE, command, partial(report, "pressure and temperature"))
        vessel, records = discharge_tests(machine)
        found = discharge(vessel, records)
        by_area = claims_by_area(machine, *grid, report=partial(report, "areas of the solenoids"))
        frictions = map_friction(machine, report=partial(report, "frictions"))
        claims = all_claims(machine, archive, found, by_area, frictions)
        return vessel, archive, frictions, claims, paper_figures(machine, archive, found, frictions, folder)

    with console.stages("paper") as report:
        vessel, archive, frictions, claims, drawn = call_in_thread(compute, report).result()
    publish(archive, folder / "valve_map.h5", overwrite=True)
    digest = read_digest(folder / "valve_map.h5")
    told = [plain(claim._asdict()) for claim in claims]
    (folder / "claims.json").write_text(json.dumps(told, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    (folder / "machine.toml").write_text(dumps(machine, folder), encoding="utf-8")
    friction_map = folder / "friction_map.csv"
    write_traces(friction_map, *friction_table(frictions))
    captions, different = captions_of(vessel, frictions), differences(machine)
    page = write_page(claims, captions, different, frictions, folder)
    faults = faults_of_map(archive)
    wall = time.perf_counter() - start
    data = {
        "claims": told,
        "different_from_the_papers_valve": different,
        "page": str(page),
        "content_sha256": digest,
        "figures": [str(path) for path in drawn],
        "friction_map": str(friction_map),
        "faults": faults,
        "wall_time_s": wall,
    }
    rows = [(claim.claim, claim.paper, claim.ours, claim.verdict, range_in_words(claim)) for claim in claims]
    header = ("claim", "paper", "model", "verdict", "holds for")
    table = table_of("The paper's claims", header, rows, left=range(len(header)))
    whose = f"judged on {claims[0].judged_on}"
    areas = (
        "holds for: effective areas of the solenoids, which the paper does not print, from a quarter of their bore on"
    )
    written = f"{page}: {len(claims)} claims, {len(captions)} figures in {wall:.1f} s"
    console.result(data, table, whose, areas, written, digest_line(digest))
    for line in faults:
        console.message(line)
    return INCOMPLETE if faults else DONE
