"""Units: what a text names, and exact conversion to SI and back."""

import math
import re
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from apesim.quantities.culprits import Wrong, quoted
from apesim.quantities.names import BASES, known_units, named, nearest

NUMBER = r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)"
"""The grammar of a number, one group."""


class Unit(NamedTuple):
    """A unit of measurement: ``SI value = number * factor + offset``, both exact."""

    factor: Fraction
    offset: Fraction
    dimension: tuple
    """Pairs of base unit and exponent. The radian counts, so that Hz and rad/s are not confused."""

    def si(self, number, reference=0.0):
        """The SI value of a number (text or rational) of this unit above a reference [SI], rounded once."""
        try:
            return float(Fraction(number) * self.factor + self.offset + Fraction(reference))
        except OverflowError:
            return math.inf

    def shortest(self, value, reference=0.0):
        """The shortest decimal number whose `si` is `value`."""
        exact = (Fraction(value) - Fraction(reference) - self.offset) / self.factor
        for digits in range(1, 40):  # 17 do, but for a tiny value that a reference or offset hides
            with localcontext(prec=digits):
                number = (Decimal(exact.numerator) / Decimal(exact.denominator)).normalize()
            if self.si(number, reference) == value:
                break
        return f"{number:f}" if -6 < number.adjusted() < 16 else f"{number:e}"

    @property
    def si_text(self):
        """The SI unit of the same dimension, e.g. "m s^-1"; "-" without dimension."""
        short = {name: symbol for symbol, name in BASES.items()}
        powers = [(short[name], f"^{power}" * (power != 1)) for name, power in self.dimension]
        return " ".join(map("".join, powers)) or "-"


TEMPERATURES = {
    "degC": Unit(Fraction(1), Fraction("273.15"), (("kelvin", 1),)),
    "degF": Unit(Fraction(5, 9), Fraction("459.67") * Fraction(5, 9), (("kelvin", 1),)),
}
SPELLINGS = ("μ", "µ"), ("⋅", "·"), ("×", "*"), ("**", "^"), ("°C", "degC"), ("°F", "degF")
NO_NAMES = {"rpm", "gauge", "abs"}
"""Words of a quantity that are right, and no names of units."""
SUPERSCRIPTS = str.maketrans("⁻¹²³⁴", "-1234")
TOKEN = re.compile(r"([A-Za-zµ°%]+)(?:\^?(-?[1-9])(?![0-9]))?|1(?![0-9])|[*·/()]|\s+")


@lru_cache(maxsize=512)
def unit(text):
    """The unit that a text names.

    Parameters
    ----------
    text : str
        E.g. "mm^2", "mm²", "N s/m", "N*s/m", "W/(m^2 K)", "W/m² K", "r/min", "1/s", "degC", "%"; "" or "-" is
        dimensionless. Factors side by side, or joined by ``·``, bind closer than a slash; ``*`` does not.

    Returns
    -------
    Unit

    Raises
    ------
    Wrong
        The text names no unit that numbers are multiplied with (nor degC or degF alone).
    """
    wrong = Wrong(f"{quoted(text)} is no known unit")
    for other, plain in SPELLINGS:
        text = text.replace(other, plain)
    if text in TEMPERATURES:
        return TEMPERATURES[text]
    text = re.sub("[⁻¹²³⁴]+", lambda power: "^" + power[0].translate(SUPERSCRIPTS), text)
    text = re.sub(r"\brpm\b", "(r/min)", "" if text == "-" else text)
    if len(text) > 60 or re.search(r"(^|[*·/(])\s*[*·/)]|[*·/]\s*$", text):  # an operator lacks its factor
        raise wrong
    factor, dimension = Fraction(1), {}
    at, sign, outer, brackets = 0, 1, 1, []
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
    return Unit(factor, Fraction(0), tuple(sorted(item for item in dimension.items() if item[1])))


def respelt(text):
    """A number with a unit whose unknown names are replaced by the nearest right ones.

    Parameters
    ----------
    text : str

    Returns
    -------
    str

    Examples
    --------
    >>> respelt("0.49 Mpa gauge"), respelt("12 Nm")
    ('0.49 MPa gauge', '12 N m')
    """
    number = re.match(rf"{NUMBER}\s*", text)
    if not number:
        return text
    right = known_units().keys() | TEMPERATURES.keys() | NO_NAMES
    body = re.sub(r"[A-Za-zµ°%]+", lambda name: name[0] if name[0] in right else nearest(name[0]), text[number.end() :])
    return number[0] + body


def si_value(raw, text, expected, reference=0.0):
    """The SI value of a text in any unit of the dimension of `expected`; `raw` is what the user wrote."""
    found = re.fullmatch(rf"{NUMBER}\s*(.*)", text) if len(text) <= 100 else None
    if not found:
        raise Wrong(f"{quoted(raw)} is no finite number" + " with a unit" * bool(expected))
    number, name = found.groups()
    if expected and not name:
        raise Wrong(f"{quoted(raw)} has no unit")
    try:
        given = unit(name)
        if given.dimension != unit(expected).dimension:
            raise Wrong(f"{quoted(name)} cannot be converted to {expected or 'a bare number'}")
    except Wrong as wrong:
        raise Wrong(f"{quoted(raw)}: {wrong.wrong}") from None
    value = given.si(number, reference)
    if math.isinf(value):
        raise Wrong(f"{quoted(raw)} is too large, not finite")
    return value
