"""All checks of a run of the engine's bench against the machine."""

from collections.abc import Iterator
from math import pi

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.kinematics import swept_volume
from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility.expected import Expected, expect
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, show
from apesim.studies.measured.plausibility.levels import (
    check_lift,
    check_pressure,
    check_supply_temperature,
    check_temperature,
    check_velocity,
    find_supply_temperature,
)
from apesim.studies.measured.plausibility.misreadings import FLOW_FACTORS, TORQUE_FACTORS, explain_factor
from apesim.studies.measured.plausibility.motion import check_swapped
from apesim.studies.measured.plausibility.signals import (
    find_correlation,
    find_noise,
    find_span,
    select_judged,
    smooth,
)
from apesim.studies.measured.plausibility.thresholds import (
    MAX_APART,
    MAX_DOUBTED,
    MAX_LEFT_AFTER_TURN,
    MAX_OFF_UNIT,
    MAX_OPEN_TURN,
    MIN_ALIKE,
    MIN_ANGLE_ALONE,
    MIN_ANGLE_WARNED,
    MIN_FLOW_FACTOR,
    MIN_NOISES_OPEN,
    MIN_SAMPLES,
    MIN_TORQUE_PRESSURE,
    SEAM,
)
from apesim.studies.measured.plausibility.valve_bench import not_simulated
from apesim.studies.measured.runs import MeasuredRun
from apesim.studies.measured.sensors import FILE

TURNS = np.radians(np.arange(-179.0, 181.0))
"""Errors of the crank angle that are tried [rad]."""
MIN_FOR_LINE = 3
"""Samples of a line that tells how a pressure goes on."""
ANGLED = ("cylinder_pressure", "lift", "pressure_a", "pressure_b")
"""Channels that tell the crank angle, the surest first: compression and expansion follow the crank itself."""


def check_engine_run(machine: Machine, run: MeasuredRun, number: int) -> tuple[list[Finding], Expected | None]:
    """Check a run of the engine's bench against the machine, and give what the machine shows of it.

    `number` is that of the run in the folder, from 0; Expected is None where it could not be simulated.

    >>> run = MeasuredRun(
    ...     "n600", "", 1.1e6, 287.0, float("nan"), "fit", np.zeros(0), {}, bench="engine", speed=20.0 * pi,
    ...     energise=-0.1, release=1.2, means={"air_flow": 2.7})
    >>> [finding.reason for finding in check_engine_run(Machine(), run, 0)[0]]
    ['per minute called per second?']
    """
    run = run._replace(channels=select_judged(run))
    expected = expect(machine, run)
    if expected is None:
        return [not_simulated(run, number)], None
    return list(_check_all(machine, run, number, expected)), expected


def check_crank_angle(run: MeasuredRun, number: int, expected: Expected) -> tuple[Finding | None, float]:
    """Check where top dead centre is; also gives by how much the angles are too large [rad], 0 without a finding.

    >>> angles = np.radians(np.arange(360.0))
    >>> pressure = np.exp(3.0 * np.cos(angles) + np.sin(2.0 * angles))
    >>> run = MeasuredRun("n600", "n600.csv", 1.1e6, 287.0, float("nan"), "fit", angles,
    ...     {"cylinder_pressure": np.roll(pressure, 180)}, bench="engine", angles=angles)
    >>> finding, error = check_crank_angle(run, 0, Expected(angles, {"cylinder_pressure": pressure}, {}, True))
    >>> finding.reason, round(np.degrees(error))
    ('0 deg at bottom dead centre?', 180)
    """
    errors = {name: _find_turn(run, name, expected) for name in ANGLED if name in run.channels}
    told = {name: error for name, error in errors.items() if error is not None}
    if not told:
        return None, 0.0
    channel = next(iter(told))
    error = told[channel]
    agree = all(abs(_wrap(other - error)) <= np.radians(MAX_APART) for other in told.values())
    size = abs(np.degrees(error))
    if size < MIN_ANGLE_WARNED or not agree:
        return None, 0.0
    kind = Kind.FAULT if size >= MIN_ANGLE_ALONE else Kind.WARNING
    when = "later" if error > 0.0 else "earlier"
    seen = f"the {channel.replace('_', ' ')} comes {size:.0f} deg {when} than the machine's"
    reason = "0 deg at bottom dead centre?" if size > 180.0 - MAX_APART else f"top dead centre {size:.0f} deg off?"
    right = f"{'take' if error > 0.0 else 'add'} {size:.0f} deg {'off' if error > 0.0 else 'to'} the crank angles: "
    right += "0 deg is top dead centre"
    return Finding(kind, Check.CRANK_ANGLE, run.data, "crank_angle", seen, reason, right, number, error), error


def check_torque(machine: Machine, run: MeasuredRun, number: int, expected: Expected) -> Finding | None:
    """Check sign and unit of a mean torque.

    >>> run = MeasuredRun("n600", "", 1.1e6, 287.0, float("nan"), "fit", np.zeros(0), {}, bench="engine",
    ...     means={"torque": -31.0})
    >>> check_torque(Machine(), run, 0, Expected(np.zeros(0), {}, {"torque": 32.0}, True)).reason
    'sign turned round?'
    """
    torque, machine_torque = run.means["torque"], expected.means["torque"]
    least = MIN_TORQUE_PRESSURE * swept_volume(machine.engine) / TURN
    if abs(machine_torque) < least:
        return None
    seen = f"is {show(run.bench, 'torque', torque)}, where the machine gives "
    seen += show(run.bench, "torque", machine_torque)
    key = f"run {number + 1}.torque"
    ratio = abs(torque / machine_torque)
    unit = explain_factor(ratio, TORQUE_FACTORS, MAX_OFF_UNIT) if ratio > 0.0 else None
    if not 1.0 / MIN_FLOW_FACTOR < ratio < MIN_FLOW_FACTOR and unit:
        return Finding(Kind.FAULT, Check.TORQUE, FILE, key, seen, unit.reason, unit.right, number)
    if torque * machine_torque < 0.0:
        is_turned = 1.0 / MAX_DOUBTED < ratio < MAX_DOUBTED
        right = "turn its sign: a torque that the engine gives is positive"
        kind = Kind.FAULT if is_turned else Kind.WARNING
        return Finding(kind, Check.TORQUE, FILE, key, seen, "sign turned round?", right, number)
    if not 1.0 / MAX_DOUBTED < ratio < MAX_DOUBTED:
        right = "look at its unit, its zero and what the brake itself takes"
        return Finding(Kind.WARNING, Check.TORQUE, FILE, key, seen, "", right, number)
    return None


def check_air_flow(run: MeasuredRun, number: int, expected: Expected) -> Finding | None:
    """Check sign and unit of a mean flow of air."""
    flow, machine_flow = run.means["air_flow"], expected.means["air_flow"]
    if machine_flow <= 0.0:
        return None
    seen = f"is {show(run.bench, 'air_flow', flow)}, where the machine takes "
    seen += show(run.bench, "air_flow", machine_flow)
    key = f"run {number + 1}.air_flow"
    if flow <= 0.0:
        right = "turn its sign: air into the engine is positive"
        return Finding(Kind.FAULT, Check.AIR_FLOW, FILE, key, seen, "sign turned round?", right, number)
    ratio = flow / machine_flow
    if 1.0 / MAX_DOUBTED < ratio < MAX_DOUBTED:
        return None
    unit = explain_factor(ratio, FLOW_FACTORS, MAX_OFF_UNIT)
    if unit and not 1.0 / MIN_FLOW_FACTOR < ratio < MIN_FLOW_FACTOR:
        return Finding(Kind.FAULT, Check.AIR_FLOW, FILE, key, seen, unit.reason, unit.right, number)
    right = "look at its unit and at leaks: it is all air, the control air too"
    return Finding(Kind.WARNING, Check.AIR_FLOW, FILE, key, seen, unit.reason if unit else "", right, number)


def _check_all(machine: Machine, run: MeasuredRun, number: int, expected: Expected) -> Iterator[Finding]:
    """Findings of the crank angle, then of the rest with the angle mended."""
    # Every trace stands over the crank angle: with a wrong one, the checks behind it would blame the channels.
    finding, error = check_crank_angle(run, number, expected)
    if finding:
        yield finding
        run = run._replace(angles=run.angles - error)

    # Each channel by itself. What the levels of a pressure show is mended for the check of both chambers below.
    values = dict(run.channels)
    temperature = find_supply_temperature(machine, run)
    for channel in run.channels:
        found = None
        if "pressure" in channel:
            judged = check_pressure(machine, run, number, channel, expected)
            found, values[channel] = judged.finding, judged.misreading.mend(values[channel])
            found = found or _check_turn(run, number, channel, expected)
        elif "temperature" in channel:
            found = check_temperature(run, number, channel, temperature)
        elif channel == "lift":
            found = check_lift(machine, run, number, expected).finding
        elif channel == "velocity":
            found = check_velocity(run, number, expected).finding
        if found:
            yield found

    # What no single channel shows: chambers that are swapped, what the run states, and means over the cycle.
    both = {"pressure_a", "pressure_b"} <= values.keys()
    for finding in (
        check_swapped(run, number, values, expected) if both else None,
        check_supply_temperature(run, number),
        check_torque(machine, run, number, expected) if "torque" in run.means else None,
        check_air_flow(run, number, expected) if "air_flow" in run.means else None,
    ):
        if finding:
            yield finding


def _check_turn(run: MeasuredRun, number: int, channel: str, expected: Expected) -> Finding | None:
    """Check that a pressure is at the end of a turn what it is at its beginning, as each turn is like the other."""
    values, places = run.channels[channel], run.angles
    known = np.isfinite(values)
    step, span = float(np.median(np.diff(places))), find_span(values)
    later = known & (places >= places[0] + TURN)
    noise = find_noise(values)

    # How far the turn is open, by what the record has: several turns, or one whole one. A part of one cannot tell.
    if later.sum() >= MIN_SAMPLES:  # several turns: each sample is compared with the one a turn before
        gap = float(np.median(values[later] - np.interp(places[later] - TURN, places[known], values[known])))
    elif abs(places[-1] + step - places[0] - TURN) < 2.0 * step:  # one: where the machine goes on at its end
        seam = 0.5 * (places[-1] + places[0] + TURN)
        off = values - expected.at(channel, run)
        first, last = known & (places <= places[0] + SEAM), known & (places >= places[-1] - SEAM)
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
    if abs(gap) <= MAX_OPEN_TURN * span + MIN_NOISES_OPEN * noise:
        return None
    size = show(run.bench, channel, abs(gap)).removesuffix(" abs")
    seen = f"is {size} {'higher' if gap > 0.0 else 'lower'} at the end of a turn than at its beginning"
    reason = "does the sensor drift, or was the engine not yet steady?"
    right = "record at a steady state with a warm sensor: a turn has to close"
    return Finding(Kind.WARNING, Check.TURN, run.data, channel, seen, reason, right, number)


def _find_turn(run: MeasuredRun, channel: str, expected: Expected) -> float | None:
    """Error of the crank angle by one channel [rad], 0 where it is right; None: the channel does not tell it."""
    values = smooth(run.channels[channel])
    alike = np.array([find_correlation(values, expected.at(channel, run, turn)) for turn in TURNS])
    best, unturned = int(np.argmax(alike)), float(alike[np.argmin(np.abs(TURNS))])
    if alike[best] < MIN_ALIKE:
        return None
    if 1.0 - alike[best] > MAX_LEFT_AFTER_TURN * (1.0 - unturned):
        return 0.0
    return float(TURNS[best])


def _wrap(angle: float) -> float:
    """An angle between -180 and 180 deg [rad]."""
    return (angle + pi) % TURN - pi
