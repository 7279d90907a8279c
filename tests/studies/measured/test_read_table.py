"""Table ``[read]`` of a file that was guessed: put into ``measured.toml`` it reads the same numbers, bit for bit."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from apesim.quantities import InputError
from apesim.studies.measured import read_measured
from tests.machines import AMBIENT
from tests.studies.measured.test_dialects import ABOUT, DATA, LIFTS, TIMES, VESSEL, comma, rows, written
from tests.studies.measured.test_laboratory_files import SAID, clocked, lvm, table

ENGINE = """bench = "engine"
{read}
[[run]]
data = "a.csv"
supply = "1 MPa gauge"
speed = "600 rpm"
energise = "-10 deg"
release = "70 deg"
"""
VALVE = f'bench = "valve"\n{{read}}\n[[run]]\n{ABOUT}'
O_RING = """[read]
header = false
skip_rows = 15
decimal = "."
columns = { time = 1, lift = 5, pressure_a = 6 }
unit = { time = "ms", lift = "mm", pressure_a = "bar gauge" }
start = "first row"
"""
SCOPE = "Record Length,12\nInterval,5e-4\n\nTIME,CH1,CH2\n" + "".join(
    f"{1e-3 * t:+.6e},{y:.6e},{0.1:.2e}\n" for t, y in zip(TIMES, LIFTS, strict=True)
)
VOLTS = 'scale.lift = "2 mm/V"\noffset.lift = "-0.3 mm"\nunit.lift = "V"'
FILES = {
    "ours": (VALVE, "time [ms],lift [mm]\n" + rows(str, ","), ""),
    "semicolons": (VALVE, "time [ms];lift [µm]\n" + rows(comma, ";"), ""),
    "latin-1": (VALVE, ("time [ms]\tlift [µm]\r\n" + rows(comma, "\t", end="\t\r\n")).encode("latin-1"), ""),
    "utf-16": (VALVE, ("time [ms]\tlift [mm]\n" + rows(str, "\t")).encode("utf-16"), ""),
    "names": (
        VALVE,
        "Zeit (ms);Weg / mm;Trig\n" + rows(comma, ";", end=";1\n"),
        '[read]\ncolumns = { time = "Zeit", lift = "Weg" }\nignore = ["Trig"]',
    ),
    "second line": (
        VALVE,
        "Time\tA\n(ms)\t(mm)\n\n" + rows(str, "\t"),
        '[read]\ncolumns = { time = "Time", lift = "A" }',
    ),
    "equal names": (VALVE, "time [ms];lift [mm];lift [mm]\n" + rows(str, ";", end=";1\n"), "[read]\nignore = [3]"),
    "quotes": (VALVE, '"time [ms]","lift [mm]"\n' + rows(lambda value: f'"{comma(value)}"', ","), ""),
    "blanks": (VALVE, "time [ms] lift [mm]\n" + rows(lambda value: f"  {value:.7f}", " "), ""),
    "seal": (VALVE, (DATA / "o_ring.csv").read_bytes(), O_RING),
    "vessel": (
        VALVE,
        (DATA / "vessel.csv").read_bytes(),
        f'{VESSEL}decimal = "."\n[read.column.time]\nthousands = "."\ndecimal = ""',
    ),
    "thousands": (
        VALVE,
        "time [us];lift [um]\n" + rows(lambda v: f"{v:,.3f}", ";", 1e3 * TIMES),
        '[read]\nthousands = ","',
    ),
    "thousands of a column": (
        VALVE,
        "time [us];lift [mm]\n" + rows(lambda v: f"{v:.3f}", ";"),
        '[read]\ndecimal = "."\ncolumn.lift.thousands = ","',
    ),
    "labview": (VALVE, lvm("\t", "valve opened"), SAID),
    "scope": (
        VALVE,
        SCOPE,
        '[read]\nskip_rows = 3\nignore_others = true\ncolumns = { time = "TIME", lift = "CH1" }\n'
        'unit = { time = "s", lift = "mm" }',
    ),
    "volts": (VALVE, "time [ms];lift\n" + rows(str, ";"), f"[read]\n{VOLTS}"),
    "clock": (VALVE, clocked(lambda n: f"12:00:00.{5 * n:04}"), '[read]\nstart = "1 ms"'),
    "no times": (
        VALVE,
        "lift [mm]\n" + "".join(f"{y}\n" for y in LIFTS),
        '[read]\nsample_rate = "2 kHz"\nstart = "1 ms"',
    ),
    "over range": (VALVE, table(["OVER", "n.v.", *range(100, 140)]), '[read]\nmissing = ["n.v."]'),
    "remarks": (
        VALVE,
        "time [ms];lift [mm]\n# half\n" + rows(str, ";") + "End \x7f;\n",
        '[read]\nignore_lines = ["#", "End \\u007f"]',
    ),
    "engine": (
        ENGINE,
        "cylinder_pressure [barg]\tcrank_angle [deg]\n" + "".join(f"{i % 90}\t{i},5\n" for i in range(360)),
        "",
    ),
}


def read(folder, toml, data, table):
    """The run of a folder with one file, its hints and its table ``[read]``."""
    Path(folder, "a.csv").write_bytes(data if isinstance(data, bytes) else data.encode())
    Path(folder, "measured.toml").write_text(toml.format(read=table), encoding="utf-8")
    measured = read_measured(folder, AMBIENT)
    return measured.runs[0], measured.hints, measured.read["a.csv"]


def holds_again(folder, toml, data, said):
    """Whether the table that is shown of a file reads the same, and says the same."""
    guessed, _, table = read(folder, toml, data, said)
    pasted, hints, again = read(folder, toml, data, table)
    assert str(again) == str(table) and tomllib.loads(str(table))["read"] == table
    assert not any("read with" in hint for hint in hints)
    assert np.array_equal(pasted.times, guessed.times) and np.array_equal(pasted.angles, guessed.angles)
    assert pasted.channels.keys() == guessed.channels.keys()
    for channel, values in guessed.channels.items():
        assert pasted.channels[channel].tobytes() == values.tobytes()
    return True


@pytest.mark.parametrize("name", FILES)
def test_the_table_that_is_shown_reads_the_same_numbers(tmp_path, name):
    assert holds_again(tmp_path, *FILES[name])


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(written(), st.sets(st.sampled_from(["separator", "decimal", "encoding", "thousands"])))
def test_any_table_that_is_guessed_reads_the_same_again(tmp_path, table, left_out):
    data, said, *_ = table
    said = "\n".join(line for line in said.splitlines() if line.split(" = ")[0] not in left_out)
    try:
        read(tmp_path, VALVE, data, said)
    except InputError:  # what may be read in two ways is refused, not guessed
        return
    assert holds_again(tmp_path, VALVE, data, said)


def test_the_table_has_what_was_said_and_what_was_guessed(tmp_path):
    _, _, table = read(tmp_path, *FILES["names"])
    assert str(table).splitlines() == [
        "[read]",
        'separator = "semicolon"',
        'decimal = ","',
        'encoding = "utf-8"',
        'thousands = ""',
        "skip_rows = 0",
        "header = true",
        'columns.time = "Zeit"',
        'columns.lift = "Weg"',
        'unit.time = "ms"',
        'unit.lift = "mm"',
        'ignore = ["Trig"]',
    ]
