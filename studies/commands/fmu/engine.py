"""Command `apesim fmu engine`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, FmiVersion, FmuFile, Overwrite, as_options


def export_engine(
    common: Common,
    out: FmuFile = Path("engine.fmu"),
    fmi: FmiVersion = 2,
    speed: Annotated[str, typer.Option(metavar="N", help="Speed at the start.")] = "1000 rpm",
    free: Annotated[bool, typer.Option("--free", help="A free shaft: its load is an input, not its speed.")] = False,
    overwrite: Overwrite = False,
) -> None:
    """The engine as an FMU for co-simulation, which other programs load without Python.

    It begins in its periodic state at a speed. Inputs are the command angles, pressure and temperature of the supply,
    and the shaft's speed or load; outputs are lift, pressures, torque, angle and air. Numbers of the machine are
    parameters. It needs a C compiler, or the package ziglang, which makes libraries for Linux and Windows. The first
    export compiles for a minute.
    """
    from apesim.studies.fmu.export import export_fmu

    machine = common.load_machine()
    with as_options("export_fmu"):
        exported = export_fmu(machine, "engine", out, fmi=fmi, speed=speed, free=free, overwrite=overwrite)
    common.console.result(exported.to_dict(), exported.summary())
