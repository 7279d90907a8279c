"""Figures of all studies say what they show, without colour, too, and nothing in them is cut or covered.

Those of a machine that departs from the default in every section, with a stroke of 6 mm; the kinds whose studies take
long are drawn in tests/studies/archives/test_result_kinds.py, for the default machine.
"""

from functools import cache, partial

import matplotlib.pyplot as plt
import numpy as np
import pytest

import apesim
from apesim.air import gas_of
from apesim.archive import Archive
from apesim.archive.columns import column
from apesim.studies.discharge import Discharge, Record, Vessel
from apesim.studies.discharge.area import AreaFit
from apesim.studies.discharge.figures import discharge_figures
from apesim.studies.drawing.files import save
from apesim.studies.drawing.panels import add_legend, add_title, label_axes, open_one, open_row
from apesim.studies.estimation.residuals import Block
from apesim.studies.gap.example_bench import read_example
from apesim.studies.gap.figures import draw_gap
from apesim.studies.gap.report.comparison import ComparedSignal
from apesim.studies.gap.report.engine_curve import EngineCurve
from apesim.studies.gap.report.html import TriedCandidate
from apesim.studies.gap.tables.latent import Branch
from apesim.studies.identify.figures import fit_figures
from apesim.studies.limit.engine_figures import engine_limit_figures
from apesim.studies.limit.engine_limit import EngineLimit, Failure, limit_columns
from apesim.studies.limit.points import Point, point_column
from apesim.studies.limit.valve_figures import limit_figures, map_figures
from apesim.studies.limit.valve_map import supply_columns
from apesim.studies.measured import MeasuredRun
from apesim.studies.paper.figures import _plot_frictions, _plot_lifts, _plot_measures
from apesim.studies.paper.friction.friction_map import FrictionMap
from apesim.studies.paper.friction.statements import STATEMENTS
from apesim.studies.sweep.figures import plot_cycle, sweep_figures
from apesim.studies.transient.figures import draw_start, draw_start_map, draw_transient
from tests.studies.drawing.figure_faults import faults_of, watch_figures

KEYS = (
    *("ambient.pressure=80 kPa abs", "ambient.temperature=278 K", "air.heat_capacity_ratio=1.39"),
    *("supply.pressure=0.7 MPa gauge", "supply.temperature=300 K", "supply.control_pressure=0.9 MPa gauge"),
    *("valve.stroke=6 mm", "valve.moving_mass=0.08 kg", "groove.lap=0.6 mm", "engine.bore=70 mm"),
    *("engine.stroke=72 mm", "engine.receiver.volume=0.4 L", "command.energise=-20 deg", "command.release=60 deg"),
    *("command.open_target=-3 deg", "command.close_target=65 deg", "shaft.inertia=0.05 kg m^2"),
)
MACHINE = apesim.Machine.load(None, KEYS)
TWO = apesim.Machine.load(None, [*KEYS, "engine.cylinders=2"])
PRESSURES, CONTROL = "0.3:1.1:0.4 MPa gauge", "0.7, 1.0 MPa gauge"
BOTH = {"supply.pressure": "0.6, 1.1 MPa gauge", "engine.receiver.volume": "0.5, 2 L"}
STUDIES = {
    "valve run": partial(apesim.run_valve, MACHINE),
    "engine run": partial(apesim.run_engine, TWO, "900 rpm"),
    "valve map": partial(apesim.map_valve, MACHINE, pressure=PRESSURES, temperature="250, 287, 322 K"),
    "map over one axis": partial(apesim.map_valve, MACHINE, pressure=PRESSURES, temperature="287 K"),
    "sweep": partial(apesim.sweep, MACHINE, "600, 1200 rpm"),
    "sweep over keys": partial(apesim.sweep, MACHINE, "600, 1200 rpm", intake="epv, ideal", timing="fixed", vary=BOTH),
    "sweep of one": partial(apesim.sweep, MACHINE, "600, 1200 rpm", intake="ideal", vary=BOTH, traces=False),
    "timing": partial(
        apesim.correct_timing, MACHINE, speed="400, 800 rpm", control_pressure=CONTROL, temperature="270, 300 K"
    ),
    "assessment": partial(apesim.assess_valve, MACHINE, speed="400, 1200 rpm"),
    "start": partial(apesim.start_engine, TWO, angle="30 deg", until="600 rpm"),
    "start of all": partial(apesim.start_engine, MACHINE, angle="all"),
    "starts": partial(
        apesim.start_engine,
        MACHINE,
        until="600 rpm",
        vary={"load.constant": "0, 20 N m", "shaft.inertia": "0.05, 0.2 kg m^2"},
    ),
    "starts of all": partial(apesim.start_engine, MACHINE, angle="all", vary={"engine.cylinders": "1, 2"}),
    "transient": partial(
        apesim.run_transient, TWO, "0.6 s", from_speed="600 rpm", load="0.3 s: 8 N m", timing="feedback"
    ),
    "measured": lambda: apesim.check_measured(apesim.Machine(), read_example()),
    "fit": lambda: apesim.fit(read_example(), ["valve.viscous_friction"]),
    "design": partial(apesim.design_machine, MACHINE, bore="60 mm"),
}
PLOTS = {
    "valve run": ("lift", "pressures"),
    "engine run": ("cylinder pressure", "lift", "indicator diagram"),
    "valve map": ("opening_delay", "closing_seating_speed"),
    "sweep over keys": ("brake_torque", "specific_air_kg_per_kWh"),
    "timing": ("energise", "release"),
    "assessment": ("brake torque lost", "air added"),
    "starts": ("time", "turns", "engine_air", "control_air"),
    "starts of all": ("angles", "share"),
    "transient": ("speed", "torque", "air", "timing"),
}
"""What `plot` draws, where that is more than one."""
WRITERS = {
    "ValveMap": lambda result, folder: map_figures(result.archive, MACHINE.ambient.pressure, folder),
    "Sweep": lambda result, folder: sweep_figures(result.archive, folder),
    "StartRun": draw_start,
    "StartMap": draw_start_map,
    "TransientRun": draw_transient,
    "CorrectedTiming": lambda result, folder: result.draw(folder),
    "ValveAssessment": lambda result, folder: result.draw(folder),
    "MeasuredCheck": lambda result, folder: result.write(folder, overwrite=True),
    "Fit": fit_figures,
}
"""What writes the figures of the command."""
found = cache(lambda name: STUDIES[name]())
RNG = np.random.default_rng(3)


@pytest.fixture
def watched(monkeypatch):
    return watch_figures(monkeypatch)


@pytest.mark.parametrize("name", STUDIES)
def test_figures_of_a_command_are_without_fault(name, watched, tmp_path):
    result = found(name)
    writer = WRITERS.get(type(result).__name__)
    if writer is not None:
        writer(result, tmp_path)
    assert writer is None or watched
    assert not {figure: faults for figure, faults in watched.items() if faults}


@pytest.mark.parametrize(("name", "what"), [(name, what) for name in STUDIES for what in PLOTS.get(name, (None,))])
def test_plots_of_a_result_are_in_the_house_style_and_without_fault(name, what):
    settings = dict(plt.rcParams)
    axes = found(name).plot(**{"what": what} if what else {})
    assert dict(plt.rcParams) == settings
    assert axes.name == "polar" or not axes.spines["top"].get_visible()
    assert not faults_of(axes.figure)
    plt.close(axes.figure)


def test_a_key_that_was_varied_is_no_condition_and_its_value_stands_in_the_figure(monkeypatch, tmp_path):
    told, archive = {}, found("sweep over keys").archive
    watch_figures(monkeypatch, told)
    sweep_figures(archive, tmp_path)
    [conditions] = set(told.values())
    assert conditions.startswith("supply 300 K, control air 0.9 MPa gauge; default machine but for ")
    assert "volume" not in conditions
    title = plot_cycle(archive).axes[0].get_title().replace("\n", " ")
    assert title.endswith(" r/min, supply pressure 0.6 MPa gauge, engine receiver volume 0.5 L")


def test_the_air_of_a_map_over_one_axis_and_no_key_of_the_engine_are_conditions(monkeypatch, tmp_path):
    told = {}
    watch_figures(monkeypatch, told)
    map_figures(found("map over one axis").archive, MACHINE.ambient.pressure, tmp_path)
    assert told["delay_time"].startswith("50 ms pulse, control air temperature 287 K; default valve but for ")
    assert not any(name in told["delay_time"] for name in ("engine", "command", "shaft", "supply"))


def test_courses_of_a_run_over_time_are_conditions(monkeypatch, tmp_path):
    told = {}
    watch_figures(monkeypatch, told)
    draw_transient(found("transient"), tmp_path)
    assert "from: 600 r/min, load over time: 0.3 s: 8 N m" in told["transient"]


def test_a_user_s_axes_keep_the_user_s_settings():
    with plt.rc_context({"lines.linewidth": 4.0, "axes.grid": False, "axes.spines.top": True}):
        figure, axes = plt.subplots()
        found("valve run").plot(axes)
    assert axes.lines[0].get_linewidth() == 4.0 and axes.spines["top"].get_visible()
    plt.close(figure)


def column_of(values, name):
    return column(np.array(values, dtype=float), "1", name)


def test_limits_are_without_fault(watched, tmp_path):
    ambient, text = MACHINE.ambient.pressure, MACHINE.to_toml()
    points = [(p, t, d) for p in (0.6e6, 1.1e6) for t in (260.0, 287.0, 320.0) for d in (0.2, 0.5)]
    rates = [1e-5 * p * d * t / 287.0 for p, t, d in points]
    kinds = [*[Point.GRID] * len(points), Point.OWN]
    columns = supply_columns([*((p, t) for p, t, _ in points), (0.9e6, 287.0)])
    for name, values in {"duty": [*(d for *_, d in points), 0.3], "limit_hz": [*rates, 3.0]}.items():
        columns[name] = column_of(values, name)
    columns |= {"point": point_column(kinds), "rule_lap_to_lap_s": column_of(np.full(len(kinds), 9e-3), "t")}
    limit_figures(Archive(text, {}, columns), ambient, tmp_path)
    limits = [EngineLimit(2e3 * rate, Failure.FULL_LIFT, np.nan, None, 9) for rate in (*rates, 0.9)]
    grid = [*((p, t, 2.0 * d + 0.6, p) for p, t, d in points), (0.9e6, 287.0, 1.2, 0.9e6)]
    engine_limit_figures(Archive(text, {}, limit_columns(grid, kinds, limits)), ambient, tmp_path)
    assert watched == {"working_limit": [], "engine_limit": []}


def test_figures_of_discharge_tests_are_without_fault(watched, tmp_path):
    knots, area = np.linspace(0.0, 4e-3, 9), 1e-6 * np.array([0.0, 0.0, 0.0, 3.0, 6.0, 9.0, 9.0, 9.0, 9.0])
    records, fits = [], []
    for number, initial in enumerate((5e5, 7e5, 9e5)):
        record = Record(f"p{initial / 1e4:03.0f}.csv", knots, initial - 1e8 * initial * np.cumsum(area) * 5e-4)
        own = area * (1.0 + 0.01 * number)
        fits.append(AreaFit(knots, own, np.full(9, 2e-7), np.eye(9), np.array([500.0]), [record.pressures], 1.0))
        records.append(record)
    pooled = fits[1]._replace(pressures=[record.pressures for record in records])
    discharge = Discharge(records, [500.0] * 3, fits, [2e-3] * 3, pooled, 2e-3, 9e-6, 2e-7, np.empty((0, 5)), None, [])
    discharge_figures(Vessel(5e-5, 293.15, MACHINE.ambient.pressure, gas_of(MACHINE.air)), discharge, tmp_path)
    assert watched == {"pressure": [], "effective_area": []}


def test_figures_of_a_gap_are_without_fault(watched, tmp_path):
    times, signals = np.linspace(0.0, 60e-3, 121), []
    marks = {"energise": 0.0, "release": 30e-3, "opening_start": 5e-3, "opening_contact": 12e-3}
    marks |= {"closing_start": 35e-3, "closing_contact": 42e-3}
    for gauge, role in ((0.3e6, "fit"), (0.4e6, "fit"), (0.5e6, "gate"), (0.6e6, "check")):
        supply = gauge + MACHINE.ambient.pressure
        for sensor, size, noise in (("lift", 6e-3, 3e-5), ("pressure_a", 5e5, 2e3)):
            values = size * np.clip(np.minimum(times - 5e-3, 42e-3 - times) / 7e-3, 0.0, 1.0)
            run = MeasuredRun("", f"p{gauge / 1e4:03.0f}.csv", supply, 287.0, 30e-3, role, times, {sensor: values})
            off, rest = np.array([[1.5], [0.0]]) + RNG.standard_normal((2, len(times)))
            models = values + noise * off, values + noise * rest
            signals.append(ComparedSignal(Block(0, run, sensor, times, values, 5e-4), noise, *models, off, rest, marks))
    rows = [TriedCandidate("ring_leakage", 12.0, 11.5), TriedCandidate("slow_ramp", 3.0, None)]
    places = np.linspace(0.0, 100.0, 6)
    branches = [
        Branch("tabulated_force", "force", places, 12.0 - 0.1 * places, np.ones(6), "N"),
        Branch("tabulated_cylinder_heat", "share", 3.6 * places, 0.01 * places, np.full(6, 0.1), ""),
    ]
    draw_gap(signals, rows, "with ring leakage", MACHINE.ambient.pressure, tmp_path, branches)
    assert watched == {key: [] for key in ("gap", "maps", "latent", "candidates", "overlays")}


def test_a_curve_of_a_dynamometer_is_without_fault(watched, tmp_path):
    rpm, curves = np.array([600.0, 900.0, 1200.0, 1500.0]), []
    for gauge in (0.7e6, 1.0e6):
        for sensor, size, noise in (("torque", 50.0, 0.2), ("air_flow", 0.06, 1e-4)):
            values, points = size * gauge / 1e6 * (1.4 - rpm / 2500.0), []
            for speed, value, role in zip(rpm, values, ("fit", "gate", "check", "fit"), strict=True):
                run = MeasuredRun("", "", gauge + 80e3, 287.0, np.nan, role, np.empty(0), {}, "engine")
                run = run._replace(speed=speed * np.pi / 30.0, means={sensor: value})
                left = np.array([2.0]), np.array([0.5])
                models = (np.array([value + one[0] * noise]) for one in left)
                block = Block(0, run, sensor, np.array([0.0]), np.array([value]), np.nan)
                points.append(ComparedSignal(block, noise, *models, *left, {}))
            lines = values * 0.97, 0.05 * values, values * 0.99, values * 1.01
            curves.append(EngineCurve(f"{gauge / 1e6:.2f} MPa gauge", sensor, points, rpm * np.pi / 30.0, *lines))
    signals = [point for curve in curves for point in curve.points]
    draw_gap(signals, [], "with friction torque", 80e3, tmp_path, curves=curves)
    assert watched == {"gap": [], "curve": []}


@pytest.mark.parametrize("draw", [_plot_lifts, _plot_measures])
def test_figures_of_the_paper_are_without_fault_for_another_valve(draw):
    figure = draw(MACHINE)
    assert not faults_of(figure)
    for axis in figure.axes:
        heights = [text.xy[1] for text in axis.texts]
        assert all(axis.get_ylim()[0] < height < axis.get_ylim()[1] for height in heights)


def test_the_map_of_frictions_is_without_fault():
    frictions, areas = np.array([20.0, 60.0, 111.0, 200.0]), 1e-6 * np.array([5.0, 9.0, 12.0])
    holds = {statement.key: np.ones((4, 3, 2, 2)) for statement in STATEMENTS}
    rest = 1e-3 * np.array([1.0, 2.0]), np.array([250.0, 290.0]), 1e6 * np.linspace(0.1, 1.9, 10)
    assert not faults_of(_plot_frictions(FrictionMap(frictions, areas, *rest, holds)))


# --- that faults are found ---


def spoilt(spoil):
    figure, axis = open_one((5.0, 3.0))
    x = np.linspace(0.0, 1.0, 50)
    axis.plot(x, x, color="C0", label="one")
    axis.plot(x, 1.0 - x, color="C1", ls="--", label="other")
    label_axes(axis, x=("time", "s"), y=("lift", "mm"), title="a title")
    add_legend(axis)
    spoil(axis)
    return faults_of(figure)


def draw_levels(axis, levels):
    axis.contour(np.add.outer(np.arange(4.0), np.arange(4.0)), levels)


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (lambda axis: axis.set_xlabel("time"), "without a unit"),
        (lambda axis: axis.set_ylabel(""), "without a unit"),
        (lambda axis: axis.lines[1].set_linestyle("-"), "differ in colour alone"),
        (lambda axis: axis.legend(loc="center"), "upon line"),
        (lambda axis: axis.legend(loc="upper left", bbox_to_anchor=(0.95, 1.3)).set_in_layout(False), "cut"),
        (lambda axis: axis.set_title("a title " * 20), "cut"),
        (lambda axis: axis.text(0.5, -0.01, "a text", transform=axis.transAxes, va="top"), "upon"),
        (lambda axis: draw_levels(axis, [0.8, 1.6, 2.4]), "levels by"),
    ],
)
def test_what_spoils_a_figure_is_found(spoil, fault):
    assert not spoilt(lambda axis: None)
    assert any(fault in found for found in spoilt(spoil))


def test_a_title_has_as_many_lines_as_the_width_of_its_panel_asks_for():
    figure, axis = open_one((4.0, 3.0))
    axis.set(xlabel="time [s]", ylabel="lift [mm]")
    add_title(axis, "supply 0.7 MPa gauge (control air 0.9 MPa gauge), 300 K, 900 r/min, two cylinders")
    assert axis.get_title().count("\n") in (1, 2) and not faults_of(figure)


def test_titles_fit_panels_that_a_legend_beside_them_makes_narrow(tmp_path):
    figure, panels = open_row(2, (8.0, 3.0), sharey=True)
    for axis in panels:
        axis.plot([0.0, 1.0], [0.0, 1.0], label="a line with a name that needs much of the figure's width")
        label_axes(axis, x=("time", "s"), y=("lift", "mm"), title="as long as its panel before there is a legend")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper")
    save(figure, tmp_path, "figure")
    assert not faults_of(figure)
