"""Command `apesim paper`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Jobs, Overwrite


def repeat_paper(
    common: Common,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder to make.")],
    jobs: Jobs = None,
    overwrite: Overwrite = False,
) -> int:
    """Repeat the paper, doi 10.1631/jzus.A0820373: its figures and a table of its claims."""
    import sys

    from apesim.archive import command_line
    from apesim.studies.execution.output import digest_line, make_folder
    from apesim.studies.paper import repetition
    from apesim.studies.paper.claims.claim import range_in_words
    from apesim.studies.terminal.console import DONE, INCOMPLETE
    from apesim.studies.terminal.tables import table_of

    console, machine = common.console, common.load_machine()

    # A folder that cannot be taken is refused before the paper is repeated, and may be written to from then on.
    make_folder(out, overwrite)
    call = command_line(["apesim", *sys.argv[1:]])
    with console.stages("paper") as report:
        result = repetition.repeat_paper(machine, jobs=jobs, progress=report, call=call)
    written = result.write(out, overwrite=True)

    # The claims with their verdicts, the valve that they are judged on, and the areas that the paper leaves open.
    claims, data = result.claims, result.to_dict() | written
    rows = [(claim.claim, claim.paper, claim.ours, claim.verdict, range_in_words(claim)) for claim in claims]
    header = ("claim", "paper", "model", "verdict", "holds for")
    table = table_of("The paper's claims", header, rows, left=range(len(header)))
    whose = f"judged on {claims[0].judged_on}"
    areas = (
        "holds for: effective areas of the solenoids, which the paper does not print, from a quarter of their bore on"
    )

    # A figure counts once, whatever formats it is written in.
    n_figures = len({path.removesuffix(".png").removesuffix(".pdf") for path in written["figures"]})
    lines = f"{written['page']}: {len(claims)} claims, {n_figures} figures in {data['wall_time_s']:.1f} s"
    console.result(data, table, whose, areas, lines, digest_line(written["content_sha256"]))

    # Warnings are of strokes on the map of the valve that were not completed; the exit code tells of them.
    for line in result.warnings:
        console.message(line)
    return INCOMPLETE if result.warnings else DONE
