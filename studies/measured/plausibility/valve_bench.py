"""All checks of a run of the valve's bench against the machine."""

from collections.abc import Iterator
from math import isfinite, nan

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility.expected import Expected, expect
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, show
from apesim.studies.measured.plausibility.levels import (
    check_lift,
    check_pressure,
    check_supply,
    check_supply_temperature,
    check_temperature,
    check_velocity,
    find_supply_temperature,
)
from apesim.studies.measured.plausibility.motion import (
    CHAMBERS,
    TIMED,
    check_exchanged,
    check_inverted,
    check_pulse,
    check_swapped,
    check_time_unit,
    check_times,
    find_motions,
    moves,
)
from apesim.studies.measured.plausibility.signals import find_edges, find_levels, find_span, select_judged
from apesim.studies.measured.plausibility.thresholds import MIN_MOVED
from apesim.studies.measured.runs import MeasuredRun

MAX_PULSE_SEEN = 10.0
"""Longest pulse that a run is simulated for in search of the true one [s]."""


def check_valve_run(machine: Machine, run: MeasuredRun, number: int) -> tuple[list[Finding], Expected | None]:
    """Check a run of the valve's bench against the machine; `number` is the run's in the folder, from 0.

    What is found of a channel or a key is mended before the checks behind it, so that each fault is said once. Returns
    also what the machine shows of the run as it is stated; None: it could not be simulated, or stands over other times.

    >>> from apesim.studies.gap.example_bench import read_example
    >>> check_valve_run(Machine(), read_example().runs[0], 0)[0]
    []
    """
    channels = select_judged(run)
    if (finding := check_time_unit(run, number, channels)) is not None:
        return [finding], None
    asked = run._replace(channels=dict.fromkeys([*channels, *TIMED], run.times))
    stated = expect(machine, asked)
    if stated is None:
        return [not_simulated(run, number)], None
    findings = list(_check_channels(machine, run._replace(channels=channels), number, asked, stated))
    return findings, stated


def not_simulated(run: MeasuredRun, number: int) -> Finding:
    """The hint that a run could not be simulated, so that most checks were left out."""
    seen, right = "the machine cannot be simulated here", "what needs it is not checked; look at the machine file"
    return Finding(Kind.HINT, Check.NOT_SIMULATED, run.data, run.name, seen, "", right, number)


def _check_channels(
    machine: Machine, run: MeasuredRun, number: int, asked: MeasuredRun, expected: Expected
) -> Iterator[Finding]:
    """Findings of levels, then of motion, each fault mended before what is behind it."""
    values = dict(run.channels)
    supply = run.supply

    # Columns that stand for each other would make all checks of their levels wrong: they are judged no further.
    if (finding := check_exchanged(run, number, values, expected)) is not None:
        yield finding
        values = {name: array for name, array in values.items() if name not in ("lift", "pressure_a")}

    # The chambers, mended, and the supply behind them: it is judged by what chamber A shows at rest.
    for channel in CHAMBERS:
        if channel in values:
            judged = check_pressure(machine, run, number, channel, expected)
            if judged.finding:
                yield judged.finding
            values[channel] = judged.misreading.mend(values[channel])
    swapped = check_swapped(run, number, values, expected)
    if swapped:
        yield swapped
        values = {name: array for name, array in values.items() if name not in CHAMBERS}
    if "pressure_a" in values:
        finding, supply = check_supply(machine, run, number, "pressure_a", values["pressure_a"])
        if finding:
            yield finding
    if (finding := check_supply_temperature(run, number)) is not None:
        yield finding

    # The lift, first its levels: from which stop it is measured is seen only of one within the stroke.
    if "lift" in values:
        judged = check_lift(machine, run, number, expected)
        if judged.finding:
            yield judged.finding
        values["lift"] = judged.misreading.mend(values["lift"])
        if (finding := check_inverted(run, number, values["lift"], expected)) is not None:
            yield finding
            values["lift"] = machine.valve.stroke - values["lift"]

    # Motion depends on the supply: with a wrong one, times and pulse would be blamed for it.
    if supply != run.supply:
        expected = expect(machine, asked._replace(supply=supply)) or expected
    yield from _check_still(machine, run, number, values, expected)
    yield from _check_motion(machine, run, number, values, asked._replace(supply=supply), expected)

    # Temperatures and velocity, on which no other check depends.
    temperature = find_supply_temperature(machine, run)
    for channel in values:
        if channel.startswith("temperature"):
            if (finding := check_temperature(run, number, channel, temperature)) is not None:
                yield finding
        elif channel == "velocity":
            judged = check_velocity(run, number, expected)
            if judged.finding:
                yield judged.finding


def _check_motion(
    machine: Machine,
    run: MeasuredRun,
    number: int,
    values: dict[str, np.ndarray],
    asked: MeasuredRun,
    expected: Expected,
) -> Iterator[Finding]:
    """Findings of the pulse, then of the time zero with the pulse that it must have been."""
    simulated, width = run.pulse, _find_width(run, values)
    if not find_motions(run, values, expected) and 0.0 < width < MAX_PULSE_SEEN:
        simulated = width
        expected = expect(machine, asked._replace(pulse=width)) or expected
    finding, pulse = check_pulse(run, number, values, expected, simulated)
    if finding and pulse > 0.0:  # a second time, from nearer by: how long the valve is open does not follow it exactly
        nearer = expect(machine, asked._replace(pulse=pulse))
        if nearer is not None:
            finding, pulse = check_pulse(run, number, values, nearer, pulse)
        if finding and finding.kind == Kind.FAULT:
            expected = nearer or expected
    if finding:
        yield finding
    if (finding := check_times(run, number, values, expected)) is not None:
        yield finding


def _find_width(run: MeasuredRun, values: dict[str, np.ndarray]) -> float:
    """Time for which the valve was open by the first channel that tells it [s]; NaN: none does."""
    for channel in (*CHAMBERS, "lift"):
        if channel in values:
            edges = find_edges(run.times, values[channel], rises=channel != "pressure_a")
            if isfinite(edges.returns - edges.leaves):
                return edges.returns - edges.leaves
    return nan


def _check_still(
    machine: Machine, run: MeasuredRun, number: int, values: dict[str, np.ndarray], expected: Expected
) -> Iterator[Finding]:
    """Channels that do not move, where the machine's do: at samples at rest neither does."""
    whole = {"lift": machine.valve.stroke} | dict.fromkeys(CHAMBERS, run.supply - machine.ambient.pressure)
    shown = {name: expected.at(name, run) for name in values if name in TIMED}
    still = [
        name
        for name, there in shown.items()
        if find_span(there) > MIN_MOVED * whole[name] and not moves(values[name], there)
    ]
    others = [name for name in values if name in TIMED and name not in still]
    for name in still:
        low, high = find_levels(values[name])
        seen = f"stays at {show(run.bench, name, low, high)}, where the machine shows "
        seen += show(run.bench, name, float(np.nanmin(shown[name])), float(np.nanmax(shown[name])))
        if name in CHAMBERS and others:
            kind, reason = Kind.FAULT, "is the sensor connected, its tap open?"
            right = f"{others[0].replace('_', ' ')} moves: leave the column out"
        else:
            kind, reason = Kind.WARNING, "did the piston stick, was the pulse given, is the sensor connected?"
            right = "leave the run out, if it did not move"
        yield Finding(kind, Check.STILL, run.data, name, seen, reason, right, number)
