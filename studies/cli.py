"""The command line of apesim."""

import gc
import os
import signal
import sys
from pathlib import Path
from typing import Annotated

import typer

from apesim.cache import remove_temporary_folders
from apesim.studies.console import INTERRUPTED, main_of
from apesim.studies.groups.archive import archive
from apesim.studies.groups.engine import engine
from apesim.studies.groups.gap import gap
from apesim.studies.groups.valve import valve
from apesim.studies.options import Common, Overwrite, command

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Simulate air-powered engines whose intake is opened by an electro-pneumatic valve.",
)
app.add_typer(valve, name="valve")
app.add_typer(engine, name="engine")
app.add_typer(archive, name="archive")
app.add_typer(gap, name="gap")


def show_version(asked: bool):
    """Print the version and end, where it was asked for."""
    if asked:
        from importlib.metadata import version

        print(f"apesim {version('apesim')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=show_version, is_eager=True, help="Print the version.")
    ] = False,
):
    """Options of apesim itself."""


@command(app)
def machine(
    common: Common,
    check: Annotated[Path | None, typer.Option("--check", metavar="FILE", help="Check a machine file.")] = None,
):
    """Print the machine, every key commented; or check a machine file."""
    from apesim.studies.commands.machine import machine_command

    return machine_command(*common, check)


@command(app)
def paper(
    common: Common,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder to make.")],
    overwrite: Overwrite = False,
):
    """Repeat the paper, doi 10.1631/jzus.A0820373: its figures and a table of its claims."""
    from apesim.studies.commands.paper import paper_command

    return paper_command(*common, out, overwrite)


def _interrupt(*_):
    """Raise it; and if whoever was at work took no notice, end at once when it comes again."""
    signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))
    raise KeyboardInterrupt


def main():
    """Entry point of the command `apesim`."""
    # A fifth of the start would be the collector's, which finds nothing among what is imported.
    gc.set_threshold(100_000, 20, 20)
    # Matrices are small here: several threads only wait for one another.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    signal.signal(signal.SIGINT, _interrupt)
    code = main_of(app)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is over
    if code == INTERRUPTED:
        remove_temporary_folders()
        os._exit(code)  # what is at work in another thread need not come to its end
    sys.exit(code)
