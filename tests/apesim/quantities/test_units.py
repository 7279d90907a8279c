"""Units: which texts are units, what they are in SI, and which are refused."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.quantities import InvalidValue, unit


@pytest.mark.parametrize(
    ("texts", "factor"),
    [
        (
            ("mm^2", "mm²", "mm2", "mm**2", "mm mm", "mm*mm", "(mm)(mm)"),
            1e-6,
        ),
        (("N s/m", "N*s/m", "N·s/m", "N⋅s/m", "N s m^-1", "N s m⁻¹", "kg/s", "N/(m/s)"), 1.0),
        (("W/(m^2 K)", "W/m²K", "W/m² K", "W/m^2/K", "W/(m²·K)", "W m⁻² K⁻¹"), 1.0),
        (("1/s", "s^-1", "Hz", "s⁻¹"), 1.0),
        (("bar/(m/s)", "bar s/m"), 1e5),
        (("µs", "μs", "us"), 1e-6),
        (("", "-", "1", "m/m"), 1.0),
        (("%", "percent"), 0.01),
        (("kgf/cm²",), 98066.5),
        (("L", "dm^3"), 1e-3),
    ],
)
def test_spellings_of_a_unit(texts, factor):
    for text in texts:
        assert unit(text) == unit(texts[0]), text
        assert float(unit(text).factor) == factor


def test_a_star_after_a_slash_multiplies_again():
    assert unit("m/s*kg").dimension == unit("kg m/s").dimension
    assert unit("m/s kg").dimension == unit("m/(s kg)").dimension


@pytest.mark.parametrize(
    "text",
    [
        "foo",
        "9**9**9",
        "m^99",
        "m^12",
        "m//",
        "/m",
        "m/",
        "m*",
        "*m",
        "(m",
        "m)",
        "()",
        "2",
        "m2.5",
        "m^0",
        "π",
        "²",
        "dB",
        "dBm",
        "statC",
        "m;m",
        "__import__",
        "m.real",
        "degC/s",
        "J/(kg degC)",
        "m\nfoo",
        "m" * 70,
        "m " * 40,
        "(" * 30,
        "mm gauge",
        "nan",
        "per",
    ],
)
def test_no_units(text):
    with pytest.raises(InvalidValue, match="no known unit"):
        unit(text)


@given(st.text("mkgsbarPNWhindeCFK°%µ²⁻¹0123456789^*/·() -.", max_size=12))
def test_any_text_is_a_unit_or_refused(text):
    with contextlib.suppress(InvalidValue):
        assert unit(text).factor > 0


def test_the_si_unit_of_a_unit():
    assert unit("N/mm^2").si_text == "kg m^-1 s^-2"
    assert unit("r/min").si_text == "rad s^-1"
    assert unit("%").si_text == "-"
