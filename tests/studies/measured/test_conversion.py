"""Numbers of a file to SI: by their unit, and by the scale and offset of a sensor."""

from pathlib import Path

import numpy as np
import pytest

from apesim.quantities import InputError
from apesim.studies.measured import read_measured
from tests.machines import AMBIENT

TIMES = np.arange(-2.0, 10.0)
"""Times of the rows [ms]."""
SIGNALS = 0.5 + 0.25 * np.arange(12)
"""What the sensor gives."""
BARS = 2.5 * (SIGNALS - 0.5)
"""Pressure above ambient that a transducer of 0.5 to 4.5 V for 0 to 10 bar means [bar]."""


def read(folder, header, values, about, times=TIMES):
    """The run of a folder with one file of two columns."""
    rows = "".join(f"{t},{y}\n" for t, y in zip(times.tolist(), values.tolist(), strict=True))
    Path(folder, "a.csv").write_text(f"{header}\n{rows}", encoding="utf-8")
    run = '[[run]]\ndata = "a.csv"\nsupply = "0.40 MPa gauge"\npulse = "50 ms"\n'
    Path(folder, "measured.toml").write_text(f'bench = "valve"\n[read]\n{about}\n{run}', encoding="utf-8")
    return read_measured(folder, AMBIENT).runs[0]


def refused(folder, *arguments):
    """The only line of a refusal, less the path of the folder."""
    with pytest.raises(InputError) as caught:
        read(folder, *arguments)
    return str(caught.value).replace(f"{folder}/", "")


TRANSDUCER = 'scale.pressure_a = "2.5 bar/V"\noffset.pressure_a = "-1.25 bar gauge"\n'


@pytest.mark.parametrize(
    ("header", "values", "about"),
    [
        ("time [ms],pressure_a [V]", SIGNALS, TRANSDUCER),
        ("time [ms],pressure_a [mV]", 1e3 * SIGNALS, TRANSDUCER),
        ("time [ms],p [V]", SIGNALS, f'{TRANSDUCER}columns.pressure_a = "p"'),
        ("time [ms],CH2", SIGNALS, f'{TRANSDUCER}columns.pressure_a = "CH2"\nunit.pressure_a = "V"'),
        ("time [ms],pressure_a [bar gauge]", 2.0 * BARS, "scale.pressure_a = 0.5"),
        ("time [ms],pressure_a [bar gauge]", BARS - 0.25, 'offset.pressure_a = "25 kPa"'),
        (
            "time [ms],pressure_a [mA]",
            4.0 + 1.6 * BARS,
            f'scale.pressure_a = "0.625 bar/mA"\noffset.pressure_a = "{-2.5 + AMBIENT / 1e5} bar abs"',
        ),
        ("time [ms],pressure_a [V]", BARS, 'unit.pressure_a = "bar gauge"\nscale.pressure_a = 1'),
    ],
)
def test_a_pressure_is_what_the_sheet_of_the_sensor_says(tmp_path, header, values, about):
    run = read(tmp_path, header, values, about)
    assert run.channels["pressure_a"] == pytest.approx(AMBIENT + 1e5 * BARS, abs=1e-3)


@pytest.mark.parametrize(
    ("header", "values", "about"),
    [
        ("time [ms],lift [V]", SIGNALS, 'scale.lift = "2 mm/V"\noffset.lift = "-1 mm"'),
        ("time [ms],lift [V]", SIGNALS - 0.5, 'scale.lift = "2 mm/V"'),
        ("time [ms],lift [mm]", 9.0 - 2.0 * (SIGNALS - 0.5), 'scale.lift = -1\noffset.lift = "9 mm"'),
        ("time [ms],counts", 200.0 * (SIGNALS - 0.5), 'columns.lift="counts"\nunit.lift = "-"\nscale.lift = "10 um"'),
    ],
)
def test_a_lift_is_what_the_sheet_of_the_sensor_says(tmp_path, header, values, about):
    run = read(tmp_path, header, values, about)
    assert run.channels["lift"] == pytest.approx(2e-3 * (SIGNALS - 0.5), abs=1e-9)


@pytest.mark.parametrize(("start", "first"), [("command", 0.0), ("first row", 0.0), ("0.4 ms", -4e-4)])
def test_sample_numbers_become_times(tmp_path, start, first):
    about = 'columns.time = "Sample"\nunit.time = "-"\nscale.time = "0.2 ms"\n'
    run = read(tmp_path, "Sample,lift [mm]", SIGNALS, f'{about}start = "{start}"', np.arange(12))
    assert run.times == pytest.approx(first + 2e-4 * np.arange(12), abs=1e-12)
    line = refused(tmp_path, "Sample,lift [mm]", SIGNALS, about, np.arange(12))
    assert line == (
        "a.csv: time: is made of other numbers by its scale, and the command may be at any of them; "
        'write in [read] start = "command" if it is at 0, start = "first row", or its time, e.g. "12.5 ms"'
    )


def test_a_temperature_has_a_zero_at_no_volts(tmp_path):
    about = 'scale.temperature_a = "100 K/V"\noffset.temperature_a = "-50 degC"'
    run = read(tmp_path, "time [ms],temperature_a [V]", SIGNALS, about)
    assert run.channels["temperature_a"] == pytest.approx(273.15 - 50.0 + 100.0 * SIGNALS)


def test_the_transducer_of_the_guide_is_read(tmp_path):
    page = (Path(__file__).parents[3] / "docs" / "guide" / "measured_data.md").read_text(encoding="utf-8")
    block = page.split("### Sensors that give volts")[1].split("```toml\n[read]\n")[1].split("```")[0]
    run = read(tmp_path, "time [ms],CH2", SIGNALS, block)
    assert run.channels["pressure_a"] == pytest.approx(AMBIENT + 1e5 * BARS, abs=1e-3)


SHEET = (
    "write in [read] what the sheet of the sensor says, e.g. "
    'scale.{0} = "2 {1}/V" and offset.{0} = "-1 {1}{2}", or "{0} [{1}{3}]" in the header if the unit is wrong'
)


@pytest.mark.parametrize(
    ("header", "about", "line"),
    [
        ("lift [V]", "", f"a.csv: lift: 'V' is no unit of lift; {SHEET.format('lift', 'mm', '', '')}"),
        (
            "pressure_a [V]",
            "",
            f"a.csv: pressure_a: 'V' is no unit of pressure_a; {SHEET.format('pressure_a', 'kPa', ' gauge', ' abs')}",
        ),
        (
            "lift [V]",
            'unit.lift = "mm"',
            "a.csv: lift: the header says 'V', unit.lift says 'mm'; write scale.lift = \"2 mm/V\" and offset.lift in "
            "place of unit.lift, or scale.lift = 1 beside it if the header is wrong",
        ),
        (
            "lift",
            'unit.lift = "5 um"',
            "a.csv: lift: '5 um' is no known unit; "
            'write scale.lift = "5 um" and unit.lift = "-" in [read] if a count of 1 is as much',
        ),
        (
            "pressure_a [V]",
            'scale.pressure_a = "2.5 bar/V"',
            "a.csv: pressure_a: is scaled to a pressure, and no offset says gauge or abs; "
            'write what 0 V stands for, e.g. offset.pressure_a = "-1 kPa gauge"',
        ),
        (
            "pressure_a [V]",
            'scale.pressure_a = "0.4 V/bar"',
            "a.csv: pressure_a: 'V' times 'V/bar' is no unit of pressure_a; unit.pressure_a is that of the file, "
            'before the scale, e.g. "V" with scale.pressure_a = "2 kPa/V"',
        ),
        (
            "pressure_a [V]",
            'scale.pressure_a = "2.5 bar/V"\noffset.pressure_a = "0.5 V"',
            "a.csv: pressure_a: an offset in 'V' is no value of pressure_a; "
            'write what 0 V stands for, e.g. offset.pressure_a = "-1 kPa gauge"',
        ),
        (
            "lift [V]",
            'scale.lift = "2 mm/V"\noffset.lift = "1 mm gauge"',
            "a.csv: lift: an offset of lift is neither gauge nor abs; "
            'write what 0 V stands for, e.g. offset.lift = "-1 mm"',
        ),
        (
            "pressure_a [bar gauge]",
            'offset.pressure_a = "1 bar abs"',
            "a.csv: pressure_a: an offset in 'bar abs' is no difference; "
            'write a difference with its unit, e.g. offset.pressure_a = "0.1 kPa"',
        ),
        (
            "temperature_a [degC]",
            "scale.temperature_a = 1.1",
            "a.csv: temperature_a: 'degC' has a zero of its own: its scale is not clear; scale what the sensor gives",
        ),
        (
            "lift [mm]",
            'scale.lift = "two"',
            "measured.toml: read.scale.lift: 'two' is no finite number with a unit; write it like \"2 mm/V\"",
        ),
        (
            "lift [mm]",
            "scale.lift = 0",
            'measured.toml: read.scale.lift: 0 is no factor; write it like "2 mm/V"',
        ),
        (
            "lift [mm]",
            'offset.lift = "1 furlong"',
            "measured.toml: read.offset.lift: 'furlong' is no known unit; write it like \"-1 mm\"",
        ),
        ("lift [mm]", "scale = 2", 'measured.toml: read.scale: 2 is no table; write scale.lift = "2 mm/V"'),
        (
            "lift [mm]",
            'offset.lfit = "1 mm"',
            "measured.toml: read.offset.lfit: unknown key; did you mean lift?",
        ),
    ],
)
def test_what_a_scale_cannot_be_is_told(tmp_path, header, about, line):
    assert refused(tmp_path, f"time [ms],{header}", SIGNALS, about) == line
