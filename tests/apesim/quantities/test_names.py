"""Names of units, against pint, which knows hundreds."""

import math
from decimal import Decimal
from fractions import Fraction

import pint
import pytest

from apesim.quantities import InvalidValue, Quantity, parse, unit
from apesim.quantities.names import WITH_PREFIXES, WITHOUT_PREFIXES, known_units, named, nearest

STROKE, SPEED = Quantity("mm", 1, 500, "a test"), Quantity("rpm", 1, 5000, "a test")
TORQUE = Quantity("N m", 0, 100, "a test")
OURS = {"r": "revolution", "rev": "revolution", "°": "degree", "%": "percent"}
OURS |= dict.fromkeys(("degCA", "CAD", "°KW"), "degree")
"""Names that pint knows not, or otherwise: to it r is no unit."""
USUAL = """
nm um µm mm cm dm km; ug µg mg kg; ns us µs ms; nsec usec µsec msec; uK µK mK; nrad urad µrad mrad; nA uA µA mA kA;
nV uV µV mV kV; uN µN mN cN dN kN MN; uPa µPa mPa hPa kPa MPa GPa; ubar µbar mbar dbar kbar; uJ µJ mJ kJ MJ GJ;
nW uW µW mW kW MW GW; mWh kWh MWh GWh; mHz kHz MHz GHz; nL uL µL mL cL dL hL kL
"""
"""Symbols with the prefixes that engines and benches are measured with."""


def test_every_unit_is_that_of_pint():
    registry = pint.UnitRegistry(non_int_type=Decimal)
    names = ["mm", "kPa", "MPa", "mbar", "hPa", "us", "µs", "kWh", "mL", "dm", "kN", "mrad", "millimeter", "kilopascal"]
    for table in (WITH_PREFIXES, WITHOUT_PREFIXES):
        names += [*table, *(other for others, *_ in table.values() for other in others.split())]
    assert len(names) > 60
    for name in names:
        theirs = registry.Quantity(Decimal(1), OURS.get(name, name)).to_base_units()
        factor, bases = named(name)
        assert float(factor) == float(theirs.magnitude), name
        assert dict(bases) == {str(base): int(power) for base, power in theirs.unit_items()}, name


def test_angles_are_those_of_math_to_the_last_bit():
    assert named("deg") == (Fraction(math.radians(1.0)), (("radian", 1),))
    assert named("r") == (Fraction(2.0 * math.pi), (("radian", 1),))


def test_no_symbol_has_a_prefix_that_nobody_measures_with():
    usual = set(USUAL.replace(";", " ").split())
    bare = {"m", "g", "s", "sec", "K", "rad", "A", "V", "N", "Pa", "bar", "J", "W", "Wh", "Hz", "L", "hl"}
    prefixed = {prefix + symbol for prefix in "nuµmcdhkMGTP" for symbol in bare} - {"min", "cd", "h", "d"}
    assert prefixed & known_units().keys() == usual


@pytest.mark.parametrize(
    ("name", "right"),
    [
        ("Grad", "deg"),
        ("grad", "deg"),
        ("Mrad", "mrad"),
        ("krad", "rad"),
        ("Mbar", "mbar"),
        ("Mm", "mm"),
        ("Mg", "mg"),
        ("Ms", "ms"),
        ("ML", "mL"),
        ("MV", "mV"),
        ("megaradian", "radian"),
        ("PSI", "psi"),
        ("Torr", "torr"),
        ("pa", "Pa"),
    ],
)
def test_a_prefix_too_large_is_refused_with_the_nearest_right_name(name, right):
    with pytest.raises(InvalidValue, match="no known unit"):
        named(name)
    assert nearest(name) == right


@pytest.mark.parametrize(
    ("name", "same"),
    [("°CA", "deg"), ("deg CA", "deg"), ("CAD", "deg"), ("°KW", "deg"), ("usec", "us"), ("msec", "ms")],
)
def test_other_names_of_a_unit_are_read(name, same):
    assert unit(name) == unit(same)


def test_names_of_one_unit_do_not_hide_each_other():
    for name, factor in (("min", 60), ("ft", Fraction("0.3048")), ("h", 3600), ("d", 86400), ("Pa", 1), ("hp", None)):
        assert factor is None or named(name)[0] == factor
    assert named("mmHg")[1] == named("Pa")[1]


@pytest.mark.parametrize("name", ["PS", "cfm", "Nm", "R", "at", "foo", "mmm", "kmin", "barg", "degC", ""])
def test_what_is_no_unit_here_is_refused(name):
    with pytest.raises(InvalidValue, match="no known unit"):
        named(name)


@pytest.mark.parametrize(
    ("name", "right"),
    [
        ("Mpa", "MPa"),
        ("KPA", "kPa"),
        ("Bar", "bar"),
        ("RPM", "rpm"),
        ("milimeter", "millimeter"),
        ("Nm", "N m"),
        ("lpm", "L/min"),
        ("xyz", "xyz"),
    ],
)
def test_the_nearest_right_name(name, right):
    assert nearest(name) == right and name not in known_units()


@pytest.mark.parametrize(
    ("text", "declaration", "right"),
    [
        ("9 milimeter", STROKE, 'write "9 millimeter"'),
        ("1000 RPM", SPEED, 'write "1000 rpm"'),
        ("12 Nm", TORQUE, 'write "12 N m"'),
    ],
)
def test_an_unknown_unit_is_refused_with_the_nearest_right_one(text, declaration, right):
    with pytest.raises(InvalidValue) as caught:
        declaration.read(text)
    assert caught.value.right == right
    assert parse(right.removeprefix("write ").strip('"'), declaration) > 0.0


def test_all_known_names_are_units():
    for name in known_units():
        assert unit(name).factor > 0
