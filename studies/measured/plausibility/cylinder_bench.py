"""Checks of a cylinder against the machine.

The pressure is given, and is compared with the supply that is stated. The force is compared with that of the pressure:
the mean of both directions, in which friction cancels, and their difference, which friction makes positive.
"""

from collections.abc import Sequence

import numpy as np

from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, show
from apesim.studies.measured.plausibility.misreadings import (
    FORCE_FACTORS,
    explain_factor,
    explain_levels,
    list_pressure_misreadings,
)
from apesim.studies.measured.plausibility.rows import Case, Seen
from apesim.studies.measured.plausibility.signals import find_noise
from apesim.studies.measured.plausibility.thresholds import (
    MAX_LEFT_OF_SUPPLY,
    MAX_OFF_FORCE,
    MAX_OFF_FORCE_SHARE,
    MAX_OFF_REST,
    MAX_OFF_REST_SHARE,
)


def drop_repeated(findings: Sequence[Finding]) -> list[Finding]:
    """Keep the first finding of each check and channel of a file: the ways of a record are repeats of each other."""
    first = {(one.kind, one.check, one.file, one.channel): one for one in reversed(findings)}
    return [
        finding for finding in findings if finding is first[finding.kind, finding.check, finding.file, finding.channel]
    ]


def judge_given_pressure(case: Case, channel: str) -> Seen | None:
    """Compare the pressure with the supply that is stated."""
    run, ambient = case.run, case.machine.ambient.pressure
    level = float(np.median(run.given[channel]))
    off = level - run.supply
    if abs(off) <= MAX_OFF_REST + MAX_OFF_REST_SHARE * run.supply:
        return None
    tolerance = max(MAX_OFF_REST, MAX_LEFT_OF_SUPPLY * abs(off))
    misreading = explain_levels((level,), (run.supply,), (tolerance,), list_pressure_misreadings(ambient))
    shown = [f"{1e-3 * (pressure - ambient):.4g} kPa gauge" for pressure in (level, run.supply)]
    seen = Seen(f"lies at {shown[0]}, the supply is stated as {shown[1]}").explained(misreading)
    return seen._replace(right=f"{seen.right}, or the supply that it was") if misreading else seen


def judge_force(case: Case, channel: str) -> Seen | None:
    """Compare the force with that of the pressure."""
    run, machine = case.run, case.machine
    pushed, force = run.given["velocity"] > 0.0, run.channels[channel]
    if case.blamed or pushed.all() or not pushed.any():
        return None
    of_pressure = machine.rig.piston_area * (run.given["pressure"] - machine.ambient.pressure)
    gap = force - of_pressure
    means = [0.5 * float(np.median(values[pushed]) + np.median(values[~pushed])) for values in (force, of_pressure)]
    if abs(means[0] - means[1]) > MAX_OFF_FORCE + MAX_OFF_FORCE_SHARE * abs(means[1]):
        text = f"is {show(run.bench, channel, means[0])} in the mean of both directions, "
        seen = Seen(f"{text}the pressure on the bore makes {show(run.bench, channel, means[1])}")
        if means[0] * means[1] < 0.0:
            right = "turn its sign: it is positive where the air pushes"
            return seen._replace(kind=Kind.FAULT, reason="inverted?", right=right)
        return seen.explained(explain_factor(means[0] / means[1], FORCE_FACTORS, MAX_OFF_FORCE_SHARE))
    friction = 0.5 * float(np.median(gap[pushed]) - np.median(gap[~pushed]))
    if friction < -max(3.0 * find_noise(force), 0.01 * abs(means[1])):
        seen_less = (
            f"is less where the stroke rises than where it falls, by {show(run.bench, channel, -2.0 * friction)}"
        )
        reason, right = "does the stroke fall where the drive pushes?", "turn its sign: it rises against the pressure"
        return Seen(seen_less, Kind.FAULT, reason, right, Check.INVERTED, "stroke")
    return None
