"""Checks of a record by itself: what a sensor or a recorder does wrong, whatever is measured."""

from collections.abc import Iterator, Sequence
from math import sqrt

import numpy as np

from apesim.studies.measured.columns import TIME
from apesim.studies.measured.plausibility import thresholds as limits
from apesim.studies.measured.plausibility.disturbances import (
    ROUNDING,
    find_disturbances,
    find_runs,
    has_noise,
    is_short,
)
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, show
from apesim.studies.measured.plausibility.signals import find_noise
from apesim.studies.measured.runs import CYLINDER, ENGINE, VALVE, Disturbance, Masked, Measured, MeasuredRun
from apesim.studies.measured.sensors import ANGLE

MAX_OFF_STEP = 0.02
"""Share of a step by which values may lie beside its multiples: the rounding of a file of a few digits."""
MIN_VALUES = 3
"""Different values that tell a step."""
DISTURBANCES = {
    Disturbance.SPIKES: (Check.SPIKES, "an electric disturbance?", "shield the cable"),
    Disturbance.REPEATED: (Check.SLOW, "was it sampled more slowly?", "record it as fast as its rows"),
    Disturbance.IMPOSSIBLE: (
        Check.IMPOSSIBLE,
        "a code of the recorder, a loose contact?",
        "look at cable and recorder",
    ),
    Disturbance.STUCK: (Check.STUCK, "did the recorder hold its last value?", "look at recorder and connection"),
    Disturbance.CLIPPED: (
        Check.CLIPPED,
        "clipped at the end of its range?",
        "choose a wider range of sensor and recorder",
    ),
}
"""What is said of each disturbance: the check, the likely reason, and what helps."""


def check_record(
    run: MeasuredRun, number: int, stated: dict[str, float], masked: Sequence[Masked] = ()
) -> Iterator[Finding]:
    """Check each channel of a run by itself, and the times of its samples.

    `number` is the run's in the folder, from 0; `stated` is the noise that the folder states, by sensor [SI]; what is
    `masked` of the run is not missing.
    """
    yield from _check_sampling(run, number)
    for channel, values in run.channels.items():
        lost = sum(each.share for each in masked if each.channel == channel)
        yield from _check_missing(run, number, channel, values, lost)
        if np.isfinite(values).sum() < limits.MIN_SAMPLES:
            continue
        if np.ptp(values[np.isfinite(values)]) == 0.0:
            right = "is the sensor connected? else leave the column out"
            yield Finding(Kind.FAULT, Check.STILL, run.data, channel, "never changes", "", right, number)
            continue
        noise = max(stated.get(channel, 0.0), find_noise(values))
        yield from _check_steps(run, number, channel, stated.get(channel), noise)
        yield from _check_disturbances(run, number, channel, noise)


def check_ends(run: MeasuredRun, number: int, channel: str, machine_values: np.ndarray | None) -> Iterator[Finding]:
    """Check whether a channel stays at its largest or smallest value, where neither noise nor the machine does.

    `machine_values` are what the machine shows at the samples, (n,) [SI]; None: it could not be simulated.

    A sensor with an end at 0.5 mm:

    >>> lift = 1e-3 * np.sin(np.linspace(0.0, 3.0, 200)) + np.random.default_rng(1).normal(0.0, 1e-5, 200)
    >>> times, cut = np.arange(200) * 1e-3, np.minimum(lift, 0.5e-3)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {"lift": cut})
    >>> [str(finding.check) for finding in check_ends(run, 0, "lift", lift)]
    ['clipped']
    """
    known = np.isfinite(run.channels[channel])
    values = run.channels[channel][known]
    if len(values) < 2 * limits.MIN_CLIPPED:
        return
    machine_values = machine_values[known] if machine_values is not None else None
    span = np.ptp(values)
    if span == 0.0:
        return

    # Equal values in a row at an end, where noise would change them or the machine goes on. A lift lies still at its
    # stop, wherever the machine's goes: noise alone tells it.
    for end, name, sign in ((values.max(), "largest", 1.0), (values.min(), "smallest", -1.0)):
        is_at_end = np.abs(values - end) <= ROUNDING * span
        longest = max(end - first for first, end in find_runs(is_at_end))
        if longest >= limits.MIN_CLIPPED and (
            has_noise(values, is_at_end)
            or (
                channel != "lift"
                and _goes_on(machine_values, is_at_end, sign * end, sign, limits.MIN_CLIPPED_AWAY * span)
            )
        ):
            shown = show(run.bench, channel, end)
            seen = f"stays at exactly {shown}, its {name} value, for {longest} samples in a row"
            right = "choose a wider range of sensor and recorder, or leave the column out"
            yield Finding(
                Kind.FAULT, Check.CLIPPED, run.data, channel, seen, "clipped at the end of its range?", right, number
            )
            return

    # Many equal values that are not in a row may be right. In a short record they may be chance.
    for end in (values.max(), values.min()) if len(values) > limits.MIN_FOR_SATURATION else ():
        is_at_end = values == end
        if np.mean(is_at_end) > limits.MAX_SATURATED and (channel != "lift" or has_noise(values, is_at_end)):
            seen = "stays at its largest or smallest value"
            right = "look whether it is right there"
            yield Finding(
                Kind.WARNING, Check.AT_ITS_END, run.data, channel, seen, "is the sensor at its end?", right, number
            )
            return


def _check_sampling(run: MeasuredRun, number: int) -> Iterator[Finding]:
    """Gaps in time, and uneven samples."""
    steps = np.diff(run.times)
    if run.bench == CYLINDER or not len(steps):  # its samples are means over cells of the stroke
        return

    # A valve's record without its motion is of no use, however evenly it is sampled.
    in_motion = int(np.sum((run.times >= 0.0) & (run.times <= run.pulse + limits.CLOSES)))
    if run.bench == VALVE and in_motion < limits.MIN_IN_MOTION:
        many = f"{in_motion or 'no'} sample{'s' * (in_motion != 1)}"
        seen = f"{many} from the command to {1e3 * limits.CLOSES:.0f} ms after the release"
        reason, right = (
            "is t = 0 the command, and is the unit of time right?",
            "record while the valve moves, and finer",
        )
        yield Finding(Kind.WARNING, Check.MOTION_MISSED, run.data, "time", seen, reason, right, number)
        return

    # Gaps, or else uneven steps: a gap makes them uneven, too.
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > limits.MIN_GAP * usual)
    axis = "crank_angle" if run.bench == ENGINE else "time"
    shown, unit = (np.degrees(run.angles), "deg") if run.bench == ENGINE else (run.times * 1e3, "ms")
    if len(gaps):
        longest = gaps[np.argmax(steps[gaps])]
        many = f"{len(gaps)} gaps, the longest" if len(gaps) > 1 else "a gap"
        seen = f"{many} from {shown[longest]:.6g} to {shown[longest + 1]:.6g} {unit}"
        right = "nothing is known between them; record without pauses"
        yield Finding(Kind.WARNING, Check.GAPS, run.data, axis, seen, "samples lost?", right, number)
    elif np.ptp(steps) > limits.MAX_UNEVEN * usual:
        seen = "the samples are not evenly spaced"
        right = "the colour of noise is taken as if they were"
        kind = Kind.WARNING if np.ptp(steps) > limits.MIN_UNEVEN_WARNED * usual else Kind.HINT
        yield Finding(kind, Check.SPACING, run.data, axis, seen, "", right, number)


def _check_missing(
    run: MeasuredRun, number: int, channel: str, values: np.ndarray, masked_share: float
) -> Iterator[Finding]:
    """Missing cells, besides those that were masked."""
    share = 1.0 - float(np.isfinite(values).mean()) - masked_share if len(values) else 0.0
    if share > ROUNDING:
        kind = Kind.WARNING if share >= limits.MIN_MISSING_WARNED else Kind.HINT
        seen = f"{100.0 * share:.2g} % of the cells are missing"
        yield Finding(kind, Check.MISSING, run.data, channel, seen, "", "what is there is used", number)


def _check_steps(run: MeasuredRun, number: int, channel: str, stated: float | None, noise: float) -> Iterator[Finding]:
    """Values in steps that noise does not carry the signal between."""
    values = run.channels[channel][np.isfinite(run.channels[channel])]
    span, step = float(np.ptp(values)), _find_step(values)
    if step < max(limits.MIN_STEP_SHARE * span, limits.MAX_STEP_OVER_NOISE * noise):
        return
    shown = _show_difference(run, channel, step)
    right = "choose a narrower range or more bits"
    if stated is not None:
        seen = f"comes in steps of {shown}, the noise is stated as {_show_difference(run, channel, stated)}"
        right = f"state a noise of {_show_difference(run, channel, step / sqrt(12.0))} or more, or {right}"
    else:
        seen = f"comes in steps of {shown}, far above its noise"
    kind = Kind.FAULT if stated is not None or step > limits.MAX_STEP_SHARE * span else Kind.WARNING
    yield Finding(kind, Check.QUANTISED, run.data, channel, seen, "quantised by the recorder?", right, number)


def _check_disturbances(run: MeasuredRun, number: int, channel: str, noise: float) -> Iterator[Finding]:
    """Spikes and held values that are not masked: they are too many, or the run comes from no folder."""
    axis, places = _axis(run)
    for disturbance, flags in find_disturbances(places, run.channels[channel], axis, noise):
        if disturbance != Disturbance.CLIPPED:  # see check_ends, which knows the machine
            share = float(np.mean(flags))
            masked = Masked(number, channel, disturbance, places[flags], run.channels[channel][flags], share)
            yield _describe_disturbance(run, masked, is_masked=False, is_short=is_short(places, flags, axis))


def check_masked(measured: Measured) -> Iterator[Finding]:
    """Say what was masked as a folder was read, and refuse what is so in most runs."""
    for each in measured.masked:
        finding = _describe_disturbance(measured.runs[each.run], each, is_masked=True, is_short=each.is_short)
        alike = {
            other.run
            for other in measured.masked
            if (other.channel, other.disturbance) == (each.channel, each.disturbance)
        }
        having = sum(each.channel in run.channels for run in measured.runs)
        least = {Disturbance.CLIPPED: 1, Disturbance.STUCK: 2}.get(each.disturbance)
        if least is not None and len(alike) >= least and len(alike) > 0.5 * having:
            right = "no other run shows what is lost there: record the channel anew, or leave its column out"
            finding = finding._replace(kind=Kind.FAULT, right=right)
        yield finding


def describe_spoilt(run: MeasuredRun, spoilt: Masked) -> Finding:
    """Describe impossible samples that are not masked: they are too much, or the run comes from no folder.

    >>> times, lift = np.arange(40) * 1e-4, np.full(40, 1e-5)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {"lift": lift})
    >>> spoilt = Masked(0, "lift", Disturbance.IMPOSSIBLE, times[10:20], np.full(10, -1e-3), 0.25)
    >>> describe_spoilt(run, spoilt).seen
    '10 samples from 1 to 1.9 ms cannot be, one of -1 mm: 25 % of the samples, too much to be masked'
    """
    axis, places = _axis(run)
    is_few = is_short(places, np.isin(places, spoilt.places), axis)
    return _describe_disturbance(run, spoilt, is_masked=False, is_short=is_few)


def _describe_disturbance(run: MeasuredRun, masked: Masked, *, is_masked: bool, is_short: bool) -> Finding:
    """The finding of a disturbance of a channel."""
    number, places = len(masked.places), masked.places
    axis, _ = _axis(run)
    shown = [f"{np.degrees(place):.5g} deg" if axis == ANGLE else f"{place * 1e3:.5g} ms" for place in places]
    check, reason, right = DISTURBANCES[masked.disturbance]

    # What is seen of each kind.
    if masked.disturbance == Disturbance.SPIKES:
        farthest = int(np.argmax(np.abs(masked.values - np.median(masked.values)))) if number > 1 else 0
        many = f"{number} spikes, one" if number > 1 else "a spike"
        seen = f"{many} to {show(run.bench, masked.channel, masked.values[farthest])} at {shown[farthest]}"
    elif masked.disturbance == Disturbance.REPEATED:
        rows = max(2, round(1.0 / max(1.0 - masked.share, 1e-3)))
        seen = f"changes in one of about {rows} rows alone, and repeats its value in the others"
    elif masked.disturbance == Disturbance.IMPOSSIBLE:
        where = f"from {shown[0].split()[0]} to {shown[-1]}" if number > 1 else f"at {shown[0]}"
        value = show(run.bench, masked.channel, float(np.median(masked.values)))
        seen = f"{number} sample{'s' * (number > 1)} {where} cannot be, one of {value}"
    else:
        held = show(run.bench, masked.channel, float(np.median(masked.values)))
        seen = f"stays at exactly {held} for {number} samples between {shown[0]} and {shown[-1]}"

    # Samples without any number cannot be shown by their values: the file itself said what they are.
    if np.isnan(masked.values).all():
        where = f"between {shown[0]} and {shown[-1]}" if number > 1 else f"at {shown[0]}"
        seen = f"is over range in {number} sample{'s' * (number > 1)} {where}, as the file says"

    # What became of the samples, and what else the user can do about those that are still there.
    if is_masked:
        seen += f"; {100.0 * masked.share:.2g} % of the samples are masked"
        right = f"these samples are used by nothing; {right}"
    elif masked.disturbance == Disturbance.REPEATED:
        right += ", or write nan into the cells that repeat"
    elif not is_short:
        seen += f": {100.0 * masked.share:.2g} % of the samples, too much to be masked"
        right += ", or leave the column out"
    else:
        right += ", or write nan into these cells"
    kind = Kind.WARNING if is_short else Kind.FAULT
    return Finding(kind, check, run.data, masked.channel, seen, reason, right, masked.run)


def _axis(run: MeasuredRun) -> tuple[str, np.ndarray]:
    """Name of the column that a run's traces stand over, and its values [s, rad]."""
    return (ANGLE, run.angles) if run.bench == ENGINE else (TIME, run.times)


def _find_step(values: np.ndarray) -> float:
    """Step that all values are multiples of; 0: there is none."""
    distinct = np.unique(values)
    gaps = np.diff(distinct)
    gaps = gaps[gaps > ROUNDING * (distinct[-1] - distinct[0])]
    if len(gaps) < MIN_VALUES - 1:
        return float(gaps.min(initial=0.0)) if len(gaps) else 0.0
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    places = (distinct - distinct[0]) / step
    off = np.abs(places - np.round(places))
    return step if np.mean(off < MAX_OFF_STEP * np.maximum(1.0, np.sqrt(places))) > 0.98 else 0.0


def _show_difference(run: MeasuredRun, channel: str, difference: float) -> str:
    """A difference of two values in words."""
    return show(run.bench, channel, difference).removesuffix(" abs")


def _goes_on(machine_values: np.ndarray | None, is_at_end: np.ndarray, end: float, sign: float, margin: float) -> bool:
    """Whether the machine goes on by a margin, and moves, while the record stays at its end."""
    if machine_values is None:
        return False
    there = sign * machine_values[is_at_end]
    return bool(np.median(there) > end + margin and np.ptp(there) > margin)
