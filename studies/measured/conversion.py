"""Conversion of the numbers of a file to SI: from their unit, or from what a sensor gives by a scale and an offset."""

import math
import re
from collections import Counter
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from apesim.quantities import InvalidValue, quoted, unit
from apesim.quantities.units import Unit, respelt, split_number

KINDS = (ABSOLUTE, GAUGE) = ("abs", "gauge")
"""Words behind the unit of a pressure."""
OTHER_KINDS = re.compile(r"(.+?)(?:\s*\(\s*(\w+)\s*\)|\s*([gGaA])|\s+(rel|relative|absolute|ü))")
"""What laboratories write for them: psig, bar(g), kPaG, mbar abs., bar (abs)."""
THEIR_KINDS = dict.fromkeys(("g", "gauge", "rel", "relative", "ü"), GAUGE) | dict.fromkeys(
    ("a", "abs", "absolute"), ABSOLUTE
)
"""Ours for theirs, in small letters."""


class Measure(NamedTuple):
    """Number with a unit, before it is known what it measures."""

    number: Fraction
    """Number."""
    unit: str
    """Unit; "": there is none."""
    kind: str = ""
    """One of `KINDS`, "": neither is said."""


SIGNALS = "V", "A", ""
"""Units of what sensors give before it is scaled; "": counts."""


def read_measure(raw: Any) -> Measure:
    """Read a number with a unit of any dimension, ``gauge`` or ``abs`` behind it or not; or one without a unit.

    Raises InvalidValue where it is no finite number, or has no known unit.
    """
    if isinstance(raw, bool) or not isinstance(raw, str | int | float):
        raise InvalidValue(f"{quoted(raw)} is no number with a unit")
    text = raw.strip() if isinstance(raw, str) else repr(raw)
    found = split_number(text)
    if not found or not math.isfinite(float(found[0])):
        raise InvalidValue(f"{quoted(raw)} is no finite number with a unit")
    name, kind = split_kind(found[1])
    unit(name)
    return Measure(Fraction(found[0]), name, kind)


def is_measure(text: str) -> bool:
    """Tell whether a text is a number with a unit, as "0.2 ms" is."""
    try:
        return bool(read_measure(text).unit)
    except InvalidValue:
        return False


def split_kind(text: str) -> tuple[str, str]:
    """Split the unit of a pressure into unit and ``gauge`` or ``abs``, one of `KINDS`; "" where neither is said.

    >>> split_kind("kPa abs"), split_kind("mm"), split_kind("psig"), split_kind("bar(a)")
    (('kPa', 'abs'), ('mm', ''), ('psi', 'gauge'), ('bar', 'abs'))
    """
    name, _, kind = text.rpartition(" ")
    if kind in KINDS:
        return name.strip(), kind
    found = OTHER_KINDS.fullmatch(text)
    if found and _is_pressure(found[1]):
        word = next(word for word in found.groups()[1:] if word).lower()
        if word in THEIR_KINDS:
            return found[1], THEIR_KINDS[word]
    return text, ""


def _is_pressure(text: str) -> bool:
    """Whether a text is a unit of pressure."""
    try:
        return unit(text).dimension == unit("Pa").dimension
    except InvalidValue:
        return False


def suggest_unit(given: str | None, expected: str, scale: Measure | None = None) -> str:
    """Suggest the unit that a column has, where what is given is none of it: the nearest right one.

    `given` is what its header says, None: nothing. `expected` is the unit of its dimension, that of a pressure ends in
    `` abs``; with `scale`, what its numbers are multiplied with, the unit is that of the numbers before it.

    >>> suggest_unit("Grad", "deg"), suggest_unit("PSIG", "kPa abs"), suggest_unit("furlong", "mm")
    ('deg', 'psi gauge', 'mm')
    >>> suggest_unit(None, "mm", read_measure("2 mm/V")), suggest_unit(None, "ms", read_measure("0.2 ms"))
    ('V', '-')
    """
    due, due_kind = split_kind(expected)
    if scale and scale.unit:
        for signal in (*SIGNALS, due):
            if _multiply_dimensions(unit(signal), unit(scale.unit)) == unit(due).dimension:
                return signal or "-"
        return expected
    for body, kind in _spellings(given or ""):
        name = respelt(f"1 {body}").removeprefix("1 ")
        try:
            if body and unit(name).dimension == unit(due).dimension:
                return f"{name} {kind or due_kind}" if due_kind else name
        except InvalidValue:
            continue
    return expected


def _spellings(text: str) -> list[tuple[str, str]]:
    """Ways to split a unit of unknown spelling into unit and kind."""
    body, kind = split_kind(text)
    found = OTHER_KINDS.fullmatch(text)
    if not found or kind:
        return [(body, kind)]
    word = next(word for word in found.groups()[1:] if word).lower()
    return [(found[1], THEIR_KINDS[word]), (body, kind)] if word in THEIR_KINDS else [(body, kind)]


def convert(
    name: str,
    given: str,
    numbers: np.ndarray,
    expected: str,
    ambient_pressure: float,
    *,
    right: str,
    scale: Measure | None = None,
    offset: Measure | None = None,
) -> np.ndarray:
    """Convert a column (n,), of our `name`, to SI; pressures become absolute.

    Its numbers have the unit `given`; `expected` is that of the dimension, for a pressure with `` abs`` at its end, and
    gauge pressures stand above `ambient_pressure` [Pa abs]. Numbers are multiplied with `scale`, then `offset` is
    added: where the scale makes volts to a pressure, it is the pressure at 0 V, and says gauge or abs; where the unit
    of the file is one of pressure already, it is a difference. Raises InvalidValue, which names `right` as the right
    form, where a unit is not known or not of the dimension, gauge or abs is not said, or a value is too large.

    A transducer that gives 0.5 to 4.5 V for 0 to 10 bar:

    >>> scale, offset = read_measure("2.5 bar/V"), read_measure("-1.25 bar gauge")
    >>> volts = np.array([0.5, 4.5])
    >>> convert("pressure_a", "V", volts, "kPa abs", 100e3, right="", scale=scale, offset=offset).tolist()
    [100000.0, 1100000.0]
    """
    due_name, due_kind = split_kind(expected)
    body, kind = split_kind(given) if due_kind else (given, "")
    try:
        source, due, by = unit(body), unit(due_name), unit(scale.unit if scale else "")
    except InvalidValue as wrong:
        raise InvalidValue(wrong.wrong, right) from None

    # The dimensions first: what is added depends on whether the numbers have the right one already.
    if _multiply_dimensions(source, by) != due.dimension:
        if not scale:
            raise InvalidValue(f"{quoted(given)} is no unit of {name}", right)
        form = f'unit.{name} is that of the file, before the scale, e.g. "V" with scale.{name} = "2 {due_name}/V"'
        by_what = quoted(scale.unit) if scale.unit else "a bare number"
        raise InvalidValue(f"{quoted(body)} times {by_what} is no unit of {name}", form)

    # What is added. Numbers of the right dimension have a zero, and an offset shifts it; what a sensor gives has none,
    # and the offset says what 0 of it stands for.
    if source.dimension == due.dimension:
        if due_kind and not kind:
            raise InvalidValue(f"{quoted(given)} says neither gauge nor abs", f"{right}, or gauge")
        if scale and source.offset:
            raise InvalidValue(
                f"{quoted(given)} has a zero of its own: its scale is not clear", "scale what the sensor gives"
            )
        shift = float(source.offset) + (ambient_pressure if kind == GAUGE else 0.0)
        shift += _read_difference(name, offset, due, due_name) if offset else 0.0
    else:
        zero = f'write what 0 {body} stands for, e.g. offset.{name} = "-1 {due_name}{" gauge" * bool(due_kind)}"'
        if kind:
            raise InvalidValue(f"{quoted(given)} is no pressure", f'write unit.{name} = "{body}"')
        offset = offset or Measure(Fraction(0), due.si_text)
        shift = _read_value(name, offset, due, ambient_pressure if due_kind else None, zero)

    # The factor is exact up to here, and is rounded once.
    factor = source.factor * scale.number * by.factor if scale else source.factor
    values = numbers * float(factor) + shift
    if np.any(np.isinf(values)):
        row = int(np.argmax(np.isinf(values))) + 1
        raise InvalidValue(f"row {row} is too large, not finite", "give finite numbers")
    return values


def _multiply_dimensions(*units: Unit) -> tuple[tuple[str, int], ...]:
    """Dimension of a product of units, as `Unit` has it."""
    powers: Counter[str] = Counter()
    for each in units:
        for base, power in each.dimension:
            powers[base] += power
    return tuple(sorted(item for item in powers.items() if item[1]))


def _read_difference(name: str, offset: Measure, due: Unit, due_name: str) -> float:
    """SI value of an offset of numbers that are of the dimension already."""
    given = unit(offset.unit)
    if offset.kind or given.offset or given.dimension != due.dimension:
        right = f'write a difference with its unit, e.g. offset.{name} = "0.1 {due_name}"'
        raise InvalidValue(f"an offset in {quoted(f'{offset.unit} {offset.kind}'.strip())} is no difference", right)
    return given.si(offset.number)


def _read_value(name: str, offset: Measure, due: Unit, ambient_pressure: float | None, right: str) -> float:
    """SI value of an offset, what a sensor that gives 0 stands for; without an ambient pressure, of no pressure."""
    given = unit(offset.unit)
    if given.dimension != due.dimension:
        raise InvalidValue(f"an offset in {quoted(offset.unit)} is no value of {name}", right)
    if ambient_pressure is not None and not offset.kind:
        raise InvalidValue("is scaled to a pressure, and no offset says gauge or abs", right)
    if ambient_pressure is None and offset.kind:
        raise InvalidValue(f"an offset of {name} is neither gauge nor abs", right)
    return given.si(offset.number, ambient_pressure if ambient_pressure and offset.kind == GAUGE else 0.0)
