"""The comparison of valves over speed, as an archive."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import nan
from typing import Any

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import column, run_axis, run_text, values_of
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.indicators import COUNTS, INDICATORS
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.quantities.settings import dumps
from apesim.studies.assessment.causes import CAUSES, EXERGY, LATENESS, LOSSES, MEASURES, ORDERS, REAL, VALVES, losses
from apesim.studies.assessment.valves import CYCLES, OUTCOMES, Assessment, Outcome, assess, without_valves
from apesim.studies.timing.solve import Timing, corrected, start_after

TIMINGS = (FIXED, CORRECTED) = ("fixed", "corrected")


def _commanded(machine: Machine, speeds: Sequence[float], timing: str) -> Iterator[Machine | None]:
    """Give the machine, at each speed, its own commands or those that meet its targets; None: out of reach."""
    before: list[tuple[float, Timing]] = []
    for speed in speeds:
        if timing == FIXED:
            yield machine
            continue
        corrected_timing = corrected(machine, speed, start_after(machine, speed, before))
        if corrected_timing.reachable:
            before.append((speed, corrected_timing))
        yield corrected_timing.machine if corrected_timing.reachable else None


def assess_speeds(
    machine: Machine,
    speeds: Sequence[float],
    timing: str = FIXED,
    command: str = "",
    report: Callable[[int, int], Any] | None = None,
) -> Archive:
    """Compare the valves over speeds [rad/s], and find what each cause costs; the archive has a run for each.

    The speeds are those of the crankshaft; the machine has an electro-pneumatic valve. `timing` is "fixed", the
    machine's own commands, or "corrected", those that meet its targets. `command` is the command line that the archive
    keeps; `report` is called with the number of speeds done and the number of all.
    """
    points: list[Assessment] = []

    # The speeds go in their order, as each corrected command is looked for from those of the speeds before it.
    for speed, timed in zip(speeds, _commanded(machine, speeds, timing), strict=True):
        points.append(assess(timed, speed) if timed else without_valves(speed, nan, nan, Outcome.OUT_OF_REACH))
        if report:
            report(len(points), len(speeds))
    valves = np.stack([point.valves for point in points])
    lost = losses(valves)

    # Axes of the archive, and what each run has once: its speed, its commands, its outcome.
    variables = {
        "run": run_axis(len(points)),
        "valve": Variable(("valve",), np.array(list(VALVES)), "1", _listed(VALVES)),
        "order": Variable(("order",), np.array(list(ORDERS)), "1", _listed(ORDERS)),
        "cause": Variable(("cause",), np.array(list(CAUSES)), "1", _listed(CAUSES)),
        "speed_rpm": column(
            [float(f"{s / TURN * 60.0:.12g}") for s in speeds], *INDICATORS["speed_rpm"], coordinate=True
        ),
        "energise_deg": column(
            [point.energise / DEGREE for point in points], "deg", "crank angle at which the solenoids are energised"
        ),
        "release_deg": column([point.release / DEGREE for point in points], "deg", "crank angle of the release"),
        "outcome": column([point.outcome for point in points], "1", "whether all valves could be compared", OUTCOMES),
    }

    # Each measure has its loss beside it. Torque is lost and air is added, which the text of the column says.
    for number, (name, (unit, description)) in enumerate(MEASURES.items()):
        variables[name] = Variable(("run", "valve"), valves[..., number].copy(), unit, f"{description} with each valve")
        lost_name, sign = list(LOSSES.items())[number]
        what = f"{description} {'lost' if sign < 0.0 else 'added'} by each cause in each order"
        variables[lost_name] = Variable(("run", "order", "cause"), lost[..., number].copy(), unit, what)

    # The exergy ledger has no axis of causes: it is compared between the valves only.
    exergy = np.stack([point.exergy for point in points])
    for number, (name, (description, _)) in enumerate(EXERGY.items()):
        values = exergy[..., number].copy()
        variables[f"exergy_{name}_J"] = Variable(("run", "valve"), values, "J", f"{description}, in a cycle")

    # The real valve alone: the others are given their angles or their lift, and have no commands to be late after.
    for name in REAL:
        unit, description = INDICATORS[name]
        kind = np.int64 if name in COUNTS else float
        values = np.array([point.real[name] for point in points], dtype=kind)
        variables[name] = column(values, unit, f"{description}; of the real valve")
    for stroke in ("opening", "closing"):
        for name, (unit, description) in LATENESS.items():
            parts = [point.lateness[f"{stroke}_{name}"] for point in points]
            variables[f"{stroke}_{name}"] = column(parts, unit, f"{stroke} of the real valve: {description}")
    variables["cycle_to_cycle_torque_Nm"] = column(
        [point.cycle_to_cycle for point in points],
        "N m",
        f"largest change of the real valve's indicated torque from a cycle to the next, of {CYCLES}",
    )
    provenance = {"kind": "engine assess", "command": command, "kernels": sources_hash(), "timing": timing}
    return Archive(dumps(machine), provenance, variables)


def _listed(meanings: Mapping[str, str]) -> str:
    return ", ".join(f"{name}: {meaning}" for name, meaning in meanings.items())


def faults_of_assessment(archive: Archive) -> list[str]:
    """Write a line for each speed at which not all valves could be compared: what is the matter, and what to change."""
    v, lines = values_of(archive), []
    for run, (outcome, change) in enumerate(zip(v["outcome"], v["cycle_to_cycle_torque_Nm"], strict=True)):
        if outcome != Outcome.COMPLETE:
            line = f"{run_text(archive, run)}: {Outcome(outcome).remedy}"
            changes = f"; its indicated torque changes by up to {change:.3g} N m from a cycle to the next"
            lines.append(line + (changes if outcome == Outcome.NOT_PERIODIC else ""))
    return lines


def undefined_ratios(archive: Archive) -> list[str]:
    """Write lines that say where valves do no work, so that their air over work is undefined.

    There is a line for each kind of work and each set of valves, with the speeds.
    """
    v = values_of(archive)
    speeds: dict[tuple[str, str], list[str]] = {}
    for work in ("indicated", "brake"):
        for torques, speed in zip(v[f"{work}_torque_Nm"], v["speed_rpm"], strict=True):
            idle = ", ".join(name for name, torque in zip(VALVES, torques, strict=True) if torque <= 0.0)
            if idle:
                speeds.setdefault((work, idle), []).append(f"{speed:g}")
    return [
        f"{work} work of {idle} is not positive at {', '.join(texts)} r/min: air over it is null"
        for (work, idle), texts in speeds.items()
    ]
