"""Checks of a valve's run against the machine that simulate it anew: the pulse, and channels that do not move."""

from math import isfinite, nan

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility.expected import Expected, expect
from apesim.studies.measured.plausibility.findings import Kind, show
from apesim.studies.measured.plausibility.motion import TIMED, find_motions, judge_pulse, moves
from apesim.studies.measured.plausibility.rows import CHAMBERS, Case, Seen
from apesim.studies.measured.plausibility.signals import find_edges, find_levels, find_span
from apesim.studies.measured.plausibility.thresholds import MIN_MOVED
from apesim.studies.measured.runs import MeasuredRun

MAX_PULSE_SEEN = 10.0
"""Longest pulse that a run is simulated for in search of the true one [s]."""


def expect_motion(machine: Machine, run: MeasuredRun) -> Expected | None:
    """What the machine shows of the channels of a run, and of all that tell when the valve moves."""
    return expect(machine, run._replace(channels=dict.fromkeys([*run.channels, *TIMED], run.times)))


def judge_stated_pulse(case: Case, key: str) -> Seen | None:
    """Judge the pulse; the case goes on with what the machine shows of the one that it must have been."""
    simulated, expected, width = case.run.pulse, case.expected, _find_width(case)
    if not find_motions(case.run, case.values, expected) and 0.0 < width < MAX_PULSE_SEEN:
        simulated = width
        expected = expect_motion(case.machine, case.run._replace(pulse=width)) or expected
    seen, pulse = judge_pulse(case, expected, simulated)
    if seen and pulse > 0.0:  # a second time, from nearer by: how long the valve is open does not follow it exactly
        nearer = expect_motion(case.machine, case.run._replace(pulse=pulse))
        if nearer is not None:
            seen, _ = judge_pulse(case, nearer, pulse)
        if seen and seen.kind == Kind.FAULT:
            expected = nearer or expected
    return (seen or Seen(""))._replace(mended=case._replace(expected=expected))


def _find_width(case: Case) -> float:
    """Time for which the valve was open by the first channel that tells it [s]; NaN: none does."""
    for channel in (*CHAMBERS, "lift"):
        if channel in case.values:
            edges = find_edges(case.run.times, case.values[channel], rises=channel != "pressure_a")
            if isfinite(edges.returns - edges.leaves):
                return edges.returns - edges.leaves
    return nan


def judge_still(case: Case, channel: str) -> Seen | None:
    """Tell whether a channel does not move where the machine's does: at samples at rest neither does."""
    timed = [name for name in case.values if name in TIMED]
    still = [name for name in timed if _is_still(case, name)]
    if channel not in still:
        return None
    there, bench = case.expected.at(channel, case.run), case.run.bench
    seen = f"stays at {show(bench, channel, *find_levels(case.values[channel]))}, where the machine shows "
    seen += show(bench, channel, float(np.nanmin(there)), float(np.nanmax(there)))
    if channel in CHAMBERS and (moving := [name for name in timed if name not in still]):
        right = f"{moving[0].replace('_', ' ')} moves: leave the column out"
        return Seen(seen, Kind.FAULT, "is the sensor connected, its tap open?", right)
    return Seen(seen)


def _is_still(case: Case, channel: str) -> bool:
    """Whether a channel stays where it is, and the machine's goes a good part of its whole way."""
    over_ambient = case.run.supply - case.machine.ambient.pressure
    whole, there = case.machine.valve.stroke if channel == "lift" else over_ambient, case.expected.at(channel, case.run)
    return find_span(there) > MIN_MOVED * whole and not moves(case.values[channel], there)
