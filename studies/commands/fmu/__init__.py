"""The commands that write FMUs."""

from apesim.studies.commands.fmu.engine import export_engine
from apesim.studies.commands.fmu.valve import export_valve
from apesim.studies.commands.options import group

fmu = group(
    "Files (FMU) by which other programs simulate valve or engine, without Python.",
    {"valve": export_valve, "engine": export_engine},
)
