"""Command `apesim fmu valve`."""

from pathlib import Path

from apesim.studies.commands.options import Common, FmiVersion, FmuFile, Overwrite, as_options


def export_valve(
    common: Common, out: FmuFile = Path("valve.fmu"), fmi: FmiVersion = 2, overwrite: Overwrite = False
) -> None:
    """The valve on its bench as an FMU for co-simulation, which other programs load without Python.

    Inputs are the command, and pressure and temperature of the control air; outputs are lift, velocity, pressures and
    control air. Numbers of the machine are parameters. It needs a C compiler, or the package ziglang, which makes
    libraries for Linux and Windows. The first export compiles for some 20 s.
    """
    from apesim.studies.fmu.export import export_fmu

    machine = common.load_machine()
    with as_options("export_fmu"):
        exported = export_fmu(machine, "valve", out, fmi=fmi, overwrite=overwrite)
    common.console.result(exported.to_dict(), exported.summary())
