"""Moving picture of a machine: valve and crank to scale, by the traces of a cycle, with pressures coloured."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.report.figures.labels import ONE_FRAME, Axis, Frames, find_shown_unit
from apesim.studies.report.figures.packing import ArrayPool
from apesim.studies.report.motion import Snapshot, motion_geometry, render_motion

STATES = {
    "lift": ("lift", "m"),
    "pressure_a": ("pA", "Pa abs"),
    "pressure_b": ("pB", "Pa abs"),
    "cylinder_pressure": ("pCylinder", "Pa abs"),
    "receiver_pressure": ("pReceiver", "Pa abs"),
}
"""Traces that move the picture: their names in the script, and their units."""
STILL_ANGLE = 40.0
"""Crank angle of the still picture [deg]: the valve is open, or opens."""


@dataclass(frozen=True)
class Moving:
    """A machine that moves along the traces of a cycle, for each frame."""

    title: str
    machine: Machine
    x: Axis
    x_values: Sequence[np.ndarray]
    """Crank angles [deg], for each frame or for all."""
    traces: Sequence[Mapping[str, np.ndarray]]
    """`STATES` over them for each frame, in SI."""
    has_engine: bool = True
    line: int = 0
    """Number of its line in the figures beside it, whose loops mark its point."""
    note: str = ""
    frames: Frames = ONE_FRAME

    kind = "moving"

    @property
    def highest(self) -> float:
        """Highest pressure of all frames [Pa abs]."""
        pressures = [traces[name] for traces in self.traces for name in STATES if name != "lift" and name in traces]
        return max((float(np.nanmax(each)) for each in pressures if np.isfinite(each).any()), default=1e6)

    def write_still(self) -> str:
        """Write the picture of one instant."""
        traces = self.traces[self.frames.start % len(self.traces)]
        x = self.x_values[self.frames.start % len(self.x_values)]
        at = int(np.abs(x - STILL_ANGLE).argmin()) if self.has_engine else len(x) // 2
        values = {name: float(np.nan_to_num(traces[name][at])) for name in STATES if name in traces}
        snapshot = Snapshot(
            float(x[at]) if self.has_engine else 0.0,
            values.get("lift", 0.0),
            values.get("pressure_a", 0.0),
            values.get("pressure_b", 0.0),
            values.get("cylinder_pressure", 0.0),
            values.get("receiver_pressure", self.machine.supply.pressure),
        )
        return render_motion(self.machine, snapshot, self.highest, self.has_engine)

    def data(self, pool: ArrayPool) -> dict[str, Any]:
        """Sizes and traces as the script takes them; in the units of the curves, so that none is stored twice."""
        shown = {}
        for name, (key, unit) in STATES.items():
            factor, _ = find_shown_unit(unit)
            if all(name in traces for traces in self.traces):
                shown[key] = {
                    "factor": 1.0 / factor,
                    "values": [pool.add(traces[name] * factor) for traces in self.traces],
                }
        return {
            "kind": self.kind,
            "geometry": motion_geometry(self.machine, self.highest, self.has_engine),
            "x": self.x.data | {"values": [pool.add(x) for x in self.x_values]},
            "traces": shown,
            "line": self.line,
            "period": 360 if self.has_engine else 0,
            "still": STILL_ANGLE if self.has_engine else None,
        }
