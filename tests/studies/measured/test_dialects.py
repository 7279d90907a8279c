"""Dialects of laboratories' files: each is read to the numbers that it means, or refused with the key that decides."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from apesim.quantities import InputError
from apesim.studies.measured import read_measured
from apesim.studies.measured.cells import MISSING, OVER_RANGE
from apesim.studies.measured.dialect import KEYS as KEYS_OF_READ
from apesim.studies.measured.dialect import SEPARATORS
from tests.machines import AMBIENT

DATA = Path(__file__).parent / "data"
"""First rows of others' files, see the README there."""
ABOUT = 'data = "a.csv"\nsupply = "0.40 MPa gauge"\npulse = "50 ms"\n'
TIMES = 0.5 * np.arange(-2, 10)
"""Times of the rows [ms]."""
LIFTS = 0.25 * np.arange(12) ** 1.5
"""Lifts of the rows [mm]."""


def read(folder, text, about="", encoding="utf-8", run=""):
    """The run of a folder with one file, and what is said of it."""
    Path(folder, "a.csv").write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    Path(folder, "measured.toml").write_text(f'bench = "valve"\n{about}\n[[run]]\n{ABOUT}{run}', encoding="utf-8")
    measured = read_measured(folder, AMBIENT)
    return measured.runs[0], measured.hints


def refused(folder, *arguments, **named):
    """The lines of a refusal, less the path of the folder."""
    with pytest.raises(InputError) as caught:
        read(folder, *arguments, **named)
    return str(caught.value).replace(f"{folder}/", "").splitlines()


def rows(form, separator, times=TIMES, lifts=LIFTS, end="\n"):
    """Lines of two columns."""
    return "".join(f"{form(t)}{separator}{form(y)}{end}" for t, y in zip(times, lifts, strict=True))


def comma(value):
    """A number as a German computer writes it."""
    return f"{value:.6f}".replace(".", ",")


def holds(run, times=TIMES, lifts=LIFTS):
    """Whether a run has the times [ms] and lifts [mm]."""
    assert run.times == pytest.approx(1e-3 * times, abs=1e-9)
    assert run.channels["lift"] == pytest.approx(1e-3 * lifts, abs=1e-9, nan_ok=True)
    return True


# --- dialects that are read ---


def test_a_german_tables_file_is_read(tmp_path):
    text = "Zeit (ms);Weg [µm];Prüfer\r\n" + rows(comma, ";", lifts=1e3 * LIFTS, end=";ok\r\n")
    about = '[read]\ncolumns = { time = "Zeit (ms)", lift = "Weg" }\nignore = ["Prüfer"]'
    run, hints = read(tmp_path, text, about, "latin-1")
    assert holds(run)
    assert hints == ('a.csv: read with separator = "semicolon", decimal = ",", encoding = "latin-1"',)


def test_a_dash_of_windows_is_read(tmp_path):
    text = "Zeit – roh (ms);Weg – roh (µm)\r\n" + rows(comma, ";", lifts=1e3 * LIFTS)
    run, hints = read(tmp_path, text, '[read]\ncolumns = { time = "Zeit – roh", lift = "Weg – roh" }', "cp1252")
    assert holds(run)
    assert hints == ('a.csv: read with separator = "semicolon", decimal = ",", encoding = "cp1252"',)
    _, hints = read(
        tmp_path, "time [ms];lift [mm];Prüfer\n" + rows(comma, ";", end=";1\n"), "[read]\nignore = [3]", "cp850"
    )
    assert 'encoding = "latin-1"' in hints[0]  # which has every byte, as cp1252 does not


def test_what_is_said_is_not_guessed(tmp_path):
    text = "Zeit (ms);Weg / mm\n" + rows(comma, ";")
    about = """[read]
separator = "semicolon"
decimal = ","
encoding = "latin-1"
columns = { time = "Zeit", lift = "Weg / mm" }"""
    run, hints = read(tmp_path, text, about)
    assert holds(run) and hints == ()


def test_a_guess_needs_no_table_where_the_header_is_ours(tmp_path):
    run, hints = read(tmp_path, "time [ms];lift [mm]\n" + rows(comma, ";"))
    assert holds(run)
    assert hints == ('a.csv: read with separator = "semicolon", decimal = ","',)


def test_an_oscilloscopes_file_with_a_preamble_is_read(tmp_path):
    head = "Model,TDS2024\nRecord Length,12\nSample Interval,5.0e-4\n\nTIME,CH1,CH2\n"
    text = head + "".join(f"{1e-3 * t:+.6e},{y:.6e},{0.1:.2e}\n" for t, y in zip(TIMES, LIFTS, strict=True))
    about = """[read]
skip_rows = 4
decimal = "."
columns = { time = "TIME", lift = "CH1" }
unit.time = "s"
unit.lift = "mm"
ignore_others = true"""
    run, hints = read(tmp_path, text, about)
    assert holds(run)
    assert hints == ('a.csv: read with separator = "comma"',)


def test_units_on_a_second_line_are_read(tmp_path):
    text = "Time\tChannel A\n(ms)\t(mm)\n\n" + rows(lambda value: f"{value:.7f}", "\t")
    run, hints = read(tmp_path, text, '[read]\ncolumns = { time = "Time", lift = "Channel A" }')
    assert holds(run)
    assert hints[1] == "a.csv: the line under the header is taken for its units"


def test_blanks_without_a_header_are_read(tmp_path):
    text = "".join(f"  {t:9.4f}   7 \t {y:9.6f}  \n" for t, y in zip(TIMES, LIFTS, strict=True))
    about = '[read]\nheader = false\ncolumns = { time = 1, lift = 3 }\nunit.time = "ms"\nunit.lift = "mm"'
    run, hints = read(tmp_path, text, about)
    assert holds(run)
    assert hints == ('a.csv: read with separator = "space", decimal = "."',)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig"])
def test_a_file_of_labview_is_read(tmp_path, encoding):
    text = "time [ms]\tlift [µm]\r\n" + rows(comma, "\t", lifts=1e3 * LIFTS, end="\t\r\n")
    run, hints = read(tmp_path, text, encoding=encoding)
    assert holds(run)
    assert ('encoding = "utf-16' in hints[0]) == encoding.startswith("utf-16")


def test_thousands_of_one_column_are_read(tmp_path):
    times = np.arange(0, 1200000, 100000)
    text = "time [us];lift [mm]\n" + "".join(
        f"{t:,}".replace(",", ".") + f";{y:.7f}\n" for t, y in zip(times, LIFTS, strict=True)
    )
    about = '[read]\ndecimal = "."\n[read.column.time]\nthousands = "."\ndecimal = ""'
    run, _ = read(tmp_path, text, about)
    assert holds(run, times=1e-3 * times)


@pytest.mark.parametrize(("thousands", "decimal"), [(".", ","), ("'", "."), (" ", ","), (",", ".")])
def test_thousands_of_all_columns_are_read(tmp_path, thousands, decimal):
    def form(value):
        return f"{value:,.3f}".translate({ord(","): thousands, ord("."): decimal})

    text = "time [us];lift [um]\n" + rows(form, ";", 1e3 * TIMES, 1e3 * np.round(LIFTS, 6))
    run, _ = read(tmp_path, text, f'[read]\nthousands = "{thousands}"\ndecimal = "{decimal}"')
    assert holds(run, lifts=np.round(LIFTS, 6))


def test_a_run_says_what_is_its_own(tmp_path):
    text = "t;Weg\n" + rows(comma, ";", lifts=1e3 * LIFTS)
    about = '[read]\ndecimal = "."\ncolumns = { time = "t", lift = "Weg" }\nunit.time = "ms"\nunit.lift = "mm"'
    run, _ = read(tmp_path, text, about, run='[run.read]\ndecimal = ","\nunit.lift = "um"\n')
    assert holds(run)


def test_quotes_and_old_ends_of_lines_are_read(tmp_path):
    text = '"time [ms]","lift [mm]"\r' + "".join(f'"{t}","{y}"\r' for t, y in zip(TIMES, LIFTS.tolist(), strict=True))
    run, hints = read(tmp_path, text)
    assert holds(run) and hints == ()


@pytest.mark.parametrize(
    ("start", "first"),
    [("", -1e-3), ('start = "command"', -1e-3), ('start = "first row"', 0.0), ('start = "1 ms"', -2e-3)],
)
def test_the_command_is_where_it_is_said_to_be(tmp_path, start, first):
    run, _ = read(tmp_path, "time [ms],lift [mm]\n" + rows(str, ","), f"[read]\n{start}\ndecimal='.'")
    assert run.times[0] == pytest.approx(first, abs=1e-12)


def test_the_rows_of_a_seal_are_read(tmp_path):
    about = """[read]
header = false
skip_rows = 15
decimal = "."
columns = { time = 1, lift = 5, pressure_a = 6 }
unit.time = "ms"
unit.lift = "mm"
unit.pressure_a = "bar gauge"
start = "first row" """
    run, hints = read(tmp_path, (DATA / "o_ring.csv").read_bytes(), about)
    table = np.loadtxt(DATA / "o_ring.csv", skiprows=15)
    assert np.array_equal(run.times, table[:, 0] * 1e-3 - table[0, 0] * 1e-3)
    assert np.array_equal(run.channels["lift"], table[:, 4] * 1e-3)
    assert np.array_equal(run.channels["pressure_a"], table[:, 5] * 1e5 + AMBIENT)
    assert hints == ('a.csv: read with separator = "tab"',)


VESSEL = """[read]
header = false
columns = { time = 1, pressure_a = 3 }
unit.time = "us"
unit.pressure_a = "bar gauge"
"""


def test_a_point_of_two_meanings_is_read(tmp_path):
    about = f'{VESSEL}decimal = "."\n[read.column.time]\nthousands = "."\ndecimal = ""'
    run, _ = read(tmp_path, (DATA / "vessel.csv").read_bytes(), about)
    cells = [line.split(";") for line in (DATA / "vessel.csv").read_text().split()]
    assert run.times == pytest.approx([1e-6 * int(cell.replace(".", "")) for cell, _, _ in cells])
    assert run.times[10] == pytest.approx(1.002)
    assert run.channels["pressure_a"] == pytest.approx([1e5 * float(cell) + AMBIENT for _, _, cell in cells])


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("quote", ["", '"'])
def test_lines_of_words_are_passed_over_where_it_is_said(tmp_path, separator, quote):
    head = f"{quote}time [ms]{quote}{separator}{quote}lift [mm]{quote}\n"
    early, late = rows(str, separator, TIMES[:5], LIFTS[:5]), rows(str, separator, TIMES[5:], LIFTS[5:])
    text = f"{head}# first half{separator}1\n{early}{head}{late}\n  End of data {separator}\n\x1a"
    said = '[read]\nignore_lines = ["End of data", "time [ms]", "#", "\\u001a"]'
    run, hints = read(tmp_path, text, said)
    assert holds(run)
    assert hints[-1] == "a.csv: 4 lines, the first is line 2, are passed over"
    run, hints = read(tmp_path, head + early + late + "End\n", '[read]\nignore_lines = ["End"]')
    assert holds(run)
    assert hints[-1] == "a.csv: line 14 is passed over"


def test_lines_are_passed_over_without_a_header_and_far_below(tmp_path):
    times, lifts = 0.01 * np.arange(300000), np.sin(0.01 * np.arange(300000))  # several blocks of text
    lines = rows(str, "\t", times, lifts).splitlines(True)
    text = "".join(["# a remark\n", *lines[:250000], "# another\n", *lines[250000:], "# end\n"])
    about = '[read]\nheader = false\ncolumns = { time = 1, lift = 2 }\nunit.time = "s"\nunit.lift = "mm"\n'
    assert "a.csv: line 1 is no row of numbers that a separator is seen in" in refused(tmp_path, text, about)[0]
    run, hints = read(tmp_path, text, f'{about}ignore_lines = ["#"]')
    assert run.channels["lift"] == pytest.approx(1e-3 * lifts, abs=1e-12)
    assert hints[-1] == "a.csv: 3 lines, the first is line 1, are passed over"
    assert refused(tmp_path, "# a remark\n", f'{about}ignore_lines = ["#"]')[0].startswith("a.csv: there is nothing")


@pytest.mark.parametrize("said", ['sample_interval = "0.5 ms"', 'sample_rate = "2 kHz"', 'sample_rate = "2000 1/s"'])
@pytest.mark.parametrize(("start", "first"), [("first row", 0.0), ("1 ms", -1e-3)])
def test_times_are_counted_where_the_file_has_none(tmp_path, said, start, first):
    text = "lift [mm];pressure_a [kPa abs]\n" + "".join(f"{y};100\n" if y != 2.0 else ";\n" for y in LIFTS.tolist())
    run, _ = read(tmp_path, text, f'[read]\n{said}\nstart = "{start}"')
    assert run.times == pytest.approx(first + 5e-4 * np.arange(len(LIFTS)), abs=1e-12)
    assert run.channels["lift"] == pytest.approx(np.where(LIFTS == 2.0, np.nan, 1e-3 * LIFTS), nan_ok=True)


@pytest.mark.parametrize(
    ("header", "form", "more"),
    [
        ("lift [mm]\n", str, ""),
        ("lift [mm]\n", comma, 'separator = "semicolon"'),
        ("", comma, 'separator = "tab"\nheader = false\ncolumns.lift = 1\nunit.lift = "mm"'),
    ],
)
def test_one_column_without_times_is_read(tmp_path, header, form, more):
    text = header + "".join(f"{form(y)}\n" for y in LIFTS.tolist())
    run, _ = read(tmp_path, text, f'[read]\nsample_interval = "0.5 ms"\nstart = "1 ms"\n{more}')
    assert run.channels["lift"] == pytest.approx(1e-3 * LIFTS, abs=1e-9)


def test_a_run_has_its_own_rate(tmp_path):
    text = "lift [mm]\n" + "".join(f"{y}\n" for y in LIFTS.tolist())
    about = '[read]\nsample_interval = "0.5 ms"\nstart = "first row"'
    run, _ = read(tmp_path, text, about, run='[run.read]\nsample_rate = "1 kHz"\nstart = "3 ms"\n')
    assert run.times == pytest.approx(1e-3 * (np.arange(len(LIFTS)) - 3.0))


@pytest.mark.parametrize(
    ("text", "about", "line"),
    [
        (
            "lift [mm]\n1\n2\n",
            'sample_interval = "0.5 ms"',
            "a.csv: time: is counted from the first row, and the command may be at any; "
            'write in [read] start = "first row", or its time after the first row, e.g. start = "12.5 ms"',
        ),
        (
            "lift [mm]\n1\n2\n",
            'sample_interval = "0.5 ms"\nstart = "command"',
            "a.csv: time: is counted from the first row, and the command may be at any; "
            'write in [read] start = "first row", or its time after the first row, e.g. start = "12.5 ms"',
        ),
        (
            "time [ms],lift [mm]\n" + rows(str, ","),
            'sample_interval = "0.5 ms"\nstart = "first row"',
            "a.csv: time: stands in the file beside a sample interval or rate: which is it?; "
            'take the key out, or write ignore = ["time [ms]"] in [read]',
        ),
        (
            "Weg [mm]\n1\n2\n",
            'sample_interval = "0.5 ms"\nstart = "first row"\nignore_others = true',
            'a.csv: no column of a sensor; name one in the header, e.g. "lift [mm]"',
        ),
        (
            "lift [mm]\n",
            'sample_interval = "0.5 ms"\nstart = "first row"',
            'a.csv: no column of a sensor; name one in the header, e.g. "lift [mm]"',
        ),
        (
            "t,lift [mm]\n" + rows(str, ","),
            'sample_rate = "2 kHz"\nstart = "first row"\ncolumns.time = "t"',
            "measured.toml: read.columns.time: stands beside sample_rate: which is the time?; keep one of the two",
        ),
        (
            "lift [mm]\n1\n2\n",
            'sample_rate = "2 kHz"\nsample_interval = "0.5 ms"\nstart = "first row"',
            "measured.toml: read.sample_rate: stands beside sample_interval: which is it?; keep one of the two",
        ),
        (
            "lift [mm]\n1\n2\n",
            'sample_rate = 2000\nstart = "first row"',
            'measured.toml: read.sample_rate: 2000 has no unit; write e.g. "2000 Hz"',
        ),
        (
            "lift [mm]\n1\n2\n",
            'sample_interval = "0 ms"\nstart = "first row"',
            "measured.toml: read.sample_interval: '0 ms' is out of range; allowed: 1e-06 to 10000 ms",
        ),
    ],
)
def test_no_time_is_counted_on_a_guess(tmp_path, text, about, line):
    assert refused(tmp_path, text, f"[read]\n{about}") == [line]


def test_the_rows_of_an_engine_are_not_counted(tmp_path):
    Path(tmp_path, "measured.toml").write_text('bench = "engine"\n[read]\nsample_rate = "2 kHz"\n[[run]]\n')
    with pytest.raises(InputError, match="sample_rate: an engine's traces stand over the crank angle"):
        read_measured(tmp_path, AMBIENT)


# --- what may be two things ---


def test_a_point_of_two_meanings_is_asked_for(tmp_path):
    lines = refused(tmp_path, (DATA / "vessel.csv").read_bytes(), VESSEL)
    assert lines == [
        "a.csv: time: '1.002.000' in line 11 is no finite number; "
        'write thousands = "." and decimal = "" in [read.column.time]',
        "a.csv: pressure_a: three digits stand behind each '.': is 1.234 a decimal number, or more than a thousand?; "
        'write decimal = "." in [read.column.pressure_a], or thousands = "." and decimal = ""',
    ]
    [line] = refused(
        tmp_path, b"".join((DATA / "vessel.csv").read_bytes().splitlines(True)[:10]), f"{VESSEL}ignore=[2]"
    )[:1]
    assert line.startswith("a.csv: time: three digits stand behind each '.'")


@pytest.mark.parametrize(
    ("cells", "is_refused"),
    [
        (["1.234", "2.345"], True),
        (["1,234", "2,345"], True),
        (["1.234", "998"], True),
        (["1.234", "0.345"], False),
        (["1.234", "2.34"], False),
        (["1.234", "1234"], False),
        (["1.234", "2.3456"], False),
        (["1.234", "2.345e0"], False),
        (["123", "234"], False),
        (["0.000", "234"], False),
    ],
)
def test_three_decimals_are_no_thousands_where_a_cell_shows_it(tmp_path, cells, is_refused):
    text = "time [ms];lift [um]\n" + "".join(f"{t};{cells[t % 2]}\n" for t in range(10))
    if is_refused:
        [line] = refused(tmp_path, text)
        assert line.startswith("a.csv: lift: three digits stand behind each ")
        mark = "," if "," in cells[0] else "."
        for said, value in ((f'decimal = "{mark}"', 1.234e-6), (f'thousands = "{mark}"', 1234e-6)):
            run, _ = read(tmp_path, text, f"[read]\n{said}")
            assert run.channels["lift"][0] == pytest.approx(value)
    else:
        run, _ = read(tmp_path, text)
        assert run.channels["lift"] == pytest.approx([1e-6 * float(cells[t % 2]) for t in range(10)])


def test_thousands_in_a_file_of_ours_are_seen_by_the_jump(tmp_path):
    cells = [f"{t:,}".replace(",", ".") for t in range(900, 1100, 10)]
    text = "time [ms],lift [um]\n" + "".join(f"{t},{cell}\n" for t, cell in enumerate(cells))
    [line] = refused(tmp_path, text)
    assert line.startswith("a.csv: lift: three digits stand behind each '.'")
    smooth = "time [ms],lift [um]\n" + "".join(f"{t},{1 + 0.001 * t:.3f}\n" for t in range(12))
    run, _ = read(tmp_path, smooth)
    assert run.channels["lift"][1] == pytest.approx(1.001e-6)


def test_commas_that_may_be_both_are_asked_for(tmp_path):
    text = rows(lambda value: comma(abs(value)), ",")
    about = '[read]\nheader = false\ncolumns = { time = 1, lift = 3 }\nunit.time = "ms"\nunit.lift = "mm"\n'
    [line] = refused(tmp_path, text, about)
    assert line == (
        "a.csv: the commas may be separators or decimal marks; "
        'write separator = "comma" in [read], or save it with another separator'
    )
    lines = refused(tmp_path, text, f'{about}separator = "comma"\ndecimal = ","')
    assert lines[0].startswith("a.csv: ',' is the separator and a mark in numbers: which is which?")
    [line] = refused(tmp_path, "time [ms],lift [mm]\n" + rows(lambda value: f"{value:.0f}", ","), "[read]\ndecimal=','")
    assert line.startswith("a.csv: ',' is the separator and a mark in numbers: which is which?")


# --- missing cells ---


@pytest.mark.parametrize("cell", sorted(MISSING | {"NaN", "#N/A"}))
def test_a_missing_cell_costs_that_cell(tmp_path, cell):
    body = "".join(f"{t},{cell if t == 3 else y},{100 + t}\n" for t, y in enumerate(LIFTS.tolist()))
    run, hints = read(tmp_path, f"time [ms],lift [mm],pressure_a [kPa abs]\n{body}")
    lifts = LIFTS.copy()
    lifts[3] = np.nan
    assert holds(run, np.arange(12.0), lifts)
    assert run.channels["pressure_a"] == pytest.approx(1e5 + 1e3 * np.arange(12))
    assert hints == ("a.csv: lift: 1 of 12 cells have no number; the other cells of their rows are used",)


def test_a_row_without_its_time_is_left_out(tmp_path):
    text = "time [ms],lift [mm]\n" + "".join(f"{'' if t == 3 else t},{t}\n" for t in range(12))
    run, hints = read(tmp_path, text)
    assert holds(run, np.delete(np.arange(12.0), 3), np.delete(np.arange(12.0), 3))
    assert hints == ("a.csv: 1 row without time left out",)


def test_a_column_of_too_few_numbers_is_refused(tmp_path):
    text = "time [ms],lift [mm]\n" + "".join(f"{t},{t if t < 7 else ''}\n" for t in range(12))
    assert refused(tmp_path, text) == ["a.csv: lift: 7 numbers; give at least 8, or leave the column out"]


# --- what is refused ---


HEAD = "time [ms];lift [mm]\n"


@pytest.mark.parametrize(
    ("text", "about", "line"),
    [
        (
            "Scope\nCh\n" + HEAD + rows(str, ";"),
            "",
            "a.csv: line 1 is no header with names and units; "
            'write skip_rows = 2, and columns = { time = "their header", … } in [read]',
        ),
        (
            rows(str, ";"),
            "",
            "a.csv: line 1 is no header with names and units; "
            "write header = false and columns = { time = 1, lift = 2 } in [read], "
            "with skip_rows = 1 if line 1 is a header of numbers",
        ),
        ("", "", "a.csv: there is nothing; give a file with rows of numbers"),
        (
            "time [ms],lift [mm]\n",
            "",
            "a.csv: time: has no number; give a number in each row",
        ),
        (
            HEAD + rows(str, ";") + "1;2;3\n",
            "",
            "a.csv: line 14 has 3 cells, the header 2; "
            "make all rows as long, or write the separator and skip_rows in [read]",
        ),
        (
            HEAD + rows(str, ";") + "[end]\n",
            '[read]\nseparator = "semicolon"\ndecimal = "."',
            "a.csv: line 14 is no row of numbers, it begins with '[end]'; "
            'write ignore_lines = ["[end]"] in [read] to pass over such lines',
        ),
        (
            HEAD + rows(str, ";") + "Sum;12;3\n",
            "[read]\nignore = [3]",
            "a.csv: line 14 has 3 cells, the header 2; "
            "make all rows as long, or write the separator and skip_rows in [read]",
        ),
        (
            HEAD + rows(str, ";") + "Mean;2.5\n",
            "",
            "a.csv: time: 'Mean' in line 14 is no finite number; give a number in every cell, "
            'or write ignore_lines = ["Mean"] in [read] to pass over such lines',
        ),
        (
            HEAD + rows(str, ";") + HEAD + rows(str, ";", TIMES + 6.0),
            "",
            "a.csv: line 14 is no row of numbers, it begins with 'time [ms]'; "
            'write ignore_lines = ["time [ms]"] in [read] to pass over such lines',
        ),
        (
            HEAD + rows(comma, ";"),
            '[read]\ndecimal = "."',
            "a.csv: time: '-1,000000' in line 2 is no finite number; write decimal = \",\" in [read]",
        ),
        (
            HEAD + rows(comma, ";"),
            '[read]\nseparator = "tab"',
            'a.csv: separator = "tab" makes no columns of numbers; '
            'write separator = "semicolon" in [read], or leave it out',
        ),
        (
            HEAD + rows(comma, ";"),
            '[read]\nseparator = "comma"',
            'a.csv: separator = "comma" makes no columns of numbers; '
            'write separator = "semicolon" in [read], or leave it out',
        ),
        (
            rows(str, ","),
            '[read]\nseparator = "semicolon"\nheader = false\ncolumns = { time = 1, lift = 2 }',
            'a.csv: separator = "semicolon" makes no columns of numbers; '
            'write separator = "comma" in [read], or leave it out',
        ),
        (
            "t;Weg\n" + rows(str, ";"),
            '[read]\ncolumns = { time = "t", lift = "Wge" }\nunit.time = "ms"',
            "a.csv: lift: there is no column 'Wge'; the file has 't', 'Weg'",
        ),
        (
            "t;Weg;Weg\n" + rows(str, ";", end=";1\n"),
            '[read]\ncolumns = { time = "t", lift = "Weg" }\nunit.time = "ms"',
            "a.csv: lift: column 'Weg' stands there 2 times; write its number, e.g. columns.lift = 2",
        ),
        (
            "t;Weg\n" + rows(str, ";"),
            '[read]\ncolumns = { time = "t", lift = "Weg" }\nunit.time = "ms"',
            'a.csv: lift: has no unit; write "lift [mm]" in the header or unit.lift = "mm" in [read]',
        ),
        (
            "time [ms];lift [mm];Trigger\n" + rows(str, ";", end=";1\n"),
            '[read]\nseparator = "semicolon"',
            "a.csv: Trigger: unknown column; valid here: time, lift, velocity, pressure_a, pressure_b, temperature_a, "
            "temperature_b, or name it in columns or in ignore of [read], or set ignore_others = true",
        ),
        (
            b"time [ms],lift [mm]\n" + b"".join(b"%d,%d\n" % (t, t) for t in range(80000)) + b"\xb5,1\n",
            "",
            'a.csv: is no text in line 80002; save it as UTF-8, or write its encoding = "latin-1" in [read]',
        ),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_key_that_helps(tmp_path, text, about, line):
    lines = refused(tmp_path, text, about)
    assert line in lines


@pytest.mark.parametrize(
    ("about", "starts"),
    [
        ("read = 1", "measured.toml: read: 1 is no table; write [read]"),
        ("[read]\nseparater = 'tab'", "measured.toml: read.separater: unknown key; did you mean separator?"),
        ("[read]\nseparator = '|'", "measured.toml: read.separator: '|' is no option; write \"comma\", "),
        ("[read]\nskip_rows = -1", "measured.toml: read.skip_rows: -1 is no number of rows; write a whole"),
        ("[read]\nskip_rows = true", "measured.toml: read.skip_rows: True is no number of rows; "),
        ("[read]\ncolumns = 3", "measured.toml: read.columns: 3 is no table; write columns = {"),
        ("[read]\ncolumns = { lfit = 2 }", "measured.toml: read.columns.lfit: unknown key; did you mean lift?"),
        ("[read]\ncolumns = { lift = 0 }", "measured.toml: read.columns.lift: 0 is no header and no number"),
        ("[read]\ncolumns = { lift = 1, time = 1 }", "measured.toml: read.columns: one column of the file has two"),
        ("[read]\nunit.lift = 1", "measured.toml: read.unit.lift: 1 is no unit; "),
        ("[read]\nignore = 'x'", "measured.toml: read.ignore: 'x' is no list of columns; "),
        ("[read]\nignore_lines = 'End'", "measured.toml: read.ignore_lines: 'End' is no list of texts; write the"),
        ("[read]\nignore_lines = [' ']", "measured.toml: read.ignore_lines: [' '] is no list of texts; write the"),
        ("[read]\nignore_lines = ['-1,']", "measured.toml: read.ignore_lines: a row of numbers may begin with '-1,',"),
        ("[read]\nheader = 0", "measured.toml: read.header: 0 is neither true nor false; "),
        ("[read]\nheader = false", "measured.toml: read.columns: is not given, and the file has no header; "),
        ("[read]\nheader = false\ncolumns.time = 't'", "measured.toml: read.columns.time: 't' in a file without"),
        ("[read]\nthousands = '.'\ndecimal = '.'", "measured.toml: read: decimal and thousands are both '.'; "),
        ("[read]\ncolumn.time = 1", "measured.toml: read.column.time: 1 is no table; "),
        ("[read]\ncolumn.time.decimal = 1", "measured.toml: read.column.time.decimal: 1 is no option; "),
        ("[read]\nstart = 'trigger'", "measured.toml: read.start: "),
        ("[read]\nencoding = 'klingon'", "measured.toml: read.encoding: 'klingon' is no option; "),
    ],
)
def test_a_wrong_table_is_told(tmp_path, about, starts):
    [line] = refused(tmp_path, "time [ms],lift [mm]\n" + rows(str, ","), about)
    assert line.startswith(starts)


def test_no_line_of_a_file_that_is_no_data_is_shown(tmp_path):
    text = "root:x:0:0:root:/root:/bin/bash\nhunter2;1;2\nhunter2;2;3\n"
    for about in ("", '[read]\ncolumns = { time = "t", lift = "Weg" }', '[read]\nseparator = "semicolon"'):
        assert not any("root:x" in line or "hunter2" in line for line in refused(tmp_path, text, about))


# --- any table ---


FINITE = st.floats(-1e12, 1e12, allow_nan=False).map(float)


@st.composite
def written(draw):
    """Any table in a random dialect: its bytes, its ``[read]``, its times and its lifts."""
    number = draw(st.integers(9, 12))
    steps = draw(st.lists(st.integers(1, 999), min_size=number, max_size=number))
    times = draw(st.integers(-9999, 0)) + np.cumsum(steps).astype(float)
    lifts = np.array(draw(st.lists(FINITE, min_size=number, max_size=number)))
    if draw(st.booleans()):
        lifts[draw(st.integers(0, number - 1))] = np.nan
    separator = draw(st.sampled_from(sorted(SEPARATORS)))
    mark = SEPARATORS[separator]
    decimal = draw(st.sampled_from([each for each in ".," if each != mark]))
    thousands = draw(st.sampled_from([each for each in ("", ".", ",", "'", " ") if each not in (mark, decimal)]))
    if separator == "space":
        assume(thousands != " ")
    form = "f" if thousands else draw(st.sampled_from("feg"))
    digits = draw(st.integers(0 if form == "f" else 6, 9))  # enough that the times differ
    missing = draw(st.sampled_from(["nan", "-", "#N/A", "NULL"]))

    def cell(value):
        if np.isnan(value):
            return missing
        text = f"{value:{',' * bool(thousands)}.{digits}{form}}"
        return text.replace(",", "T").replace(".", decimal).replace("T", thousands)

    table = [[cell(t), cell(y), "1"] for t, y in zip(times.tolist(), lifts.tolist(), strict=True)]
    order = draw(st.permutations(range(3)))
    headers = [["t/s", "Weg", "Trigger"][at] for at in order]
    preamble = draw(st.integers(0, 3))
    has_header = draw(st.booleans())
    lines = [f"made by {n}" for n in range(preamble)] + [mark.join(headers)] * has_header
    lines += [mark.join(row[at] for at in order) for row in table]
    end, encoding = draw(st.sampled_from(["\n", "\r\n", "\r"])), draw(st.sampled_from(["utf-8", "utf-16", "latin-1"]))
    names = ['"t/s"', '"Weg"'] if has_header else [str(order.index(at) + 1) for at in range(2)]
    said = [
        "[read]",
        f'separator = "{separator}"',
        f'decimal = "{decimal}"',
        f'thousands = "{thousands}"',
        f'encoding = "{encoding}"',
        f"skip_rows = {preamble}",
        f"header = {str(has_header).lower()}",
        f"columns = {{ time = {names[0]}, lift = {names[1]} }}",
        "ignore_others = true",
        'unit.time = "s"',
        'unit.lift = "m"',
    ]
    plain = [[text.replace(thousands or "T", "").replace(decimal, ".") for text in row[:2]] for row in table]
    meant = [float(t) for t, _ in plain], [np.nan if y == missing else float(y) for _, y in plain]
    return (end.join(lines) + end).encode(encoding), "\n".join(said), *map(np.array, meant)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(written())
def test_any_table_in_any_dialect_is_read_to_its_numbers(tmp_path, table):
    data, said, times, lifts = table
    assume(times[-1] > 0.0)
    run, _ = read(tmp_path, data, said)
    assert np.array_equal(run.times, times)
    assert np.array_equal(run.channels["lift"], lifts, equal_nan=True)


SEEDS = [
    ("time [ms];lift [mm]\n" + rows(comma, ";")).encode("utf-16"),
    ("Zeit (ms)\tWeg\n(ms)\t(mm)\n" + rows(str, "\t")).encode(),
    (DATA / "vessel.csv").read_bytes()[:600],
    ("time [ms],lift [mm]\n" + rows(str, ",")).encode(),
]
TABLES = [
    "",
    '[read]\ncolumns = { time = "Zeit", lift = "Weg" }',
    f'{VESSEL}[read.column.time]\nthousands = "."',
    '[read]\nheader = false\ncolumns = { time = 1, lift = 2 }\nunit.time = "s"\nunit.lift = "mm"\nthousands = "."',
    '[read]\nencoding = "utf-16"\nstart = "first row"',
    '[read]\nseparator = "space"\nskip_rows = 3',
]


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from(SEEDS),
    st.sampled_from(TABLES),
    st.lists(st.tuples(st.integers(0, 700), st.integers(0, 3), st.binary(max_size=6)), max_size=6),
)
def test_no_mutated_file_gives_a_traceback(tmp_path, seed, about, changes):
    data = bytearray(seed)
    for at, cut, new in changes:
        data[at : at + cut] = new
    try:
        run, _ = read(tmp_path, bytes(data), about)
    except InputError as error:
        assert all(fault.wrong and fault.right for fault in error.faults)
    else:
        assert np.all(np.diff(run.times) > 0.0)
        assert all(values.shape == run.times.shape for values in run.channels.values())


KEYS = st.sampled_from([*KEYS_OF_READ, "columns.lift", "unit.lift", "column.time", "column.time.decimal"])
VALUES = st.sampled_from(
    """"tab" "space" "," "." "" 1 -1 true [] [1,[]] {} {time={}} 1.5 "x" {time=1,lift=2} "start" 1979-05-27 nan
    99999999999999999999 "utf-16" """.split()
)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.dictionaries(KEYS, VALUES, max_size=4))
def test_no_table_gives_a_traceback(tmp_path, table):
    about = "[read]\n" + "".join(f"{key} = {value}\n" for key, value in table.items())
    try:
        run, _ = read(tmp_path, SEEDS[3], about)
    except InputError as error:
        assert all(fault.right and not re.search("Traceback|object at", str(fault)) for fault in error.faults)
    else:
        assert len(run.times) == len(TIMES)


def test_the_guide_has_every_key():
    page = (Path(__file__).parents[3] / "docs" / "guide" / "measured_data.md").read_text(encoding="utf-8")
    section = page[page.index("## Files of a laboratory") : page.index("### What is guessed")]
    cells = re.findall(r"^\| (`[^|]+`) \|", section, re.MULTILINE)
    assert {key for cell in cells for key in re.findall(r"`(\w+)", cell)} == set(KEYS_OF_READ)
    assert all(f"`{cell}`" in page for cell in (MISSING | OVER_RANGE) - {""})


def test_the_guides_example_is_read(tmp_path):
    page = (Path(__file__).parents[3] / "docs" / "guide" / "measured_data.md").read_text(encoding="utf-8")
    section = page[page.index("## Files of a laboratory") : page.index("### What is guessed")]
    head = re.search(r"```text\n(.*?)```", section, re.DOTALL)[1]
    more = "".join(f"{1e-3 * t:.6e},{t},100,5\n" for t in range(10))
    (tmp_path / "scope.csv").write_text(head + more)
    (tmp_path / "measured.toml").write_text(re.search(r"```toml\n(.*?)```", section, re.DOTALL)[1])
    measured = read_measured(tmp_path, AMBIENT)
    assert measured.hints == ()
    assert measured.runs[0].times[:3] == pytest.approx([-1e-3, -9.8e-4, 0.0])
    assert measured.runs[0].channels["pressure_a"][0] == pytest.approx(101300.0)
