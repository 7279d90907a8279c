"""Command `apesim measured check`: an oscilloscope's files as they come, read, judged and drawn."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.commands.cli import app
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import predict, run_of
from tests.machines import AMBIENT

HEAD = "Sample Interval,0.0001\r\nVertical Units,CH1:V,CH2:V\r\n\r\nSecond,Volt,Volt,mm,bar\r\n"
READ = """[read]
skip_rows = 4
header = false
decimal = "."
columns = { time = 1, lift = 4, pressure_a = 5 }
unit.time = "s"
unit.lift = "mm"
unit.pressure_a = "bar KIND"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three files of a scope: volts beside units, no names, a clock that jitters, and a spike in the second."""
    path, rng = tmp_path_factory.mktemp("scope"), np.random.default_rng(4)
    about = ['bench = "valve"', READ.replace("KIND", "gauge")]
    for number, supply in enumerate((0.3, 0.4, 0.6), 1):
        times = np.arange(-0.01, 0.11, 1e-4)
        times = times + rng.normal(0.0, 2e-6, len(times))
        asked = dict.fromkeys(("lift", "pressure_a"), times)
        run = MeasuredRun("a", "a.csv", 1e6 * supply + AMBIENT, 290.0, 50e-3, "fit", times, asked)
        shown = predict(run_of(Machine(), run), run).channels
        lift = 1e3 * shown["lift"] + rng.normal(0.0, 0.03, len(times))
        pressure = 1e-5 * (shown["pressure_a"] - AMBIENT) + rng.normal(0.0, 0.02, len(times))
        if number == 2:
            lift[300] = 40.0
        rows = zip(times, lift / 2.0, pressure, lift, pressure, strict=True)
        text = "".join(f"{t:+.7f},{u:.4f},{v:.4f},{x:.3f},{p:.3f}\r\n" for t, u, v, x, p in rows)
        (path / f"SDS{number}.csv").write_text(HEAD + text, encoding="latin-1")
        about += ["[[run]]", f'data = "SDS{number}.csv"', f'supply = "{supply} MPa gauge"', 'pulse = "50 ms"']
    (path / "measured.toml").write_text("\n".join(about))
    return path


def check(folder, *options):
    return CliRunner().invoke(app, ["measured", "check", str(folder), *options], standalone_mode=False)


def test_honest_files_of_a_scope_pass_and_what_was_guessed_and_masked_is_said(folder):
    done = check(folder)
    assert done.return_value == 0
    assert 'note: SDS1.csv: read with separator = "comma"' in done.stderr
    assert "a spike" in done.stdout and "SDS2.csv" in done.stdout
    shown = done.stdout[done.stdout.index("SDS1.csv and 2 more, as measured.toml may say it:") :].splitlines()[1:-1]
    assert shown[:3] == ["[read]", 'separator = "comma"', 'decimal = "."'] and 'unit.pressure_a = "bar gauge"' in shown
    assert "\n".join(shown) == json.loads(check(folder, "--json").stdout)["read"]["SDS1.csv"]
    assert done.stdout.splitlines()[-1] == "0 faults, 1 warning, 3 hints in 3 runs"  # no name of a class


def test_json_has_each_finding_by_itself(folder):
    found = json.loads(check(folder, "--json").stdout)
    assert [one["check"] for one in found["warnings"]] == ["spikes"]
    assert len(found["hints"]) == 3 and len(found["notes"]) == 3 and found["faults"] == []


def test_a_fault_of_all_files_is_one_line_with_its_reason_and_exits_2(folder, tmp_path):
    wrong = tmp_path / "wrong"
    wrong.mkdir()
    for file in folder.iterdir():
        (wrong / file.name).write_bytes(file.read_bytes().replace(b"bar gauge", b"bar abs"))
    done = check(wrong)
    assert done.return_value == 2
    assert done.stdout.count("gauge called abs?") == 1
    assert "3 faults" in done.stdout


def test_figures_show_what_was_masked(folder, tmp_path):
    done = check(folder, "--out", str(tmp_path / "out"))
    assert done.return_value == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["runs_1.pdf", "runs_1.png"]
    from apesim.studies.measured.check import check_measured

    axis = check_measured(Machine(), folder).plot(run="SDS2.csv", channel="lift")
    [masked] = [line for line in axis.lines if line.get_label() == "masked"]
    assert masked.get_xdata() == pytest.approx([20.0], abs=0.1)


def test_means_alone_are_no_trace_to_draw(tmp_path):
    run = ['supply = "1.0 MPa gauge"', 'temperature = "287 K"', 'speed = "1000 rpm"', 'torque = "29.4 N m"']
    angles = ['energise = "-5 deg"', 'release = "70 deg"']
    (tmp_path / "measured.toml").write_text("\n".join(['bench = "engine"', "[[run]]", *run, *angles]))
    from apesim.studies.measured.check import check_measured

    with pytest.raises(InputError, match="has means alone, and no trace to draw"):
        check_measured(Machine(), tmp_path).plot()
