"""Commands `apesim fmu valve` and `apesim fmu engine`."""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Overwrite, as_options, group

FmuFile = Annotated[Path, typer.Option("--out", "-o", metavar="F.fmu", help="FMU to write.")]
Version = Annotated[int, typer.Option("--fmi", metavar="2|3", help="Version of the standard FMI.")]


def export_valve(
    common: Common, out: FmuFile = Path("valve.fmu"), fmi: Version = 2, overwrite: Overwrite = False
) -> None:
    """The valve on its bench as an FMU for co-simulation, which other programs load without Python.

    Inputs are the command, and pressure and temperature of the control air; outputs are lift, velocity, pressures and
    control air. Numbers of the machine are parameters. It needs a C compiler, or the package ziglang, which makes
    libraries for Linux and Windows. The first export of a kind compiles for half a minute.
    """
    _export(common, "valve", out, fmi, overwrite)


def export_engine(
    common: Common, out: FmuFile = Path("engine.fmu"), fmi: Version = 2, overwrite: Overwrite = False
) -> None:
    """The engine as an FMU for co-simulation, which other programs load without Python.

    It begins in its periodic state. It needs a C compiler, or the package ziglang, which makes libraries for Linux and
    Windows. The first export of a kind compiles for a minute.
    """
    _export(common, "engine", out, fmi, overwrite)


def _export(common: Common, model: str, out: Path, fmi: int, overwrite: bool) -> None:
    """Export a model, and say what was written."""
    from apesim.studies.fmu.export import export_fmu

    machine = common.load_machine()
    with as_options("export_fmu"):
        fmu = export_fmu(machine, model, out, fmi=fmi, overwrite=overwrite)
    data = fmu.to_dict()
    lines = [
        f"{out}: written, FMI {fmi}, {data['bytes'] / 1e3:.0f} kB, for {' and '.join(fmu.platforms)}",
        _line("inputs", fmu.inputs),
        _line("outputs", fmu.outputs),
        _line("parameters", fmu.parameters),
        _line("fixed at export", [*fmu.fixed, "all curves and choices"]),
    ]
    common.console.result(data, "\n".join(lines))


def _line(what: str, names: Iterable[str]) -> str:
    """Line that lists names."""
    return f"{what}: {', '.join(names)}"


fmu = group("Files that simulation programs load without Python.", {"valve": export_valve})
