"""Checks of the runs of a folder against each other."""

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from apesim.studies.measured.plausibility.engine_bench import ANGLED
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind
from apesim.studies.measured.plausibility.thresholds import MAX_APART, MIN_ANGLE_REFUSED, MIN_SAMPLES
from apesim.studies.measured.runs import Measured, MeasuredRun
from apesim.studies.measured.sensors import FILE


def check_folder(measured: Measured) -> Iterator[Finding]:
    """Check whether two columns hold the same data, and whether a channel is there in some runs alone.

    >>> times, lift = np.arange(9) * 1e-3, np.arange(9) * 1e-3
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {"lift": lift})
    >>> measured = Measured("measured", {}, (run, run._replace(data="p049.csv")))
    >>> [finding.seen for finding in check_folder(measured)]
    ['has the same data as lift of p040.csv']
    """
    earlier: list[tuple[int, str, np.ndarray]] = []
    for number, run in enumerate(measured.runs):
        twins: dict[int, list[tuple[str, str]]] = {}
        for channel, values in run.channels.items():
            known = values[np.isfinite(values)]
            if len(known) < MIN_SAMPLES or np.ptp(known) == 0.0:
                continue
            twin = next((each for each in earlier if _is_same(known, each[2])), None)
            if twin is not None:
                twins.setdefault(twin[0], []).append((channel, twin[1]))
            earlier.append((number, channel, known))
        for other, pairs in twins.items():
            yield _same(run, number, pairs, "" if other == number else measured.runs[other].data)
    yield from _check_means(measured)
    yield from _check_left_out(measured)


def escalate_still(findings: Sequence[Finding], measured: Measured) -> list[Finding]:
    """Findings in which a channel that moves in none of its runs is a fault.

    One run in which the piston stays where it is may be real; a sensor that shows no motion in any run is of no use.

    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", np.zeros(9), {"lift": np.zeros(9)})
    >>> still = Finding(Kind.WARNING, Check.STILL, "p040.csv", "lift", "stays", "", "plug it in", 0)
    >>> [str(finding.kind) for finding in escalate_still([still], Measured("measured", {}, (run,)))]
    ['fault']
    """
    still = {(finding.run, finding.channel) for finding in findings if finding.check == Check.STILL}
    useless = {
        channel
        for _, channel in still
        if all((number, channel) in still for number, run in enumerate(measured.runs) if channel in run.channels)
    }
    return _escalate(findings, Check.STILL, useless)


def escalate_crank_angle(findings: Sequence[Finding], measured: Measured) -> list[Finding]:
    """Findings in which an error of the crank angle is a fault where all runs show it.

    The sensor of the crank angle is one for all runs. What the machine lacks turns the course of the pressure, too, but
    not by as much at each speed and pressure.

    >>> angles = np.radians(np.arange(360.0))
    >>> run = MeasuredRun("n600", "n600.csv", 1.1e6, 287.0, float("nan"), "fit", angles,
    ...     {"cylinder_pressure": np.zeros(360)}, bench="engine", angles=angles)
    >>> off = Finding(Kind.WARNING, Check.CRANK_ANGLE, "n600.csv", "crank_angle", "", "", "", 0, np.radians(20.0))
    >>> for runs in ((run,), (run, run)):
    ...     print(*(str(one.kind) for one in escalate_crank_angle([off], Measured("measured", {}, runs))))
    fault
    warning
    """
    sizes = {finding.run: np.degrees(finding.size) for finding in findings if finding.check == Check.CRANK_ANGLE}
    telling = {number for number, run in enumerate(measured.runs) if any(name in run.channels for name in ANGLED)}
    if not sizes or sizes.keys() != telling:
        return list(findings)
    low, middle, high = np.quantile(list(sizes.values()), [0.0, 0.5, 1.0])
    if high - low > MAX_APART or abs(middle) < MIN_ANGLE_REFUSED:
        return list(findings)
    return _escalate(findings, Check.CRANK_ANGLE, {finding.channel for finding in findings})


def _escalate(findings: Sequence[Finding], check: Check, channels: Collection[str]) -> list[Finding]:
    """Findings in which those of a check at some channels are faults."""
    return [
        finding._replace(kind=Kind.FAULT) if finding.check == check and finding.channel in channels else finding
        for finding in findings
    ]


def _is_same(values: np.ndarray, others: np.ndarray) -> bool:
    """Whether two columns are equal, as far as the shorter one goes."""
    length = min(len(values), len(others))
    if length < 0.5 * max(len(values), len(others)) or np.ptp(values[:length]) == 0.0:
        return False
    return bool(np.array_equal(values[:length], others[:length]))


def _same(run: MeasuredRun, number: int, pairs: Sequence[tuple[str, str]], other: str) -> Finding:
    """The finding of columns with the same data, in one run where the other is ""."""
    channels, others = (", ".join(names) for names in zip(*pairs, strict=True))
    seen = f"{'has' if len(pairs) == 1 else 'have'} the same data as {others}{f' of {other}' if other else ''}"
    reason = "a file copied, or named twice?" if other else "a column written twice?"
    right = "give each run its own file; noise is never the same" if other else "give each column its own data"
    return Finding(Kind.FAULT, Check.SAME_DATA, run.data, channels, seen, reason, right, number)


def _check_means(measured: Measured) -> Iterator[Finding]:
    """Means that two runs share to the last digit, both of them."""
    for number, run in enumerate(measured.runs):
        for other_number, other in enumerate(measured.runs[:number]):
            if len(run.means) > 1 and run.means == other.means:
                seen = f"has the same {' and '.join(run.means)} as run {other_number + 1}"
                right = "look which run they are of"
                yield Finding(Kind.WARNING, Check.SAME_DATA, FILE, f"run {number + 1}", seen, "copied?", right, number)


def _check_left_out(measured: Measured) -> Iterator[Finding]:
    """Channels that some runs have, and others do not."""
    channels = list(dict.fromkeys(channel for run in measured.runs for channel in run.channels))
    for number, run in enumerate(measured.runs):
        lacking = [channel for channel in channels if run.channels and channel not in run.channels]
        if lacking:
            seen = f"{'has' if len(lacking) == 1 else 'have'} no values here, and some in other runs"
            right = "a column of nan counts as not measured"
            yield Finding(Kind.HINT, Check.MISSING, run.data, ", ".join(lacking), seen, "", right, number)
