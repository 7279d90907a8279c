"""Checks of when a valve moves: columns swapped, a lift turned round, a late trigger, a pulse that was another one."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from apesim.studies.measured.plausibility import thresholds as limits
from apesim.studies.measured.plausibility.expected import Expected
from apesim.studies.measured.plausibility.findings import Kind
from apesim.studies.measured.plausibility.misreadings import TIME_FACTORS, explain_factor
from apesim.studies.measured.plausibility.rows import CHAMBERS, Case, Seen
from apesim.studies.measured.plausibility.signals import (
    Edges,
    find_correlation,
    find_edges,
    find_levels,
    find_noise,
    find_span,
    smooth,
)
from apesim.studies.measured.runs import MeasuredRun

SHIFTS = np.linspace(-limits.MAX_TRIED_SHIFT, limits.MAX_TRIED_SHIFT, 81)
"""Shifts at which shapes are compared [s]: steps of 0.5 ms."""
FINE_SHIFTS = np.linspace(-2e-3, 2e-3, 81)
"""Shifts about a rough one among which the best is taken [s]."""
TIMED = ("lift", *CHAMBERS)
"""Channels that tell when the valve moves."""


class Motion(NamedTuple):
    """When a channel leaves its rest and comes back, measured and by the machine."""

    channel: str
    measured: Edges
    machine: Edges

    @property
    def opening(self) -> float:
        """Time by which it leaves its rest later than the machine's [s]; NaN: unknown."""
        return self.measured.leaves - self.machine.leaves

    @property
    def closing(self) -> float:
        """Time by which it comes back later than the machine's [s]; NaN: unknown."""
        return self.measured.returns - self.machine.returns


def moves(values: np.ndarray, machine_values: np.ndarray) -> bool:
    """Tell whether a channel moves where the machine's does; True where the machine's does not move either."""
    span = find_span(machine_values)
    low, high = find_levels(values)
    return bool(span == 0.0 or high - low > limits.MIN_MOVED * span)


def compare_shapes(run: MeasuredRun, values: np.ndarray, expected: Expected, channel: str) -> tuple[float, float]:
    """Largest correlation of values, and of them turned round, with a channel of the machine, over small shifts.

    >>> times = np.arange(0.0, 60e-3, 1e-3)
    >>> pulse = np.where(abs(times - 30e-3) < 15e-3, 9e-3, 0.0)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {})
    >>> alike, turned = compare_shapes(run, -pulse, Expected(times, {"lift": pulse}, {}, False), "lift")
    >>> turned > 0.99 > alike
    True
    """
    smoothed = smooth(values)
    shifts = SHIFTS if not expected.is_engine else np.zeros(1)
    found = [find_correlation(smoothed, expected.at(channel, run, shift)) for shift in shifts]
    return max(found), -min(found)


def judge_swapped(case: Case, channel: str) -> Seen | None:
    """Tell whether the columns of the chambers stand for each other; the case goes on without them."""
    here = [channel for channel in CHAMBERS if channel in case.values]
    if not here or not _go_as_each_other(case, CHAMBERS, here):
        return None
    seen = "goes as the other chamber of the machine does: b is filled and a emptied to open the valve"
    return Seen(seen, channel=" and ".join(here), mended=case.without(*CHAMBERS))


def _go_as_each_other(case: Case, pair: Sequence[str], here: Sequence[str]) -> bool:
    """Whether those of two channels that are here go clearly better as the other of the two."""
    run, values, expected = case.run, case.values, case.expected
    own = [compare_shapes(run, values[channel], expected, channel)[0] for channel in here]
    other = [compare_shapes(run, values[channel], expected, pair[channel == pair[0]])[0] for channel in here]
    return bool(min(other) >= limits.MIN_ALIKE and np.mean(other) >= np.mean(own) + limits.MIN_BETTER)


def judge_exchanged(case: Case, channel: str) -> Seen | None:
    """Tell whether the columns of lift and of chamber A stand for each other, whatever their units make of them.

    Chamber A alone is judged: chamber B and the lift have much the same shape. The case goes on without them.
    """
    pair, values = ("lift", "pressure_a"), case.values
    if not _go_as_each_other(case, pair, pair):
        return None
    if "pressure_b" in values:
        alike, _ = compare_shapes(case.run, values["pressure_b"], case.expected, "pressure_b")
        if alike < limits.MIN_ALIKE:
            return None  # else a lift turned round and swapped chambers would look the same
    return Seen("goes as the other channel of the machine does", mended=case.without(*pair))


def judge_inverted(case: Case, channel: str) -> Seen | None:
    """Tell whether a lift within the stroke [m] is measured from the open stop."""
    alike, turned = compare_shapes(case.run, case.values[channel], case.expected, channel)
    if turned < limits.MIN_ALIKE or turned < alike + limits.MIN_BETTER:
        return None
    values = {**case.values, channel: case.machine.valve.stroke - case.values[channel]}
    return Seen("is high where the valve is closed and low where it is open", mended=case._replace(values=values))


def find_motions(run: MeasuredRun, values: Mapping[str, np.ndarray], expected: Expected) -> list[Motion]:
    """Find when the channels of a run [SI] move, and when they do in the machine; only those that move in both.

    >>> times = np.arange(0.0, 100e-3, 1e-3)
    >>> lift = np.where(abs(times - 30e-3) < 15e-3, 9e-3, 0.0)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {"lift": lift})
    >>> [motion] = find_motions(run, {"lift": np.roll(lift, -10)}, Expected(times, {"lift": lift}, {}, False))
    >>> round(1e3 * motion.opening, 2), round(1e3 * motion.closing, 2)
    (-10.0, -10.0)
    """
    found = []
    for channel in TIMED:
        if channel not in values or not moves(values[channel], expected.channels[channel]):
            continue
        machine_values = expected.channels[channel]
        if np.ptp(machine_values) <= limits.MIN_MOVED * find_span(smooth(values[channel])):
            continue
        rises = bool(machine_values[0] < 0.5 * (machine_values.min() + machine_values.max()))
        machine = find_edges(expected.places, machine_values, rises=rises)
        noise = find_noise(values[channel])
        found.append(Motion(channel, find_edges(run.times, values[channel], rises=rises, noise=noise), machine))
    return found


def judge_time_unit(case: Case, key: str) -> Seen | None:
    """Judge the unit of the times: how long the valve is open, and when it opens, by the pulse."""
    run, values = case.run, case.values
    for channel in (*CHAMBERS, "lift"):
        if channel not in values:
            continue
        edges = find_edges(run.times, values[channel], rises=channel != "pressure_a")
        width = edges.returns - edges.leaves
        unit = explain_factor(width / run.pulse, TIME_FACTORS, limits.MAX_OFF_TIME_UNIT) if width > 0.0 else None
        if unit and limits.MIN_OPENS < unit.factor * edges.leaves < limits.MAX_OPENS:
            seen = f"by the {channel.replace('_', ' ')} the valve is open for {width:.3g} s, "
            return Seen(f"{seen}where the pulse is {1e3 * run.pulse:.4g} ms").explained(unit)
    return None


def judge_times(case: Case, key: str) -> Seen | None:
    """Tell whether the valve moves when it can: after the command, and about as late as the machine's."""
    run, values, expected = case.run, case.values, case.expected
    motions = find_motions(run, values, expected)
    if not motions:
        return None

    # How much later than the machine's the edges are, and whether both by the same, as a wrong trigger makes them.
    shifts = np.array([[motion.opening, motion.closing] for motion in motions])
    opening, closing = _median(shifts[:, 0]), _median(shifts[:, 1])
    before = [motion for motion in motions if _is_before_command(motion, run)]
    rough = _median(np.array([opening, closing]))
    is_common = abs(opening - closing) <= max(limits.MAX_UNEQUAL[0], limits.MAX_UNEQUAL[1] * abs(rough))  # NaN: False
    channel = (before or motions)[0].channel

    # Motion before the command is a fault of the times, whatever the machine is.
    if before:
        begins = min(motion.measured.begins for motion in before)
        at = "at its first sample" if begins == run.times[0] else f"at {1e3 * begins:.1f} ms"
        seen, reason = f"is away from its rest {at}, before the command can have moved anything", "trigger late?"
        if np.isfinite(rough) and rough < -limits.MIN_SHIFT_WARNED:
            late = -_refine(run, values, expected, motions, rough)[0]
            seen += f", and {1e3 * late:.1f} ms earlier than the machine's"
            reason = f"trigger {1e3 * late:.1f} ms late?"
            right = f"add {1e3 * late:.1f} ms to the times: t = 0 is the command"
        else:
            right = "make t = 0 the command"
        return Seen(seen, Kind.FAULT, reason, right, channel=channel)

    # A shift of both edges may be one of the times. Of one edge alone it has to be longer than any effect delays it.
    if not np.isfinite(opening) and not np.isfinite(closing):
        return None
    one_edge = np.isfinite(opening) and not np.isfinite(closing) and abs(opening) >= limits.MIN_ONE_EDGE_LATE
    if not ((is_common and abs(rough) >= limits.MIN_SHIFT_WARNED) or one_edge):
        return None

    # The shift by the whole traces, which also tell whether their shape fits: only then is it refused.
    shift, left = _refine(run, values, expected, motions, rough)
    if abs(shift) < limits.MIN_SHIFT_WARNED:
        return None
    kind = Kind.FAULT if abs(shift) >= limits.MIN_SHIFT_REFUSED and left < limits.MAX_LEFT_AFTER_SHIFT else Kind.WARNING
    size, when = f"{1e3 * abs(shift):.1f} ms", "later" if shift > 0.0 else "earlier"
    what = "opens" if one_edge else "opens and closes"
    seen = f"{what} {size} {when} than the machine's"
    right = (
        f"{'take' if shift > 0.0 else 'add'} {size} {'off' if shift > 0.0 else 'to'} the times, or mend the delays of "
    )
    right += "the machine: t = 0 is the command"
    reason = f"trigger {size} {'early' if shift > 0.0 else 'late'}?"
    return Seen(seen, kind, reason, right, channel=channel)


def judge_pulse(case: Case, expected: Expected, simulated: float) -> tuple[Seen | None, float]:
    """Tell whether the pulse was as long as the run states, by its channels.

    `simulated` is the pulse of `expected` [s]: the stated one, or one about as long as the measured one where the
    stated one moves nothing. Returns the pulse that it must have been, too, or that of the run where it is right [s].
    """
    run, values = case.run, case.values
    motions = [motion for motion in find_motions(run, values, expected) if np.isfinite(motion.opening)]
    off_by = {motion.channel: motion.closing - motion.opening for motion in motions}
    by_pressure = _median(np.array([off_by.get(channel, np.nan) for channel in CHAMBERS]))
    by_lift = off_by.get("lift", np.nan)
    off = by_pressure if np.isfinite(by_pressure) else by_lift
    pulse = simulated + off
    off = pulse - run.pulse
    if not abs(off) >= limits.MIN_LATE_WARNED:  # NaN, too
        return None, run.pulse
    ratio = max(pulse, 1e-4) / run.pulse
    slips = [
        factor
        for factor in (limits.PULSE_FACTOR, 1.0 / limits.PULSE_FACTOR)
        if abs(np.log(ratio / factor)) < limits.MAX_OFF_FACTOR
    ]
    is_sure = np.isfinite(by_pressure) and abs(off) >= max(limits.MIN_PULSE_OFF, limits.MIN_PULSE_OFF_SHARE * run.pulse)
    channel = motions[0].channel if not np.isfinite(by_pressure) else "chamber pressures"
    seen = f"is stated as {1e3 * run.pulse:.4g} ms; by the {channel.replace('_', ' ')} the release came after about "
    seen += f"{1e3 * pulse:.1f} ms"
    reason = f"{1e3 * run.pulse * slips[0]:.4g} ms called {1e3 * run.pulse:.4g} ms?" if slips else "another pulse?"
    kind = Kind.FAULT if is_sure or slips else Kind.WARNING
    right = "write the pulse that it was" + ("" if kind == Kind.FAULT else ", unless the valve is so slow to close")
    return Seen(seen, kind, reason, right), pulse


def _median(values: np.ndarray) -> float:
    """Median of the numbers among some; NaN: there are none."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else np.nan


def _is_before_command(motion: Motion, run: MeasuredRun) -> bool:
    """Whether a channel is away from its rest before the command, or at its first sample long before the machine's is.

    Long is more than effects of the library let a channel begin earlier.
    """
    edges = motion.measured
    if edges.starts_away:
        return edges.begins < motion.machine.begins - limits.MIN_SHIFT_WARNED
    return edges.begins < -float(np.median(np.diff(run.times)))


def _refine(
    run: MeasuredRun, values: Mapping[str, np.ndarray], expected: Expected, motions: list[Motion], rough: float
) -> tuple[float, float]:
    """Shift by which the machine fits best [s], and the share of the square of the difference that it leaves."""

    def misfit(shift: float) -> float:
        total = 0.0
        for motion in motions:
            there = expected.at(motion.channel, run, shift)
            span = np.ptp(expected.channels[motion.channel])
            total += float(np.nanmean((smooth(values[motion.channel]) - there) ** 2)) / span**2
        return total

    tried = [misfit(rough + shift) for shift in FINE_SHIFTS]
    best = int(np.argmin(tried))
    unshifted = misfit(0.0)
    return float(rough + FINE_SHIFTS[best]), tried[best] / unshifted if unshifted else 1.0
