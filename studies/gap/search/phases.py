"""Which phase of a stroke or of a cycle each sample belongs to."""

from enum import StrEnum
from math import isnan
from typing import Any

import numpy as np

from apesim.engine.angles import TURN
from apesim.studies.estimation.nuisance_space import NuisanceSpace
from apesim.studies.estimation.residuals import Block, WhitenedResiduals
from apesim.studies.measured import CYLINDER, ENGINE
from apesim.studies.measured.prediction import MEANS


class Phase(StrEnum):
    """A phase of the valve's stroke, of an engine's cycle, or of the way of a cylinder."""

    DEAD_TIME = "dead time"
    OPENING_FLIGHT = "opening flight"
    IMPACT = "impact"
    DWELL = "dwell"
    CLOSING_FLIGHT = "closing flight"
    CHARGING = "charging"
    EXPANSION = "expansion"
    EXHAUST = "exhaust"
    INWARD = "stroke against the pressure"
    OUTWARD = "stroke with the pressure"


PHASES = tuple(Phase)
"""All phases; samples hold their places in it."""
IMPACT_TIME = 3e-3
"""Time after a contact for which a sample belongs to it: rebounds are over by then [s]."""
CYLINDER_SENSORS = ("cylinder_pressure", "cylinder_temperature", "receiver_pressure")
"""Sensors of an engine that follow the cycle, not the stroke of the valve."""


def find_phases(block: Block, marks: dict[str, Any]) -> np.ndarray:
    """The phase of the stroke or cycle of each sample, (n,): its place in `PHASES`, -1 for a mean over the cycle.

    Samples of the valve, and of the valve's sensors on an engine, are in dead time, flight, impact or dwell; pressures
    and temperature of an engine's cylinder and receiver are in charging, expansion or exhaust. `marks` are the instants
    that divide them [s], see `Prediction`.
    """
    times = block.times
    if block.sensor in MEANS:
        return np.full(len(times), -1)
    if block.run.bench == CYLINDER:
        against = block.run.given["velocity"] > 0.0
        return np.where(against, PHASES.index(Phase.INWARD), PHASES.index(Phase.OUTWARD))
    if block.run.bench == ENGINE:
        period = TURN / block.run.speed
        times = times % period
        if block.sensor in CYLINDER_SENSORS:
            return _find_cycle_phases(times, marks, period)
    phase_of_sample = np.full(len(times), PHASES.index(Phase.DWELL))
    for command, start, contact, flight in (
        ("energise", "opening_start", "opening_contact", Phase.OPENING_FLIGHT),
        ("release", "closing_start", "closing_contact", Phase.CLOSING_FLIGHT),
    ):
        edge, begin, end = marks[command], marks[start], marks[contact]
        horizon = np.inf if command == "release" else marks["release"]
        begin = horizon if isnan(begin) else begin
        end = horizon if isnan(end) else end
        phase_of_sample[(times >= edge) & (times < begin)] = PHASES.index(Phase.DEAD_TIME)
        phase_of_sample[(times >= begin) & (times < end)] = PHASES.index(flight)
        phase_of_sample[(times >= end) & (times < end + IMPACT_TIME)] = PHASES.index(Phase.IMPACT)
    return phase_of_sample


def _find_cycle_phases(times: np.ndarray, marks: dict[str, Any], period: float) -> np.ndarray:
    """The phase of the cycle at times within it: charging, expansion or exhaust."""

    def within(name: str) -> np.ndarray:
        opens, closes = marks[f"{name}_opens"], marks[f"{name}_closes"]
        return (times - opens) % period < (closes - opens) % period

    phase_of_sample = np.full(len(times), PHASES.index(Phase.EXPANSION))
    # From the exhaust's opening to the groove's: exhaust and recompression.
    since = (times - marks["exhaust_opens"]) % period
    phase_of_sample[since < (marks["groove_opens"] - marks["exhaust_opens"]) % period] = PHASES.index(Phase.EXHAUST)
    phase_of_sample[within("groove")] = PHASES.index(Phase.CHARGING)
    return phase_of_sample


def find_local_shapes(residuals: WhitenedResiduals, marks: list[dict[str, Any]], space: NuisanceSpace) -> np.ndarray:
    """Shapes of a gap of unknown cause: a constant and a slope of each channel over each phase, alike in all runs.

    Whatever its cause, a gap has some of them; what nuisances can imitate is taken off. They are columns (n + p, m) of
    `WhitenedResiduals.at` [standard deviations]; `marks` divide each run.
    """
    cells = [find_phases(block, marks[block.number]) for block in residuals.blocks]
    columns = []
    for sensor in dict.fromkeys(block.sensor for block in residuals.blocks):
        for phase in range(-1, len(PHASES)):
            pairs = zip(cells, residuals.blocks, strict=True)
            inside = [(cell == phase) & (block.sensor == sensor) for cell, block in pairs]
            if not any(i.any() for i in inside):
                continue
            for power in (0, 1):
                arrays = [_ramp(i, power) for i in inside]
                column = residuals.whiten(arrays)[:, 0]
                columns.append(np.append(column, np.zeros(len(residuals.parameters))))
    return space.project_out(np.column_stack(columns))


def _ramp(inside: np.ndarray, power: int) -> np.ndarray:
    """A constant (power 0) or a slope (1) over the samples inside a phase, 0 outside of it."""
    ramp = np.zeros(len(inside))
    if inside.any():
        ramp[inside] = np.linspace(-1.0, 1.0, int(inside.sum())) ** power
    return ramp
