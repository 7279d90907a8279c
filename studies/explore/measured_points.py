"""Measured runs of an engine that are laid over the curves of the page."""

from math import isnan
from typing import Any

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.quantities import Fault, InputError
from apesim.studies.explore.live_point import FIRST_ANGLE
from apesim.studies.measured.runs import Bench, Measured, MeasuredRun

MAX_POINTS = 90
"""Most points of a curve: more hide the line below them."""
OVERLAID = "lift", "pressure_a", "pressure_b", "cylinder_pressure", "receiver_pressure"
"""Channels that have a curve on the page."""


def overlays_of(measured: Measured) -> list[dict[str, Any]]:
    """Make of each run of an engine what the page lays over its curves; raises InputError for another bench."""
    if measured.bench != Bench.ENGINE:
        wrong = f"is of the {measured.bench} bench, and the page shows an engine"
        raise InputError([Fault(measured.folder, "bench", wrong, 'name a folder with bench = "engine"')])
    return [_overlay_of(run) for run in measured.runs]


def _overlay_of(run: MeasuredRun) -> dict[str, Any]:
    """What the page draws of a run, and the operating point that it was measured at, as texts for its sliders."""
    values = {
        "speed": f"{run.speed / TURN * 60.0:.6g} rpm",
        "supply.pressure": f"{run.supply / 1e6:.7g} MPa abs",
        "command.energise": f"{run.energise / DEGREE:.6g} deg",
        "command.release": f"{run.release / DEGREE:.6g} deg",
    }
    if not isnan(run.temperature):
        values["supply.temperature"] = f"{run.temperature:.6g} K"
    if not isnan(run.control_supply):
        values["supply.control_pressure"] = f"{run.control_supply / 1e6:.7g} MPa abs"
    curves = {name: _points_of(run.angles, run.channels[name]) for name in OVERLAID if name in run.channels}
    means = {name: float(value) for name, value in run.means.items()}
    return {"name": run.name, "values": values, "curves": curves, "means": means}


def _points_of(angles: np.ndarray, values: np.ndarray) -> dict[str, list[float]]:
    """Points of a channel over the angles of the page [deg], ascending, and not too many."""
    within = FIRST_ANGLE + (angles / DEGREE - FIRST_ANGLE) % 360.0
    order = np.argsort(within, kind="stable")
    order = order[np.isfinite(values[order])]
    order = order[:: max(1, -(-len(order) // MAX_POINTS))]
    return {"x": within[order].round(3).tolist(), "values": values[order].tolist()}
