"""Velocity is d(lift)/dt, positive as the valve opens, wherever it is written, drawn or read."""

import csv
import json

import numpy as np
import pytest

from apesim.archive import Archive, Variable, read, write
from apesim.archive.comparison import diff
from apesim.archive.inspection import info, verify
from apesim.archive.migration import MIGRATED, migrate
from apesim.engine.cylinder import EPV
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.limit.valve_figures import plot_velocities
from apesim.studies.limit.valve_map import compute_map
from apesim.studies.measured import read_measured
from apesim.studies.measured.prediction import predict
from apesim.studies.sweep import run_sweep
from tests.folders import SAMPLES
from tests.machines import AMBIENT, RPM, machine

MAP_OF_VERSION_1 = SAMPLES / "version_1_map.h5"
PULSE = 12e-3
VALVE_RUN = '[[run]]\ndata = "a.csv"\nsupply = "1.0 MPa gauge"\ntemperature = "287 K"\npulse = "50 ms"\n'
ENGINE_RUN = (
    '[[run]]\ndata = "a.csv"\nsupply = "1.0 MPa gauge"\ntemperature = "287 K"\n'
    'speed = "800 rpm"\nenergise = "-5 deg"\nrelease = "70 deg"\n'
)
BENCHES = {
    "valve": (("valve", "run"), VALVE_RUN, "time [s]", 1.0),
    "engine": (("engine", "run", "--speed", "800 rpm"), ENGINE_RUN, "crank_angle [deg]", 1.0 / (6.0 * 800.0)),
}


def columns_of(path):
    """Columns of a CSV by header."""
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def follows(time, lift, velocity):
    """Whether a velocity is the slope of a lift, but for the samples beside a contact, at which it jumps."""
    slope = np.gradient(lift, time)[1:-1]
    smooth = np.abs(np.diff(velocity, 2)) < 0.1
    return (
        velocity.max() > 1.0
        and velocity.min() < -1.0
        and np.abs(slope - velocity[1:-1])[smooth].max() < 0.02
        and smooth.mean() > 0.9
    )


@pytest.mark.parametrize("bench", BENCHES)
def test_what_a_bench_writes_is_the_slope_of_its_lift(apesim, bench):
    command, _, axis, seconds = BENCHES[bench]
    assert apesim(*command, "--csv", "a.csv")[0] == 0
    found = columns_of("a.csv")
    assert follows(seconds * found[axis], found["lift [m]"], found["velocity [m/s]"])
    assert not np.signbit(found["velocity [m/s]"][found["velocity [m/s]"] == 0.0]).any()


@pytest.mark.parametrize("bench", BENCHES)
def test_what_a_bench_writes_is_what_is_predicted_of_it_when_read(apesim, tmp_path, bench):
    command, run, *_ = BENCHES[bench]
    assert apesim(*command, "--csv", "a.csv")[0] == 0
    (tmp_path / "measured.toml").write_text(f'bench = "{bench}"\n{run}')
    [measured] = read_measured(tmp_path, AMBIENT).runs
    found = predict(Machine(), measured, ["velocity"])
    assert found.channels["velocity"] == pytest.approx(measured.channels["velocity"], abs=1e-5)


def test_the_velocities_in_archives_are_the_slopes_of_their_lifts(tmp_path):
    valve = compute_map(machine(), [AMBIENT + 1e6], [287.0]).variables
    assert follows(valve["time"].values, valve["lift"].values[0], valve["velocity"].values[0])
    engine = run_sweep(Machine(), [800.0 * RPM], [EPV], tmp_path / "s.h5").archive.variables
    time = engine["crank_angle"].values / (6.0 * 800.0)
    assert follows(time, engine["lift"].values[0], engine["velocity"].values[0])
    assert valve["velocity"].description == engine["velocity"].description


def test_a_figure_of_the_map_shows_speeds_towards_the_stop():
    archive = compute_map(machine(), [AMBIENT + 1e6], [287.0])
    for stroke, axis in zip(("opening", "closing"), plot_velocities(archive, AMBIENT).axes, strict=True):
        seating = archive.variables[f"{stroke}_seating_speed_m_s"].values[0]
        [line] = axis.lines
        shown = (line.get_xdata() > 0.0) & (line.get_xdata() < axis.get_xlim()[1])
        speeds = line.get_ydata()[shown]
        assert speeds.min() > -1e-3 and seating <= speeds.max() < 1.5 * seating


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("bench", BENCHES)
def test_a_measured_velocity_of_the_wrong_sign_is_told(apesim, tmp_path, bench, sign):
    command, run, axis, _ = BENCHES[bench]
    assert apesim(*command, "--csv", "all.csv")[0] == 0
    found = columns_of("all.csv")
    noise = np.random.default_rng(3).normal(size=(2, len(found[axis])))
    lift, velocity = found["lift [m]"] + 1e-4 * noise[0], sign * found["velocity [m/s]"] + 0.2 * noise[1]
    rows = "\n".join(
        ",".join(map(repr, row)) for row in zip(*map(np.ndarray.tolist, (found[axis], lift, velocity)), strict=True)
    )
    (tmp_path / "a.csv").write_text(f"{axis},lift [m],velocity [m/s]\n{rows}\n")
    (tmp_path / "measured.toml").write_text(f'bench = "{bench}"\n{run}')
    if sign > 0.0:
        assert "velocity" in read_measured(tmp_path, AMBIENT).runs[0].channels
        return
    with pytest.raises(InputError, match="velocity: falls where the lift rises; turn its sign") as error:
        read_measured(tmp_path, AMBIENT)
    assert len(error.value.faults) == 1


def test_a_map_of_format_version_1_is_turned_when_it_is_read_and_says_so(apesim, tmp_path):
    old, new = read(MAP_OF_VERSION_1), compute_map(Machine(), [AMBIENT + 0.4e6], [287.0], PULSE)
    assert verify(MAP_OF_VERSION_1) == []
    for name in ("lift", "velocity", "pressure_b"):
        np.testing.assert_allclose(old.variables[name].values, new.variables[name].values, rtol=1e-9, atol=1e-12)
        assert old.variables[name].description == new.variables[name].description
    told = "velocity: turned from dL/dt, as format version 1 has it, to d(lift)/dt"
    assert info(MAP_OF_VERSION_1)["provenance"][MIGRATED] == told
    _, out, _ = apesim("archive", "info", str(MAP_OF_VERSION_1))
    assert told in out and "positive as it opens" in " ".join(out.split())
    _, out, _ = apesim("archive", "info", str(MAP_OF_VERSION_1), "--json")
    assert json.loads(out)["provenance"][MIGRATED] == told
    again = write(old, tmp_path / "again.h5")
    assert verify(again) == [] and diff(again, MAP_OF_VERSION_1).differences == []
    assert read(again).provenance["format_version"] == "3"


@pytest.mark.parametrize(
    ("version", "description", "factor"),
    [
        ("1", "dL/dt, positive as the valve closes", -1.0),
        ("1", "dL/dt, positive as it closes", -1.0),
        ("1", "velocity of the lift, positive as it opens", 1.0),
        ("2", "dL/dt, positive as the valve closes", 1.0),
    ],
)
def test_only_what_format_version_1_says_is_dl_dt_is_turned(version, description, factor):
    values = np.array([0.0, 1.5, np.nan, -0.5])
    variable = Variable(("run",), values, "m/s", description)
    found = migrate(Archive("", {"format_version": version}, {"any_velocity": variable}))
    np.testing.assert_array_equal(found.variables["any_velocity"].values, factor * values)
    assert not np.signbit(found.variables["any_velocity"].values[0])
    assert (MIGRATED in found.provenance) == (factor < 0.0)
