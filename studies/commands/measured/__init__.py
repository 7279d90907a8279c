"""The commands of measured data."""

from apesim.studies.commands.measured.check import check_measured_folder
from apesim.studies.commands.options import group

measured = group("Measured data: a folder with a measured.toml.", {"check": check_measured_folder})
