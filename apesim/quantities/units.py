"""Units: what a text names, and exact conversion to SI and back."""

import math
import re
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from apesim.quantities.input_errors import InvalidValue, quoted
from apesim.quantities.names import BASES, known_units, named, nearest

NUMBER = r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)"
"""The grammar of a number, one group. No digit matches in two ways: a pattern of several numbers would try them all."""
MAX_TEXT = 100
"""Characters of a number with its unit: a longer text is none, and no pattern is tried on it."""


class Unit(NamedTuple):
    """Unit of measurement: ``SI value = number * factor + offset``, both exact."""

    factor: Fraction
    """Factor to SI."""
    offset: Fraction
    """Zero of the unit, in SI."""
    dimension: tuple
    """Pairs of base unit and exponent. The radian counts, so that Hz and rad/s are not confused."""

    def si(self, number: str | Fraction | Decimal, reference: float = 0.0) -> float:
        """Return the SI value of a number of this unit above a reference in SI, rounded once; inf where too large."""
        try:
            return float(Fraction(number) * self.factor + self.offset + Fraction(reference))
        except OverflowError:
            return math.inf

    def shortest(self, value: float, reference: float = 0.0) -> str:
        """Return the shortest decimal number of this unit above a reference whose `si` is a value; both are in SI."""
        exact = (Fraction(value) - Fraction(reference) - self.offset) / self.factor
        for digits in range(1, 40):  # 17 do, but for a tiny value that a reference or offset hides
            with localcontext(prec=digits):
                number = (Decimal(exact.numerator) / Decimal(exact.denominator)).normalize()
            if self.si(number, reference) == value:
                break
        return f"{number:f}" if -6 < number.adjusted() < 16 else f"{number:e}"

    @property
    def si_text(self) -> str:
        """SI unit of the same dimension, e.g. "m s^-1"; "-" without dimension."""
        short = {name: symbol for symbol, name in BASES.items()}
        powers = [(short[name], f"^{power}" * (power != 1)) for name, power in self.dimension]
        return " ".join(map("".join, powers)) or "-"


TEMPERATURES = {
    "degC": Unit(Fraction(1), Fraction("273.15"), (("kelvin", 1),)),
    "degF": Unit(Fraction(5, 9), Fraction("459.67") * Fraction(5, 9), (("kelvin", 1),)),
}
"""Units of temperature with a zero of their own."""
SPELLINGS = ("μ", "µ"), ("⋅", "·"), ("×", "*"), ("**", "^"), ("°C", "degC"), ("°F", "degF"), ("deg CA", "degCA")
NO_NAMES = {"rpm", "gauge", "abs"}
"""Words of a quantity that are right, and no names of units."""
SUPERSCRIPTS = str.maketrans("⁻¹²³⁴", "-1234")
TOKEN = re.compile(r"([A-Za-zµ°%]+)(?:\^?(-?[1-9])(?![0-9]))?|1(?![0-9])|[*·/()]|\s+")


PER_MINUTE = Unit(Fraction(1, 60), Fraction(0), (("second", -1),))
"""A count per minute."""


@lru_cache(maxsize=512)
def unit(text: str) -> Unit:
    """Return the unit that a text names, e.g. "mm^2", "mm²", "N s/m", "N*s/m", "W/(m^2 K)", "r/min", "degC" or "%".

    The texts "" and "-" are dimensionless. Factors side by side, or joined by ``·``, bind closer than a slash; ``*``
    does not. Raises InvalidValue where the text names no unit that numbers are multiplied with (nor degC or degF
    alone).

    >>> unit("W/(m^2 K)").si_text, float(unit("r/min").factor)
    ('K^-1 kg s^-3', 0.10471975511965977)
    """
    wrong = InvalidValue(f"{quoted(text)} is no known unit")
    if len(text) > MAX_TEXT:
        raise wrong

    # One spelling for each sign. A temperature with a zero of its own is no factor in a product, and stands alone.
    for other, plain in SPELLINGS:
        text = text.replace(other, plain)
    if text in TEMPERATURES:
        return TEMPERATURES[text]
    text = re.sub("[⁻¹²³⁴]+", lambda power: "^" + power[0].translate(SUPERSCRIPTS), text)
    text = re.sub(r"\brpm\b", "(r/min)", "" if text == "-" else text)
    if len(text) > 60 or re.search(r"(^|[*·/(])\s*[*·/)]|[*·/]\s*$", text):  # an operator lacks its factor
        raise wrong

    # Token by token: `sign` is that of the exponents in force, `outer` that of the bracket, which `*` brings back.
    factor = Fraction(1)
    dimension: dict[str, int] = {}
    brackets: list[tuple[int, int]] = []
    at, sign, outer = 0, 1, 1
    while at < len(text):
        token = TOKEN.match(text, at)
        if not token or (token[0] == ")" and not brackets):
            raise wrong
        at = token.end()
        if token[1]:
            power = sign * int(token[2] or 1)
            scale, bases = named(token[1])
            factor *= scale**power
            for base, exponent in bases:
                dimension[base] = dimension.get(base, 0) + exponent * power
        elif token[0] == "/":
            sign = -outer
        elif token[0] == "*":
            sign = outer
        elif token[0] == "(":
            brackets.append((sign, outer))
            outer = sign
        elif token[0] == ")":
            sign, outer = brackets.pop()
    if brackets:
        raise wrong

    # Base units that cancel out do not count, so that m/m is without dimension.
    return Unit(factor, Fraction(0), tuple(sorted(item for item in dimension.items() if item[1])))


def respelt(text: str) -> str:
    """Return a number with a unit whose unknown names are replaced by the nearest right ones.

    >>> respelt("0.49 Mpa gauge"), respelt("12 Nm")
    ('0.49 MPa gauge', '12 N m')
    """
    number = re.match(rf"{NUMBER}\s*", text)
    if not number:
        return text
    right = known_units().keys() | TEMPERATURES.keys() | NO_NAMES
    body = re.sub(r"[A-Za-zµ°%]+", lambda name: name[0] if name[0] in right else nearest(name[0]), text[number.end() :])
    return number[0] + body


def split_number(text: str) -> tuple[str, str] | None:
    """Split a text into its number and the name of its unit, "" without one.

    None where the text does not begin with a number, or is longer than `MAX_TEXT`.

    >>> split_number("9 mm"), split_number("9"), split_number("mm")
    (('9', 'mm'), ('9', ''), None)
    """
    found = re.fullmatch(rf"{NUMBER}\s*(.*)", text) if len(text) <= MAX_TEXT else None
    return (found[1], found[2]) if found else None


def si_value(raw: object, text: str, expected: str, reference: float = 0.0) -> float:
    """Return the SI value of a number with its unit, which has to be of the dimension of `expected` ("" for none).

    `raw` is what the user wrote, for the message, and `reference` a value in SI that the number stands above. Raises
    InvalidValue where the text is no number, its unit is not of the dimension, or it is too large.
    """
    found = split_number(text)
    if not found:
        raise InvalidValue(f"{quoted(raw)} is no finite number" + " with a unit" * bool(expected))
    number, name = found
    if expected and not name:
        raise InvalidValue(f"{quoted(raw)} has no unit")
    try:
        given = unit(name)
        if given == PER_MINUTE and unit(expected) == unit("rpm"):
            given = unit("rpm")  # what engineers write for it: min^-1 of a speed counts revolutions
        if given.dimension != unit(expected).dimension:
            raise InvalidValue(f"{quoted(name)} cannot be converted to {expected or 'a bare number'}")
    except InvalidValue as wrong:
        raise InvalidValue(f"{quoted(raw)}: {wrong.wrong}") from None
    value = given.si(number, reference)
    if math.isinf(value):
        raise InvalidValue(f"{quoted(raw)} is too large, not finite")
    return value
