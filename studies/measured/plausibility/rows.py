"""Rows of checks: what is checked, where, by which statistic, and what is said; one loop reads all tables of them."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import nan
from typing import NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility.expected import Expected
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind
from apesim.studies.measured.plausibility.misreadings import Misreading
from apesim.studies.measured.runs import MeasuredRun
from apesim.studies.measured.sensors import FILE

CHAMBERS = ("pressure_a", "pressure_b")
"""Channels of the valve's chambers."""
RUN_KEYS = ("supply", "temperature", "pulse", "torque", "air_flow")
"""Keys of a run that checks judge: their findings stand in ``measured.toml``."""


class Case(NamedTuple):
    """A run as a check judges it: what the checks before it have found is mended, so that each fault is said once."""

    machine: Machine
    run: MeasuredRun
    number: int
    """Number of the run in the folder, from 0."""
    values: Mapping[str, np.ndarray]
    """Channels, mended, (n,) [SI]."""
    expected: Expected
    """What the machine shows."""
    blamed: frozenset[str] = frozenset()
    """Channels of which something was found."""

    def mend(self, channel: str, misreading: Misreading) -> "Case":
        """Take a misreading out of a channel."""
        return self._replace(values={**self.values, channel: misreading.mend(self.values[channel])})

    def without(self, *channels: str) -> "Case":
        """Leave channels out that cannot be mended."""
        return self._replace(values={name: each for name, each in self.values.items() if name not in channels})


class Seen(NamedTuple):
    """What a statistic beyond its threshold looks like; what is "" or None here is as the row says it."""

    seen: str
    """What was seen, in numbers with units; "": nothing is wrong, and only the case is another one."""
    kind: Kind | None = None
    reason: str | None = None
    right: str = ""
    check: Check | None = None
    channel: str = ""
    size: float = nan
    mended: Case | None = None
    """What the checks behind this one judge."""

    def explained(self, misreading: Misreading | None) -> "Seen":
        """Take reason and right form of a misreading, if there is one: it makes a fault."""
        if misreading is None:
            return self
        return self._replace(kind=Kind.FAULT, reason=misreading.reason, right=misreading.right)


class Row(NamedTuple):
    """One check."""

    check: Check
    kind: Kind
    """How grave it is, where the statistic does not say it."""
    where: Callable[[Case], Iterable[str]]
    """Names the channels, or the one key of the run, to which it applies."""
    judge: Callable[[Case, str], Seen | None]
    """Compares the statistic of a channel with its threshold; None: it is within."""
    reason: str = ""
    right: str = ""


def named(*names: str) -> Callable[[Case], Iterable[str]]:
    """Apply a check to channels of these names."""
    return lambda case: [name for name in names if name in case.values]


def holding(part: str) -> Callable[[Case], Iterable[str]]:
    """Apply a check to channels whose name holds a part."""
    return lambda case: [name for name in case.values if part in name]


def once(name: str, *needed: str) -> Callable[[Case], Iterable[str]]:
    """Apply a check once to a run, under a name, if it has the needed channels."""
    return lambda case: [name] if set(needed) <= case.values.keys() else []


def mean(name: str) -> Callable[[Case], Iterable[str]]:
    """Apply a check to a mean, if it is measured."""
    return lambda case: [name] if name in case.run.means else []


def check_rows(rows: Sequence[Row], case: Case, findings: list[Finding]) -> Case:
    """Make the checks of a table, in its order; `findings` gets what they find, and what they mend is returned."""
    for row in rows:
        for channel in row.where(case):
            seen = row.judge(case, channel)
            if seen is None:
                continue
            blamed = case.blamed
            if seen.seen:
                findings.append(_make_finding(row, case, channel, seen))
                blamed |= {channel}
            case = (seen.mended or case)._replace(blamed=blamed)
    return case


def _make_finding(row: Row, case: Case, channel: str, seen: Seen) -> Finding:
    """Put together what was seen and what the row says."""
    is_key = channel in RUN_KEYS
    return Finding(
        seen.kind or row.kind,
        seen.check or row.check,
        FILE if is_key else case.run.data,
        f"run {case.number + 1}.{channel}" if is_key else seen.channel or channel,
        seen.seen,
        row.reason if seen.reason is None else seen.reason,
        seen.right or row.right,
        case.number,
        seen.size,
    )
