"""Misreadings: units, signs and zeros that are often confused, and which of them explains what was measured."""

from collections.abc import Iterable, Iterator, Sequence
from math import log
from typing import NamedTuple

import numpy as np

from apesim.studies.measured.plausibility.thresholds import MAX_OFF_SPAN


class Misreading(NamedTuple):
    """What may have gone wrong with a column: its right values are ``(values - zero) * factor + new_zero``."""

    reason: str
    """What may have happened, as a question."""
    right: str
    """What would be right."""
    factor: float = 1.0
    zero: float = 0.0
    """Value that is taken off before [SI]."""
    new_zero: float = 0.0
    """Value that is added behind [SI]."""

    def mend(self, values: np.ndarray) -> np.ndarray:
        """Values (n,) [SI] as they would be without the misreading."""
        return (values - self.zero) * self.factor + self.new_zero


PRESSURE_FACTORS = {
    0.1: "bar called MPa, or 10 times too large",
    10.0: "MPa called bar, or 10 times too small",
    0.01: "kPa called bar",
    100.0: "bar called kPa",
    1e-3: "kPa called MPa, or Pa called kPa",
    1e3: "MPa called kPa, or kPa called Pa",
    1e-5: "Pa called bar",
    1e5: "bar called Pa",
    1e-6: "Pa called MPa",
    1e6: "MPa called Pa",
    6.894757: "psi called kPa",
    0.06894757: "psi called bar",
    0.006894757: "psi called MPa",
    1 / 6.894757: "kPa called psi",
    1 / 0.06894757: "bar called psi",
}
"""What is confused where pressures are off by a factor: right value over the one that was read."""
LENGTH_FACTORS = {
    1e-3: "µm called mm, or mm called m",
    1e3: "mm called µm, or m called mm",
    0.1: "mm called cm",
    10.0: "cm called mm",
    0.01: "cm called m",
    100.0: "m called cm",
    25.4: "inches called mm",
    1 / 25.4: "mm called inches",
    1e-6: "µm called m",
    1e6: "m called µm",
}
"""What is confused where lengths are off by a factor."""
SPEED_FACTORS = {1e-3: "mm/s called m/s", 1e3: "m/s called mm/s", 0.01: "cm/s called m/s", 100.0: "m/s called cm/s"}
"""What is confused where velocities are off by a factor."""
TIME_FACTORS = {
    1e-3: "ms called s, or µs called ms",
    1e3: "s called ms, or ms called µs",
    1e-6: "µs called s",
    1e6: "s called µs",
}
"""What is confused where times are off by a factor."""
TORQUE_FACTORS = {
    1e-3: "N mm called N m",
    0.01: "N cm called N m",
    9.80665: "kgf m called N m",
    1e3: "N m called N mm, or kN m called N m",
    100.0: "N m called N cm",
}
"""What is confused where a torque is off by a factor."""
FORCE_FACTORS = {
    1e-3: "mN called N",
    4.448222: "lbf called N",
    9.80665: "kgf called N",
    1e3: "kN called N",
    9.80665e-3: "gf called N",
}
"""What is confused where a force is off by a factor."""
FLOW_FACTORS = {
    1 / 60.0: "per minute called per second",
    60.0: "per second called per minute",
    1 / 3600.0: "per hour called per second",
    3600.0: "per second called per hour",
    1e-3: "g called kg",
    1e3: "kg called g",
    1 / 49.8: "L/min (ANR) called g/s",
    1 / 3.6: "kg/h called g/s",
    3.6: "g/s called kg/h",
}
"""What is confused where a flow of air is off by a factor; 1 g/s is 49.8 L/min at 20 °C and 100 kPa."""
CELSIUS = 273.15
"""Kelvin less degrees Celsius."""
TEMPERATURES = (
    Misreading("degC called K?", 'write "degC" as its unit', new_zero=CELSIUS),
    Misreading("K called degC?", 'write "K" as its unit', new_zero=-CELSIUS),
)
"""What is confused with temperatures."""


def list_pressure_misreadings(ambient_pressure: float) -> Iterator[Misreading]:
    """What is often confused with pressures, the most likely first; `ambient_pressure` is [Pa abs]."""
    p = ambient_pressure
    gauge = "gauge called abs", 'write "gauge" behind its unit', 0.0, p
    absolute = "abs called gauge", 'write "abs" behind its unit', p, 0.0
    for reason, right, zero, new_zero in (gauge, absolute):
        yield Misreading(f"{reason}?", right, 1.0, zero, new_zero)
    for factor, confused in PRESSURE_FACTORS.items():
        yield Misreading(f"{confused}?", "write the unit that the file has", factor)
        yield Misreading(f"{confused}?", "write the unit that the file has", factor, p, p)
    for factor, confused in PRESSURE_FACTORS.items():
        for reason, right, zero, new_zero in (gauge, absolute):
            yield Misreading(
                f"{confused}, and {reason}?", f"write the unit that the file has, and {right}", factor, zero, new_zero
            )


def list_lift_misreadings(rest: float) -> Iterator[Misreading]:
    """List what is often confused with a lift, the most likely first.

    `rest` is the lift read of the closed valve [m].
    """
    named, turned = "write the unit that the file has", "turn its sign: lift is 0 closed and positive towards open"
    for factor, confused in LENGTH_FACTORS.items():
        yield Misreading(f"{confused}?", named, factor)
    yield Misreading("inverted?", turned, -1.0)
    if rest:
        yield Misreading("zero not set, or the sensor slipped?", "subtract what the closed valve shows", zero=rest)
        yield Misreading(
            "inverted, and zero not set?", f"subtract what the closed valve shows, and {turned}", -1.0, rest
        )
    for factor, confused in LENGTH_FACTORS.items():
        yield Misreading(f"inverted, and {confused}?", f"{named}, and {turned}", -factor)
        if rest:
            yield Misreading(
                f"{confused}, and zero not set?", f"{named}, and subtract the closed valve's", factor, rest
            )


def explain_levels(
    levels: Sequence[float], expected: Sequence[float], tolerances: Sequence[float], misreadings: Iterable[Misreading]
) -> Misreading | None:
    """Find the misreading that best brings measured levels to those that the machine has; None where none does.

    `levels` and `expected` are the lowest and the highest level [SI], `tolerances` by how much each may be off.
    `misreadings` begin with the most likely: a later one has to be clearly nearer. Where a unit is confused, the span
    between the levels has to become the machine's as well: at a low supply both levels may lie within their tolerances
    of anything.

    >>> found = explain_levels((0.0, 0.4e6), (101e3, 501e3), (2e4, 2e4), list_pressure_misreadings(101e3))
    >>> found.reason
    'gauge called abs?'
    """
    best, least = None, 1.0
    for misreading in misreadings:
        mended = np.sort(misreading.mend(np.array(levels)))
        off = float(np.max(np.abs(mended - np.array(expected)) / np.array(tolerances)))
        if abs(misreading.factor) != 1.0 and not _is_span(float(np.ptp(mended)), float(np.ptp(expected))):
            continue
        if off < (least if best is None else 0.5 * least):
            best, least = misreading, off
    return best


def explain_factor(ratio: float, factors: dict[float, str], max_off: float) -> Misreading | None:
    """Find the confusion of units that explains a factor; None where none does.

    `ratio` is the measured value over that of the machine, positive; `factors` has what is confused by the right value
    over the one that was read; `max_off` is the share by which the factor may be missed.

    >>> explain_factor(62.0, FLOW_FACTORS, 0.3).reason
    'per minute called per second?'
    """
    factor, confused = min(factors.items(), key=lambda item: abs(log(ratio * item[0])))
    if abs(log(ratio * factor)) > log(1.0 + max_off):
        return None
    return Misreading(f"{confused}?", "write the unit that the file has", factor)


def _is_span(span: float, machine_span: float) -> bool:
    """Whether a span is the machine's but for what units are missed by; true where the machine has none."""
    return not machine_span > 0.0 or (span > 0.0 and abs(log(span / machine_span)) < log(1.0 + MAX_OFF_SPAN))
