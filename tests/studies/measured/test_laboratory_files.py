"""Files as instruments and spreadsheets write them: LabVIEW, words over range, clock times, units, quoted numbers."""

import numpy as np
import pytest

import apesim
from apesim.studies.measured import Disturbance
from tests.studies.measured.test_dialects import LIFTS, TIMES, comma, holds, read, refused, rows

# --- LabVIEW ---

LVM = """LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t.
Multi_Headings\tYes
X_Columns\tOne
Time_Pref\tRelative
Operator\tlab
Date\t2026/03/01
Time\t14:32:11.3281250
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t12\t12\t
Date\t2026/03/01\t2026/03/01\t
Time\t14:32:11.328125\t14:32:11.328125\t
Y_Unit_Label\tVolts\tVolts\t
X_Dimension\tTime\tTime\t
X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t
Delta_X\t0.000500\t0.000500\t
***End_of_Header***\t\t\t
X_Value\tVoltage_0\tVoltage_1\tComment
"""
"""Head of a file of LabVIEW, by the specification of the format: the names of the columns stand in line 23."""
SAID = """[read]
skip_rows = 22
columns = { time = "X_Value", lift = "Voltage_0", pressure_a = 3 }
unit.time = "s"
unit.lift = "mm"
unit.pressure_a = "bar abs"
ignore = ["Comment"]
"""


def lvm(end="", comment="", form=str):
    """A file of LabVIEW: rows end before the comment, or with an empty one; the fourth has one."""
    body = [
        f"{form(1e-3 * t)}\t{form(y)}\t{form(5.0)}{end}" for t, y in zip(TIMES.tolist(), LIFTS.tolist(), strict=True)
    ]
    body[3] = body[3].removesuffix(end) + (comment and f"\t{comment}")
    return (LVM + "\n".join(body) + "\n").replace("\n", "\r\n")


@pytest.mark.parametrize("end", ["", "\t"])
@pytest.mark.parametrize("comment", ["", "valve opened", "run 3, 0.4 MPa"])
@pytest.mark.parametrize("more", ["", 'separator = "tab"\ndecimal = "."\n'])
def test_a_measurement_file_of_labview_is_read(tmp_path, end, comment, more):
    run, _ = read(tmp_path, lvm(end, comment), SAID + more)
    assert holds(run)
    assert run.channels["pressure_a"] == pytest.approx(5e5)


def test_a_measurement_file_with_decimal_commas_is_read(tmp_path):
    run, hints = read(tmp_path, lvm(form=comma), SAID)
    assert holds(run) and 'separator = "tab", decimal = ","' in hints[0]


@pytest.mark.parametrize("end", ["", "\t"])
def test_the_header_of_labview_is_found(tmp_path, end):
    [line] = refused(tmp_path, lvm(end, "valve opened"))
    assert line.startswith("a.csv: line 1 is no header with names and units; write skip_rows = 22, and columns = {")


def test_a_row_that_lacks_more_than_its_comment_is_refused(tmp_path):
    text = lvm() + "0.006\t1.5\r\n"
    assert "a.csv: line 36 has 2 cells, the header 4" in refused(tmp_path, text, SAID)[0]
    assert "Comment: unknown column" in refused(tmp_path, lvm(), SAID.replace('ignore = ["Comment"]', ""))[0]


def test_a_further_segment_of_labview_is_named(tmp_path):
    head = "Channels\t2\t\t\nSamples\t12\t12\t\n***End_of_Header***\t\t\t\nX_Value\tVoltage_0\tVoltage_1\n"
    [line] = refused(tmp_path, f"{lvm()}\n{head}0\t1\t2\n", SAID)
    assert line == "a.csv: line 37 begins another segment of LabVIEW; save each segment in a file of its own"


# --- words over range ---


def table(cells, header="time [ms],lift [mm],pressure_a [kPa abs]"):
    """A file whose pressures are these cells."""
    return f"{header}\n" + "".join(f"{t},{0.01 * (t % 7)},{cell}\n" for t, cell in enumerate(cells))


@pytest.mark.parametrize("word", ["∞", "OVER", "1.#INF", "-1.#INF", "#DIV/0!", "Inf", "O.L", "9.9E+37", "Over Range"])
def test_words_over_range_are_missing_and_count_as_clipped(tmp_path, word):
    cells = [100.0 + 3.0 * (t % 5) for t in range(400)]
    cells[7] = cells[8] = word
    run, hints = read(tmp_path, table(cells))
    assert np.flatnonzero(np.isnan(run.channels["pressure_a"])).tolist() == [7, 8]
    assert "a.csv: pressure_a: 2 of 400 cells have no number, 2 of them as it is over range" in hints[0]
    measured = apesim.read_measured(tmp_path)
    [masked] = measured.masked
    assert (masked.channel, masked.disturbance, masked.is_short) == ("pressure_a", Disturbance.CLIPPED, True)
    assert masked.places == pytest.approx([7e-3, 8e-3])


@pytest.mark.parametrize(
    ("word", "is_clipped"),
    [("OVER", True), ("out of range", True), ("n.v.", False), ("-9999", False), ("-9999.0", False)],
)
def test_words_that_are_stated_are_missing(tmp_path, word, is_clipped):
    cells = [100.0 + 3.0 * (t % 5) for t in range(40)]
    cells[7] = word
    run, _ = read(tmp_path, table(cells), f'[read]\nmissing = ["{word}"]\ndecimal = "."')
    assert np.flatnonzero(np.isnan(run.channels["pressure_a"])).tolist() == [7]
    assert len(apesim.read_measured(tmp_path).masked) == is_clipped


def test_a_word_that_nobody_stated_is_refused(tmp_path):
    [line] = refused(tmp_path, table([100.0] * 8 + ["n.v."]))
    assert "'n.v.' in line 10 is no finite number; give a number in every cell, or write missing = [\"n.v.\"]" in line
    assert (
        "read.missing: 'OVER' is no list of texts" in refused(tmp_path, table([100.0]), "[read]\nmissing = 'OVER'")[0]
    )


def test_a_channel_that_is_over_range_throughout_is_refused(tmp_path):
    [line] = refused(tmp_path, table(["OVER"] * 40))
    assert line == "a.csv: pressure_a: is over range in every row that has a value; leave the column out"


def test_the_check_counts_what_is_over_range_as_clipped(tmp_path):
    from apesim.studies.measured.plausibility.records import check_masked

    cells = [100.0 + 3.0 * (t % 5) for t in range(400)]
    for few, kind in ((2, "warning"), (200, "fault")):
        read(tmp_path, table(["OVER"] * few + cells[few:]), run='name = "a"\n')
        measured = apesim.read_measured(tmp_path)
        measured = measured._replace(runs=measured.runs * 3)  # two others show what is lost
        [finding] = check_masked(measured)
        assert (str(finding.check), str(finding.kind)) == ("clipped", kind)
        assert f"is over range in {few} samples between 0 ms and {few - 1} ms, as the file says" in finding.seen
        assert "nan" not in finding.seen


# --- units in headers ---


@pytest.mark.parametrize(
    ("header", "scale", "is_gauge"),
    [
        ("pressure_a [psig]", 6894.757293168361, True),
        ("pressure_a [psia]", 6894.757293168361, False),
        ("pressure_a [barg]", 1e5, True),
        ("pressure_a (bara)", 1e5, False),
        ("pressure_a [bar(g)]", 1e5, True),
        ("pressure_a (bar(a))", 1e5, False),
        ("pressure_a / bar (g)", 1e5, True),
        ("pressure_a in bar(g)", 1e5, True),
        ("pressure_a [kPaG]", 1e3, True),
        ("pressure_a [kPa gauge]", 1e3, True),
        ("pressure_a [mbar rel]", 1e2, True),
        ("pressure_a [hPa absolute]", 1e2, False),
    ],
)
def test_a_gauge_pressure_in_a_header_is_read(tmp_path, header, scale, is_gauge):
    run, _ = read(tmp_path, table(range(1, 41), f"time [msec],lift [mm],{header}"))
    expected = scale * np.arange(1, 41) + is_gauge * 101325.0
    assert run.channels["pressure_a"] == pytest.approx(expected, rel=1e-12)
    assert run.times == pytest.approx(1e-3 * np.arange(40))


def test_a_gauge_pressure_on_a_line_of_units_is_read(tmp_path):
    text = "time,pressure_a\nmsec,bar(g)\n" + "".join(f"{t},{t}\n" for t in range(1, 20))
    run, _ = read(tmp_path, text)
    assert run.channels["pressure_a"] == pytest.approx(1e5 * np.arange(1, 20) + 101325.0)


@pytest.mark.parametrize(
    ("header", "right"),
    [
        ("pressure_a [PSIG]", 'write "pressure_a [psi gauge]" in the header'),
        ("pressure_a [Bar gauge]", 'write "pressure_a [bar gauge]" in the header'),
        ("pressure_a [Torr]", 'write "pressure_a [torr abs]" in the header'),
        (
            "pressure_a [psi]",
            'write "pressure_a [psi abs]" in the header or unit.pressure_a = "psi abs" in [read], or gauge',
        ),
        ("pressure_a [Mbar abs]", 'write "pressure_a [mbar abs]" in the header'),
        ("pressure_a [furlong]", 'write "pressure_a [kPa abs]" in the header'),
    ],
)
def test_a_unit_that_is_nearly_right_is_named(tmp_path, header, right):
    [line] = refused(tmp_path, table(range(1, 41), f"time [ms],lift [mm],{header}"))
    assert right in line


@pytest.mark.parametrize(
    ("header", "said", "right"),
    [
        ("Ch1", 'scale.lift = "2 mm/V"', 'write unit.lift = "V" in [read], the unit before the scale'),
        ("Ch1 [furlong]", 'scale.lift = "2 mm/V"', 'write unit.lift = "V" in [read], the unit before the scale'),
        ("Ch1", 'scale.lift = "2 mm/mA"', 'write unit.lift = "A" in [read], the unit before the scale'),
        ("Ch1", 'scale.lift = "0.01 mm"', 'write unit.lift = "-" in [read], the unit before the scale'),
        ("Ch1", "scale.lift = -1", 'write unit.lift = "mm" in [read], the unit before the scale'),
        ("Ch1 [-]", "", 'e.g. scale.lift = "2 mm" and offset.lift = "-1 mm"'),
        ("Ch1 [kPa abs]", 'unit.lift = "mm"', 'write scale.lift = "2 mm/kPa" and offset.lift'),
        ("Ch1 [V]", "scale.lift = 2", "'V' times a bare number is no unit of lift"),
    ],
)
def test_the_unit_beside_a_scale_is_that_before_it(tmp_path, header, said, right):
    text = f"time [ms];{header}\n" + rows(str, ";")
    [line] = refused(tmp_path, text, f"[read]\ncolumns.lift = 2\n{said}")
    assert right in line


# --- quoted cells ---


def test_quoted_names_behind_blanks_are_read(tmp_path):
    text = '"time [ms]", "lift [mm]"\n' + rows(str, ", ")
    run, hints = read(tmp_path, text)
    assert holds(run) and hints == ()


@pytest.mark.parametrize("said", ["", '[read]\ndecimal = ","', '[read]\nseparator = "comma"\ndecimal = ","'])
@pytest.mark.parametrize("between", [",", ", "])
def test_quoted_decimal_commas_between_commas_are_read(tmp_path, said, between):
    text = f'"time [ms]"{between}"lift [mm]"\n' + rows(lambda value: f'"{comma(value)}"', between)
    run, hints = read(tmp_path, text, said)
    assert holds(run)
    assert ('decimal = ","' in "".join(hints)) == (not said)


def test_quoted_thousands_between_commas_are_read(tmp_path):
    times = np.arange(0.0, 12000.0, 1000.0)
    text = "time [us],lift [mm]\n" + rows(lambda value: f'"{value:,.4f}"', ",", times, np.round(LIFTS, 4))
    run, _ = read(tmp_path, text, '[read]\nthousands = ","\ndecimal = "."')
    assert holds(run, 1e-3 * times, np.round(LIFTS, 4))


def test_decimal_commas_between_commas_without_quotes_are_refused(tmp_path):
    text = '"time [ms]","lift [mm]"\n' + rows(comma, ",")
    assert refused(tmp_path, text) and refused(tmp_path, text, '[read]\ndecimal = ","')


# --- clock times ---


def clocked(form, separator=";", header="time"):
    """A file of clock times half a millisecond apart."""
    cells = [form(number) for number in range(len(LIFTS))]
    lines = "".join(f"{cell}{separator}{y}\n" for cell, y in zip(cells, LIFTS.tolist(), strict=True))
    return f"{header}{separator}lift [mm]\n{lines}"


@pytest.mark.parametrize(
    "form",
    [
        lambda n: f"2026-03-01 12:00:00.{5 * n:04}",
        lambda n: f"2026-03-01T12:00:00.{5 * n:04}Z",
        lambda n: f"01.03.2026 12:00:00,{5 * n:04}",
        lambda n: f"3/1/2026 12:00:00.{5 * n:04} PM",
        lambda n: f"12:00:00.{5 * n:04}",
        lambda n: f"00:01.{5 * n:04}",
        lambda n: f"23:59:59.{9980 + 5 * n}" if n < 4 else f"00:00:00.{5 * (n - 4):04}",
        lambda n: f"2026-02-28 23:59:59.{9980 + 5 * n}" if n < 4 else f"2026-03-01 00:00:00.{5 * (n - 4):04}",
    ],
)
@pytest.mark.parametrize("header", ["time", "time [s]", "time [hh:mm:ss]"])
def test_clock_times_are_counted_from_the_first_row(tmp_path, form, header):
    run, hints = read(tmp_path, clocked(form, header=header), '[read]\nstart = "1 ms"\n')
    assert holds(run, 0.5 * np.arange(12) - 1.0)
    assert "a.csv: time: clock times are read as seconds since the first row" in hints


@pytest.mark.parametrize(
    ("form", "about", "words"),
    [
        (lambda n: f"12:00:00.{n:04}", "", "time: is counted from the first row, and the command may be at any"),
        (lambda n: f"12:00:00.{n:04}", "[read]\nunit.time = 'ms'", "holds clock times, and its unit is 'ms'"),
        (lambda n: f"12:00:00.{n:04}", "[read]\nscale.time = '2 ms'", "holds clock times, which are neither scaled"),
        (lambda n: f"12:00:0{n % 2}", "", "time: does not rise in row 3"),
        (lambda n: f"3/{1 + n // 5}/26 12:00:00.{n:04}", "", "the date changes in '3/2/26 12:00:00.0005'"),
        (lambda n: f"2026-02-30 12:00:00.{n:04}", "", "there is no such day as in '2026-02-30 12:00:00.0000'"),
        (lambda n: f"25:00:00.{n:04}", "", "line 2: '25:00:00.0000' is no clock time"),
        (lambda n: "12:00", "", "line 2: '12:00' is no clock time; give hours, minutes and seconds"),
    ],
)
def test_clock_times_that_have_no_one_meaning_are_refused(tmp_path, form, about, words):
    assert any(words in line for line in refused(tmp_path, clocked(form), about))


# --- columns by number ---


def test_columns_are_numbered_beside_names_that_are_numbers(tmp_path):
    text = "time;1;2\n" + rows(str, ";", end=";7\n")
    about = '[read]\ncolumns = { time = 1, lift = 2 }\nignore = [3]\nunit.time = "ms"\nunit.lift = "mm"'
    run, _ = read(tmp_path, text, about)
    assert holds(run)


def test_a_header_of_numbers_is_asked_for(tmp_path):
    text = "1;2\n" + rows(str, ";")
    about = '[read]\ncolumns = { time = 1, lift = 2 }\nunit.time = "ms"\nunit.lift = "mm"\n'
    [line] = refused(tmp_path, text, about)
    assert "write header = false" in line and "with skip_rows = 1 if line 1 is a header of numbers" in line
    run, _ = read(tmp_path, text, f"{about}header = false\nskip_rows = 1\n")
    assert holds(run)


def test_columns_are_numbered_among_equal_names(tmp_path):
    text = "time [ms];lift [mm];lift [mm]\n" + "".join(
        f"{t};99;{y}\n" for t, y in zip(TIMES.tolist(), LIFTS.tolist(), strict=True)
    )
    [line] = refused(tmp_path, text)
    assert "lift: stands in several columns; keep one of them, or write ignore = [3] in [read]" in line
    for said in ("columns.lift = 3", "ignore = [2]"):
        run, _ = read(tmp_path, text, f"[read]\n{said}")
        assert holds(run)
