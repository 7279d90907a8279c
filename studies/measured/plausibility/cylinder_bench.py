"""All checks of a run of the cylinder's bench against the machine."""

from collections.abc import Iterator, Sequence

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility.expected import Expected
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, show
from apesim.studies.measured.plausibility.misreadings import (
    FORCE_FACTORS,
    explain_factor,
    explain_levels,
    list_pressure_misreadings,
)
from apesim.studies.measured.plausibility.signals import find_noise
from apesim.studies.measured.plausibility.thresholds import (
    MAX_LEFT_OF_SUPPLY,
    MAX_OFF_FORCE,
    MAX_OFF_FORCE_SHARE,
    MAX_OFF_REST,
    MAX_OFF_REST_SHARE,
)
from apesim.studies.measured.prediction import predict, run_of
from apesim.studies.measured.runs import MeasuredRun


def check_cylinder_run(machine: Machine, run: MeasuredRun, number: int) -> tuple[list[Finding], Expected]:
    """Check a way to and fro of a cylinder against the machine, and give what the machine shows of it as stated.

    The pressure is given, and is compared with the supply that is stated. The force is compared with that of the
    pressure: the mean of both directions, in which friction cancels, and their difference, which friction makes
    positive. `number` is that of the run in the folder, from 0.

    A stroke that falls where the drive pushes the piston against the pressure, with a friction of 5 N:

    >>> times, velocity = np.arange(40.0), np.repeat([0.01, -0.01], 20)
    >>> given = {"stroke": np.cumsum(velocity), "velocity": velocity, "pressure": np.full(40, 0.5e6)}
    >>> force = machine.rig.piston_area * (0.5e6 - machine.ambient.pressure) if (machine := Machine()) else 0.0
    >>> channels = {"force": force - 5.0 * np.sign(velocity)}
    >>> run = MeasuredRun("a", "a.csv", 0.5e6, 287.0, np.nan, "fit", times, channels, "cylinder", given=given)
    >>> [finding.reason for finding in check_cylinder_run(machine, run, 0)[0]]
    ['does the stroke fall where the drive pushes?']
    """
    channels = predict(run_of(machine, run), run).channels
    findings = [*_check_pressure(machine, run, number)]
    if not findings and "force" in run.channels:
        findings += _check_force(machine, run, number)
    return findings, Expected(run.times, channels, {}, False)


def drop_repeated(findings: Sequence[Finding]) -> list[Finding]:
    """Keep the first finding of each check and channel of a file: the ways of a record are repeats of each other."""
    first = {(one.kind, one.check, one.file, one.channel): one for one in reversed(findings)}
    return [
        finding for finding in findings if finding is first[finding.kind, finding.check, finding.file, finding.channel]
    ]


def _check_pressure(machine: Machine, run: MeasuredRun, number: int) -> Iterator[Finding]:
    """Findings of the pressure against the supply that is stated."""
    ambient, level = machine.ambient.pressure, float(np.median(run.given["pressure"]))
    off = level - run.supply
    if abs(off) <= MAX_OFF_REST + MAX_OFF_REST_SHARE * run.supply:
        return
    tolerance = max(MAX_OFF_REST, MAX_LEFT_OF_SUPPLY * abs(off))
    misreading = explain_levels((level,), (run.supply,), (tolerance,), list_pressure_misreadings(ambient))
    shown = [f"{1e-3 * (pressure - ambient):.4g} kPa gauge" for pressure in (level, run.supply)]
    seen = f"lies at {shown[0]}, the supply is stated as {shown[1]}"
    kind = Kind.FAULT if misreading else Kind.WARNING
    reason = misreading.reason if misreading else "another run's?"
    right = f"{misreading.right}, or the supply that it was" if misreading else "write the supply that it was"
    yield Finding(kind, Check.SUPPLY, run.data, "pressure", seen, reason, right, number)


def _check_force(machine: Machine, run: MeasuredRun, number: int) -> Iterator[Finding]:
    """Findings of the force against that of the pressure."""
    pushed, force = run.given["velocity"] > 0.0, run.channels["force"]
    if pushed.all() or not pushed.any():
        return
    of_pressure = machine.rig.piston_area * (run.given["pressure"] - machine.ambient.pressure)
    gap = force - of_pressure
    means = [0.5 * float(np.median(values[pushed]) + np.median(values[~pushed])) for values in (force, of_pressure)]
    friction = 0.5 * float(np.median(gap[pushed]) - np.median(gap[~pushed]))
    if abs(means[0] - means[1]) > MAX_OFF_FORCE + MAX_OFF_FORCE_SHARE * abs(means[1]):
        seen = f"is {show(run.bench, 'force', means[0])} in the mean of both directions, "
        seen += f"the pressure on the bore makes {show(run.bench, 'force', means[1])}"
        kind, reason, right = Kind.WARNING, "bore, unit or zero of the load cell?", "write the bore as rig.bore"
        if means[0] * means[1] < 0.0:
            kind, reason, right = Kind.FAULT, "inverted?", "turn its sign: it is positive where the air pushes"
        elif misreading := explain_factor(means[0] / means[1], FORCE_FACTORS, MAX_OFF_FORCE_SHARE):
            kind, reason, right = Kind.FAULT, misreading.reason, misreading.right
        yield Finding(kind, Check.LEVEL, run.data, "force", seen, reason, right, number)
    elif friction < -max(3.0 * find_noise(force), 0.01 * abs(means[1])):
        seen = f"is less where the stroke rises than where it falls, by {show(run.bench, 'force', -2.0 * friction)}"
        reason, right = "does the stroke fall where the drive pushes?", "turn its sign: it rises against the pressure"
        yield Finding(Kind.FAULT, Check.INVERTED, run.data, "stroke", seen, reason, right, number)
