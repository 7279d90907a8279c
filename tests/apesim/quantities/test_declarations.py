"""Declared quantities: printing loses nothing."""

import math
from fractions import Fraction

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from apesim.quantities import Pressure, Quantity, parse
from tests.apesim.quantities.samples import AMBIENT, ANGLE, GAUGE, INTAKE, RATIO, STROKE, SUPPLY, TEMPERATURE, VOLUME


@pytest.mark.parametrize(
    ("value", "declaration", "text"),
    [
        (9e-3, STROKE, "9 mm"),
        (90.0, STROKE, "90000 mm"),
        (9.0e-6, Quantity("mm^2", 0, 1, ""), "9 mm^2"),
        (0.72e5, Quantity("bar", 0, 1, ""), "0.72 bar"),
        (math.radians(15), ANGLE, "15 deg"),
        (-0.0, ANGLE, "0 deg"),
        (18.0, RATIO, "18"),
        (1e-30, RATIO, "1e-30"),
        (math.inf, VOLUME, "inf"),
        (293.15, TEMPERATURE, "293.15 K"),
        (293.15, Quantity("degC", 0, 100, ""), "20 degC"),
        (1.101325e6, SUPPLY, "1.101325 MPa abs"),
        (1.101325e6, GAUGE, "1 MPa gauge"),
        (math.inf, Pressure(0, math.inf, ""), "inf"),
        (2, INTAKE, "ideal"),
    ],
)
def test_prints(value, declaration, text):
    assert declaration.render(value, AMBIENT) == text
    assert parse(text, declaration_without_range(declaration), AMBIENT) == value


def declaration_without_range(declaration):
    if isinstance(declaration, Pressure):
        return Pressure(-math.inf, math.inf, "", declaration.unit, declaration.show)
    if isinstance(declaration, Quantity):
        return Quantity(declaration.unit, -math.inf, math.inf, "")
    return declaration


UNITS = [
    "",
    "mm",
    "mm^2",
    "L",
    "deg",
    "rpm",
    "degC",
    "degF",
    "psi",
    "%",
    "kg",
    "ms",
    "J/(kg K)",
    "kN s/m",
    "bar",
]


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(UNITS))
def test_every_float_has_a_text(value, name):
    assume(abs(value) > 1e-9 or not name.startswith("deg"))
    declaration = Quantity(name, -math.inf, math.inf, "")
    text = declaration.render(value)
    assert parse(text, declaration) == value


@given(
    st.floats(-1e9, 1e9),
    st.floats(1e4, 1e6),
    st.sampled_from(["Pa", "MPa", "psi"]),
    st.sampled_from(["abs", "gauge"]),
)
def test_every_pressure_has_a_text(value, ambient, name, show):
    assume(abs(value) > 1e-9)
    declaration = Pressure(-math.inf, math.inf, "", name, show)
    text = declaration.render(value, ambient)
    assert text.endswith(show)
    assert parse(text, declaration, ambient) == value


@given(st.decimals(-1000, 1000, places=4), st.sampled_from(["mm", "mm^2", "bar", "ms", "L"]))
def test_a_text_is_the_literal_in_code(number, name):
    exponent = {"mm": -3, "mm^2": -6, "bar": 5, "ms": -3, "L": -3}[name]
    value = parse(f"{number} {name}", Quantity(name, -math.inf, math.inf, ""))
    assert value == float(f"{number}e{exponent}")
    shown = Quantity(name, -math.inf, math.inf, "").render(value)
    assert Fraction(shown.split()[0]) == Fraction(number)
