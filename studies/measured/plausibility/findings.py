"""Findings: what a check of plausibility says of measured data."""

import re
from collections.abc import Sequence
from enum import StrEnum
from typing import NamedTuple

from apesim.quantities import Fault, unit
from apesim.studies.measured.runs import Bench
from apesim.studies.measured.sensors import SENSORS


class Kind(StrEnum):
    """How grave a finding is."""

    FAULT = "fault"
    """It cannot be physics of a rig anywhere near the machine: nothing is fitted to such data."""
    WARNING = "warning"
    """It may be real, and more often is not."""
    HINT = "hint"
    """It is good to know."""


class Check(StrEnum):
    """What is checked."""

    STILL = "never moves"
    CLIPPED = "clipped"
    AT_ITS_END = "often at its end"
    QUANTISED = "quantised"
    SPIKES = "spikes"
    STUCK = "stuck"
    SLOW = "sampled more slowly"
    GAPS = "gaps in time"
    SPACING = "uneven samples"
    MOTION_MISSED = "motion not recorded"
    MISSING = "missing cells"
    IMPOSSIBLE = "impossible values"
    BELOW_ZERO = "pressure below zero"
    LEVEL = "level"
    SUPPLY = "supply"
    TEMPERATURE = "temperature"
    LIFT = "lift out of its range"
    REST = "rest"
    STROKE = "stroke"
    FLIGHT = "flight"
    INVERTED = "inverted"
    SWAPPED = "swapped chambers"
    EXCHANGED = "lift and pressure swapped"
    TIME_UNIT = "unit of time"
    TIME_ZERO = "time zero"
    PULSE = "pulse"
    CRANK_ANGLE = "crank angle"
    TURN = "open turn"
    TORQUE = "torque"
    AIR_FLOW = "air flow"
    SAME_DATA = "same data"
    NOT_SIMULATED = "not simulated"


class Finding(NamedTuple):
    """One finding of a check."""

    kind: Kind
    """How grave it is."""
    check: Check
    """What was checked."""
    file: str
    """File that it stands in, from the folder of the data."""
    channel: str
    """Column, or key of the run, that it is about."""
    seen: str
    """What was seen, in numbers with units."""
    reason: str
    """Likely reason, mostly a question; "": none is known."""
    right: str
    """What would be right."""
    run: int = -1
    """Number of the run in the folder, from 0; -1: none."""
    size: float = float("nan")
    """Size of what was seen, where runs are compared by it: of a crank angle [rad]."""

    def __str__(self) -> str:
        return str(self.to_fault(""))

    def to_fault(self, folder: str) -> Fault:
        """Make the fault of the input that refuses the data; the folder "" is left out."""
        reason = f" ({self.reason})" if self.reason else ""
        return Fault(f"{folder}/{self.file}" if folder else self.file, self.channel, self.seen + reason, self.right)


def group_findings(findings: Sequence[Finding]) -> list[tuple[Finding, int]]:
    """Group findings that say the same of several files, as a folder of many runs often has one reason.

    Each group is given by its first finding and the number of further ones.
    """
    groups: dict[tuple[str, ...], list[Finding]] = {}
    for finding in findings:
        key = finding.channel.split(".")[-1]  # a key of measured.toml without its run
        said = re.sub(r"[-+]?[0-9.]+", "", finding.reason + finding.right)
        groups.setdefault((finding.kind, finding.check, key, said), []).append(finding)
    return [(group[0], len(group) - 1) for group in groups.values()]


def show(bench: Bench, channel: str, *values: float) -> str:
    """Values of a channel in words, in the unit that the channel is usually given in.

    `values` are one value, or the two ends of a range [SI]; ends that look alike are written once.
    """
    sensors = SENSORS[bench]
    declared = (sensors.traces | sensors.means)[channel].unit
    scale = unit(declared).si("1")
    numbers = " to ".join(dict.fromkeys(f"{value / scale + 0.0:.4g}" for value in values))
    return f"{numbers} {declared}{' abs' if 'pressure' in channel else ''}"
