"""Single names of units: a table of those that engines, valves and their test benches are measured in.

Factors are exact, but for pi: a degree is the float that `math.radians` multiplies by, so that radians(15) and "15 deg"
agree to the last bit.
"""

import difflib
import math
from fractions import Fraction
from functools import lru_cache

from apesim.quantities.input_errors import InvalidValue, quoted

Bases = tuple[tuple[str, int], ...]
"""Type of a dimension: pairs of base unit and exponent."""

PREFIXES = {
    "n": ("nano", -9),
    "u": ("micro", -6),
    "µ": ("micro", -6),
    "m": ("milli", -3),
    "c": ("centi", -2),
    "d": ("deci", -1),
    "h": ("hecto", 2),
    "k": ("kilo", 3),
    "M": ("mega", 6),
    "G": ("giga", 9),
}
"""Symbol of each prefix: its name, its power of ten."""

BASES = {"m": "meter", "kg": "kilogram", "s": "second", "K": "kelvin", "rad": "radian", "A": "ampere"}
FORCE, PRESSURE, ENERGY, POWER = "kg m s^-2", "kg m^-1 s^-2", "kg m^2 s^-2", "kg m^2 s^-3"

WITH_PREFIXES: dict[str, tuple[str, int | str | Fraction, str, str]] = {
    "m": ("meter metre", 1, "m", "nuµmcdk"),
    "g": ("gram", "1/1000", "kg", "uµmk"),
    "s": ("second", 1, "s", "nuµm"),
    "sec": ("", 1, "s", "nuµm"),
    "K": ("kelvin", 1, "K", "uµm"),
    "rad": ("radian", 1, "rad", "nuµm"),
    "A": ("ampere", 1, "A", "nuµmk"),
    "V": ("volt", 1, "kg m^2 s^-3 A^-1", "nuµmk"),
    "N": ("newton", 1, FORCE, "uµmcdkM"),
    "Pa": ("pascal", 1, PRESSURE, "uµmhkMG"),
    "bar": ("bar", 100_000, PRESSURE, "uµmdk"),
    "J": ("joule", 1, ENERGY, "uµmkMG"),
    "W": ("watt", 1, POWER, "nuµmkMG"),
    "Wh": ("", 3600, ENERGY, "mkMG"),
    "Hz": ("hertz", 1, "s^-1", "mkMG"),
    "L": ("l liter litre", "1/1000", "m^3", "nuµmcdhk"),
}
"""Units by their symbol: other names, factor in SI, SI units, prefixes; names in full take these in full.

A prefix that nobody measures with is a slip: Grad is German for a degree and no giga-radian, Mbar is mbar, Ms is ms.
"""

WITHOUT_PREFIXES: dict[str, tuple[str, int | str | Fraction, str]] = {
    "min": ("minute", 60, "s"),
    "h": ("hour hr", 3600, "s"),
    "d": ("day", 86400, "s"),
    "deg": ("degree ° degCA CAD °KW", Fraction(math.pi / 180.0), "rad"),
    "r": ("rev revolution turn", Fraction(2.0 * math.pi), "rad"),
    "t": ("tonne", 1000, "kg"),
    "lb": ("pound", "0.45359237", "kg"),
    "in": ("inch inches", "0.0254", "m"),
    "ft": ("foot feet", "0.3048", "m"),
    "micron": ("", "1/1000000", "m"),
    "kgf": ("", "9.80665", FORCE),
    "lbf": ("", "4.4482216152605", FORCE),
    "atm": ("atmosphere", 101_325, PRESSURE),
    "psi": ("", Fraction("4.4482216152605") / Fraction("0.0254") ** 2, PRESSURE),
    "torr": ("", Fraction(101_325, 760), PRESSURE),
    "mmHg": ("", "133.322387415", PRESSURE),
    "hp": ("horsepower", Fraction("4.4482216152605") * Fraction("0.3048") * 550, POWER),
    "percent": ("%", "1/100", ""),
    "ppm": ("", "1/1000000", ""),
}
SHORTEST_PLURAL = 4
"""Letters of a name from which on it may stand in the plural: "days" and "meters", not "ms"."""
RIGHT_FORMS = {
    "Nm": "N m",
    "Ns": "N s",
    "Nms": "N m s",
    "kgm": "kg m",
    "lpm": "L/min",
    "slpm": "L/min",
    "C": "degC",
    "F": "degF",
    "kp": "kgf",
}
RIGHT_FORMS |= {"Grad": "deg", "grad": "deg"}
"""What is often written and no unit here, or not this one: the right form."""
MIN_LIKENESS = 0.75
"""Likeness of a name to a right one, by `difflib`: "milimeter" and "barr" have it, "xyz" has not."""


@lru_cache(maxsize=1)
def known_units() -> dict[str, tuple[Fraction, Bases]]:
    """Return factor and bases of every name of a unit, prefixes and plurals among them.

    Factors to SI are those of NIST's guide [1]_; torr is 101325/760 Pa, micron a micrometre.

    Returns
    -------
    dict of str to (Fraction, tuple)
        Factor to SI, and pairs of base unit and exponent, by name.

    References
    ----------
    .. [1] A. Thompson and B. N. Taylor, "Guide for the Use of the International System of Units (SI)", NIST Special
       Publication 811, 2008, appendix B.

    Examples
    --------
    >>> known_units()["mm"]
    (Fraction(1, 1000), (('meter', 1),))
    """
    known: dict[str, tuple[Fraction, Bases]] = {}
    for symbol, (others, factor, units, prefixes) in WITH_PREFIXES.items():
        found = Fraction(factor), bases_of(units)
        for name in (symbol, *others.split()):
            for prefix in prefixes:
                full, power = PREFIXES[prefix]
                written = prefix if len(name) < 3 or name == symbol else full
                known.setdefault(written + name, (found[0] * Fraction(10) ** power, found[1]))
    for table in (WITH_PREFIXES, WITHOUT_PREFIXES):
        for symbol, (others, factor, units, *_) in table.items():
            known |= dict.fromkeys((symbol, *others.split()), (Fraction(factor), bases_of(units)))
    return {f"{name}s": found for name, found in known.items() if len(name) >= SHORTEST_PLURAL} | known


def bases_of(units: str) -> Bases:
    """Return the pairs of base unit and exponent of a text of SI units, such as "m s^-2", in its order.

    Raises KeyError where a symbol is not in `BASES`.
    """
    factors = (unit.partition("^") for unit in units.split())
    return tuple((BASES[name], int(power or 1)) for name, _, power in factors)


def named(name: str) -> tuple[Fraction, Bases]:
    """Return what a single name of a unit stands for: its factor to SI, and its pairs of base unit and exponent.

    The name is letters, "%" or "°"; raises InvalidValue where it names no unit that numbers are multiplied with.
    """
    try:
        return known_units()[name]
    except KeyError:
        raise InvalidValue(f"{quoted(name)} is no known unit") from None


def nearest(name: str) -> str:
    """Return the right name that is nearest to an unknown one; the unknown one itself where none is near.

    >>> nearest("Mpa"), nearest("milimeter"), nearest("Nm"), nearest("xyz")
    ('MPa', 'millimeter', 'N m', 'xyz')
    """
    if name in RIGHT_FORMS:
        return RIGHT_FORMS[name]
    right = (*known_units(), "rpm", "degC", "degF")
    alike = [known for known in right if known.lower() == name.lower()]
    alike.sort(key=lambda known: -sum(map(str.__eq__, known, name)))
    return (alike or difflib.get_close_matches(name, right, n=1, cutoff=MIN_LIKENESS) or [name])[0]
