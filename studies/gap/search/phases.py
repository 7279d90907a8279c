"""Which phase of a stroke or of a cycle each sample belongs to."""

from math import isnan

import numpy as np

from apesim.engine.angles import TURN
from apesim.studies.measured import ENGINE
from apesim.studies.measured.prediction import MEANS

PHASES = (
    "dead time",
    "opening flight",
    "impact",
    "dwell",
    "closing flight",
    "charging",
    "expansion",
    "exhaust",
)
IMPACT = 3e-3
"""How long after a contact a sample belongs to it [s]."""
CYLINDER = ("cylinder_pressure", "cylinder_temperature", "receiver_pressure")


def phases(block, marks):
    """Number of the phase in `PHASES` of each sample, (n,) int array; -1 of a mean over the cycle.

    Parameters
    ----------
    block : apesim.studies.estimation.residuals.Block
    marks : dict
        See `apesim.studies.measured.prediction.Prediction`.
    """
    times = block.times
    if block.sensor in MEANS:
        return np.full(len(times), -1)
    if block.run.bench == ENGINE:
        period = TURN / block.run.speed
        times = times % period
        if block.sensor in CYLINDER:
            return _of_cycle(times, marks, period)
    found = np.full(len(times), PHASES.index("dwell"))
    for command, start, contact, flight in (
        ("energise", "opening_start", "opening_contact", "opening flight"),
        ("release", "closing_start", "closing_contact", "closing flight"),
    ):
        edge, begin, end = marks[command], marks[start], marks[contact]
        horizon = np.inf if command == "release" else marks["release"]
        begin = horizon if isnan(begin) else begin
        end = horizon if isnan(end) else end
        found[(times >= edge) & (times < begin)] = PHASES.index("dead time")
        found[(times >= begin) & (times < end)] = PHASES.index(flight)
        found[(times >= end) & (times < end + IMPACT)] = PHASES.index("impact")
    return found


def _of_cycle(times, marks, period):
    def within(name):
        opens, closes = marks[f"{name}_opens"], marks[f"{name}_closes"]
        return (times - opens) % period < (closes - opens) % period

    found = np.full(len(times), PHASES.index("expansion"))
    # From the exhaust's opening to the groove's: exhaust and recompression.
    since = (times - marks["exhaust_opens"]) % period
    found[since < (marks["groove_opens"] - marks["exhaust_opens"]) % period] = PHASES.index("exhaust")
    found[within("groove")] = PHASES.index("charging")
    return found


def local_shapes(problem, marks, space):
    """A shape for each channel and phase, free of what nuisances can imitate, as columns of `Problem.errors`.

    A constant and a slope over the stretch, the same in all runs: whatever the cause, a gap has some of them.

    Parameters
    ----------
    problem : apesim.studies.estimation.residuals.Problem
    marks : list of dict
        Of each run.
    space : apesim.studies.estimation.nuisance_space.NuisanceSpace

    Returns
    -------
    (n + p, m) float array
    """
    cells = [phases(block, marks[block.number]) for block in problem.blocks]
    columns = []
    for sensor in dict.fromkeys(block.sensor for block in problem.blocks):
        for phase in range(-1, len(PHASES)):
            pairs = zip(cells, problem.blocks, strict=True)
            inside = [(cell == phase) & (block.sensor == sensor) for cell, block in pairs]
            if not any(i.any() for i in inside):
                continue
            for power in (0, 1):
                arrays = [_ramp(i, power) for i in inside]
                column = problem.whiten(arrays)[:, 0]
                columns.append(np.append(column, np.zeros(len(problem.parameters))))
    return space.project_out(np.column_stack(columns))


def _ramp(inside, power):
    found = np.zeros(len(inside))
    if inside.any():
        found[inside] = np.linspace(-1.0, 1.0, int(inside.sum())) ** power
    return found
