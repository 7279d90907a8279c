"""Checks of levels against the machine: pressures, supply, lift, velocity, temperatures, whenever they are reached."""

from typing import NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility.expected import Expected
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, show
from apesim.studies.measured.plausibility.misreadings import (
    CELSIUS,
    SPEED_FACTORS,
    TEMPERATURES,
    Misreading,
    explain_factor,
    explain_levels,
    list_lift_misreadings,
    list_pressure_misreadings,
)
from apesim.studies.measured.plausibility.signals import (
    fill,
    find_correlation,
    find_levels,
    find_noise,
    find_span,
    smooth,
)
from apesim.studies.measured.plausibility.thresholds import (
    MAX_ABOVE,
    MAX_BELOW,
    MAX_COLD,
    MAX_HOT,
    MAX_LEFT_OF_SUPPLY,
    MAX_OFF_LIFT,
    MAX_OFF_PRESSURE,
    MAX_OFF_PRESSURE_SHARE,
    MAX_OFF_REST,
    MAX_OFF_REST_SHARE,
    MAX_OFF_SUPPLY_SHARE,
    MAX_OFF_SUPPLY_TEMPERATURE,
    MAX_SUPPLY_TEMPERATURE,
    MIN_ALIKE,
    MIN_MOVED,
    MIN_OFF_REST,
    MIN_REST_NOISES,
    MIN_SAMPLES,
    MIN_SLIPPED,
    MIN_SUPPLY_TEMPERATURE,
    MIN_VELOCITY_FACTOR,
)
from apesim.studies.measured.runs import ENGINE, MeasuredRun
from apesim.studies.measured.sensors import FILE

MIN_DONE = 0.8
"""Share of the stroke from which the machine's lift goes from stop to stop."""
IDENTICAL = Misreading("", "")


class Judged(NamedTuple):
    """What a check of levels says of a channel."""

    finding: Finding | None
    misreading: Misreading = IDENTICAL
    """What mends its values, so that the checks behind it can go on."""


def check_pressure(machine: Machine, run: MeasuredRun, number: int, channel: str, expected: Expected) -> Judged:
    """Check the levels of a pressure against those of the machine.

    >>> from apesim.studies.measured.plausibility.expected import Expected
    >>> times = np.arange(40) * 1e-3
    >>> values = np.where(times < 20e-3, 0.4e6, 0.0)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {"pressure_a": values})
    >>> expected = Expected(times, {"pressure_a": values + 101325.0}, {}, False)
    >>> check_pressure(Machine(), run, 0, "pressure_a", expected).finding.reason
    'gauge called abs?'
    """
    ambient, values = machine.ambient.pressure, run.channels[channel]
    levels, machine_levels = find_levels(values), find_levels(expected.at(channel, run))
    tolerances = [MAX_OFF_PRESSURE + MAX_OFF_PRESSURE_SHARE[run.bench] * level for level in machine_levels]
    is_off = [abs(a - b) > limit for a, b, limit in zip(levels, machine_levels, tolerances, strict=True)]
    is_below = levels[0] < -3.0 * find_noise(values) / np.sqrt(2.0)
    if not (any(is_off) or is_below):
        return Judged(None)
    misreading = explain_levels(levels, machine_levels, tolerances, list_pressure_misreadings(ambient))
    seen = f"lies at {show(run.bench, channel, *levels)}, where the machine shows "
    seen += show(run.bench, channel, *machine_levels)
    if misreading is None and not is_below and not is_off[0]:
        return Judged(None)  # the lowest is right: the supply, or the pulse, is the question
    if misreading is None:
        reason = "unit, zero or span of the gauge?"
        right = "see what the sensor shows in open air and at the supply"
        kind, check = (Kind.FAULT, Check.BELOW_ZERO) if is_below else (Kind.WARNING, Check.LEVEL)
        return Judged(Finding(kind, check, run.data, channel, seen, reason, right, number))
    check = Check.BELOW_ZERO if is_below else Check.LEVEL
    right = misreading.right + (", or the supply that it was" if misreading.zero == misreading.new_zero != 0.0 else "")
    return Judged(Finding(Kind.FAULT, check, run.data, channel, seen, misreading.reason, right, number), misreading)


def check_supply(
    machine: Machine, run: MeasuredRun, number: int, channel: str, values: np.ndarray
) -> tuple[Finding | None, float]:
    """Check the supply that a run states against a channel that stands at it when there is no flow.

    That is ``pressure_a``, the chamber that the supply fills at rest; `values` (n,) are freed of what a check of its
    levels has found [Pa abs]. Returned with the finding is the supply as it was, where the label is understood, else as
    it is stated [Pa abs].

    >>> run = MeasuredRun("p040", "p040.csv", 0.4e6, 287.0, 5e-3, "fit", np.arange(40), {})
    >>> finding, supply = check_supply(Machine(), run, 0, "pressure_a", np.full(40, 0.501e6))
    >>> finding.reason, round(supply)
    ("gauge called abs, or another run's?", 501325)
    """
    ambient, (_, rest) = machine.ambient.pressure, find_levels(values)
    off = rest - run.supply
    tolerance = MAX_OFF_REST + MAX_OFF_REST_SHARE * abs(run.supply)
    if abs(off) <= tolerance:
        return None, run.supply
    label = explain_levels(
        (run.supply,), (rest,), (max(MAX_OFF_REST, MAX_LEFT_OF_SUPPLY * abs(off)),), list_pressure_misreadings(ambient)
    )
    seen = f"is stated as {_gauge(run.supply, ambient)}, {channel} at rest shows {_gauge(rest, ambient)}"
    if label is not None and abs(float(label.mend(np.array(run.supply))) - rest) < MAX_LEFT_OF_SUPPLY * abs(off):
        supply = float(label.mend(np.array(run.supply)))
        right = f'write supply = "{_gauge(supply, ambient)}", if that is what it was'
        reason = f"{label.reason.removesuffix('?')}, or another run's?"
        return Finding(Kind.FAULT, Check.SUPPLY, FILE, _key(number, "supply"), seen, reason, right, number), supply
    kind = Kind.FAULT if abs(off) > MAX_OFF_SUPPLY_SHARE * (run.supply - ambient) + tolerance else Kind.WARNING
    right = "write the supply that it was, or look at the sensor"
    reason = "is it another run's, or has the regulator moved?"
    return Finding(kind, Check.SUPPLY, FILE, _key(number, "supply"), seen, reason, right, number), run.supply


def check_lift(machine: Machine, run: MeasuredRun, number: int, expected: Expected | None) -> Judged:
    """Check that a lift lies within the stroke of the valve.

    Without `expected`, None, the machine could not be simulated.

    >>> times = np.arange(40) * 1e-3
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {"lift": np.repeat([0.0, 9.0], 20)})
    >>> check_lift(Machine(), run, 0, None).finding.reason
    'µm called mm, or mm called m?'
    """
    stroke, values = machine.valve.stroke, run.channels["lift"]
    low, high = find_levels(values)
    noise = find_noise(values)
    machine_levels = find_levels(expected.at("lift", run)) if expected else (0.0, stroke)
    allowance = 2.0 * noise
    is_out = low < MAX_BELOW * stroke - allowance or high > MAX_ABOVE * stroke + allowance
    is_small = high - low < MIN_MOVED * stroke and machine_levels[1] - machine_levels[0] > MIN_DONE * stroke

    # A lift that keeps to the stroke, and moves as far as the machine's, may still rest beside zero.
    if not (is_out or is_small):
        return Judged(_find_rest(run, number, expected, stroke, noise) if expected else None)

    # What may have been misread: a unit, a sign, a zero. Units are tried only where the machine moves: by some factor
    # nearly any levels agree with a lift of nothing.
    rest = _rest(run, expected)
    tolerances = [MAX_OFF_LIFT * stroke] * 2
    slipped = rest if abs(rest) > MIN_SLIPPED * stroke else 0.0
    is_moving = machine_levels[1] - machine_levels[0] > MIN_MOVED * stroke
    tried = (each for each in list_lift_misreadings(slipped) if is_moving or abs(each.factor) == 1.0)
    misreading = explain_levels((low, high), machine_levels, tolerances, tried)

    # A lift that is small alone may be true, as of a piston that sticks: once mended, it has to go as the machine's.
    if is_small and (misreading is None or _likeness(run, expected, misreading) < MIN_ALIKE):
        if not is_out:
            return Judged(None)
        misreading = None
    seen = f"lies at {show(run.bench, 'lift', low, high)}, the stroke is {show(run.bench, 'lift', stroke)}"
    reason = "is valve.stroke of the machine the rig's, or the gain of the sensor?"
    right = "write the rig's stroke, or calibrate the sensor: lift is 0 closed and the stroke open"
    if misreading is None:
        return Judged(Finding(Kind.FAULT, Check.LIFT, run.data, "lift", seen, reason, right, number))
    return Judged(
        Finding(Kind.FAULT, Check.LIFT, run.data, "lift", seen, misreading.reason, misreading.right, number), misreading
    )


def check_velocity(run: MeasuredRun, number: int, expected: Expected) -> Judged:
    """Check size and sign of a velocity.

    >>> times = np.arange(40) * 1e-3
    >>> speed = np.sin(0.1 * np.arange(40))
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {"velocity": -speed})
    >>> check_velocity(run, 0, Expected(times, {"velocity": speed}, {}, False)).finding.reason
    'inverted?'
    """
    values, machine_values = run.channels["velocity"], expected.at("velocity", run)
    fastest, machine_fastest = (float(np.nanmax(np.abs(smooth(each)))) for each in (values, machine_values))
    if not (fastest and machine_fastest):
        return Judged(None)
    ratio = fastest / machine_fastest
    if not 1.0 / MIN_VELOCITY_FACTOR < ratio < MIN_VELOCITY_FACTOR and fastest > 10.0 * find_noise(values):
        seen = f"is up to {show(run.bench, 'velocity', fastest)}, where the machine shows "
        seen += show(run.bench, "velocity", machine_fastest)
        unit = explain_factor(ratio, SPEED_FACTORS, MIN_VELOCITY_FACTOR - 1.0)
        if unit:
            return Judged(
                Finding(Kind.FAULT, Check.LEVEL, run.data, "velocity", seen, unit.reason, unit.right, number), unit
            )
        right = "look at its unit and at the calibration"
        return Judged(Finding(Kind.WARNING, Check.LEVEL, run.data, "velocity", seen, "", right, number))
    alike = find_correlation(smooth(values), machine_values)
    goes_back = _travel(run.times, values) * _travel(run.times, machine_values) < 0.0
    if alike < -MIN_ALIKE or (run.bench != ENGINE and goes_back and alike < 0.0):
        seen = "runs towards closed where the valve opens"
        right = "turn its sign: it is positive as the valve opens"
        return Judged(
            Finding(Kind.FAULT, Check.INVERTED, run.data, "velocity", seen, "inverted?", right, number),
            Misreading("inverted?", right, -1.0),
        )
    return Judged(None)


def check_temperature(run: MeasuredRun, number: int, channel: str, supply_temperature: float) -> Finding | None:
    """Check the unit of a temperature, against that of the supply [K].

    >>> run = MeasuredRun("a", "a.csv", 0.5e6, 287.0, 5e-3, "fit", np.arange(9), {"temperature_a": np.full(9, 20.0)})
    >>> check_temperature(run, 0, "temperature_a", 287.0).reason
    'degC called K?'
    """
    values = run.channels[channel]
    (low, high), middle = find_levels(values), float(np.nanmedian(smooth(values)))
    seen = f"lies at {show(run.bench, channel, low, high)}, the supply is {supply_temperature:.4g} K"
    is_out = low < MAX_COLD or high > MAX_HOT
    for misreading in TEMPERATURES:
        mended = float(misreading.mend(np.array(middle)))
        if (
            abs(middle - supply_temperature) > 0.5 * CELSIUS
            and abs(mended - supply_temperature) < MAX_OFF_SUPPLY_TEMPERATURE
        ):
            return Finding(
                Kind.FAULT, Check.TEMPERATURE, run.data, channel, seen, misreading.reason, misreading.right, number
            )
    if is_out:
        right = "look at its unit and at the sensor"
        return Finding(Kind.WARNING, Check.TEMPERATURE, run.data, channel, seen, "", right, number)
    return None


def check_supply_temperature(run: MeasuredRun, number: int) -> Finding | None:
    """Check the temperature of the supply that a run states.

    >>> run = MeasuredRun("a", "a.csv", 0.5e6, 560.15, 5e-3, "fit", np.arange(9), {})
    >>> check_supply_temperature(run, 0).reason
    'K called degC?'
    """
    stated = run.temperature
    if np.isnan(stated) or MIN_SUPPLY_TEMPERATURE <= stated <= MAX_SUPPLY_TEMPERATURE:
        return None
    is_celsius = MIN_SUPPLY_TEMPERATURE <= stated - CELSIUS <= MAX_SUPPLY_TEMPERATURE
    return Finding(
        Kind.WARNING,
        Check.TEMPERATURE,
        FILE,
        _key(number, "temperature"),
        f"is stated as {stated:.4g} K",
        "K called degC?" if is_celsius else "",
        f'write temperature = "{stated - CELSIUS:.4g} K"' if is_celsius else "look whether the air was so warm or cold",
        number,
    )


def find_supply_temperature(machine: Machine, run: MeasuredRun) -> float:
    """Temperature of the supply [K] that the temperatures of a run are compared with.

    It is that of the run, unless no laboratory has such air; else the machine's.
    """
    if MIN_SUPPLY_TEMPERATURE <= run.temperature <= MAX_SUPPLY_TEMPERATURE:
        return run.temperature
    return machine.supply.temperature


def _gauge(pressure: float, ambient_pressure: float) -> str:
    """A supply pressure in words."""
    return f"{(pressure - ambient_pressure) / 1e6:.3g} MPa gauge"


def _key(number: int, key: str) -> str:
    """Key of a run, as the reader names it."""
    return f"run {number + 1}.{key}"


def _rest(run: MeasuredRun, expected: Expected | None) -> float:
    """What the closed valve shows: the middle of the samples at which the machine's is closed."""
    values = smooth(run.channels["lift"])
    if run.bench == ENGINE or expected is None:
        return (
            float(find_levels(values)[0])
            if expected is None
            else float(np.nanmedian(values[_is_closed(expected, run)]))
        )
    closed = _is_closed(expected, run)
    return float(np.median(values[closed] if closed.any() else values[np.isfinite(values)][:1]))


def _find_rest(run: MeasuredRun, number: int, expected: Expected, stroke: float, noise: float) -> Finding | None:
    """Hint of a lift that rests beside zero while the machine's valve is closed."""
    values = smooth(run.channels["lift"])
    closed = _is_closed(expected, run)
    if closed.sum() < MIN_SAMPLES:
        return None
    rest = float(np.median(values[closed]))
    off = rest - float(np.median(expected.at("lift", run)[closed]))
    lies_low = abs(rest - find_levels(values)[0]) <= MIN_REST_NOISES * noise + MIN_OFF_REST * stroke
    if not lies_low or abs(off) <= max(MIN_OFF_REST * stroke, MIN_REST_NOISES * noise):
        return None
    seen = f"rests at {show(run.bench, 'lift', rest)} while the valve is closed"
    seen += f", {abs(off) / noise:.0f} times its noise" if noise > 0.0 else ""
    right = "subtract what the closed valve shows, or state sensor.lift.offset in [known_to]"
    reason = "is the zero of the sensor set?"
    return Finding(Kind.HINT, Check.REST, run.data, "lift", seen, reason, right, number)


def _is_closed(expected: Expected, run: MeasuredRun) -> np.ndarray:
    """Known samples at which the machine's valve is closed."""
    lift = expected.at("lift", run)
    return lift <= np.nanmin(lift) + 0.02 * find_span(lift)


def _likeness(run: MeasuredRun, expected: Expected | None, misreading: Misreading) -> float:
    """Correlation of a mended lift with the machine's; 1 where that is not known."""
    if expected is None:
        return 1.0
    return find_correlation(misreading.mend(smooth(run.channels["lift"])), expected.at("lift", run))


def _travel(times: np.ndarray, velocity: np.ndarray) -> float:
    """The farthest way from the start that a velocity leads to [m]."""
    smoothed = fill(smooth(velocity))
    way = np.append(0.0, np.cumsum(0.5 * (smoothed[1:] + smoothed[:-1]) * np.diff(times)))
    return float(way[np.argmax(np.abs(way))])
