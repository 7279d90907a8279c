"""Measured runs are laid over the curves, at the operating point that they were measured at."""

import numpy as np
import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.execution.output import write_traces
from apesim.studies.explore.live_point import ANGLES
from apesim.studies.explore.measured_points import MAX_POINTS, overlays_of
from apesim.studies.explore.requests import Asked, read_request
from apesim.studies.run.engine_run import trace_table

TOML = """
bench = "engine"
[[run]]
data = "run.csv"
speed = "1000 rpm"
supply = "1.0 MPa gauge"
temperature = "287 K"
energise = "-5 deg"
release = "70 deg"
torque = "29.4 N m"
role = "fit"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("measured")
    run = apesim.run_engine(Machine(), "1000 rpm")
    header, rows = trace_table(run)
    kept = [header.index(name) for name in header if name.split(" ")[0] in ("crank_angle", "lift", "cylinder_pressure")]
    write_traces(folder / "run.csv", [header[place] for place in kept], rows[:, kept])
    (folder / "measured.toml").write_text(TOML, encoding="utf-8")
    return folder


def test_points_lie_on_the_curve_of_the_run_they_are_of(folder):
    (overlay,) = overlays_of(apesim.read_measured(folder))
    run = apesim.run_engine(Machine(), "1000 rpm")
    points = overlay["curves"]["cylinder_pressure"]
    assert len(points["x"]) <= MAX_POINTS and points["x"] == sorted(points["x"])
    assert ANGLES[0] <= min(points["x"]) and max(points["x"]) <= ANGLES[-1]
    angles, pressure = run.traces["crank_angle_deg"].values, run.traces["cylinder_pressure"].values
    assert np.interp(points["x"], angles, pressure, period=360.0) == pytest.approx(points["values"], rel=1e-6)
    assert overlay["means"]["torque"] == pytest.approx(29.4)


def test_sliders_take_the_operating_point_of_a_run(folder):
    (overlay,) = overlays_of(apesim.read_measured(folder))
    request = read_request(Machine().with_(supply_pressure="0.5 MPa gauge"), Asked(1, overlay["values"]))
    assert request.machine.supply.pressure == pytest.approx(Machine().supply.pressure)
    assert request.speed == pytest.approx(1000.0 * 2.0 * np.pi / 60.0)


def test_another_bench_is_refused(tmp_path):
    (tmp_path / "measured.toml").write_text(
        '[[run]]\ndata = "a.csv"\nsupply = "0.4 MPa gauge"\ntemperature = "287 K"\npulse = "50 ms"\nrole = "fit"\n'
    )
    run = apesim.run_valve(Machine())
    run.to_pandas()[["lift"]].rename(columns={"lift": "lift [m]"}).rename_axis("time [s]").to_csv(tmp_path / "a.csv")
    with pytest.raises(InputError, match="engine"):
        overlays_of(apesim.read_measured(tmp_path))
