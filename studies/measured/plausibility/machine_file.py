"""Whether the numbers of the machine file are the rig's: its stroke, and how fast its valve flies.

All runs of a folder are asked together: a run alone may be odd, a wrong number of the machine shows in each of them.
"""

from collections.abc import Collection, Iterator, Sequence
from math import inf, isfinite, nan
from typing import NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.engine.stated_uncertainties import GAIN
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.measured.plausibility import thresholds as limits
from apesim.studies.measured.plausibility.expected import Expected, expect
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, show
from apesim.studies.measured.plausibility.signals import find_levels, find_noise, select_judged, smooth
from apesim.studies.measured.prediction import with_value
from apesim.studies.measured.runs import VALVE, Measured, MeasuredRun

FLIGHT = 0.1, 0.9
"""Shares of the span between which a flight is timed."""
FLIGHT_KEYS = (
    "valve.piston_area",
    "valve.moving_mass",
    "valve.spring_rate",
    "valve.viscous_friction",
    "valve.solenoid.effective_area",
)
"""Keys of the machine file that make a flight several times longer or shorter."""
HIDING = (Check.LIFT, Check.INVERTED, Check.EXCHANGED, Check.TIME_UNIT, Check.STILL, Check.CLIPPED, Check.IMPOSSIBLE)
"""Checks whose faults say that a lift is not what it seems: nothing is concluded of the machine from it."""


class _Top(NamedTuple):
    """Lift of a run that ends flat, as a valve does at its stop."""

    number: int
    """Number of the run, from 0."""
    run: MeasuredRun
    expected: Expected
    span: float
    """Lift from closed to flat [m]."""


def check_machine(
    machine: Machine, measured: Measured, expected: Sequence[Expected | None], findings: Collection[Finding]
) -> Iterator[Finding]:
    """Check the stroke of a machine, and how long its valve flies, against the lifts of all runs.

    `expected` is what the machine shows of each run, `findings` what was found of the runs: a lift that is not what it
    seems is not judged.

    >>> from apesim.studies.gap.example_bench import read_example
    >>> from apesim.studies.measured.prediction import with_value
    >>> longer, example = with_value(Machine(), "valve.stroke", 10e-3), read_example()
    >>> expected = [expect(longer, run) for run in example.runs]
    >>> [finding.reason for finding in check_machine(longer, example, expected, [])]
    ['is the stroke 9.00 mm, or the gain of the sensor 0.90?']
    """
    hidden = {one.run for one in findings if one.kind == Kind.FAULT and one.check in HIDING and "lift" in one.channel}
    hidden |= {one.run for one in findings if one.check == Check.TIME_UNIT}
    tops = [
        top
        for number, (run, shown) in enumerate(zip(measured.runs, expected, strict=True))
        if number not in hidden and (top := _find_top(machine, number, run, shown)) is not None
    ]
    if tops:
        yield from _check_stroke(machine, measured, tops)
        yield from _check_flight(machine, [top for top in tops if top.run.bench == VALVE])


def _find_top(machine: Machine, number: int, run: MeasuredRun, expected: Expected | None) -> _Top | None:
    """Lift of a run where it is measured, ends flat, and the machine is known; else None."""
    values = select_judged(run).get("lift")
    if values is None or expected is None or "lift" not in expected.channels:
        return None
    low, high = find_levels(values)[0], float(np.nanmax(smooth(values)))  # a hop is shorter than a level
    noise = find_noise(values)
    near = 4.0 * noise + limits.FLAT_LEVEL * (high - low)
    flat, rest = values[values >= high - near], values[values <= low + near]
    away = np.sum(values > 0.5 * (low + high))
    lasting = max(
        limits.MIN_FLAT / float(np.median(np.diff(run.times))), limits.MIN_FLAT_SHARE * away, limits.MIN_SAMPLES
    )
    if len(flat) < lasting:
        return None
    span = float(np.median(flat) - np.median(rest))
    moves = span > max(limits.MIN_NOISES_FLAT * noise, limits.MIN_MOVED * machine.valve.stroke)
    return _Top(number, run, expected, span) if moves else None


def _check_stroke(machine: Machine, measured: Measured, tops: Sequence[_Top]) -> Iterator[Finding]:
    """Finding of lifts that end flat at another place than the stroke, where the machine comes to its stop."""
    reaching = [(top, float(np.ptp(top.expected.channels["lift"]))) for top in tops]
    shares = np.array([top.span / span for top, span in reaching if span > limits.MIN_REACHED * machine.valve.stroke])
    if not len(shares) or np.ptp(shares) > limits.MAX_TOPS_APART:
        return
    share = float(np.median(shares))
    if not (shares.max() < 1.0 - limits.MAX_OFF_STROKE_WARNED or shares.min() > 1.0 + limits.MAX_OFF_STROKE_WARNED):
        return
    off = abs(share - 1.0)
    is_allowed = off <= limits.MIN_REACHED_OF_PRIOR * _find_deviation(machine, measured)
    is_wrong = off > limits.MAX_GAIN or (off > limits.MAX_OFF_STROKE and _is_shorter(machine, tops, share))
    kind = Kind.FAULT if is_wrong and not is_allowed else Kind.WARNING
    first, flat = tops[0], share * machine.valve.stroke
    many = f"all {len(shares)} runs" if len(shares) > 1 else "the run"
    stated = show(first.run.bench, "lift", machine.valve.stroke)
    seen = f"ends flat at {1e3 * flat:.2f} mm in {many}, valve.stroke is {stated}"
    reason = f"is the stroke {1e3 * flat:.2f} mm, or the gain of the sensor {share:.2f}?"
    right = "write valve.stroke as it is into the machine file, or mend the sensor's scale"
    yield Finding(kind, Check.STROKE, first.run.data, "lift", seen, reason, right, first.number)


def _is_shorter(machine: Machine, tops: Sequence[_Top], share: float) -> bool:
    """Whether a machine whose stroke is so much of its own shows the lifts better than its own lift times the share.

    A valve of another stroke flies for another time, a sensor of another gain does not.
    """
    shorter = with_value(machine, "valve.stroke", share * machine.valve.stroke)
    left_of_gain = left_of_stroke = 0.0
    for top in tops[: limits.MAX_COMPARED]:
        shown = expect(shorter, top.run)
        if shown is None:
            return False
        values = top.run.channels["lift"]
        noise = find_noise(values) ** 2
        gained, other = share * top.expected.at("lift", top.run), shown.at("lift", top.run)
        left_of_gain += max(float(np.nanmean((values - gained) ** 2)) - noise, 0.0)
        left_of_stroke += max(float(np.nanmean((values - other) ** 2)) - noise, 0.0)
    return left_of_stroke < limits.MAX_LEFT_OF_GAIN * left_of_gain


def _find_deviation(machine: Machine, measured: Measured) -> float:
    """Largest standard deviation that the user states of stroke or gain, as a share; 0: none is stated."""
    stated = dict(machine.known_to) | measured.known_to
    own = {"valve.stroke": machine.valve.stroke, f"{GAIN}lift": 1.0}
    return max((_as_share(stated[key], size) for key, size in own.items() if key in stated), default=0.0)


def _as_share(uncertainty: Uncertainty, size: float) -> float:
    """A standard deviation as a share of a number."""
    return uncertainty.deviation if uncertainty.is_share else uncertainty.deviation / size


def _check_flight(machine: Machine, tops: Sequence[_Top]) -> Iterator[Finding]:
    """Finding of a machine whose valve opens in another time than the measured one in each run, or not at all."""
    flights = [(_time_flight(top.run.times, smooth(top.run.channels["lift"]), top.span), top) for top in tops]
    known = [(flight, top) for flight, top in flights if isfinite(flight)]
    if not known:
        return
    of_machine, ratios = [], []
    for flight, top in known:
        own = _time_machine(machine, top, flight)
        if own is None:
            return
        of_machine.append(own)
        ratios.append(own / flight)
    if not (min(ratios) > limits.MAX_FLIGHT_FACTOR or max(ratios) < 1.0 / limits.MAX_FLIGHT_FACTOR):
        return
    flight, first = known[0]
    many = f"all {len(known)} runs" if len(known) > 1 else "the run"
    seen = f"opens in {1e3 * flight:.2g} ms, where the machine takes {1e3 * of_machine[0]:.2g} ms, and alike in {many}"
    if not isfinite(max(ratios)):
        first = next(top for (_, top), ratio in zip(known, ratios, strict=True) if not isfinite(ratio))
        seen = f"opens in {many}, where the valve of the machine does not come to its stop"
    reason = f"is one of {', '.join(FLIGHT_KEYS[:-1])} and {FLIGHT_KEYS[-1]} wrong by a factor?"
    right = "look at these numbers of the machine file and their units"
    yield Finding(Kind.FAULT, Check.FLIGHT, first.run.data, "lift", seen, reason, right, first.number)


def _time_machine(machine: Machine, top: _Top, flight: float) -> float | None:
    """Time of the machine's opening flight [s], inf: it does not come to its stop; None: it cannot be simulated.

    Where it is far off it is asked for again with a pulse that lasts, so that no wrong pulse is laid at its door.
    """
    stroke = machine.valve.stroke
    own = _time_opening(top.expected, stroke)
    step = float(np.median(np.diff(top.run.times)))
    if abs(own - flight) <= limits.MIN_FLIGHT_STEPS * step:
        return flight  # the samples do not tell
    if own > limits.MAX_FLIGHT_FACTOR * flight:
        lasting = expect(machine, top.run._replace(pulse=max(top.run.pulse, float(top.run.times[-1]))))
        return None if lasting is None else _time_opening(lasting, stroke)
    return own


def _time_opening(expected: Expected, stroke: float) -> float:
    """Time of the opening flight of a machine [s]; inf: it does not come to its stop."""
    lift = expected.channels["lift"]
    return _time_flight(expected.places, lift, stroke) if np.ptp(lift) > limits.MIN_REACHED * stroke else inf


def _time_flight(times: np.ndarray, lift: np.ndarray, span: float) -> float:
    """Time in which a lift goes from 10 to 90 % of its span [s]; NaN: not, from its first sample on, or over a gap."""
    known = np.isfinite(lift)
    times, away = times[known], lift[known] - find_levels(lift)[0]
    usual = float(np.median(np.diff(times)))
    crossings = []
    for share in FLIGHT:
        place = int(np.argmax(away > share * span))
        if place == 0:
            return nan
        if np.ptp(times[place - 1 : place + 1]) > max(limits.MIN_GAP * usual, limits.MIN_BLIND):
            return nan
        part = (share * span - away[place - 1]) / (away[place] - away[place - 1])
        crossings.append(float(times[place - 1] + part * (times[place] - times[place - 1])))
    return crossings[1] - crossings[0]
