"""Long and many: lengths are looked at before patterns are tried, and of many faults the first are told.

Before, these inputs took minutes to hours; nothing here is held to a time.
"""

import pytest

from apesim import InputError, Machine
from apesim.quantities import Quantity, parse, parse_range, split_header, unit
from apesim.quantities.input_errors import MAX_LINES, MAX_NAMED, InvalidValue
from apesim.quantities.toml_text import parse_toml
from apesim.quantities.uncertainties import read_uncertainty
from apesim.studies.measured.conversion import read_measure
from apesim.studies.measured.dialect import KEYS, find_unknown_keys
from apesim.studies.measured.layout import split_name

STROKE, SHARE = Quantity("mm", 1, 50, "chosen"), Quantity("", 0, 1, "chosen")
LONG = {
    "digits": "1" * 100_000,
    "digits and unit": "1" * 100_000 + " mm",
    "digits and dots": "1." * 50_000,
    "blanks": "1" + " " * 100_000 + "x",
    "letters": "m" * 100_000,
    "numbers": ":".join(["1" * 30_000] * 3),
    "short numbers": ":".join(["1" * 99] * 4),
    "commas": "1," * 50_000,
}
READERS = {
    "quantity": lambda text: parse(text, STROKE),
    "number": lambda text: parse(text, SHARE),
    "range": lambda text: parse_range(text, STROKE),
    "deviation": lambda text: read_uncertainty(text, STROKE),
    "measure": read_measure,
    "unit": unit,
}


@pytest.mark.parametrize("text", LONG)
@pytest.mark.parametrize("reader", READERS)
def test_a_long_text_is_refused_by_its_length_and_shown_short(reader, text):
    with pytest.raises((InputError, InvalidValue)) as caught:
        READERS[reader](LONG[text])
    lines = str(getattr(caught.value, "wrong", caught.value)).splitlines()
    assert len(lines) <= MAX_LINES + 1 and all(len(line) < 400 for line in lines)


def test_the_message_says_how_long_it_is():
    with pytest.raises(InputError, match=r"no finite number with a unit: it has 30000 characters, 100 are read; write"):
        parse("1" * 30_000, STROKE)


@pytest.mark.parametrize("text", ["a" + " " * 100_000 + "b", "[" * 100_000, "a (" * 50_000, "a in " * 50_000])
def test_a_long_header_is_a_name_without_unit(text):
    assert split_header(text) == split_name(text) == (text.strip(), None)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("lift [mm]", ("lift", "mm")),
        ("lift\n[mm]", ("lift", "mm")),
        ("a [b] c [d]", ("a", "b] c [d")),
        ("[ mm ]", ("", "mm")),
        ("a]", ("a]", None)),
        ("a [m\nm]", ("a [m\nm]", None)),
    ],
)
def test_a_header_is_split_at_its_first_bracket(text, parts):
    assert split_header(text) == parts


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("a." * 100_000 + "b = 1", "more than 50 parts"),
        ("[" + '"a b" . ' * 100_000 + "b]", "more than 50 parts"),
        ("x = " + "1" * 30_000, "thousands of digits"),
        ("a" * 100_000, "no TOML"),
    ],
)
def test_toml_that_its_parser_takes_long_for_is_refused(text, wrong):
    with pytest.raises(InputError) as caught:
        parse_toml("m.toml", text, 'bore = "85 mm"')
    assert wrong in str(caught.value) and len(str(caught.value)) < 300


def test_long_lines_of_numbers_are_no_long_keys():
    numbers = ", ".join(["0.125"] * 1000)
    assert len(parse_toml("m.toml", f"x = [{numbers}]\ny = '{'one two. ' * 1000}'", "")["x"]) == 1000


def test_of_many_unknown_keys_the_first_are_named_and_the_others_counted(tmp_path):
    (tmp_path / "m.toml").write_text("[engine]\n" + "".join(f"boar_{i} = 1\n" for i in range(16_000)))
    with pytest.raises(InputError) as caught:
        Machine.load(tmp_path / "m.toml")
    *named, rest = str(caught.value).splitlines()
    assert len(named) == MAX_NAMED and "did you mean engine.bore?" in named[0]
    assert "15950 more unknown keys" in rest


@pytest.mark.parametrize("table", ["known_to", "effects", "engine", "valve.solenoid", "effects.ring_leakage"])
def test_unknown_keys_are_counted_in_every_table(tmp_path, table):
    (tmp_path / "m.toml").write_text(f"[{table}]\n" + "".join(f"boar_{i} = 1\n" for i in range(1_000)))
    with pytest.raises(InputError, match="950 more unknown keys"):
        Machine.load(tmp_path / "m.toml")


def test_unknown_keys_of_measured_data_are_counted():
    *named, rest = find_unknown_keys("measured.toml", "read", [f"separater{i}" for i in range(16_000)], KEYS)
    assert len(named) == MAX_NAMED and str(rest).startswith("measured.toml: read: 15950 more unknown keys; mend")


def test_of_many_faults_a_screen_is_shown():
    with pytest.raises(InputError) as caught:
        parse_range(["x"] * 5_000, STROKE)
    lines = str(caught.value).splitlines()
    assert len(lines) == MAX_LINES + 1 and lines[-1] == "4900 more faults are not shown; mend these first"
    assert len(caught.value.faults) == 5_000
