"""Models that an FMU can have, by their names."""

from collections.abc import Callable

from apesim.engine.machine import Machine
from apesim.studies.fmu.model import Model
from apesim.studies.fmu.valve_model import valve_model

MODELS: dict[str, Callable[[Machine], Model]] = {"valve": valve_model}
"""Functions from a machine to its model."""
