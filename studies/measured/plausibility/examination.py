"""All checks of a folder of measured data, against a machine."""

from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.measured.plausibility.benches import check_cylinder_run, check_engine_run, check_valve_run
from apesim.studies.measured.plausibility.cylinder_bench import drop_repeated
from apesim.studies.measured.plausibility.expected import Expected
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, group_findings
from apesim.studies.measured.plausibility.folder import check_folder, escalate_crank_angle, escalate_still
from apesim.studies.measured.plausibility.impossible import find_spoilt, without
from apesim.studies.measured.plausibility.machine_file import FLIGHT_KEYS, check_machine
from apesim.studies.measured.plausibility.records import check_ends, check_masked, check_record, describe_spoilt
from apesim.studies.measured.runs import CYLINDER, ENGINE, VALVE, Measured, MeasuredRun

BENCHES = {VALVE: check_valve_run, ENGINE: check_engine_run, CYLINDER: check_cylinder_run}
"""Checks of a run against the machine, by bench."""

FOLLOWERS = {
    Check.LEVEL: (Check.STILL, Check.CLIPPED),
    Check.LIFT: (Check.CLIPPED,),
    Check.SUPPLY: (Check.STILL, Check.CLIPPED),
    Check.AT_ITS_END: (Check.QUANTISED, Check.CLIPPED),
}
"""Checks whose findings say nothing new where one of others stands at the same channel."""
RUN_FOLLOWERS = {Check.LEVEL: Check.PULSE, Check.MOTION_MISSED: Check.TIME_UNIT}
"""Checks whose warnings say nothing new where another one finds a fault of the run."""
EXPLAINED_BY = {
    "valve.stroke": (Check.LIFT, Check.STROKE),
    "effects.sensor_gain.lift": (Check.STROKE,),
    "supply.pressure": (Check.SUPPLY,),
    "valve.solenoid.dead_time": (Check.TIME_ZERO,),
} | dict.fromkeys(FLIGHT_KEYS, (Check.FLIGHT,))
"""Checks whose faults a key of the machine would explain."""
OF_THE_MACHINE = (Check.TIME_ZERO, Check.PULSE)
"""Checks that blame a run for what a machine with a wrong number makes."""


class Examination(NamedTuple):
    """What the checks say of a folder."""

    findings: list[Finding]
    """Faults first, then warnings, then hints; each in the order of the runs."""
    expected: list[Expected | None]
    """What the machine shows of each run as it is stated; None: it could not be simulated."""

    def select(self, kind: Kind) -> list[Finding]:
        """Findings of one kind."""
        return [finding for finding in self.findings if finding.kind == kind]


def examine(
    machine: Machine | None, measured: Measured, report: Callable[[str, int, int], object] | None = None
) -> Examination:
    """Check whether measured data can be what they are said to be.

    Without a machine, None, the records are checked by themselves alone. `report` is called with the name of the stage,
    the runs that are checked and all runs.
    """
    findings: list[Finding] = []
    expected: list[Expected | None] = []
    runs: list[MeasuredRun] = []
    for number, run in enumerate(measured.runs):
        # What cannot be is said once, and the checks behind it judge the rest.
        spoilt = [] if machine is None else find_spoilt(machine, run, number)
        findings += [describe_spoilt(run, each) for each in spoilt]
        run = without(run, spoilt)
        runs.append(run)

        # The record by itself, and then against the machine, of which each bench has its own checks.
        masked = [each for each in measured.masked if each.run == number]
        findings += check_record(run, number, measured.noise, [*masked, *spoilt])
        check = BENCHES.get(run.bench)
        more, shown = check(machine, run, number) if machine is not None and check else ([], None)
        findings += more
        if machine is not None and not any(finding.kind == Kind.FAULT for finding in more):  # else that is the reason
            findings += [describe_spoilt(run, each) for each in find_spoilt(machine, run, number, max_share=1.0)]
        expected.append(shown)
        for channel in run.channels:
            known = shown is not None and channel in shown.channels
            findings += check_ends(run, number, channel, shown.at(channel, run) if shown and known else None)
        if report:
            report("plausibility", number + 1, len(measured.runs))

    # What all runs say of the machine file. A wrong flight of it explains times for which single runs were blamed.
    if machine is not None:
        wrong = list(check_machine(machine, measured._replace(runs=tuple(runs)), expected, findings))
        if any(finding.check == Check.FLIGHT for finding in wrong):
            findings = [finding for finding in findings if finding.check not in OF_THE_MACHINE]
        findings += wrong

    # Only what stands by itself is left before findings that all runs share are made faults.
    if measured.bench == CYLINDER:
        findings = drop_repeated(findings)
    findings = escalate_still([*_drop_followers(findings), *check_masked(measured), *check_folder(measured)], measured)
    findings = escalate_crank_angle(findings, measured)
    order = list(Kind)
    return Examination(sorted(findings, key=lambda one: (order.index(one.kind), one.run)), expected)


def _drop_followers(findings: Sequence[Finding]) -> list[Finding]:
    """Findings less those that only follow from another one of the same channel, or of the same run."""
    by_channel = {(finding.run, finding.channel, finding.check) for finding in findings}
    by_run = {(finding.run, finding.check) for finding in findings if finding.kind == Kind.FAULT}

    def follows(finding: Finding) -> bool:
        channel = "pressure_a" if finding.check == Check.SUPPLY else finding.channel
        leaders = FOLLOWERS.get(finding.check, ())
        explained_by = RUN_FOLLOWERS.get(finding.check)
        by_fault = finding.kind == Kind.WARNING and (finding.run, explained_by) in by_run
        return by_fault or any((finding.run, channel, leader) in by_channel for leader in leaders)

    return [finding for finding in findings if not follows(finding)]


def refuse_faults(machine: Machine | None, measured: Measured, free: Collection[str] = ()) -> list[str]:
    """Refuse data that cannot be what they are said to be, and pass on what may be wrong, as warnings of one line.

    Without a machine, None, the records are checked by themselves alone. `free` are keys of the machine that are to be
    fitted: what they would explain refuses nothing, and is a warning. Raises InputError with every fault.
    """
    examination = examine(machine, measured)
    fitted = {check for key in free for check in EXPLAINED_BY.get(key, ())}
    faults = examination.select(Kind.FAULT)
    refusing = [finding for finding in faults if finding.check not in fitted]
    if refusing:
        raise InputError(finding.to_fault(measured.folder) for finding in refusing)
    grouped = group_findings([*faults, *examination.select(Kind.WARNING)])
    return [f"{finding}{f' (and {more} more files alike)' if more else ''}" for finding, more in grouped]
