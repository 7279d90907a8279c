"""Keys that are varied: each combination is the machine that ``--set`` would have made, each key a named axis."""

import json
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray

import apesim
from apesim.archive import ArchiveError, read, write
from apesim.archive.grid import axes_of, places_of, read_grid
from apesim.archive.inspection import verify
from apesim.archive.merge import merge
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import CAM, EPV, IDEAL_VALVE
from apesim.engine.indicators import INDICATORS, indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.quantities import InputError
from apesim.quantities.settings import dumps, load, schema
from apesim.studies.sweep import TIMINGS, run_sweep, vary
from apesim.studies.sweep.figures import sweep_figures
from apesim.studies.sweep.plan import plan
from apesim.studies.sweep.run import _first_of_each_kind
from apesim.studies.sweep.variation import stored
from tests.folders import ROOT

RPM = np.pi / 30.0
SPEEDS = [900.0 * RPM, 600.0 * RPM]
TEXTS = [
    "supply.pressure=0.8:1.2:0.2 MPa gauge",
    "air.model=ideal,thermally_perfect",
    "effects.blow_by.area=0 mm^2, 0.3 mm^2",
]
GRID = ("actuation", "supply_pressure", "air_model", "effects_blow_by_area", "speed_rpm")


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    path = tmp_path_factory.mktemp("variation") / "sweep.h5"
    return run_sweep(Machine(), SPEEDS, [CAM, IDEAL_VALVE], path, variation=vary(TEXTS))


def test_each_combination_is_the_machine_that_set_would_have_made(tmp_path):
    path = tmp_path / "m.toml"
    path.write_text('[ambient]\npressure = "90 kPa abs"\n[supply]\npressure = "1.1 MPa gauge"\n')
    texts = ["supply.pressure=0.8 MPa gauge, 1 MPa abs", "command.release=70:80:5 deg"]
    variation = vary(texts, path, ["engine.bore=90 mm"])
    expected = [
        dumps(load(Machine, path, ["engine.bore=90 mm", f"supply.pressure={p}", f"command.release={angle} deg"]))
        for p in ("0.8 MPa gauge", "1 MPa abs")
        for angle in (70, 75, 80)
    ]
    assert [dumps(machine) for machine in variation.machines] == expected


def test_a_gauge_pressure_of_the_file_stands_above_a_varied_ambient_pressure(tmp_path):
    path = tmp_path / "m.toml"
    path.write_text('[supply]\npressure = "1 MPa gauge"\n')
    machines = vary(["ambient.pressure=80 kPa abs, 100 kPa abs"], path).machines
    assert [machine.supply.pressure for machine in machines] == [1.08e6, 1.1e6]


def test_a_file_whose_name_holds_gauge_is_no_gauge_pressure(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "gauge.csv").write_text("crank_angle [deg],lift [mm]\n0,0\n40,9\n80,0\n")
    texts = ["ambient.pressure=80 kPa abs, 100 kPa abs", "engine.cam.lift_curve=gauge.csv"]
    assert len(vary(texts).machines) == 2


@pytest.mark.parametrize(
    ("text", "values", "unit"),
    [
        ("supply.pressure=0.6:1.0:0.2 MPa gauge", [701325.0, 901325.0, 1101325.0], "Pa abs"),
        ("command.release=70 deg, 1.5 rad", [70.0, np.degrees(1.5)], "deg"),
        ("effects.ring_leakage.area=0:0.2:0.1 mm^2", [0.0, 1e-7, 2e-7], "m^2"),
        ("valve.spring_rate=1 N/mm", [1000.0], "kg s^-2"),
        ("engine.compression_ratio=15:17:1", [15.0, 16.0, 17.0], "1"),
        ("engine.receiver.volume=1 L, inf", [1e-3, np.inf], "m^3"),
        ("air.model=thermally_perfect, ideal", [1, 0], "1"),
    ],
)
def test_archives_hold_si_and_degrees(text, values, unit):
    [axis] = vary([text]).axes
    assert stored(axis)[0] == pytest.approx(values, rel=1e-15) and stored(axis)[1] == unit


@pytest.mark.parametrize(
    ("texts", "told"),
    [
        (["supply.pressure=0.6:1.4:0.2"], [["--vary: supply.pressure", "no unit", "MPa"]]),
        (["supply.pressure=0.6:1.4:0.2 MPa"], [["--vary: supply.pressure", "neither gauge nor abs"]]),
        (["supply.presure=1 MPa abs"], [["--vary: supply.presure", "supply.pressure?"]]),
        (["valve.solenoid=1 mm"], [["--vary: valve.solenoid", "section", "valve.solenoid.dead_time"]]),
        (["supply.pressure"], [["--vary: 'supply.pressure'", "KEY=RANGE"]]),
        (["air.model=ideal,foo"], [["--vary: air.model", "'foo'", '"thermally_perfect"']]),
        (["engine.intake=epv,cam"], [["--vary: engine.intake", "--intake"]]),
        (["known_to=1 mm"], [["--vary: known_to", "is a table", "vary a number"]]),
        (["cylinder=1 mm"], [["--vary: cylinder", "is a table", "vary a number"]]),
        (["engine.phases=1 deg, 2 deg"], [["--vary: engine.phases", "is a list", "vary a number"]]),
        (["groove.lap=1 mm", "groove.lap=2 mm"], [["--vary: groove.lap", "twice", "at once"]]),
        (["groove.lap=1 mm, 1000 um"], [["--vary: groove.lap", "'1 mm' is given twice", "once"]]),
        (["groove.lap=1:9", "engine.bore=9"], [["--vary: groove.lap"], ["--vary: engine.bore", "no unit"]]),
        (
            ["supply.pressure=1 MPa gauge", "ambient.pressure=80 kPa abs, 90 kPa abs"],
            [["--vary: supply.pressure", "gauge", "write it abs"]],
        ),
        (
            ["groove.lap=2:6:2 mm", "valve.stroke=3 mm, 5 mm"],
            [
                ["--vary: groove.lap", "never opens", "groove.lap=4 mm, valve.stroke=3 mm and 1 more"],
                ["--vary: groove.lap", "groove.lap=6 mm, valve.stroke=5 mm)", "stroke, 5 mm"],
            ],
        ),
        (["effects.cylinder_wall_heat.wall_temperature=300 K"], [["--vary: effects.cylinder_wall_heat", "without h"]]),
        (["groove.lap=0.001:8:0.001 mm", "engine.bore=50:100:1 mm"], [["--vary", "408000 machines", "larger steps"]]),
        (["groove.area_curve=no.csv"], [["--vary: groove.area_curve", "no.csv"]]),
    ],
)
def test_what_is_wrong_is_named_with_the_option_the_key_and_the_right_form(texts, told):
    with pytest.raises(InputError) as error:
        vary(texts)
    lines = str(error.value).splitlines()
    assert len(lines) == len(told)
    for line, parts in zip(lines, told, strict=True):
        assert all(part in line for part in parts), line


def test_no_key_has_the_name_of_a_result():
    names = {leaf.key.replace(".", "_") for leaf in schema(Machine)}
    others = {*INDICATORS, "run", "crank_angle", "actuation", "intake", "timing", "status", "timing_reason"}
    assert len(names) == len(list(schema(Machine)))
    assert not names & (others | {"energise_deg", "release_deg"} | {header.split(" [")[0] for header in TRACE})


def test_the_grid_opens_with_named_axes_and_each_point_is_the_operating_point_alone(swept):
    assert verify(swept.path) == []
    data = read_grid(swept.path)
    assert data["brake_torque_Nm"].dims == GRID
    assert data["cylinder_pressure"].dims == (*GRID, "crank_angle")
    assert data["actuation"].values.tolist() == ["cam", "ideal"]
    assert data["speed_rpm"].values.tolist() == [900.0, 600.0]  # as they were given
    assert data["supply_pressure"].attrs["units"] == "Pa"
    assert data["run"].dtype.kind == "i"
    place = {
        "supply_pressure": 1.301325e6,
        "air_model": "thermally_perfect",
        "effects_blow_by_area": 3e-7,
        "speed_rpm": 600.0,
    }
    settings = ["supply.pressure=1.2 MPa gauge", "air.model=thermally_perfect", "effects.blow_by.area=0.3 mm^2"]
    machine = load(Machine, None, [*settings, "engine.intake=cam"])
    run = run_steady(machine, 600.0 * RPM)
    point = data.sel(actuation="cam", **place)
    assert float(point["brake_torque_Nm"]) == indicators(machine, run)["brake_torque_Nm"]
    np.testing.assert_array_equal(point["cylinder_pressure"], run.trace[:, 0])


def test_without_our_help_xarray_finds_the_varied_keys_beside_the_runs(swept):
    with xarray.open_dataset(swept.path, engine="h5netcdf") as data:
        kept = (data["effects_blow_by_area"] > 0.0) & (data["supply_pressure"] < 1e6)
        assert data["brake_torque_Nm"].where(kept, drop=True).sizes == {"run": 2 * 2 * 2}


@pytest.mark.slow
def test_a_part_of_a_grid_has_gaps_and_the_parts_make_the_whole(swept, tmp_path):
    parts = []
    for number in (1, 2, 3):
        path = tmp_path / f"{number}.h5"
        options = {"variation": vary(TEXTS), "shard": (number, 3)}
        parts.append(run_sweep(Machine(), SPEEDS, [CAM, IDEAL_VALVE], path, **options).archive)
    third = read_grid(tmp_path / "1.h5")
    assert third["brake_torque_Nm"].dims == GRID
    assert int(third["run"].notnull().sum()) == len(parts[0].runs) == 48 // 3
    assert int(third["brake_torque_Nm"].notnull().sum()) == 48 // 3
    joined = merge(parts)
    assert axes_of(joined) == axes_of(swept.archive)
    for name, variable in swept.archive.variables.items():
        np.testing.assert_array_equal(joined.variables[name].values, variable.values, err_msg=name)
    write(joined, tmp_path / "joined.h5")
    assert read_grid(tmp_path / "joined.h5").drop_attrs().identical(read_grid(swept.path).drop_attrs())


def test_a_sweep_over_other_values_does_not_go_on_with_these_shards(tmp_path, monkeypatch):
    path = tmp_path / "sweep.h5"
    from apesim.studies.sweep import run

    def killed(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "merge", killed)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(Machine(), SPEEDS[:1], [CAM], path, variation=vary(["engine.bore=80 mm"]))
    monkeypatch.undo()
    with pytest.raises(ArchiveError, match="part of another sweep"):
        run_sweep(Machine(), SPEEDS[:1], [CAM], path, variation=vary(["engine.bore=81 mm"]), resume=True)
    result = run_sweep(Machine(), SPEEDS[:1], [CAM], path, variation=vary(["engine.bore=80 mm"]), resume=True)
    assert axes_of(result.archive)["engine_bore"] == ["80 mm"]


def test_a_curve_is_varied_by_its_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, area in (("small", 100), ("large", 300)):
        (tmp_path / f"{name}.csv").write_text(f"lift [mm],effective_area [mm^2]\n0,0\n1,0\n9,{area}\n")
    variation = vary(["groove.area_curve=small.csv, large.csv"])
    result = run_sweep(Machine(), SPEEDS[:1], [CAM], tmp_path / "sweep.h5", variation=variation)
    torque = read_grid(result.path)["brake_torque_Nm"].sel(groove_area_curve=["small.csv", "large.csv"])
    assert float(torque[0, 0, 0]) < float(torque[0, 1, 0])


def test_commands_that_are_varied_leave_traces_at_common_angles(tmp_path):
    variation = vary(["command.energise=-10 deg, -5.2 deg, 3.3 deg"])
    result = run_sweep(Machine(), SPEEDS[:1], [EPV], tmp_path / "sweep.h5", variation=variation)
    data = read_grid(result.path).isel(actuation=0, speed_rpm=0)
    assert data["command_energise"].values.tolist() == [-10.0, -5.2, 3.3]
    assert data["crank_angle"].values[0] == pytest.approx(-10.0, abs=1e-12)
    volume = data["cylinder_volume"]
    np.testing.assert_allclose(volume, np.broadcast_to(volume[0], volume.shape), rtol=1e-9)
    # a later command opens later
    angles = data["crank_angle"].values
    opened = [angles[np.argmax(lift > 1e-3)] for lift in data["lift"].values]
    assert opened == sorted(opened) and opened[0] < opened[1] < opened[2]


@pytest.mark.slow
def test_figures_over_each_key_are_drawn(swept, tmp_path):
    names = {path.stem for path in sweep_figures(swept.archive, tmp_path)}
    assert {"over_supply_pressure", "over_air_model", "over_effects_blow_by_area", "torque_and_air"} <= names


@pytest.mark.parametrize(
    "axes",
    ["", "[]", '{"actuation": 1}', '{"nothing": ["1"]}', '{"actuation": ["cam"]}', "{", '{"crank_angle": ["1"]}'],
)
def test_an_archive_that_is_no_grid_is_told(swept, tmp_path, axes):
    archive = read(swept.path)
    archive.provenance["axes"] = axes
    write(archive, tmp_path / "other.h5")
    with pytest.raises(ArchiveError, match=r"other\.h5"):
        read_grid(tmp_path / "other.h5")


def test_the_last_axis_runs_fastest(swept):
    planned = plan(vary(TEXTS), SPEEDS, [CAM, IDEAL_VALVE])
    assert json.loads(swept.archive.provenance["axes"]) == planned.axes
    places = np.array(places_of(swept.archive)).T
    assert places[:3].tolist() == [[0, 0, 0, 0, 0], [0, 0, 0, 0, 1], [0, 0, 0, 1, 0]]
    assert planned.points[2].machine.effects.blow_by.area == 3e-7
    assert planned.points[0].machine.command.energise == pytest.approx(-5.0 * DEGREE)


def test_the_example_of_the_page_on_archives_runs(tmp_path, monkeypatch):
    text = (ROOT / "docs" / "guide" / "archives.md").read_text(encoding="utf-8")
    [example] = re.findall(r"```python\n([^`]*?data = apesim\.read_archive.*?)```", text, flags=re.DOTALL)
    monkeypatch.chdir(tmp_path)
    texts = ["supply.pressure=0.8 MPa gauge, 1 MPa gauge", "effects.ring_leakage.area=0:0.1:0.1 mm^2"]
    run_sweep(Machine(), SPEEDS, [EPV, CAM], "sweep.h5", timings=TIMINGS, variation=vary(texts))
    names = {"apesim": apesim}
    exec(example, names)
    plt.close("all")
    assert names["torque"].dims == ("supply_pressure", "speed_rpm")
    assert '# ("supply_pressure", "speed_rpm")' in example


def test_all_that_any_machine_needs_is_compiled_before_the_work_is_shared_out():
    points = plan(vary(TEXTS), SPEEDS, [EPV, CAM], TIMINGS).points
    told = {(point.timing, point.machine.effects.blow_by.area > 0.0) for point in _first_of_each_kind(points)}
    assert told == {(0, False), (0, True), (1, False), (1, True)}
    assert len(_first_of_each_kind(points)) == 4


def test_a_second_exhaust_valve_is_a_kind_that_is_compiled_before_the_work_is_shared_out():
    areas = vary(["engine.exhaust_2.effective_area=0 mm^2, 100 mm^2, 200 mm^2"])
    chosen = _first_of_each_kind(plan(areas, SPEEDS, [EPV]).points)
    assert [len(point.machine.engine.exhausts) for point in chosen] == [1, 2]
