"""Content of pages: what each kind says, whatever its archive has or lacks."""

import numpy as np
import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.studies.report.figures.bars import Bars
from apesim.studies.report.figures.curves import Curves
from apesim.studies.report.figures.moving import Moving
from apesim.studies.report.page import render_page, write_content
from apesim.studies.report.pages.cycle import find_entropy
from apesim.studies.report.pages.sweep import choose_runs
from tests.studies.report.conftest import found


def content_of(result):
    content, odd = write_content(result, result.archive.provenance["kind"])
    assert odd == [] and "nan" not in "".join(fact.value for fact in content.facts)
    return content


def figures_of(content, kind=object):
    return [figure for section in content.sections for figure in section.figures if isinstance(figure, kind)]


@pytest.mark.parametrize(
    ("options", "title", "cycles"),
    [
        ({"speed": "900 rpm"}, "The engine at 900 r/min", 4),
        ({"speed": "600, 900 rpm", "intake": "cam"}, "The engine from 600 to 900 r/min: cam", 1),
        ({"speed": "600, 900 rpm", "traces": False}, "The engine from 600 to 900 r/min", 0),
        (
            {"speed": "900 rpm", "vary": {"supply.pressure": "0.8, 1 MPa gauge"}},
            "The engine at 900 r/min, over supply pressure",
            4,
        ),
    ],
    ids=["one speed", "one intake", "no traces", "over a key"],
)
def test_a_sweep_says_what_was_swept_and_shows_the_cycles_that_it_has(options, title, cycles):
    content = content_of(apesim.sweep(Machine(), **options))
    loops = [figure for figure in figures_of(content, Curves) if figure.title == "p–V diagram"]
    assert content.title == title and sum(len(loop.lines) for loop in loops) == cycles
    assert len(figures_of(content, Moving)) == bool(cycles) and len(figures_of(content, Bars)) == 1


def test_several_cylinders_have_no_ledger_and_no_number_that_is_none():
    result = apesim.sweep(Machine().with_(engine_cylinders=2), "900 rpm", intake="epv", timing="fixed")
    assert figures_of(content_of(result), Bars) == [] and '="nan"' not in render_page(result)


def test_the_parts_of_a_ledger_sum_to_what_enters():
    archive, [bars] = found("sweep").archive, figures_of(content_of(found("sweep")), Bars)
    for (_, parts), (_, run) in zip(bars.rows, choose_runs(archive), strict=True):
        v = {
            name: float(archive.variables[f"exergy_{name}_J"].values[run])
            for name in ("engine_air", "control_air", "stored")
        }
        assert sum(parts.values()) == pytest.approx(v["engine_air"] + v["control_air"] - v["stored"], rel=1e-6)


def test_the_loop_of_p_and_v_encloses_the_indicated_work():
    archive = found("sweep").archive
    [loop] = [figure for figure in figures_of(content_of(found("sweep")), Curves) if figure.title == "p–V diagram"]
    speeds, torque = (archive.variables[name].values for name in ("speed_rpm", "indicated_torque_Nm"))
    for frame, speed in enumerate((600.0, 1000.0, 1400.0)):
        for line, own in zip(loop.lines, torque[speeds == speed], strict=True):
            pressure, volume = line.values[frame], line.x[frame]
            work = np.sum(0.5 * (pressure + np.roll(pressure, -1)) * (np.roll(volume, -1) - volume))
            assert work == pytest.approx(2.0 * np.pi * own, rel=2e-2, abs=1.0)  # of every second sample


def test_turns_of_a_transient_are_whole_and_ascend():
    turns = next(
        figure for figure in figures_of(content_of(found("transient")), Curves) if figure.title == "p–V diagram"
    )
    [lift] = [
        figure for figure in figures_of(content_of(found("start")), Curves) if figure.title == "Lift of the intake"
    ]
    assert len(turns.frames.texts) >= 3 and turns.frames.start == len(turns.frames.texts) - 1
    assert lift.frames.start == 0 and lift.frames.texts[0].startswith("1, from")
    assert all(np.all(np.diff(x) > 0.0) and x[0] >= 0.0 and x[-1] <= 360.0 + 1e-9 for x in lift.x_values)


def test_entropy_is_constant_along_an_isentrope():
    machine = Machine()
    pressure = np.array([1e5, 5e5, 1e6])
    temperature = 300.0 * (pressure / 1e5) ** (0.4 / 1.4)
    entropy = find_entropy(machine, pressure, temperature)
    assert np.ptp(entropy) < 1e-9 * 1005.0 and np.isnan(find_entropy(machine, pressure[:1], np.array([-1.0]))[0])


def test_the_valve_of_a_map_moves_at_the_pressure_of_its_run():
    [moving] = figures_of(content_of(found("map")), Moving)
    archive = found("map").archive
    assert not moving.has_engine and len(moving.frames.texts) == len(moving.traces) == 6
    assert moving.traces[-1]["receiver_pressure"][0] == archive.variables["supply_pressure"].values[-1]


def test_the_start_of_all_angles_shows_its_intervals():
    result = apesim.start_engine(Machine(), angle="all")
    content = content_of(result)
    [rings] = figures_of(content)
    assert [list(ends) for ends in rings.rows[0][1]] == [list(ends) for ends in result.intervals_deg]
