"""Single values, ranges and lists: what is read, and what is refused with which remedy."""

import math

import pytest

from apesim.quantities import Quantity, parse, parse_range
from tests.apesim.quantities.samples import (
    AMBIENT,
    ANGLE,
    GAUGE,
    INTAKE,
    OPTIONAL,
    PORTS,
    RATIO,
    SPEED,
    STROKE,
    SUPPLY,
    TEMPERATURE,
    VOLUME,
    faults_of,
)


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


PER_MINUTE = "1000 1/min", "1000 min^-1", "1000 min-1", "1000 min⁻¹", "1000min^-1"


@pytest.mark.parametrize("other", ["1000 r/min", "1000 rev/min", "6000 deg/s", "1000 min^-1 rev", *PER_MINUTE])
def test_spellings_of_a_speed_agree(other):
    assert parse(other, SPEED) == pytest.approx(1000 * 2 * math.pi / 60, rel=1e-15)
    assert parse("1000 rpm", SPEED) == parse("1000 r/min", SPEED)


def test_hertz_is_no_angular_speed():
    for text in ("20 Hz", "20 1/s", "1200 1/h"):
        assert faults_of(parse, text, SPEED)[0].right == 'write e.g. "3000 rpm"'


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
        ("9, 10 mm", STROKE, "is more than one value", 'write one, e.g. "9 mm"'),
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
        ("500, 600 rpm", SPEED, ["500 rpm", "600 rpm"]),
        ("1.5, 2e1", RATIO, ["1.5", "20"]),
        ("2, 1.5", RATIO, ["2", "1.5"]),
        ("-5, 15°", ANGLE, ["-5 deg", "15 deg"]),
        ("0.4, .6 MPa gauge", SUPPLY, ["0.4 MPa gauge", "0.6 MPa gauge"]),
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
        ("500,600 rpm", SPEED, "a comma between digits", "give each value its unit"),
        ("500 rpm, 600", SPEED, "' 600' has no unit", '"600 rpm"'),
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


def test_every_typical_value_of_a_command_or_a_sensor_is_a_right_one():
    import apesim.studies.run.operating_conditions as conditions
    from apesim.studies.measured.sensors import LIFT, SENSORS

    shown = [value for value in vars(conditions).values() if isinstance(value, Quantity)]
    shown += [LIFT, *SENSORS["valve"].keys.values(), *SENSORS["engine"].means.values()]
    shown = [declaration for declaration in shown if getattr(declaration, "typical", "")]
    assert len(shown) > 5
    for declaration in shown:
        assert parse(declaration.typical, declaration, AMBIENT) > 0.0
