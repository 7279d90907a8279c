"""Measured data: what is good is read in SI, what is wrong is told all at once."""

import os
import re

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.execution.output import write_traces
from apesim.studies.measured import VALVE, read_measured
from apesim.studies.measured.prediction import run_of
from apesim.valve.bench import TRACE, run_bench
from tests.machines import AMBIENT, machine, settled

RUN = '[[run]]\ndata = "a.csv"\nsupply = "0.40 MPa gauge"\ntemperature = "287 K"\npulse = "50 ms"\nrole = "fit"\n'
ENGINE_RUN = """[[run]]
data = "a.csv"
supply = "1.0 MPa gauge"
speed = "600 rpm"
energise = "-10 deg"
release = "70 deg"
"""
ROWS = "".join(f"{0.5 * i},{0.01 * i}\n" for i in range(10))


@pytest.fixture
def folder(tmp_path):
    """Writes files into a folder; returns it."""

    def write(toml, **files):
        (tmp_path / "measured.toml").write_text(toml)
        for name, text in ({"a": f"time [ms],lift [mm]\n{ROWS}"} | files).items():
            (tmp_path / f"{name}.csv").write_text(text)
        return tmp_path

    return write


def faults(folder, bench=None):
    """The lines of what is wrong with a folder, less its path."""
    with pytest.raises(InputError) as caught:
        read_measured(folder, AMBIENT, bench)
    lines = str(caught.value).replace(f"{folder}/", "").splitlines()
    assert len(lines) == len(caught.value.faults)
    return lines


def test_a_folder_is_read_in_si(folder):
    toml = f'bench = "valve"\n[sensor.lift]\nnoise = "0.03 mm"\n[sensor.pressure_a]\nnoise = "2 kPa"\n{RUN}name = "p"\n'
    header = "lift [um],time [s],pressure_a [bar gauge],pressure_b [kPa abs],temperature_a [degC]\n"
    rows = "".join(f"{i},{i}e-3,{i},{100 + i},{i}\n" for i in range(-2, 10))
    measured = read_measured(folder(toml, a=header + rows), AMBIENT)
    [run] = measured.runs
    steps = np.arange(-2, 10)
    assert measured.noise == pytest.approx({"lift": 3e-5, "pressure_a": 2000.0})
    assert (run.name, run.role, run.temperature, run.pulse) == ("p", "fit", 287.0, 0.05)
    assert run.supply == 0.4e6 + AMBIENT
    assert run.times == pytest.approx(steps * 1e-3)
    assert run.channels["lift"] == pytest.approx(steps * 1e-6)
    assert run.channels["pressure_a"] == pytest.approx(steps * 1e5 + AMBIENT)
    assert run.channels["pressure_b"] == pytest.approx(1e5 + steps * 1e3)
    assert run.channels["temperature_a"] == pytest.approx(steps + 273.15)


def test_roles_names_and_temperature_have_defaults(folder):
    toml = 'bench = "valve"\n[[run]]\ndata = "a.csv"\nsupply = "5 bar abs"\npulse = "0.05 s"\n'
    [run] = read_measured(folder(toml), AMBIENT).of("fit")
    assert run.name == "a.csv"
    assert np.isnan(run.temperature)


def test_what_we_write_we_read(folder):
    run = run_bench(machine(supply=0.4), 50e-3, 100e-3)
    where = folder(f'bench = "valve"\n{RUN}')
    write_traces(where / "a.csv", ("time [s]", *TRACE), np.column_stack((run.times, run.trace)))
    [read] = read_measured(where, AMBIENT).runs
    assert np.array_equal(read.times, run.times)
    for column, header in enumerate(TRACE):
        assert np.array_equal(read.channels[header.split(" [")[0]], run.trace[:, column])


def test_every_fault_is_told_at_once(folder):
    toml = """
bench = "valv"
colour = "red"
[sensor.lfit]
[sensor.lift]
noise = "0.03"
nose = 1
[[run]]
data = "a.csv"
supply = "0.40 MPa"
pulse = 50
role = "train"
pules = "50 ms"
[[run]]
data = "b.csv"
name = ""
"""
    lines = faults(folder(toml, a="time [ms],lft [mm]\n1,2\n"))
    assert lines == [
        "measured.toml: colour: unknown key; valid here: bench, sensor, known_to, scatter, run, read",
        'measured.toml: bench: \'valv\' is no bench known here; write bench = "valve", "engine" or "cylinder"',
        "measured.toml: sensor.lfit: unknown key; did you mean lift?",
        "measured.toml: sensor.lift.nose: unknown key; did you mean noise?",
        lines[4],
        "measured.toml: run 1.pules: unknown key; did you mean pulse?",
        "measured.toml: run 1.supply: '0.40 MPa' says neither gauge nor abs; "
        'write "0.40 MPa gauge" or "0.40 MPa abs"',
        lines[7],
        'measured.toml: run 1.role: \'train\' is no option; write "fit", "gate" or "check"',
        "a.csv: lft: unknown column; did you mean lift?",
        'a.csv: no column of a sensor; name one in the header, e.g. "lift [mm]"',
        'measured.toml: run 2.supply: is not given; write supply = "0.4 MPa gauge"',
        'measured.toml: run 2.pulse: is not given; write pulse = "50 ms"',
        "measured.toml: run 2.name: '' is no text; write name = \"p040\"",
        lines[14],
    ]
    assert lines[4].startswith("measured.toml: sensor.lift.noise: '0.03' has no unit; ")
    assert lines[7].startswith("measured.toml: run 1.pulse: 50 has no unit; ")
    assert re.fullmatch(
        "measured.toml: run 2.data: there is no file '.*b.csv'; write data = \"p040.csv\", its path from the folder",
        lines[14],
    )


def test_a_name_of_a_data_file_that_the_system_cannot_have_is_named(folder):
    [line] = faults(folder('bench = "valve"\n' + RUN.replace("a.csv", "a" * 300)))
    assert line.startswith("measured.toml: run 1.data: ") and "cannot be read: File name too long" in line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "time,lift [mm]\n" + ROWS,
            'a.csv: time: has no unit; write "time [ms]" in the header or unit.time = "ms" in [read]',
        ),
        (
            "time [ms],lift [bar]\n" + ROWS,
            'a.csv: lift: \'bar\' is no unit of lift; write "lift [mm]" in the header or unit.lift = "mm" in [read]',
        ),
        (
            "time [ms],pressure_a [kPa]\n" + ROWS,
            "a.csv: pressure_a: 'kPa' says neither gauge nor abs; write \"pressure_a [kPa abs]\" in the header "
            'or unit.pressure_a = "kPa abs" in [read], or gauge',
        ),
        (
            "time [ms],lift [mm]\n0,1\n1,one\n",
            "a.csv: lift: 'one' in line 3 is no finite number; give a number in every cell, "
            'or write missing = ["one"] in [read] if it stands for a missing one',
        ),
        (
            "time [ms],lift [mm]\n0,nan\n1,nan\n",
            'a.csv: no column of a sensor; name one in the header, e.g. "lift [mm]"',
        ),
        ("time [ms],lift [mm]\n0,1e999\n", "a.csv: lift: row 1 is too large, not finite; give finite numbers"),
        ("time [ms],lift [mm]\n1,1\n1,2\n", "a.csv: time: does not rise in row 2; sort the rows, one of equals"),
        (
            "time [ms],lift [mm],lift [m]\n" + ROWS.replace("\n", ",1\n"),
            "a.csv: lift: stands in several columns; keep one of them, or write ignore = [3] in [read]",
        ),
        (
            "time [ms],lift [mm],Trigger\n" + ROWS.replace("\n", ",1\n"),
            "a.csv: Trigger: unknown column; valid here: time, lift, velocity, pressure_a, pressure_b, temperature_a, "
            "temperature_b, or name it in columns or in ignore of [read], or set ignore_others = true",
        ),
        (
            "lift [mm]\n1\n",
            'a.csv: time: there is no such column; write "time [ms]" in the header, '
            'or in [read] columns.time = "the header that it has", '
            'or sample_interval = "0.02 ms" if the file has no times',
        ),
        (
            "time [ms],lift [mm]\n0,1\n1,2\n",
            "a.csv: time: 2 rows up to 1 ms; give at least 8 rows, some after t = 0, when the solenoids are energised",
        ),
    ],
)
def test_a_wrong_csv_is_told(folder, text, line):
    assert faults(folder(f'bench = "valve"\n{RUN}', a=text)) == [line]


@pytest.mark.parametrize(
    ("toml", "starts"),
    [
        ("bench = ", "measured.toml: end of document: no TOML: "),
        ('bench = "valve', 'measured.toml: line 1: bench has no closing quote; write bench = "valve"'),
        (
            'bench = "valve"\nbench = "engine"',
            "measured.toml: line 2: bench stands twice, first in line 1; keep one of them",
        ),
        ('bench = "valve"\nrun = 3\n', "measured.toml: run: no list of runs; "),
        (
            'bench = "motor"\n' + RUN,
            "measured.toml: bench: 'motor' is no bench known here; write bench = \"valve\", ",
        ),
        ('bench = "engine"\n' + RUN, "measured.toml: run 1.pulse: unknown key; valid here: data, name, supply, "),
        (f'bench = "valve"\nsensor = 1\n{RUN}', "measured.toml: sensor: 1 is no table; write [sensor.lift]"),
        (f'bench = "valve"\nsensor.lift = 1\n{RUN}', "measured.toml: sensor.lift: 1 is no table; "),
        (f'bench = "valve"\n{RUN.replace("a.csv", " ")}', "measured.toml: run 1.data: ' ' is no text; "),
    ],
)
def test_a_wrong_file_is_told(folder, toml, starts):
    assert faults(folder(toml))[0].startswith(starts)


def test_a_folder_without_the_file_is_told(tmp_path):
    [line] = faults(tmp_path)
    assert line.endswith("give a folder with measured.toml and the CSV files that it names")


# --- an engine's bench ---


def test_an_engines_folder_is_read_in_si(folder):
    noise = '[sensor.torque]\nnoise = "0.5 N m"\n[sensor.cylinder_pressure]\nnoise = "0.1 bar"\n'
    means = 'torque = "-3 N m"\nair_flow = "12 g/s"\ntemperature = "300 K"\nrole = "check"\nname = "n"\n'
    header = "cylinder_pressure [bar gauge],crank_angle [deg],receiver_pressure [kPa abs],lift [mm]\n"
    rows = "".join(f"{i},{i - 46},{i},{i}\n" for i in range(360))
    measured = read_measured(folder(f'bench = "engine"\n{noise}{ENGINE_RUN}{means}', a=header + rows), AMBIENT)
    [run] = measured.runs
    steps = np.arange(360)
    assert measured.bench == run.bench == "engine"
    assert measured.noise == pytest.approx({"torque": 0.5, "cylinder_pressure": 1e4})
    assert (run.name, run.role, run.temperature, run.supply) == ("n", "check", 300.0, 1e6 + AMBIENT)
    assert (run.speed, run.energise, run.release) == pytest.approx((20.0 * np.pi, -np.pi / 18.0, 7.0 * np.pi / 18.0))
    assert np.isnan(run.pulse)
    assert run.angles == pytest.approx(np.radians(steps - 46))
    assert run.times == pytest.approx((steps - 36) / 3600.0)  # 3600 degrees a second
    assert run.means == pytest.approx({"torque": -3.0, "air_flow": 12e-3})
    assert run.channels["cylinder_pressure"] == pytest.approx(AMBIENT + steps * 1e5)
    assert run.channels["receiver_pressure"] == pytest.approx(steps * 1e3)
    assert run.channels["lift"] == pytest.approx(steps * 1e-3)


@pytest.mark.parametrize(
    ("said", "stated", "control"),
    [("", "", 1.0e6), ("", "6 bar gauge", 0.6e6), ("5 bar gauge", "", 0.5e6), ("5 bar gauge", "6 bar gauge", 0.5e6)],
)
def test_the_control_air_of_an_engines_run_is_as_it_says_else_as_the_machine_does(folder, said, stated, control):
    line = f'control_supply = "{said}"\n' if said else ""
    text = f'bench = "engine"\n{ENGINE_RUN}{line}torque = "31.2 N m"\n'.replace('data = "a.csv"\n', "")
    [run] = read_measured(folder(text), AMBIENT).runs
    supply = run_of(Machine().with_(supply_control_pressure=stated), run).supply
    assert (supply.pressure, supply.control().pressure) == (1e6 + AMBIENT, control + AMBIENT)


def test_the_supply_of_a_valves_run_is_its_control_air(folder):
    [run] = read_measured(folder(f'bench = "valve"\n{RUN}'), AMBIENT).runs
    assert (
        run_of(Machine().with_(supply_control_pressure="6 bar gauge"), run).supply.control().pressure == 0.4e6 + AMBIENT
    )


def test_an_engines_run_may_have_means_alone(folder):
    text = f'bench = "engine"\n{ENGINE_RUN}torque = "31.2 N m"\n'.replace('data = "a.csv"\n', "")
    [run] = read_measured(folder(text), AMBIENT).runs
    assert (run.name, run.data, run.means) == ("run 1", "", {"torque": 31.2})
    assert len(run.times) == len(run.angles) == len(run.channels) == 0


@pytest.mark.parametrize("intake", ["epv", "cam"])
def test_what_an_engine_run_writes_we_read(folder, apesim, intake):
    where = folder(f'bench = "engine"\n{ENGINE_RUN}')
    code, _, _ = apesim("engine", "run", "--speed", "600 rpm", "--set", f"engine.intake={intake}", "--csv", "a.csv")
    assert code == 0
    [read] = read_measured(where, AMBIENT).runs
    run = settled(machine(intake, supply=1.0, receiver=1.0), 600.0)
    assert read.angles == pytest.approx(run.angles, abs=1e-15)
    assert np.array_equal(read.channels["cylinder_pressure"], run.trace[:, 0])
    valve = {"velocity", "pressure_a", "pressure_b"}
    others = {"cylinder_pressure", "cylinder_temperature", "lift", "receiver_pressure"}
    assert read.channels.keys() == others | (valve if intake == "epv" else set())


def test_every_fault_of_an_engines_folder_is_told_at_once(folder):
    toml = """
bench = "engine"
[sensor.troque]
[sensor.air_flow]
noise = "1 kg"
[[run]]
data = "a.csv"
supply = "1 MPa abs"
speed = "600 K"
energise = "70 deg"
release = "70 deg"
pulse = "50 ms"
[[run]]
supply = "1 MPa abs"
speed = "600 rpm"
energise = "-5 deg"
"""
    lines = faults(folder(toml, a="crank_angle [deg],time [ms],lift [mm]\n1,1,1\n1,1,1\n"))
    assert [line.partition("; ")[0] for line in lines] == [
        "measured.toml: sensor.troque: unknown key",
        "measured.toml: sensor.air_flow.noise: '1 kg': 'kg' cannot be converted to g/s",
        "measured.toml: run 1.pulse: unknown key",
        "measured.toml: run 1.speed: '600 K': 'K' cannot be converted to rpm",
        "measured.toml: run 1.release: release at 70 deg is no later than energise at 70 deg",
        "a.csv: time: unknown column",
        "a.csv: crank_angle: does not rise in row 2",
        "measured.toml: run 2.release: is not given",
        "measured.toml: run 2: nothing is measured",
    ]
    assert lines[-1].endswith('write data = "p040.csv", torque = "31.2 N m" or air_flow = "12.3 g/s"')


def test_a_record_of_few_angles_is_told(folder):
    text = "crank_angle [deg],lift [mm]\n1,1\n2,1\n"
    assert faults(folder(f'bench = "engine"\n{ENGINE_RUN}', a=text)) == [
        "a.csv: crank_angle: 2 rows; give at least 8 rows"
    ]


def test_a_bench_that_a_command_does_not_take_is_told_in_one_line(folder, apesim):
    where = folder(f'bench = "engine"\ncolour = "red"\n{ENGINE_RUN}')
    told = "bench: is the engine's; this command takes the valve's alone; give a folder with bench = \"valve\""
    assert faults(where, VALVE) == [f"measured.toml: {told}"]
    code, out, err = apesim("valve", "fit", str(where), "--free", "valve.viscous_friction")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert told in err


SECRET = "root:x:0:0:root:/root:/bin/bash"


@pytest.mark.parametrize("name", ["../secret.csv", "link.csv", "links/secret.csv", "{outside}/secret.csv", "loop.csv"])
def test_a_folder_reads_nothing_outside_of_itself(folder, tmp_path_factory, name):
    outside = tmp_path_factory.mktemp("outside")
    where = folder(f'bench = "valve"\n{RUN}'.replace("a.csv", name.format(outside=outside)))
    for secret in (outside / "secret.csv", where.parent / "secret.csv"):
        secret.write_text(f"time [ms],lift [mm]\n{ROWS}")
    (where / "link.csv").symlink_to(outside / "secret.csv")
    (where / "links").symlink_to(outside)
    (where / "loop.csv").symlink_to("loop.csv")
    [line] = faults(where)
    assert line.startswith("measured.toml: run 1.data: ") and "leads out of the folder; put the file into" in line


@pytest.mark.parametrize("name", [".", "more"])
def test_a_folder_in_place_of_a_file_is_refused_with_its_key(folder, name):
    where = folder(f'bench = "valve"\n{RUN}'.replace("a.csv", name))
    (where / "more").mkdir()
    assert faults(where) == [f"measured.toml: run 1.data: '{name}' is a folder; give the path of a file"]


def test_a_folder_reached_by_a_link_is_read_with_all_below_it(folder, tmp_path_factory):
    where = folder(f'bench = "valve"\n{RUN}'.replace("a.csv", "runs/../runs/b.csv"))
    (where / "runs").mkdir()
    (where / "runs" / "b.csv").symlink_to("../a.csv")
    link = tmp_path_factory.mktemp("links") / "link"
    link.symlink_to(where)
    assert len(read_measured(link, AMBIENT).runs) == 1


@pytest.mark.parametrize("text", [f"{SECRET}\n{SECRET[:-3]}\n", f"[{SECRET}]\n1\n", f"{SECRET},hunter2\n1,2\n"])
def test_no_line_of_a_file_that_is_no_data_is_shown(folder, text):
    [line] = faults(folder(f'bench = "valve"\n{RUN}', a=text))
    assert "line 1 is no header with names and units" in line
    assert "root" not in line and "hunter2" not in line


def test_a_folders_file_that_is_a_link_out_of_it_is_not_read(tmp_path, tmp_path_factory):
    secret = tmp_path_factory.mktemp("outside") / "secret.toml"
    secret.write_text('password = "hunter2"\n')
    (tmp_path / "measured.toml").symlink_to(secret)
    [line] = faults(tmp_path)
    assert "leads out of the folder" in line and "password" not in line


@pytest.mark.parametrize("name", ["measured.toml", "a.csv"])
def test_a_pipe_in_a_folder_is_refused_at_once(folder, name):
    where = folder(f'bench = "valve"\n{RUN}')
    (where / name).unlink()
    os.mkfifo(where / name)
    [line] = faults(where)
    assert line.startswith("measured.toml") and name in line


def test_more_runs_than_are_read_are_refused_before_any_file_is(folder):
    where = folder('bench = "valve"\n' + '[[run]]\ndata = "none.csv"\n' * 20_000)
    [fault] = faults(where)
    assert "run: 20000 runs, more than the 1000 that are read; share them out over folders" in fault
