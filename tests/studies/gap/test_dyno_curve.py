"""Torque and air flow of an engine over its speed, without traces: what a dynamometer gives."""

import re
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import uncalibrated
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals
from apesim.studies.gap.design.deciding_trace import find_deciding_trace
from apesim.studies.gap.figures.curve import plot_curves
from apesim.studies.gap.report.comparison import ComparedSignal
from apesim.studies.gap.report.curve_notes import write_misses
from apesim.studies.gap.report.engine_curve import POINTS, find_curves, group_by_supply, is_speed_curve
from apesim.studies.gap.search.file_numbers import list_suspects
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import Measured, MeasuredRun, read_measured
from apesim.studies.measured.prediction import predict, run_of
from tests.gap_bench import AMBIENT

ROLES = {400: "fit", 600: "fit", 800: "gate", 1000: "fit", 1200: "check", 1400: "fit"}
NOISE = {"torque": 0.2, "air_flow": 1e-4}
SOUGHT = "friction_torque", "exhaust_back_pressure", "exhaust_timing", "slow_ramp"
LEFT_OUT = [effect.name for effect in ALL_EFFECTS if effect.name not in SOUGHT and not effect.tabulated]
LEFT_OUT += [suspect.key for suspect in list_suspects("engine") if suspect.key != "engine.receiver.volume"]


def run_at(rpm, gauge=1.0e6, role="fit", **more):
    command = Machine().command
    means = more.pop("means", dict.fromkeys(NOISE, 0.0))
    run = MeasuredRun(f"{rpm}", "", gauge + AMBIENT, 287.0, np.nan, role, np.empty(0), {}, "engine")
    run = run._replace(speed=rpm * np.pi / 30.0, energise=command.energise, release=command.release, means=means)
    return run._replace(**more)


def measure(settings, seed=7):
    """Runs of an engine with effects, with noise."""
    machine, rng = Machine.load(None, settings), np.random.default_rng(seed)
    runs = []
    for rpm, role in ROLES.items():
        run = run_at(rpm, role=role)
        means = predict(run_of(machine, run), run).means
        runs.append(run._replace(means={name: means[name] + rng.normal(0.0, NOISE[name]) for name in NOISE}))
    return Measured("", NOISE, tuple(runs), "engine", AMBIENT)


def write_folder(folder, measured):
    """Runs as a folder without files."""
    lines = ['bench = "engine"', '[sensor.torque]\nnoise = "0.2 N m"', '[sensor.air_flow]\nnoise = "0.1 g/s"']
    for run in measured.runs:
        lines += [
            "[[run]]",
            'supply = "1.0 MPa gauge"',
            'temperature = "287 K"',
            f'speed = "{run.speed * 30.0 / np.pi:.12g} rpm"',
            f'energise = "{np.degrees(run.energise):.12g} deg"',
            f'release = "{np.degrees(run.release):.12g} deg"',
            f'torque = "{run.means["torque"]:.12g} N m"',
            f'air_flow = "{1e3 * run.means["air_flow"]:.12g} g/s"',
            f'role = "{run.role}"',
        ]
    (folder / "measured.toml").write_text("\n".join(lines) + "\n")
    return folder


@pytest.fixture(scope="module")
def rubbing(tmp_path_factory):
    folder = write_folder(tmp_path_factory.mktemp("dyno"), measure(["effects.friction_torque.fmep=40 kPa"]))
    return explain(Machine(), read_measured(folder), without=LEFT_OUT)


def test_a_dyno_curve_is_explained_and_its_page_begins_with_the_curve(rubbing, tmp_path):
    open_yet = (rubbing.decision.best, *rubbing.decision.rivals)
    assert "friction_torque" in {name for choice in open_yet for name in choice.names}
    written = rubbing.write(tmp_path / "out")
    figures = {path.stem for path in (tmp_path / "out/figures").iterdir()}
    assert "curve" in figures and not figures & {"maps", "overlays"}
    page = (tmp_path / "out/report.html").read_text()
    first, second, *_ = re.findall(r"<figure><img alt=\"([^\"]*)\"", page)
    assert "over the speed" in first and "each run" in second
    assert written["next_test"]["trace"]["text"] in page
    rubbing.write(tmp_path / "again")
    assert (tmp_path / "again/report.html").read_bytes() == (tmp_path / "out/report.html").read_bytes()
    curve = "figures/curve.png"
    assert (tmp_path / "again" / curve).read_bytes() == (tmp_path / "out" / curve).read_bytes()


def test_one_trace_is_told_that_would_tell_most(rubbing):
    trace = rubbing.next_test["trace"]
    assert set(trace["sensors"]) & {"cylinder_pressure", "lift", "pressure_a"}
    assert trace["settled"] is not None or 0 < len(trace["shown"]) <= len(trace["unclear"])
    # Where nothing is ranked, it is the trace that shows most of what is unclear, what the scores point to first.
    hinted = find_deciding_trace(rubbing, {"text": ""})
    assert hinted["settled"] is None
    assert set(hinted["hinted"]) <= set(hinted["shown"]) <= set(hinted["unclear"])
    assert {"friction_torque", "exhaust_back_pressure"} <= set(hinted["shown"])


def test_of_ranked_experiments_the_trace_is_told_that_settles_most():
    rows = [
        {"text": "again", "added_sensors": [], "settled": 0.9},
        {"text": "lift", "added_sensors": ["lift"], "settled": 0.4},
        {"text": "pressure", "added_sensors": ["cylinder_pressure"], "settled": 0.6},
        {"text": "torque", "added_sensors": ["torque"], "settled": 0.8},
    ]
    trace = find_deciding_trace(None, {"experiments": rows})
    assert (trace["text"], trace["sensors"], trace["settled"]) == ("pressure", ["cylinder_pressure"], 0.6)


def test_an_explanation_without_traces_draws_the_curve(rubbing):
    for sensor, label in (("torque", "torque [N m]"), ("air_flow", "air flow [g/s]")):
        axes = rubbing.plot(sensor=sensor)
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("speed [r/min]", label)
        assert len(axes.containers) == len(ROLES)  # a measured point each, with its error bar
        plt.close(axes.figure)
    assert rubbing.plot(ax=axes) is axes


def compared_with(measured, machine, sensors=("torque", "air_flow")):
    """An explanation of data by a machine that was not calibrated, and its signals."""
    residuals, _ = uncalibrated(machine, measured)
    model = SimpleNamespace(residuals=residuals, fitted=SimpleNamespace(x=np.zeros(len(residuals.parameters))))
    every = WhitenedResiduals(machine, measured.runs, residuals.parameters, residuals.noise)
    signals = [
        ComparedSignal(block, NOISE[block.sensor], values, None, values, None, {})
        for block, values in zip(every.blocks, every.predicted(model.fitted.x), strict=True)
        if block.sensor in sensors
    ]
    return SimpleNamespace(calibrated=model, best=model, measured=measured), signals


@pytest.fixture(scope="module")
def plain():
    return compared_with(measure([]), Machine())


def test_curves_go_through_what_the_model_gives_at_the_measured_speeds(plain):
    explanation, signals = plain
    curves = find_curves(explanation, signals)
    assert [curve.sensor for curve in curves] == ["torque", "air_flow"]
    for curve in curves:
        assert [point.block.run.name for point in curve.points] == list(map(str, ROLES))
        assert len(curve.speeds) >= POINTS and curve.after is None
        at = np.interp([point.block.run.speed for point in curve.points], curve.speeds, curve.before)
        assert at == pytest.approx([point.before[0] for point in curve.points], rel=1e-5)
        assert curve.stated == pytest.approx(curve.before, rel=1e-5)  # nothing was calibrated
        assert np.all(curve.spread > 0.0)
    assert "torque by up to" in write_misses(curves, "")


def test_the_band_is_as_wide_as_what_is_known_of_the_rig(plain):
    """To first order: where friction alone is known half as well, its part of the variance is four times as large."""
    explanation, signals = plain
    (torque, _) = find_curves(explanation, signals)
    own = explanation.calibrated.residuals
    place = [p.key for p in own.parameters].index("engine.friction.constant")
    friction = own.parameters[place]
    x = np.zeros(len(own.parameters))
    x[place] = 1.0  # one standard deviation more of it
    moved = WhitenedResiduals(own.machine, own.runs, own.parameters, own.noise).predicted(x)
    shift = [v[0] for block, v in zip(own.blocks, moved, strict=True) if block.sensor == "torque"]
    base = [v[0] for block, v in zip(own.blocks, own.predicted(0.0 * x), strict=True) if block.sensor == "torque"]
    wider = [p._replace(scale=2.0 * p.scale) if p is friction else p for p in own.parameters]
    model = SimpleNamespace(residuals=own.with_parameters(wider), fitted=explanation.calibrated.fitted)
    (wide, _) = find_curves(SimpleNamespace(calibrated=model, best=model, measured=explanation.measured), signals)
    speeds = [run.speed for run in own.runs]
    gained = np.interp(speeds, wide.speeds, wide.spread) ** 2 - np.interp(speeds, torque.speeds, torque.spread) ** 2
    assert np.sqrt(gained / 3.0) == pytest.approx(np.abs(np.subtract(shift, base)), rel=0.02)


def test_a_speed_at_which_the_engine_cannot_be_simulated_is_a_gap_in_the_line(plain, monkeypatch):
    explanation, signals = plain
    predicted = WhitenedResiduals.predicted

    def broken(self, x, *more):
        if any(105.0 < run.speed < 115.0 for run in self.runs):
            raise EndedEarly("no periodic state")
        return predicted(self, x, *more)

    monkeypatch.setattr(WhitenedResiduals, "predicted", broken)
    (torque, _) = find_curves(explanation, signals)
    assert np.array_equal(np.isnan(torque.before), np.isnan(torque.stated))
    assert torque.speeds[np.isnan(torque.before)] == pytest.approx(
        [speed for speed in torque.speeds if 105.0 < speed < 115.0]
    )
    assert 0 < np.isnan(torque.before).sum() < len(torque.speeds)
    assert plot_curves([torque], "").axes


def test_runs_of_one_supply_are_one_curve_unless_their_commands_differ():
    sagging = [run_at(rpm, 1.0e6 - 40.0 * rpm / 1.5) for rpm in (400, 900, 1400)]
    other = [run_at(rpm, 0.6e6) for rpm in (1400, 400)]
    late = [run_at(900, 1.0e6, release=run_at(900).release + 0.3, name="late")]
    groups = group_by_supply(Measured("", {}, (*sagging, *other), "engine", AMBIENT))
    assert [[run.name for run in group] for group in groups] == [["400", "1400"], ["400", "900", "1400"]]
    groups = group_by_supply(Measured("", {}, (*sagging, *late), "engine", AMBIENT))
    assert sorted([run.name for run in group] for group in groups) == [["400", "900", "1400"], ["late"]]


def test_a_curve_takes_three_speeds_and_no_traces():
    three = [run_at(rpm) for rpm in (400, 900, 1400)]
    angles = np.linspace(0.0, 6.0, 30)
    traced = three[0]._replace(times=angles, angles=angles, channels={"lift": angles})

    def is_curve(*runs, bench="engine"):
        return is_speed_curve(Measured("", {}, runs, bench, AMBIENT))

    assert is_curve(*three)
    assert not is_curve(*three[:2], three[1]._replace(name="again", speed=1.002 * three[1].speed))
    assert not is_curve(*three[:2], run_at(1400, 0.5e6))
    assert not is_curve(*three, traced)
    assert not is_curve(*three, bench="valve")


def test_curves_of_several_pressures_have_units_and_their_legend_outside(plain):
    explanation, _ = plain
    low = [run._replace(supply=0.6e6 + AMBIENT) for run in explanation.measured.runs]
    measured = explanation.measured._replace(runs=(*explanation.measured.runs, *low))
    curves = find_curves(*compared_with(measured, Machine()))
    assert {curve.label for curve in curves} == {"0.60 MPa gauge", "1.00 MPa gauge"}
    figure = plot_curves(curves, "")
    figure.draw_without_rendering()
    assert [axis.get_ylabel() for axis in figure.axes[:2]] == ["torque [N m]", "air flow [g/s]"]
    assert {axis.get_xlabel() for axis in figure.axes[2:]} == {"speed [r/min]"}
    legend = figure.legends[0].get_window_extent()
    assert {"0.60 MPa gauge", "1.00 MPa gauge"} <= {text.get_text() for text in figure.legends[0].get_texts()}
    assert not any(axis.get_window_extent().overlaps(legend) for axis in figure.axes)
