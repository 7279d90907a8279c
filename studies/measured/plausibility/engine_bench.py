"""Checks of an engine's run against the machine: crank angle, turns that close, and means over the cycle."""

from math import pi

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.kinematics import swept_volume
from apesim.studies.measured.plausibility import thresholds as limits
from apesim.studies.measured.plausibility.expected import Expected
from apesim.studies.measured.plausibility.findings import Kind, show
from apesim.studies.measured.plausibility.misreadings import FLOW_FACTORS, TORQUE_FACTORS, explain_factor
from apesim.studies.measured.plausibility.rows import Case, Seen
from apesim.studies.measured.plausibility.signals import (
    find_correlation,
    find_noise,
    find_span,
    smooth,
)
from apesim.studies.measured.runs import MeasuredRun

TURNS = np.radians(np.arange(-179.0, 181.0))
"""Errors of the crank angle that are tried [rad]."""
MIN_FOR_LINE = 3
"""Samples of a line that tells how a pressure goes on."""
ANGLED = ("cylinder_pressure", "lift", "pressure_a", "pressure_b")
"""Channels that tell the crank angle, the surest first: compression and expansion follow the crank itself."""


def judge_crank_angle(case: Case, axis: str) -> Seen | None:
    """Find where top dead centre is; the case goes on with the angles mended."""
    run, expected = case.run, case.expected
    errors = {name: _find_turn(run, name, expected) for name in ANGLED if name in run.channels}
    told = {name: error for name, error in errors.items() if error is not None}
    if not told:
        return None
    channel = next(iter(told))
    error = told[channel]
    agree = all(abs(_wrap(other - error)) <= np.radians(limits.MAX_APART) for other in told.values())
    size = abs(np.degrees(error))
    if size < limits.MIN_ANGLE_WARNED or not agree:
        return None
    kind = Kind.FAULT if size >= limits.MIN_ANGLE_ALONE else Kind.WARNING
    when = "later" if error > 0.0 else "earlier"
    seen = f"the {channel.replace('_', ' ')} comes {size:.0f} deg {when} than the machine's"
    reason = (
        "0 deg at bottom dead centre?" if size > 180.0 - limits.MAX_APART else f"top dead centre {size:.0f} deg off?"
    )
    right = f"{'take' if error > 0.0 else 'add'} {size:.0f} deg {'off' if error > 0.0 else 'to'} the crank angles: "
    right += "0 deg is top dead centre"
    mended = case._replace(run=run._replace(angles=run.angles - error))
    return Seen(seen, kind, reason, right, size=error, mended=mended)


def judge_torque(case: Case, key: str) -> Seen | None:
    """Compare sign and unit of a mean torque with the machine's."""
    machine, run, expected = case.machine, case.run, case.expected
    torque, machine_torque = run.means["torque"], expected.means["torque"]
    least = limits.MIN_TORQUE_PRESSURE * swept_volume(machine.engine) / TURN
    if abs(machine_torque) < least:
        return None
    text = f"is {show(run.bench, key, torque)}, where the machine gives {show(run.bench, key, machine_torque)}"
    seen, ratio = Seen(text), abs(torque / machine_torque)
    unit = explain_factor(ratio, TORQUE_FACTORS, limits.MAX_OFF_UNIT) if ratio > 0.0 else None
    if not 1.0 / limits.MIN_FLOW_FACTOR < ratio < limits.MIN_FLOW_FACTOR and unit:
        return seen.explained(unit)
    is_like = 1.0 / limits.MAX_DOUBTED < ratio < limits.MAX_DOUBTED
    if torque * machine_torque < 0.0:
        right = "turn its sign: a torque that the engine gives is positive"
        kind = Kind.FAULT if is_like else Kind.WARNING
        return seen._replace(kind=kind, reason="sign turned round?", right=right)
    return None if is_like else seen


def judge_air_flow(case: Case, key: str) -> Seen | None:
    """Compare sign and unit of a mean flow of air with the machine's."""
    bench, flow, machine_flow = case.run.bench, case.run.means[key], case.expected.means[key]
    if machine_flow <= 0.0:
        return None
    seen = Seen(f"is {show(bench, key, flow)}, where the machine takes {show(bench, key, machine_flow)}")
    if flow <= 0.0:
        right = "turn its sign: air into the engine is positive"
        return seen._replace(kind=Kind.FAULT, reason="sign turned round?", right=right)
    ratio = flow / machine_flow
    if 1.0 / limits.MAX_DOUBTED < ratio < limits.MAX_DOUBTED:
        return None
    unit = explain_factor(ratio, FLOW_FACTORS, limits.MAX_OFF_UNIT)
    if unit and not 1.0 / limits.MIN_FLOW_FACTOR < ratio < limits.MIN_FLOW_FACTOR:
        return seen.explained(unit)
    return seen._replace(reason=unit.reason if unit else "")


def judge_turn(case: Case, channel: str) -> Seen | None:
    """Check that a pressure is at the end of a turn what it is at its beginning, as each turn is like the other."""
    run, expected = case.run, case.expected
    if channel in case.blamed:
        return None
    values, places = run.channels[channel], run.angles
    known = np.isfinite(values)
    step, span = float(np.median(np.diff(places))), find_span(values)
    later = known & (places >= places[0] + TURN)
    noise = find_noise(values)

    # How far the turn is open, by what the record has: several turns, or one whole one. A part of one cannot tell.
    if later.sum() >= limits.MIN_SAMPLES:  # several turns: each sample is compared with the one a turn before
        gap = float(np.median(values[later] - np.interp(places[later] - TURN, places[known], values[known])))
    elif abs(places[-1] + step - places[0] - TURN) < 2.0 * step:  # one: where the machine goes on at its end
        seam = 0.5 * (places[-1] + places[0] + TURN)
        off = values - expected.at(channel, run)
        first, last = known & (places <= places[0] + limits.SEAM), known & (places >= places[-1] - limits.SEAM)
        if min(first.sum(), last.sum()) < MIN_FOR_LINE:
            return None
        begin, end = (
            float(np.polyval(np.polyfit(places[part] + turn - seam, off[part], 1), 0.0))
            for part, turn in ((first, TURN), (last, 0.0))
        )
        gap = end - begin
    else:
        return None

    # Noise and effects of the library leave a turn a little open; only what is more is told.
    if abs(gap) <= limits.MAX_OPEN_TURN * span + limits.MIN_NOISES_OPEN * noise:
        return None
    size = show(run.bench, channel, abs(gap)).removesuffix(" abs")
    seen = f"is {size} {'higher' if gap > 0.0 else 'lower'} at the end of a turn than at its beginning"
    return Seen(seen)


def _find_turn(run: MeasuredRun, channel: str, expected: Expected) -> float | None:
    """Error of the crank angle by one channel [rad], 0 where it is right; None: the channel does not tell it."""
    values = smooth(run.channels[channel])
    alike = np.array([find_correlation(values, expected.at(channel, run, turn)) for turn in TURNS])
    best, unturned = int(np.argmax(alike)), float(alike[np.argmin(np.abs(TURNS))])
    if alike[best] < limits.MIN_ALIKE:
        return None
    if 1.0 - alike[best] > limits.MAX_LEFT_AFTER_TURN * (1.0 - unturned):
        return 0.0
    return float(TURNS[best])


def _wrap(angle: float) -> float:
    """An angle between -180 and 180 deg [rad]."""
    return (angle + pi) % TURN - pi
