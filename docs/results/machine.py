"""The default machine, drawn to scale."""

from functools import partial
from math import pi

from apesim.engine.machine import Machine
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.machine import machine_figure
from docs.results import Number
from docs.results._figures import keep


def compute():
    """Its picture, and the displacement that it has."""
    machine = Machine()
    keep(partial(write_figures, {"machine": partial(machine_figure, machine)}), machine="machine")
    swept = 0.25 * pi * machine.engine.bore**2 * machine.engine.stroke
    return {"displacement": Number(1e6 * swept, "cm³", error=0.05)}
