"""The command line as a user meets it: exit codes, one line per fault, JSON and nothing else."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import warnings
from importlib.metadata import version
from pathlib import Path

import numba
import numpy as np
import pytest

from apesim.archive import write
from apesim.archive.inspection import info as archive_info
from apesim.studies.terminal.console import Console
from tests.archive_samples import sample
from tests.folders import ROOT
from tests.processes import ENVIRONMENT

FAST = ["--speed", "800 rpm, 1000 rpm", "--intake", "cam,ideal"]


PROMISED = """
speed_rpm indicated_torque_Nm brake_torque_Nm indicated_power_W brake_power_W imep_Pa engine_air_kg_per_cycle
control_air_kg_per_cycle specific_air_kg_per_kWh specific_engine_air_kg_per_kWh indicated_specific_air_kg_per_kWh
air_L_per_min_ANR exergy_efficiency isothermal_efficiency isentropic_efficiency full_admission_efficiency valve_open_deg
valve_close_deg full_open_deg closed_deg peak_lift_m opening_seating_speed_m_s closing_seating_speed_m_s
peak_cylinder_pressure_Pa lowest_cylinder_temperature_K exhaust_temperature_K
fluctuation exergy_J_per_cycle converged period_cycles cycles closure wall_time_s warnings
""".split()


def test_engine_run_gives_every_promised_key_as_one_json_object(apesim):
    code, out, _ = apesim("engine", "run", "--speed", "1000 rpm", "--json")
    data = json.loads(out)
    assert code == 0
    assert set(PROMISED) <= set(data)
    assert data["speed_rpm"] == 1000.0
    assert data["converged"] is True
    assert 0.0 <= data["closure"]["mass"] < 1e-6 and 0.0 <= data["closure"]["energy"] < 1e-6
    assert 0.0 < data["wall_time_s"] < 60.0


def test_a_ratio_over_work_that_is_not_positive_is_null_with_a_warning(apesim):
    code, out, err = apesim("engine", "run", "--speed", "2000 rpm", "--json")
    data = json.loads(out)
    assert code == 0
    assert data["brake_torque_Nm"] < 0.0
    assert data["specific_air_kg_per_kWh"] is None and data["exergy_efficiency"] is None
    assert data["full_open_deg"] is None
    assert any("not positive" in warning for warning in data["warnings"])
    assert "not positive" in err


def test_engine_traces_have_the_promised_columns_and_fit_the_result(apesim):
    _, out, _ = apesim("engine", "run", "--speed", "1000 rpm", "--json", "--csv", "traces.csv")
    with open("traces.csv", newline="") as file:
        header, *rows = csv.reader(file)
    promised = (
        "crank_angle [deg],cylinder_pressure [Pa abs],cylinder_temperature [K],lift [m],velocity [m/s],"
        "pressure_a [Pa abs],pressure_b [Pa abs],groove_flow [kg/s],torque [N m]"
    )
    assert header[:9] == promised.split(",")
    table = np.array(rows, dtype=float)
    mean_torque = np.trapezoid(table[:, 8], table[:, 0]) / 360.0
    assert mean_torque == pytest.approx(json.loads(out)["indicated_torque_Nm"], rel=1e-4)


def test_valve_run_gives_the_papers_measures_and_its_traces(apesim):
    code, out, _ = apesim(
        "valve", "run", "--supply", "0.4 MPa gauge", "--temperature", "287 K", "--json", "--csv", "v.csv"
    )
    data = json.loads(out)
    assert code == 0
    assert data["opening"]["delay_s"] == pytest.approx(5.59512e-3, rel=2e-5)
    assert data["closing"]["seating_speed_m_s"] == pytest.approx(1.35425, rel=2e-5)
    assert set(data["closing"]) >= {"delay_s", "stroke_time_s", "seating_speed_m_s", "fluctuation"}
    assert data["control_air_kg"] > 0.0 and data["closure"]["mass"] < 1e-9
    header = Path("v.csv").read_text().splitlines()[0]
    assert header == (
        "time [s],lift [m],velocity [m/s],pressure_a [Pa abs],pressure_b [Pa abs],temperature_a [K],temperature_b [K]"
    )


def test_a_repeated_pulse_is_brought_to_its_periodic_state(apesim):
    code, out, _ = apesim("valve", "run", "--pulse", "25 ms", "--repeat", "20 Hz", "--json")
    data = json.loads(out)
    assert code == 0 and data["converged"] and data["period_cycles"] == 1
    for name in ("delay_s", "stroke_time_s", "seating_speed_m_s"):
        assert data["opening"][name] == pytest.approx(data["closing"][name], rel=1e-6)


def test_a_pulse_too_short_to_open_is_told(apesim):
    code, out, err = apesim("valve", "run", "--pulse", "2 ms", "--json")
    assert code == 0
    assert json.loads(out)["opening"]["stroke_time_s"] is None
    assert "the valve does not open" in err


@pytest.mark.slow
def test_tables_show_a_dash_where_there_is_no_number(apesim):
    _, out, _ = apesim("valve", "run", "--pulse", "2 ms")
    assert "nan" not in out
    assert next(line for line in out.splitlines() if "full stroke time" in line).split()[3:] == ["-", "-", "ms"]
    _, out, _ = apesim(*"valve map --temperature 287K --pulse".split(), "2 ms", "--pressure", "0.4 MPa gauge")
    assert "nan" not in out
    assert next(line for line in out.splitlines() if line.split()[:1] == ["0.4"]).split()[3:] == ["-"] * 5


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["engine", "run", "--speed", "1000"], ["--speed", "no unit", "rpm"]),
        (["engine", "run", "--speed", "1000 mm"], ["--speed", "cannot be converted", "rpm"]),
        (["engine", "run"], ["command line", "--speed", "--help"]),
        (["engine", "rum"], ["command line", "rum", "--help"]),
        (["engine", "run", "--speed", "1000 rpm", "--set", "engine.bore=90"], ["--set", "engine.bore", "mm"]),
        (["engine", "run", "--speed", "1000 rpm", "--set", "engine.bor=90 mm"], ["--set", "engine.bor", "engine.bore"]),
        (["engine", "run", "--speed", "1000 rpm", "--set", "engine.bore"], ["--set", "KEY=VALUE"]),
        (["engine", "run", "--speed", "1000 rpm", "--machine", "no.toml"], ["no.toml"]),
        (["engine", "sweep", "--speed", "300:100:50 rpm"], ["--speed", "300:100:50"]),
        (["engine", "sweep", "--intake", "epv,cams"], ["--intake", "cams", "cam"]),
        (["engine", "sweep", "--shard", "3/2"], ["--shard", "1/4"]),
        (["engine", "sweep", "--jobs", "0"], ["command line", "--jobs"]),
        (["engine", "sweep", "--jobs", "2", "--dask", "tcp://127.0.0.1:1"], ["--jobs", "not for --dask"]),
        (["engine", "sweep", "--dask", "nonsense"], ["--dask", "tcp://127.0.0.1:8786"]),
        (["engine", "sweep", "--timing", "late"], ["--timing", "late", '"corrected"']),
        (["engine", "sweep", "--timing", "corrected", "--intake", "cam"], ["--timing", "add epv to --intake"]),
        (["engine", "sweep", "--speed", "500 rpm, 500 rpm"], ["--speed", "500 r/min is given twice", "once"]),
        (["engine", "sweep", "--vary", "groove.lap"], ["--vary", "KEY=RANGE"]),
        (["engine", "sweep", "--vary", "groove.lapp=1 mm"], ["--vary: groove.lapp", "groove.lap?"]),
        (["engine", "sweep", "--vary", "groove.lap=1:2:1"], ["--vary: groove.lap", "no unit", "mm"]),
        (["engine", "sweep", "--intake", "epv, cam,epv"], ["command line: --intake: epv is given twice", "once"]),
        (["valve", "run", "--supply", "0.4 MPa"], ["command line: --supply:", "gauge", "abs"]),
        (["valve", "run", "--temperature", "9000 K"], ["command line: --temperature:", "150 to 600 K"]),
        (["valve", "run", "--pulse", "50 ms", "--repeat", "30 Hz"], ["--pulse", "period"]),
        (["valve", "run", "--repeat", "30 Hz", "--pulse", "10 ms", "--until", "1 s"], ["--until", "--repeat"]),
        (["archive", "info", "no.h5"], ["no.h5", "no such file"]),
        (["archive", "info", "a" * 300], ["cannot be read: File name too long"]),
        (["measured", "check", "a" * 300], ["measured.toml' cannot be read: File name too long"]),
        (["engine", "sweep", "--out", "a" * 300], ["File name too long", "another name or folder"]),
        (["archive", "diff", "no.h5"], ["command line", "--help"]),
    ],
)
def test_bad_input_ends_with_2_and_one_line_that_tells_the_right_form(apesim, arguments, told):
    code, out, err = apesim(*arguments)
    assert code == 2
    assert out == ""
    assert len(err.strip().splitlines()) == 1
    assert "Traceback" not in err
    for part in told:
        assert part in err


def test_each_culprit_has_its_own_line(apesim):
    Path("m.toml").write_text('[engine]\nbore = 90\nbohr = "1 mm"\n')
    code, _, err = apesim("machine", "--check", "m.toml")
    assert code == 2
    assert sorted(line.split(": ")[1] for line in err.splitlines()) == ["engine.bohr", "engine.bore"]


def test_machine_prints_what_it_reads(apesim):
    code, out, _ = apesim("machine", "--set", "engine.bore=90 mm")
    assert code == 0 and 'bore = "90 mm"' in out
    Path("m.toml").write_text(out)
    assert apesim("machine", "--check", "m.toml")[0] == 0
    assert apesim("machine", "--machine", "m.toml")[1] == out


PROGRAM = [sys.executable, "-c", "from apesim.studies.commands.cli import main; main()"]


def test_the_module_is_the_program_too():
    command = [sys.executable, "-m", "apesim.studies.commands.cli", "machine", "--set", "engine.boar=90 mm"]
    run = subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, check=False)
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr == "--set: engine.boar: unknown key; did you mean engine.bore?\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device is always full here")
@pytest.mark.parametrize("arguments", [["machine"], ["machine", "--json"], ["--help"], ["valve", "run", "--help"], []])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_device_is_told_on_one_line(arguments, unbuffered):
    environment = {**ENVIRONMENT, "PYTHONUNBUFFERED": unbuffered}
    with open("/dev/full", "w") as full:
        run = subprocess.run(
            [*PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, env=environment, check=False
        )
    assert run.returncode == 2
    [line] = run.stderr.splitlines()
    assert line.startswith("standard output: cannot be written")


@pytest.mark.parametrize("arguments", [["machine"], ["machine", "--json"], ["--help"], ["valve", "run", "--quiet"]])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_nobody_listening_any_more_is_no_fault(arguments, unbuffered):
    read, write = os.pipe()
    os.close(read)
    environment = {**ENVIRONMENT, "PYTHONUNBUFFERED": unbuffered}
    run = subprocess.run(
        [*PROGRAM, *arguments], stdout=write, stderr=subprocess.PIPE, text=True, env=environment, check=False
    )
    os.close(write)
    assert (run.returncode, run.stderr) == (0, "")


def with_closed(descriptor, *arguments):
    """A command whose standard output (1) or error (2) is closed."""
    script = f'exec "$@" {descriptor}>&-'
    return subprocess.run(
        ["sh", "-c", script, "sh", *PROGRAM, *arguments], capture_output=True, text=True, env=ENVIRONMENT, check=False
    )


@pytest.mark.parametrize("arguments", [["machine"], ["--help"], ["--version"], ["machine", "--check", "none.toml"]])
def test_a_closed_output_is_told_on_one_line(arguments):
    run = with_closed(1, *arguments)
    assert (run.returncode, run.stdout) == (2, "")
    [line] = run.stderr.splitlines()
    assert line.startswith("standard output: is closed")


def test_where_errors_cannot_be_told_none_goes_to_the_output():
    run = with_closed(2, "machine", "--check", "none.toml")
    assert (run.returncode, run.stdout, run.stderr) == (2, "", "")


ASCII_CASES = (
    ["machine"],
    ["gap", "effects"],
    ["archive", "info", "a.h5"],
    ["archive", "verify", "a.h5"],
    ["--help"],
    ["ü"],
)


@pytest.mark.parametrize("arguments", ASCII_CASES)
@pytest.mark.slow
def test_a_terminal_that_knows_ascii_alone_is_no_fault(tmp_path, arguments):
    """In the locale C the error handler of Python is not the strict one."""
    write(sample(), tmp_path / "a.h5")
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    for environment in (plain, {"LC_ALL": "C", "PYTHONIOENCODING": "ascii"}):
        command = [*PROGRAM, *arguments]
        run = subprocess.run(
            command, cwd=tmp_path, env={**ENVIRONMENT, **environment}, capture_output=True, check=False
        )
        assert run.returncode == (2 if arguments == ["ü"] else 0), run.stderr
        assert (run.stdout + run.stderr).isascii()


def test_what_libraries_warn_of_is_a_message_and_nothing_to_a_quiet_console(capsys):
    for quiet in (False, True):
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            with Console(quiet=quiet).library_warnings():
                warnings.warn("overflow\nin exp", RuntimeWarning, stacklevel=1)
    assert capsys.readouterr().err == "warning: overflow in exp (RuntimeWarning in test_cli.py)\n"


def test_a_quiet_command_says_nothing_of_what_matplotlib_lacks(tmp_path):
    """A glyph, which it warns of, and a folder for its settings, which it logs."""
    shutil.copy(ROOT / "docs" / "examples" / "data" / "discharge" / "p060.csv", tmp_path / "日本.csv")
    command = [*PROGRAM, "valve", "discharge", "日本.csv", "--volume", "100 cm^3", "--out", "c.csv", "--quiet"]
    environment = ENVIRONMENT | {"PYTHONUTF8": "1", "MPLCONFIGDIR": str(tmp_path / "日本.csv")}
    run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, encoding="utf-8")
    assert (run.returncode, run.stderr) == (0, "")


@pytest.mark.parametrize("group", [[], ["valve"], ["engine"], ["archive"]])
def test_a_group_alone_shows_its_help(apesim, group):
    code, out, err = apesim(*group)
    assert (code, err) == (0, "")
    assert out == apesim(*group, "--help")[1]
    assert len(out.splitlines()) > 8


def test_the_version_is_the_packages(apesim):
    assert apesim("--version") == (0, f"apesim {version('apesim')}\n", "")


def test_a_fault_of_ours_ends_with_1(apesim, monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError("broken for the test")

    monkeypatch.setattr("apesim.engine.drivetrain.point.run_steady", broken)
    code, _, err = apesim("engine", "run", "--speed", "1000 rpm")
    assert code == 1 and "fault of ours" in err and "broken for the test" in err


def test_an_interrupt_ends_with_130(apesim, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("apesim.engine.drivetrain.point.run_steady", interrupted)
    assert apesim("engine", "run", "--speed", "1000 rpm") == (130, "", "interrupted\n")


@pytest.mark.skipif(os.name != "posix" or bool(numba.config.DISABLE_JIT), reason="Ctrl-C of POSIX, while compiling")
@pytest.mark.parametrize("command", [["run", "--speed", "1000 rpm"], ["sweep", *FAST, "--jobs", "2"]])
def test_an_interrupt_is_heard_at_once_while_the_model_is_compiled(tmp_path, command):
    run = subprocess.Popen(
        [*PROGRAM, "engine", *command],
        cwd=tmp_path,
        env={**ENVIRONMENT, "APESIM_CACHE_DIR": str(tmp_path / "cache")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert "compiling" in run.stderr.readline()
    time.sleep(1.0)
    run.send_signal(signal.SIGINT)
    start = time.perf_counter()
    _, err = run.communicate(timeout=60)
    assert time.perf_counter() - start < 2.0
    assert run.returncode == 130
    assert err.endswith("interrupted\n") and "Traceback" not in err


@pytest.mark.skipif(os.name != "posix" or bool(numba.config.DISABLE_JIT), reason="Ctrl-C of POSIX, in compiled code")
@pytest.mark.parametrize("later", [0.0, 0.21, 0.43])
def test_an_interrupt_while_it_computes_ends_with_130_whenever_it_comes(tmp_path, later):
    """Raised where compiled code hands on its results, it would crash the process."""
    sweep = [*PROGRAM, "engine", "sweep", "--speed", "300:2400:2 rpm", "--intake", "cam", "--jobs", "1", "--no-figures"]
    run = subprocess.Popen(sweep, cwd=tmp_path, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
    while not any(tmp_path.glob("**/*.h5")):
        time.sleep(0.01)
        assert run.poll() is None
    time.sleep(later)
    run.send_signal(signal.SIGINT)
    _, err = run.communicate(timeout=60)
    assert run.returncode == 130
    assert err.endswith("--resume\ninterrupted\n")


def test_on_a_terminal_a_long_march_shows_the_time_it_has_taken(monkeypatch, capsys):
    monkeypatch.setattr("apesim.studies.terminal.console.PATIENCE", 0.05)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    assert Console().run("at work", lambda n: time.sleep(0.3) or n, 7) == 7
    err = capsys.readouterr().err
    assert "at work" in err and "0:00:00" in err
    assert Console(quiet=True).run("at work", lambda n: time.sleep(0.3) or n, 8) == 8
    assert Console().run("at work", lambda: 9) == 9
    assert capsys.readouterr().err == ""


def test_a_point_that_does_not_converge_ends_with_3(apesim, monkeypatch):
    from apesim.engine.drivetrain import point

    run_steady = point.run_steady
    monkeypatch.setattr(point, "run_steady", lambda machine, speed, **_: run_steady(machine, speed, max_cycles=2))
    code, out, err = apesim("engine", "run", "--speed", "1000 rpm", "--json")
    data = json.loads(out)
    assert code == 3
    assert data["converged"] is False and data["period_cycles"] == 0
    assert "not periodic" in err


def test_an_interrupted_sweep_keeps_what_is_done_and_says_how_to_go_on(apesim, monkeypatch):
    from apesim.studies.sweep import completion
    from apesim.studies.sweep import run as sweep

    monkeypatch.setattr(completion, "SHARD_SECONDS", 0.0)
    compute, calls = sweep.compute, []

    def interrupted(points):
        calls.append(points)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return compute(points)

    monkeypatch.setattr(sweep, "compute", interrupted)
    code, _, err = apesim("engine", "sweep", *FAST, "--no-figures")
    assert code == 130 and "--resume" in err
    assert len(list(Path("sweep.h5.shards").glob("*.h5"))) == 1  # the first call warms up
    code, _, err = apesim("engine", "sweep", *FAST, "--no-figures")
    assert code == 2 and "--resume" in err
    calls.clear()
    monkeypatch.setattr(sweep, "compute", lambda points: calls.append(points) or compute(points))
    assert apesim("engine", "sweep", *FAST, "--no-figures", "--resume")[0] == 0
    assert [len(points) for points in calls[1:]] == [1, 1, 1]
    monkeypatch.setattr(sweep, "compute", compute)
    assert apesim("engine", "sweep", *FAST, "--no-figures", "--out", "whole.h5")[0] == 0
    assert apesim("archive", "diff", "sweep.h5", "whole.h5")[0] == 0


def test_quiet_says_nothing_on_standard_error(apesim):
    code, out, err = apesim("engine", "run", "--speed", "2000 rpm", "--quiet")
    assert code == 0 and err == ""
    assert "brake torque" in out


def test_a_sweep_leaves_an_archive_figures_and_a_table(apesim):
    code, out, _ = apesim("engine", "sweep", *FAST)
    assert code == 0
    assert "800" in out and "cam" in out and "[N m]" in out
    figures = sorted(path.name for path in Path("sweep.figures").iterdir())
    assert figures == [
        f"{n}.{e}" for n in ("cycle_traces", "indicator_diagrams", "torque_and_air") for e in ("pdf", "png")
    ]
    assert not Path("sweep.h5.shards").exists()
    code, out, _ = apesim("archive", "info", "sweep.h5", "--json")
    info = json.loads(out)
    assert info["runs"] == 4 and info["missing_runs"] == []
    assert info["provenance"]["command"].startswith("apesim engine sweep --speed")
    assert apesim("archive", "verify", "sweep.h5")[0] == 0


def test_an_archive_names_the_versions_of_what_computed_it(tmp_path):
    command = ["valve", "map", "--pressure", "0.5 MPa gauge", "--temperature", "287 K"]
    subprocess.run([*PROGRAM, *command, "--no-figures"], cwd=tmp_path, env=ENVIRONMENT, check=True, capture_output=True)
    versions = archive_info(tmp_path / "valve_map.h5")["versions"]
    assert {"apesim", "numpy", "numba", "h5py", "hdf5", "python"} <= versions.keys()


def test_a_point_whose_corrected_timing_is_out_of_reach_is_kept_and_ends_with_3(apesim):
    brief = ["--set", "command.close_target=-4.5 deg", "--speed", "2400 rpm", "--intake", "epv,cam"]
    code, out, err = apesim("engine", "sweep", *brief, "--json", "--no-figures")
    data = json.loads(out)
    assert code == 3
    assert data["runs"] == 3
    [fault] = data["faults"]
    assert "epv corrected, 2400 r/min" in fault and "out of reach" in fault and fault in err


def test_the_default_sweep_compares_fixed_corrected_cam_and_ideal(apesim):
    code, out, _ = apesim("engine", "sweep", "--speed", "1000 rpm", "--json")
    assert code == 0
    assert json.loads(out)["axes"] == {
        "actuation": ["epv", "epv corrected", "cam", "ideal"],
        "speed_rpm": ["1000 r/min"],
    }
    _, out, _ = apesim(
        "engine", "sweep", "--speed", "1000 rpm", "--timing", "corrected", "--no-figures", "--out", "c.h5"
    )
    assert "epv corrected" in " ".join(out.split()) and out.count("epv") == 2


def test_a_table_over_varied_keys_shows_them_with_their_units(apesim):
    varied = ["--vary", "supply.pressure=0.8 MPa gauge, 1 MPa gauge", "--vary", "air.model=ideal,thermally_perfect"]
    code, out, _ = apesim("engine", "sweep", "--speed", "1000 rpm", "--intake", "cam", *varied)
    assert code == 0
    assert "[MPa gauge]" in out
    rows = [line.split()[:3] for line in out.splitlines() if "1000" in line]
    assert rows == [
        ["0.8", "ideal", "1000"],
        ["0.8", "thermally_perfect", "1000"],
        ["1", "ideal", "1000"],
        ["1", "thermally_perfect", "1000"],
    ]
    names = {path.stem for path in Path("sweep.figures").iterdir()}
    assert {"over_supply_pressure", "over_air_model", "torque_and_air"} <= names


def test_a_sweep_does_not_replace_an_archive_unasked(apesim):
    assert apesim("engine", "sweep", *FAST, "--no-figures", "--quiet")[0] == 0
    code, _, err = apesim("engine", "sweep", *FAST, "--no-figures")
    assert code == 2 and "--overwrite" in err
    assert apesim("engine", "sweep", *FAST, "--no-figures", "--overwrite")[0] == 0


def test_archives_that_differ_end_with_3_and_name_what_differs(apesim):
    apesim("engine", "sweep", *FAST, "--no-figures", "--out", "a.h5")
    apesim("engine", "sweep", *FAST, "--no-figures", "--out", "b.h5")
    apesim("engine", "sweep", *FAST, "--no-figures", "--out", "c.h5", "--set", "engine.bore=90 mm")
    code, out, _ = apesim("archive", "diff", "a.h5", "b.h5")
    assert code == 0 and " variables the same, 0 differ" in out
    code, out, _ = apesim("archive", "diff", "a.h5", "c.h5")
    assert code == 3
    assert "largest relative difference" in out and out.index("runs compared") < out.index("engine.bore")
    assert out.index("engine.bore") < out.index("brake_torque_Nm") and "Differences" not in out
    assert len(out.splitlines()) < 40 < len(apesim("archive", "diff", "a.h5", "c.h5", "--all")[1].splitlines())
    code, out, _ = apesim("archive", "diff", "a.h5", "c.h5", "--json")
    data = json.loads(out)
    assert data["variables_same"] > 0 and data["variables_different"] > 10
    names = {row["name"] for row in data["differences"]}
    assert code == 3
    assert {"engine.bore", "brake_torque_Nm"} <= names


def test_a_damaged_archive_ends_with_3(apesim):
    apesim("engine", "sweep", *FAST, "--no-figures")
    path = Path("sweep.h5")
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    assert apesim("archive", "verify", "sweep.h5")[0] == 3


def test_archive_commands_say_whether_an_archive_was_made_with_a_machine(apesim):
    point = ["valve", "map", "--pressure", "0.5 MPa gauge", "--temperature", "287 K", "--no-figures"]
    assert apesim(*point, "--out", "a.h5", "--set", "valve.moving_mass=0.04 kg")[0] == 0
    Path("m.toml").write_text('[valve]\nmoving_mass = "40 g"\n')
    for command in (["info", "a.h5"], ["verify", "a.h5"], ["diff", "a.h5", "a.h5"], ["export", "a.h5", "--out", "csv"]):
        assert apesim("archive", *command, "--machine", "m.toml")[0] == 0
        code, out, _ = apesim("archive", *command, "--machine", "m.toml", "--set", "valve.stroke=8 mm", "--json")
        [*rows] = json.loads(out)["machine_differences"]
        assert code == 3
        assert {tuple(row.values()) for row in rows} == {("a.h5", "valve.stroke", "9 mm", "8 mm")}
        code, out, _ = apesim("archive", *command, "--set", "valve.moving_mass=50 g")
        assert code == 3
        assert "a.h5: machine: valve.moving_mass is '0.04 kg', given '0.05 kg'" in out
    code, out, _ = apesim(*"archive merge a.h5 --out b.h5 --set".split(), "valve.moving_mass=50 g")
    assert code == 3 and "valve.moving_mass" in out
    assert not Path("b.h5").exists()


def test_shards_of_a_sweep_join_to_the_whole(apesim):
    apesim("engine", "sweep", *FAST, "--no-figures", "--out", "whole.h5")
    for part in ("1", "2"):
        assert apesim("engine", "sweep", *FAST, "--no-figures", "--shard", f"{part}/2", "--out", f"{part}.h5")[0] == 0
    code, out, _ = apesim("archive", "merge", "1.h5", "--out", "half.h5", "--json")
    assert code == 3 and json.loads(out)["missing_runs"]
    assert apesim("archive", "merge", "1.h5", "2.h5", "--out", "joined.h5")[0] == 0
    assert apesim("archive", "diff", "whole.h5", "joined.h5")[0] == 0


def test_export_writes_what_a_spreadsheet_reads(apesim):
    apesim("engine", "sweep", *FAST, "--no-figures")
    assert apesim("archive", "export", "sweep.h5", "--out", "csv")[0] == 0
    header = Path("csv/runs.csv").read_text().splitlines()[0]
    assert "brake_torque_Nm [N m]" in header


@pytest.mark.parametrize("command", [["engine", "sweep", *FAST], ["valve", "map"], ["valve", "limit"]])
def test_a_folder_is_no_archive(apesim, command):
    code, _, err = apesim(*command, "--out", ".", "--overwrite")
    assert code == 2 and "is a folder" in err and "Traceback" not in err


def test_an_empty_share_of_the_work_is_told(apesim):
    code, _, err = apesim("engine", "sweep", *FAST, "--shard", "9/9")
    assert code == 2 and "share of the work is empty" in err


def test_a_supply_on_the_command_line_is_not_overruled_by_the_machines_control_pressure(apesim):
    plain = apesim("valve", "run", "--supply", "0.49 MPa gauge", "--json")[1]
    other = apesim(
        *("valve", "run", "--supply", "0.49 MPa gauge", "--json", "--set", "supply.control_pressure=1 MPa gauge")
    )[1]
    assert json.loads(plain)["opening"] == json.loads(other)["opening"]


def test_efficiency_counts_control_air_at_the_pressure_it_is_drawn_at(apesim):
    drawn = ["engine", "run", "--speed", "800 rpm", "--json", "--set", "supply.control_air=receiver"]
    plain = json.loads(apesim(*drawn)[1])
    other = json.loads(apesim(*drawn, "--set", "supply.control_pressure=3 MPa abs")[1])
    assert plain["exergy_efficiency"] == other["exergy_efficiency"]


def test_a_receiver_too_large_to_settle_is_refused(apesim):
    code, _, err = apesim("engine", "run", "--speed", "1000 rpm", "--set", "engine.receiver.volume=1e8 L")
    assert code == 2 and "engine.receiver.volume" in err and "inf" in err
