"""Checks of levels against the machine: pressures, supply, lift, velocity, temperatures, whenever they are reached."""

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility import thresholds as limits
from apesim.studies.measured.plausibility.expected import Expected
from apesim.studies.measured.plausibility.findings import Check, Kind, show
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
from apesim.studies.measured.plausibility.rows import Case, Seen
from apesim.studies.measured.plausibility.signals import (
    fill,
    find_correlation,
    find_levels,
    find_noise,
    find_span,
    smooth,
)
from apesim.studies.measured.runs import ENGINE, MeasuredRun

MIN_DONE = 0.8
"""Share of the stroke from which the machine's lift goes from stop to stop."""


def judge_pressure(case: Case, channel: str) -> Seen | None:
    """Compare the levels of a pressure with those of the machine."""
    ambient, run, values = case.machine.ambient.pressure, case.run, case.run.channels[channel]
    levels, machine_levels = find_levels(values), find_levels(case.expected.at(channel, run))
    tolerances = [
        limits.MAX_OFF_PRESSURE + limits.MAX_OFF_PRESSURE_SHARE[run.bench] * level for level in machine_levels
    ]
    is_off = [abs(a - b) > limit for a, b, limit in zip(levels, machine_levels, tolerances, strict=True)]
    is_below = levels[0] < -3.0 * find_noise(values) / np.sqrt(2.0)
    if not (any(is_off) or is_below):
        return None
    misreading = explain_levels(levels, machine_levels, tolerances, list_pressure_misreadings(ambient))
    text = f"lies at {show(run.bench, channel, *levels)}, where the machine shows "
    seen = Seen(text + show(run.bench, channel, *machine_levels))
    if is_below:
        seen = seen._replace(check=Check.BELOW_ZERO, kind=Kind.FAULT)
    if misreading is None:  # where the lowest is right, the supply or the pulse is the question
        return seen if is_below or is_off[0] else None
    right = misreading.right + (", or the supply that it was" if misreading.zero == misreading.new_zero != 0.0 else "")
    return seen.explained(misreading)._replace(right=right, mended=case.mend(channel, misreading))


def judge_supply(case: Case, key: str) -> Seen | None:
    """Compare the supply that a run states with ``pressure_a``, which stands at it where there is no flow.

    Where the label is understood, the run is mended.
    """
    ambient, stated, (_, rest) = case.machine.ambient.pressure, case.run.supply, find_levels(case.values["pressure_a"])
    off = rest - stated
    tolerance = limits.MAX_OFF_REST + limits.MAX_OFF_REST_SHARE * abs(stated)
    if abs(off) <= tolerance:
        return None
    near = max(limits.MAX_OFF_REST, limits.MAX_LEFT_OF_SUPPLY * abs(off))
    label = explain_levels((stated,), (rest,), (near,), list_pressure_misreadings(ambient))
    seen = f"is stated as {_gauge(stated, ambient)}, pressure_a at rest shows {_gauge(rest, ambient)}"
    if label is not None:
        supply = float(label.mend(np.array(stated)))
        if abs(supply - rest) < limits.MAX_LEFT_OF_SUPPLY * abs(off):
            right = f'write supply = "{_gauge(supply, ambient)}", if that is what it was'
            reason = f"{label.reason.removesuffix('?')}, or another run's?"
            return Seen(seen, Kind.FAULT, reason, right, mended=case._replace(run=case.run._replace(supply=supply)))
    return Seen(seen, Kind.FAULT if abs(off) > limits.MAX_OFF_SUPPLY_SHARE * (stated - ambient) + tolerance else None)


def judge_lift(case: Case, channel: str) -> Seen | None:
    """Compare a lift with the stroke of the valve."""
    machine, run, expected = case.machine, case.run, case.expected
    stroke, values = machine.valve.stroke, run.channels[channel]
    low, high = find_levels(values)
    noise = find_noise(values)
    machine_levels = find_levels(expected.at(channel, run))
    allowance = 2.0 * noise
    is_out = low < limits.MAX_BELOW * stroke - allowance or high > limits.MAX_ABOVE * stroke + allowance
    is_small = high - low < limits.MIN_MOVED * stroke and machine_levels[1] - machine_levels[0] > MIN_DONE * stroke

    # A lift that keeps to the stroke, and moves as far as the machine's, may still rest beside zero.
    if not (is_out or is_small):
        return _find_rest(run, expected, stroke, noise)

    # What may have been misread: a unit, a sign, a zero. Units are tried only where the machine moves: by some factor
    # nearly any levels agree with a lift of nothing.
    rest = _rest(run, expected)
    tolerances = [limits.MAX_OFF_LIFT * stroke] * 2
    slipped = rest if abs(rest) > limits.MIN_SLIPPED * stroke else 0.0
    is_moving = machine_levels[1] - machine_levels[0] > limits.MIN_MOVED * stroke
    tried = (each for each in list_lift_misreadings(slipped) if is_moving or abs(each.factor) == 1.0)
    misreading = explain_levels((low, high), machine_levels, tolerances, tried)

    # A lift that is small alone may be true, as of a piston that sticks: once mended, it has to go as the machine's.
    if is_small and (misreading is None or _likeness(run, expected, misreading) < limits.MIN_ALIKE):
        if not is_out:
            return None
        misreading = None
    seen = Seen(f"lies at {show(run.bench, channel, low, high)}, the stroke is {show(run.bench, channel, stroke)}")
    return seen.explained(misreading)._replace(mended=case.mend(channel, misreading) if misreading else None)


def judge_velocity(case: Case, channel: str) -> Seen | None:
    """Compare size and sign of a velocity with the machine's."""
    run = case.run
    values, machine_values = run.channels[channel], case.expected.at(channel, run)
    fastest, machine_fastest = (float(np.nanmax(np.abs(smooth(each)))) for each in (values, machine_values))
    if not (fastest and machine_fastest):
        return None
    ratio = fastest / machine_fastest
    if not 1.0 / limits.MIN_VELOCITY_FACTOR < ratio < limits.MIN_VELOCITY_FACTOR and fastest > 10.0 * find_noise(
        values
    ):
        seen = f"is up to {show(run.bench, channel, fastest)}, where the machine shows "
        seen += show(run.bench, channel, machine_fastest)
        return Seen(seen).explained(explain_factor(ratio, SPEED_FACTORS, limits.MIN_VELOCITY_FACTOR - 1.0))
    alike = find_correlation(smooth(values), machine_values)
    goes_back = _travel(run.times, values) * _travel(run.times, machine_values) < 0.0
    if alike < -limits.MIN_ALIKE or (run.bench != ENGINE and goes_back and alike < 0.0):
        right = "turn its sign: it is positive as the valve opens"
        seen = "runs towards closed where the valve opens"
        return Seen(seen, Kind.FAULT, "inverted?", right, Check.INVERTED)
    return None


def judge_temperature(case: Case, channel: str) -> Seen | None:
    """Compare the unit of a temperature with that of the supply [K]."""
    values, supply = case.run.channels[channel], find_supply_temperature(case.machine, case.run)
    (low, high), middle = find_levels(values), float(np.nanmedian(smooth(values)))
    seen = Seen(f"lies at {show(case.run.bench, channel, low, high)}, the supply is {supply:.4g} K")
    for misreading in TEMPERATURES:
        is_near = abs(float(misreading.mend(np.array(middle))) - supply) < limits.MAX_OFF_SUPPLY_TEMPERATURE
        if abs(middle - supply) > 0.5 * CELSIUS and is_near:
            return seen.explained(misreading)
    return seen if low < limits.MAX_COLD or high > limits.MAX_HOT else None


def judge_supply_temperature(case: Case, key: str) -> Seen | None:
    """Compare the temperature of the supply that a run states with what laboratories have."""
    stated = case.run.temperature
    if np.isnan(stated) or limits.MIN_SUPPLY_TEMPERATURE <= stated <= limits.MAX_SUPPLY_TEMPERATURE:
        return None
    seen = Seen(f"is stated as {stated:.4g} K")
    if limits.MIN_SUPPLY_TEMPERATURE <= stated - CELSIUS <= limits.MAX_SUPPLY_TEMPERATURE:
        return seen._replace(reason="K called degC?", right=f'write temperature = "{stated - CELSIUS:.4g} K"')
    return seen


def find_supply_temperature(machine: Machine, run: MeasuredRun) -> float:
    """Temperature of the supply [K] that the temperatures of a run are compared with.

    It is that of the run, unless no laboratory has such air; else the machine's.
    """
    if limits.MIN_SUPPLY_TEMPERATURE <= run.temperature <= limits.MAX_SUPPLY_TEMPERATURE:
        return run.temperature
    return machine.supply.temperature


def _gauge(pressure: float, ambient_pressure: float) -> str:
    """A supply pressure in words."""
    return f"{(pressure - ambient_pressure) / 1e6:.3g} MPa gauge"


def _rest(run: MeasuredRun, expected: Expected) -> float:
    """What the closed valve shows: the middle of the samples at which the machine's is closed."""
    values, closed = smooth(run.channels["lift"]), _is_closed(expected, run)
    if run.bench == ENGINE:
        return float(np.nanmedian(values[closed]))
    return float(np.median(values[closed] if closed.any() else values[np.isfinite(values)][:1]))


def _find_rest(run: MeasuredRun, expected: Expected, stroke: float, noise: float) -> Seen | None:
    """Hint of a lift that rests beside zero while the machine's valve is closed."""
    values = smooth(run.channels["lift"])
    closed = _is_closed(expected, run)
    if closed.sum() < limits.MIN_SAMPLES:
        return None
    rest = float(np.median(values[closed]))
    off = rest - float(np.median(expected.at("lift", run)[closed]))
    lies_low = abs(rest - find_levels(values)[0]) <= limits.MIN_REST_NOISES * noise + limits.MIN_OFF_REST * stroke
    if not lies_low or abs(off) <= max(limits.MIN_OFF_REST * stroke, limits.MIN_REST_NOISES * noise):
        return None
    seen = f"rests at {show(run.bench, 'lift', rest)} while the valve is closed"
    seen += f", {abs(off) / noise:.0f} times its noise" if noise > 0.0 else ""
    right = "subtract what the closed valve shows, or state sensor.lift.offset in [known_to]"
    reason = "is the zero of the sensor set?"
    return Seen(seen, Kind.HINT, reason, right, Check.REST)


def _is_closed(expected: Expected, run: MeasuredRun) -> np.ndarray:
    """Known samples at which the machine's valve is closed."""
    lift = expected.at("lift", run)
    return lift <= np.nanmin(lift) + 0.02 * find_span(lift)


def _likeness(run: MeasuredRun, expected: Expected, misreading: Misreading) -> float:
    """Correlation of a mended lift with the machine's."""
    return find_correlation(misreading.mend(smooth(run.channels["lift"])), expected.at("lift", run))


def _travel(times: np.ndarray, velocity: np.ndarray) -> float:
    """The farthest way from the start that a velocity leads to [m]."""
    smoothed = fill(smooth(velocity))
    way = np.append(0.0, np.cumsum(0.5 * (smoothed[1:] + smoothed[:-1]) * np.diff(times)))
    return float(way[np.argmax(np.abs(way))])
