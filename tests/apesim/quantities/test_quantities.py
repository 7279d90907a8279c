"""Quantities: what is read, what is refused and with which remedy, and that printing loses nothing."""

import contextlib
import math
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from apesim.quantities import (
    NO_CURVE,
    Choice,
    Curve,
    Fault,
    InputError,
    InvalidValue,
    Pressure,
    Quantity,
    parse,
    parse_range,
    split_header,
    unit,
)
from apesim.quantities.files import MAX_BYTES

STROKE = Quantity("mm", 1, 50, "Table 1")
SPEED = Quantity("rpm", 0, 3000, "chosen")
ANGLE = Quantity("deg", -180, 180, "chosen")
RATIO = Quantity("", 1, 50, "Table 1")
PORTS = Quantity("", 1, 100, "here", whole=True)
VOLUME = Quantity("L", 0, math.inf, "chosen")
TEMPERATURE = Quantity("K", 200, 350, "20 °C")
SUPPLY = Pressure(0.02, 30, "chosen")
GAUGE = Pressure(0.02, 30, "chosen", show="gauge")
OPTIONAL = Quantity("mm", 1, 50, "chosen", text="the stroke's", optional=True)
INTAKE = Choice(("epv", "cam", "ideal"), "chosen")
CURVE = Curve(("time [ms]", "opening [-]"), "a discharge test")
AMBIENT = 101325.0


def faults_of(function, *arguments, **named):
    with pytest.raises(InputError) as caught:
        function(*arguments, **named)
    assert len(str(caught.value).splitlines()) == len(caught.value.faults)
    return caught.value.faults


@pytest.mark.parametrize(
    ("text", "declaration", "value"),
    [
        ("9 mm", STROKE, 9e-3),
        ("9mm", STROKE, 9e-3),
        (" +.9e1  mm ", STROKE, 9e-3),
        ("0.9 cm", STROKE, 9e-3),
        ("1 mm", STROKE, 1e-3),
        ("50 mm", STROKE, 50e-3),
        ("15 deg", ANGLE, math.radians(15)),
        ("-5°", ANGLE, math.radians(-5)),
        ("18", RATIO, 18.0),
        (18, RATIO, 18.0),
        (18.5, RATIO, 18.5),
        ("1800 %", RATIO, 18.0),
        ("inf", VOLUME, math.inf),
        ("5 l", VOLUME, 5e-3),
        ("20 degC", TEMPERATURE, 293.15),
        ("20 °C", TEMPERATURE, 293.15),
        ("68 degF", TEMPERATURE, 293.15),
        ("0.59 MPa abs", SUPPLY, 0.59e6),
        ("590kPa abs", SUPPLY, 0.59e6),
        ("0.49 MPa gauge", SUPPLY, 591325.0),
        ("-20 kPa gauge", SUPPLY, 81325.0),
        ("cam", INTAKE, 1),
    ],
)
def test_reads(text, declaration, value):
    read = parse(text, declaration, AMBIENT)
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize("other", ["1000 r/min", "1000 rev/min", "6000 deg/s", "1000 min^-1 rev"])
def test_spellings_of_a_speed_agree(other):
    assert parse(other, SPEED) == pytest.approx(1000 * 2 * math.pi / 60, rel=1e-15)
    assert parse("1000 rpm", SPEED) == parse("1000 r/min", SPEED)


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


def test_hertz_is_no_angular_speed():
    assert faults_of(parse, "20 Hz", SPEED)[0].right == 'write e.g. "3000 rpm"'


@pytest.mark.parametrize(
    ("text", "declaration", "wrong", "right"),
    [
        (90, STROKE, "90 has no unit", 'write e.g. "50 mm"'),
        (90.0, STROKE, "90.0 has no unit", 'write e.g. "50 mm"'),
        ("90", STROKE, "'90' has no unit", 'write e.g. "50 mm"'),
        (True, STROKE, "True is no quantity", 'write e.g. "50 mm"'),
        (True, RATIO, "True is no number", "write e.g. 50"),
        ([9, "mm"], STROKE, "[9, 'mm'] is no quantity", 'write e.g. "50 mm"'),
        ({}, RATIO, "{} is no number", "write e.g. 50"),
        (None, RATIO, "None is no number", "write e.g. 50"),
        ("", STROKE, "'' is no finite number with a unit", '"50 mm"'),
        ("mm", STROKE, "'mm' is no finite number with a unit", '"50 mm"'),
        ("nan mm", STROKE, "no finite number", '"50 mm"'),
        ("nan", RATIO, "no finite number", "write e.g. 50"),
        (math.nan, RATIO, "nan is no finite number", "write e.g. 50"),
        (math.inf, RATIO, "inf is no finite number", "write e.g. 50"),
        (10**70, RATIO, "is out of range", "allowed: 1 to 50"),
        pytest.param(16**9999, RATIO, "a huge number", "write e.g. 50", id="huge"),
        ("inf", STROKE, "no finite number", '"50 mm"'),
        ("-inf", VOLUME, "no finite number", '"0 L"'),
        ("inf L", VOLUME, "no finite number", '"0 L"'),
        ("1e400 mm", STROKE, "too large", '"50 mm"'),
        ("1e999999999 mm", STROKE, "'1e999999999 mm': '999999 mm' is no known unit", '"50 mm"'),
        ("1e400", RATIO, "too large", "write e.g. 50"),
        ("9**9**9 mm", STROKE, "no known unit", '"50 mm"'),
        ("0x9 mm", STROKE, "no known unit", '"50 mm"'),
        ("1_0 mm", STROKE, "no known unit", '"50 mm"'),
        ("٩ mm", STROKE, "no finite number", '"50 mm"'),
        ("9,5 mm", STROKE, "no known unit", 'write "9.5 mm"'),
        ("95,5 mm", STROKE, "out of range", "allowed: 1 to 50 mm"),
        ("18,5", RATIO, "',5' is no known unit", "write 18.5"),
        ("0,49 MPa", SUPPLY, "says neither", 'write "0.49 MPa gauge" or "0.49 MPa abs"'),
        ("0,49 MPa gauge", SUPPLY, "no known unit", 'write "0.49 MPa gauge"'),
        ("4.9 barg", SUPPLY, "'barg' is no known unit", 'write "4.9 bar gauge"'),
        ("5,9bara", SUPPLY, "no known unit", 'write "5.9bar abs"'),
        ("490 kPa(g)", SUPPLY, "cannot be converted to MPa", 'write "490 kPa gauge"'),
        ("85 psi a", SUPPLY, "'a' is no known unit", 'write "85 psi abs"'),
        ("20 C", TEMPERATURE, "'C' is no known unit", 'write "20 degC"'),
        ("68F", TEMPERATURE, "'F' is no known unit", 'write "68 degF"'),
        ("20 C", STROKE, "'C' is no known unit", 'write e.g. "50 mm"'),
        ("fast", Quantity("rpm", 1, 30000, "here", typical="1000 rpm"), "no finite number", 'write e.g. "1000 rpm"'),
        ("9" * 101 + " mm", STROKE, "no finite number", '"50 mm"'),
        ("9 kg", STROKE, "'kg' cannot be converted to mm", '"50 mm"'),
        ("9 mm abs", STROKE, "no known unit", '"50 mm"'),
        ("18 mm", RATIO, "'mm' cannot be converted to a bare number", "write e.g. 50"),
        ("0.9 mm", STROKE, "'0.9 mm' is out of range", "allowed: 1 to 50 mm"),
        ("50.000000000000001 cm", STROKE, "out of range", "allowed: 1 to 50 mm"),
        ("-1 L", VOLUME, "out of range", "allowed: at least 0 L"),
        ("0.49 MPa", SUPPLY, "says neither", 'write "0.49 MPa gauge" or "0.49 MPa abs"'),
        ("0.49", SUPPLY, "has no unit", 'write "0.49 MPa gauge" or "0.49 MPa abs"'),
        (0.49, SUPPLY, "has no unit", 'write "0.49 MPa gauge" or "0.49 MPa abs"'),
        ("49", SUPPLY, "has no unit", 'write e.g. "30 MPa abs"'),
        ("9", STROKE, "'9' has no unit", 'write e.g. "9 mm"'),
        (9.0, STROKE, "9.0 has no unit", 'write e.g. "9 mm"'),
        ("1000:2000:100 rpm", SPEED, "is more than one value", 'write one, e.g. "1000 rpm"'),
        ("9 mm, 10 mm", STROKE, "is more than one value", 'write one, e.g. "9 mm"'),
        ("99 mm, 10 mm", STROKE, "no known unit", '"50 mm"'),
        (2.5, PORTS, "2.5 is no whole number", "write 2 or 3"),
        ("2.5", PORTS, "'2.5' is no whole number", "write 2 or 3"),
        (2000, PORTS, "out of range", "allowed: 1 to 100, whole"),
        ("0.49 abs", SUPPLY, "has no unit", 'write e.g. "30 MPa abs"'),
        ("0.49 mm", SUPPLY, "cannot be converted to MPa", 'write e.g. "30 MPa abs"'),
        ("30 MPa gauge", SUPPLY, "out of range", "allowed: 0.02 to 30 MPa abs"),
        ("CAM", INTAKE, "'CAM' is no option", 'write "epv", "cam" or "ideal"'),
        (1, INTAKE, "1 is no option", 'write "epv", "cam" or "ideal"'),
        (True, INTAKE, "True is no option", '"ideal"'),
        (["cam"], INTAKE, "is no option", '"ideal"'),
    ],
)
def test_refuses_with_the_remedy(text, declaration, wrong, right):
    (fault,) = faults_of(parse, text, declaration, AMBIENT, where="--key", file="m.toml")
    assert len(str(fault)) < 200
    assert (fault.file, fault.key) == ("m.toml", "--key")
    assert wrong in fault.wrong
    assert right in fault.right


def test_every_right_form_is_right():
    for declaration in (STROKE, SPEED, ANGLE, RATIO, VOLUME, TEMPERATURE, SUPPLY, GAUGE):
        (fault,) = faults_of(parse, "x", declaration, AMBIENT)
        parse(fault.right.removeprefix("write e.g. ").strip('"'), declaration, AMBIENT)


def test_gauge_needs_an_ambient_pressure():
    assert "no ambient pressure" in faults_of(parse, "0.49 MPa gauge", SUPPLY)[0].wrong


def test_optional():
    assert math.isnan(parse("", OPTIONAL))
    assert OPTIONAL.render(math.nan) == ""
    assert parse("5 mm", OPTIONAL) == 5e-3


def test_a_culprit_is_one_line():
    fault = Fault("a\nb.toml", "x\r\ny", "'\x1b[31m'", "\udc80 ok\u2028")
    assert str(fault) == "a\\nb.toml: x\\r\\ny: '\\x1b[31m'; \\udc80 ok\\u2028"
    assert str(Fault("", "", "wrong", "right")) == "wrong; right"
    faults_of(parse, "9\nmm\n" * 100, STROKE)
    faults_of(parse, "9 MPa\x0bgauge", SUPPLY)


# ---- printing


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


# ---- ranges


@pytest.mark.parametrize(
    ("text", "declaration", "texts"),
    [
        ("300:600:100 rpm", SPEED, ["300 rpm", "400 rpm", "500 rpm", "600 rpm"]),
        ("600 : 300 : -150rpm", SPEED, ["600 rpm", "450 rpm", "300 rpm"]),
        ("300:650:200 rpm", SPEED, ["300 rpm", "500 rpm"]),
        ("300:300:1 rpm", SPEED, ["300 rpm"]),
        (
            "0:1:0.3333333333333333 deg",
            ANGLE,
            ["0 deg", "0.3333333333333333 deg", "0.6666666666666666 deg", "1 deg"],
        ),
        ("0:1:0.33333333334 deg", ANGLE, ["0 deg", "0.33333333334 deg", "0.66666666668 deg", "1 deg"]),
        ("0.4:1.0:0.2 MPa gauge", SUPPLY, [f"{x} MPa gauge" for x in ("0.4", "0.6", "0.8", "1.0")]),
        ("0:20:10 degC", TEMPERATURE, ["273.15 K", "283.15 K", "293.15 K"]),
        ("1:2:.5", RATIO, ["1", "1.5", "2"]),
        ("500 rpm, 600 rpm", SPEED, ["500 rpm", "600 rpm"]),
        ("500 rpm", SPEED, ["500 rpm"]),
        (["500 rpm", "600 rpm"], SPEED, ["500 rpm", "600 rpm"]),
        ("epv,cam, ideal", INTAKE, ["epv", "cam", "ideal"]),
        ([1, 2], RATIO, ["1", "2"]),
    ],
)
def test_ranges(text, declaration, texts):
    got = parse_range(text, declaration, AMBIENT)
    assert got == pytest.approx([parse(item, declaration, AMBIENT) for item in texts], rel=1e-15)
    assert len(got) == len(texts)


def test_a_stop_is_met_exactly_despite_rounding():
    assert parse_range("0.1:0.9:0.1 deg", ANGLE)[-1] == parse("0.9 deg", ANGLE)
    assert parse_range("0:1:0.33333333334 deg", ANGLE)[-1] == parse("1 deg", ANGLE)
    assert parse_range("0:50:0.1", Quantity("", 0, 50, ""))[-1] == 50.0


@pytest.mark.parametrize(
    ("text", "declaration", "wrong", "right"),
    [
        ("300:600:0 rpm", SPEED, "the step is 0", "from start to stop"),
        ("300:600:0.0 rpm", SPEED, "the step is 0", "from start to stop"),
        ("300,5 rpm", SPEED, "a comma between digits", 'write "300.5 rpm", or give each value its unit'),
        ("0,4 MPa gauge, 0,5 MPa gauge", SUPPLY, "a comma between digits", '"0.4 MPa gauge, 0.5 MPa gauge"'),
        ("0,4:1:0,2 MPa gauge", SUPPLY, "a comma between digits", '"0.4:1:0.2 MPa gauge"'),
        ("600:300:100 rpm", SPEED, "steps of 100 do not lead to 300", "sign"),
        ("300:600:-100 rpm", SPEED, "do not lead", "sign"),
        ("300:3000:100", SPEED, "has no unit", '"300:3000:100 rpm"'),
        ("0.4:1:0.2 MPa", SUPPLY, "says neither", '"0.4 MPa gauge" or "0.4 MPa abs"'),
        ("0.4:1:0.2", SUPPLY, "has no unit", '"0.4:1:0.2 MPa abs"'),
        ("300:600 rpm", SPEED, "no range", "start:stop:step rpm"),
        ("300:600:100:2 rpm", SPEED, "is no known unit", '"3000 rpm"'),
        ("300 rpm:600 rpm:100 rpm", SPEED, "no range", "start:stop:step rpm"),
        ("0:1:1e-9 rpm", SPEED, "more than 100000 points", "larger step"),
        ("0:1:1e-999 rpm", SPEED, "more than 100000 points", "larger step"),
        ("300:9000:100 rpm", SPEED, "out of range", "allowed: 0 to 3000 rpm"),
        ("300:600:100 mm", SPEED, "cannot be converted", '"3000 rpm"'),
        ("500 rpm,", SPEED, "'' is no finite number", '"3000 rpm"'),
        ("", SPEED, "'' is no finite number", '"3000 rpm"'),
        ([], SPEED, "no list", '"3000 rpm"'),
        (500, SPEED, "no list", '"3000 rpm"'),
        ([500], SPEED, "500 has no unit", '"500 rpm"'),
        ("1:2:1", INTAKE, "no option", '"epv"'),
    ],
)
def test_no_ranges(text, declaration, wrong, right):
    (fault,) = faults_of(parse_range, text, declaration, AMBIENT, where="--speed")
    assert fault.key == "--speed"
    assert wrong in fault.wrong
    assert right in fault.right


def test_every_wrong_item_of_a_list_is_told():
    faults = faults_of(parse_range, "500, 600 rpm, 700 mm", SPEED, where="--speed")
    assert [c.wrong.split("'")[1] for c in faults] == ["500", " 700 mm"]


# ---- curves


def test_split_header():
    assert split_header(" lift  [mm] ") == ("lift", "mm")
    assert split_header("pressure_a [kPa abs]") == ("pressure_a", "kPa abs")
    assert split_header("lift") == ("lift", None)


def read_csv(folder, text, curve=CURVE):
    (folder / "curve.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return curve.read("curve.csv", folder=folder)


@pytest.mark.parametrize(
    "text",
    [
        "time [ms],opening [-]\n0,0\n1.5,1\n",
        "\ufefftime [s], opening [%]\r\n0,0\r\n\r\n0.0015,1e2\r\n",
        "run,opening [-],time [us]\na,0,0\nb,1.0,1500",
    ],
)
def test_curve_of_a_file(tmp_path, text):
    array = read_csv(tmp_path, text)
    assert array.tolist() == [[0.0, 0.0], [0.0015, 1.0]]
    assert array.dtype == np.float64
    assert array.flags.c_contiguous


def test_curve_of_a_table_and_none():
    assert CURVE.read({"opening [%]": [0, 50.0], "time [ms]": [0, 1.5]}).tolist() == [
        [0.0, 0.0],
        [0.0015, 0.5],
    ]
    assert CURVE.read("") is NO_CURVE
    assert CURVE.render(NO_CURVE) == ""


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=5, unique=True))
def test_a_printed_curve_reads_back_as_itself(values):
    array = np.column_stack([np.sort(np.array(values)), values])
    assert np.array_equal(CURVE.read(CURVE.render(array)), array)


@pytest.mark.parametrize(
    ("text", "wrong", "right"),
    [
        ("", "no CSV", "time [ms],opening [-]"),
        ("time [ms],opening [-]\n", "no CSV", "time [ms],opening [-]"),
        ("time [ms],opening [-]\n0,0\n1\n", "no CSV", "time [ms],opening [-]"),
        ('time [ms],opening [-]\n0,0\n"1,1\n', "no CSV", "time [ms],opening [-]"),
        ("time [ms],time [ms],opening [-]\n0,0,0\n1,1,1\n", "no CSV", "time [ms],opening [-]"),
        ("time [ms],time [s],opening [-]\n0,0,0\n1,1,1\n", "2 columns 'time'", "time [ms],opening [-]"),
        ("time [ms],area [-]\n0,0\n1,1\n", "no columns 'opening'", "time [ms],opening [-]"),
        ("time,opening [-]\n0,0\n1,1\n", "'time' has no unit", "time [ms],opening [-]"),
        ("time [foo],opening [-]\n0,0\n1,1\n", "'foo' is no known unit", "time [ms],opening [-]"),
        ("time [mm],opening [-]\n0,0\n1,1\n", "'mm' is no unit of 'time'", "time [ms],opening [-]"),
        ("time [ms],opening [-]\n0,0\n", "1 and 1 numbers", "2 to 100000"),
        ("time [ms],opening [-]\n0,0\n2,1\n2,1\n", "does not rise in row 3", "sort"),
        ("time [ms],opening [-]\n1,0\n0,1\n", "does not rise in row 2", "sort"),
        ("time [ms],opening [-]\n0,0\n1,nan\n", "'nan' in row 2", "numbers"),
        ("time [ms],opening [-]\n0,0\n1,\n", "'' in row 2", "numbers"),
        ("time [ms],opening [-]\n0,0\ninf,1\n", "'inf' in row 2", "numbers"),
        ("time [ms],opening [-]\n0,0\n1,1e400\n", "'1e400' in row 2", "numbers"),
        (b"time [ms],opening [-]\n0,0\n\xff,1\n", "no text in line 3", "UTF-8"),
        (b"x" * (MAX_BYTES + 1), "larger than 10 MB", "keep fewer rows"),
    ],
)
def test_no_curves(tmp_path, text, wrong, right):
    with pytest.raises(InvalidValue) as caught:
        read_csv(tmp_path, text)
    assert wrong in caught.value.wrong
    assert right in caught.value.right


@pytest.mark.parametrize(
    ("raw", "wrong"),
    [
        (3, "3 is no curve"),
        (True, "True is no curve"),
        ([[0, 0], [1, 1]], "is no curve"),
        ({"time [ms]": 3, "opening [-]": [0, 1]}, "is no curve"),
        ({"time [ms]": [0, 1]}, "1 columns, not 2"),
        ({"time [ms]": [0, 1], "opening [-]": [0, 1], "x [m]": [0, 1]}, "3 columns, not 2"),
        ({"time [ms]": [0, 1], "opening [-]": [0]}, "2 and 1 numbers"),
        ({"time [ms]": [0, 1], "opening [-]": [0, True]}, "True in row 2"),
        ({"time [ms]": [0, 1], "opening [-]": [0, math.nan]}, "nan in row 2"),
        ({"time [ms]": [0, 1], "opening [-]": [0, [1]]}, "[1] in row 2"),
        ("absent.csv", "there is no file"),
        ("/dev/zero", "there is no file '/dev/zero'"),
        ("nul\0", "there is no file"),
    ],
)
def test_no_tables(raw, wrong):
    with pytest.raises(InvalidValue) as caught:
        CURVE.read(raw)
    assert wrong in caught.value.wrong
    assert caught.value.right


def test_importing_is_light():
    code = "import apesim.quantities, sys; print({'pint', 'pydantic', 'scipy', 'tomlkit'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_importing_settings_is_light():
    code = "import apesim.quantities.settings, sys; print({'pint', 'pydantic', 'scipy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_every_typical_value_of_a_command_or_a_sensor_is_a_right_one():
    import apesim.studies.operating_conditions as conditions
    from apesim.studies.measured.sensors import LIFT, SENSORS

    shown = [value for value in vars(conditions).values() if isinstance(value, Quantity)]
    shown += [LIFT, *SENSORS["valve"].keys.values(), *SENSORS["engine"].means.values()]
    shown = [declaration for declaration in shown if getattr(declaration, "typical", "")]
    assert len(shown) > 5
    for declaration in shown:
        assert parse(declaration.typical, declaration, AMBIENT) > 0.0
