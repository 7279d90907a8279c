"""The command line of apesim."""

import gc
import os
import signal
import sys
import warnings
from typing import Annotated, NoReturn

import typer

from apesim.cache import CacheWarning, remove_temporary_folders
from apesim.studies.commands.archive import archive
from apesim.studies.commands.doctor import check_installation
from apesim.studies.commands.engine import engine
from apesim.studies.commands.explore import explore_machine
from apesim.studies.commands.fmu import fmu
from apesim.studies.commands.gap import gap
from apesim.studies.commands.machine import print_machine
from apesim.studies.commands.measured import measured
from apesim.studies.commands.new import make_machine_file
from apesim.studies.commands.options import register
from apesim.studies.commands.paper import repeat_paper
from apesim.studies.commands.report import write_report
from apesim.studies.commands.valve import valve
from apesim.studies.terminal.console import INTERRUPTED, main_of

app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Simulate air-powered engines whose intake is opened by an electro-pneumatic valve.",
)
app.add_typer(valve, name="valve")
app.add_typer(engine, name="engine")
app.add_typer(fmu, name="fmu")
app.add_typer(archive, name="archive")
app.add_typer(gap, name="gap")
app.add_typer(measured, name="measured")
register(app, "new", make_machine_file)
register(app, "machine", print_machine)
register(app, "report", write_report)
register(app, "explore", explore_machine)
register(app, "paper", repeat_paper)
register(app, "doctor", check_installation)


def _show_version(asked: bool) -> None:
    """Print the version and end, where it was asked for."""
    if asked:
        import apesim

        print(f"apesim {apesim.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Options of apesim itself."""


def _interrupt(*_: object) -> None:
    """Raise it; and if whoever was at work took no notice, end at once when it comes again."""
    signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))
    raise KeyboardInterrupt


def main() -> NoReturn:
    r"""Run the command line `apesim` on the arguments of the process, and end the process with its exit code."""
    # A fifth of the start would be the collector's, which finds nothing among what is imported.
    gc.set_threshold(100_000, 20, 20)
    # Matrices are small here: several threads only wait for one another.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ["MPLBACKEND"] = "Agg"  # figures go into files, in whatever thread they are drawn
    warnings.simplefilter("ignore", CacheWarning)  # said where something is compiled, in a line of the console
    signal.signal(signal.SIGINT, _interrupt)
    code = main_of(app)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is over
    if code == INTERRUPTED:
        remove_temporary_folders()
        os._exit(code)  # what is at work in another thread need not come to its end
    sys.exit(code)


if __name__ == "__main__":
    main()
