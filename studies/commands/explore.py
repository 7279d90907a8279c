"""Command `apesim explore`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, as_options


def explore_machine(
    common: Common,
    machine: Annotated[Path | None, typer.Argument(metavar="[M]", help="Machine file, as --machine.")] = None,
    speed: Annotated[str, typer.Option(metavar="N", help="Speed to begin with.")] = "1000 rpm",
    port: Annotated[int | None, typer.Option(metavar="PORT", help="Port to listen at; a free one if left out.")] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open the page in a browser.")] = False,
    measured: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Measured runs of an engine, laid over the curves.")
    ] = None,
) -> None:
    """Open a live page: sliders, and the engine that is run again while they move.

    The page is for this computer alone. Ctrl-C ends it.
    """
    from apesim.quantities import Fault, InputError
    from apesim.studies.explore import live_page
    from apesim.studies.terminal.console import COMMAND_LINE

    if machine is not None and common.machine_file is not None:
        raise InputError([Fault(COMMAND_LINE, "M", "stands beside --machine", "give one of them")])
    if machine is not None:
        common = common._replace(machine_file=machine)

    def tell(address: str) -> None:
        common.console.result({"address": address}, f"{address} (Ctrl-C ends it)")

    with as_options("explore"):
        live_page.explore(
            common.load_machine(), speed=speed, port=port, browser=not no_browser, measured=measured, ready=tell
        )
