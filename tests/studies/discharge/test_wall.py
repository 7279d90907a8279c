"""A vessel with a warm wall: the area of the valve is found beside its conductance, or no curve is given."""

import json
from math import inf, sqrt

import numpy as np
import pytest

from apesim.air import Air, gas_of
from apesim.studies.commands.options import Common
from apesim.studies.commands.valve.discharge import evaluate_discharge as command
from apesim.studies.discharge import Vessel, discharge
from apesim.studies.discharge.area import AreaFit
from apesim.studies.discharge.opening import Plateau, cut, find_plateau, leaves_band
from apesim.studies.discharge.vessel import Descent
from apesim.studies.discharge.wall import fit_wall
from apesim.studies.terminal.console import INCOMPLETE, Console
from tests.machines import AMBIENT
from tests.studies.discharge.vessels import FULL, ROOM, psi, record_of, warm


def vessel(volume, wall=0.0):
    return Vessel(volume, ROOM, AMBIENT, gas_of(Air()), wall)


def wall_of(volume, records, opened=20e-3):
    """Wall found in records, without the smooth fit, which is slow."""
    knots = np.linspace(0.0, 0.1, 5)
    smooth = [np.convolve(np.pad(r.pressures, 5, mode="edge"), np.ones(11) / 11.0, mode="valid") for r in records]
    fit = AreaFit(knots, np.full(5, FULL), np.full(5, 1e-7), np.zeros((5, 5)), np.zeros(len(records)), smooth, 1.0)
    return fit_wall(vessel(volume), records, fit, opened, vessel(volume).gas.critical_ratio)


@pytest.mark.parametrize("conductance", [0.5, 5.0, 50.0])
def test_the_law_of_a_warm_vessel_is_that_of_its_balances(conductance):
    times, pressures = warm(2e-3, conductance, 8e5, 2.0, 1e3)
    passed = FULL * np.clip(times - 2.25e-3, 0.0, None)
    part = (times > 4e-3) & (pressures > 1.03 * AMBIENT)
    found = Descent(vessel(2e-3, conductance / FULL), 8e5).pressure(passed)[0]
    assert found[part] == pytest.approx(pressures[part], rel=2e-5)


def test_an_isothermal_vessel_is_the_limit_of_a_warm_one():
    passed = np.linspace(0.0, 1.5e-5, 50)
    limit = Descent(vessel(2e-3, 1e12), 8e5).pressure(passed)[0]
    assert Descent(vessel(2e-3, inf), 8e5).pressure(passed)[0] == pytest.approx(limit, rel=1e-4)


CASES = {
    "2 L of steel": (2e-3, 5.0, (8e5,), 2.0, inf),
    "2 L whose wall grows cold": (2e-3, 5.0, (8e5,), 2.0, 2000.0),
    "0.5 L from two pressures": (0.5e-3, 1.2, (5e5, 8e5), 0.5, inf),
    "20 L in 20 s": (20e-3, 20.0, (8e5,), 20.0, inf),
    "full of wire, not said": (1e-3, 500.0, (8e5,), 1.0, inf),
}


@pytest.mark.parametrize("case", CASES)
def test_area_and_conductance_of_a_warm_vessel_are_found(case):
    volume, conductance, initials, end, capacity = CASES[case]
    for seed in range(2):
        records = [record_of(volume, conductance, p, end, seed=seed, capacity=capacity) for p in initials]
        wall = wall_of(volume, records)
        assert wall.is_identified
        assert wall.area == pytest.approx(FULL, abs=1.5 * wall.area_half_band)
        assert wall.area_half_band < 0.005 * FULL
        assert wall.adiabatic_area < 0.99 * FULL
        assert wall.conductance == pytest.approx(conductance, abs=2.0 * wall.half_band)


def test_the_area_lies_within_its_band_as_often_as_the_band_says():
    areas = [wall_of(0.5e-3, [record_of(0.5e-3, 1.2, p, 0.5, seed=s) for p in (5e5, 8e5)]) for s in range(6)]
    assert sum(abs(wall.area - FULL) <= wall.area_half_band for wall in areas) >= 5


@pytest.mark.parametrize("noise", [200.0, 2000.0])
def test_no_wall_is_found_where_none_gives_heat(noise):
    for seed in range(3):
        wall = wall_of(0.5e-3, [record_of(0.5e-3, 0.0, p, 0.5, noise=noise, seed=seed) for p in (5e5, 8e5)])
        assert not wall.is_identified


def test_a_record_that_is_choked_for_too_short_a_time_tells_no_wall():
    record = record_of(0.5e-3, 1.2, 8e5, 0.5)
    assert wall_of(0.5e-3, [record._replace(times=record.times, pressures=np.full_like(record.times, 1.5e5))]) is None


def test_the_curve_of_a_warm_vessel_comes_to_the_true_area():
    result = discharge(vessel(0.5e-3), [record_of(0.5e-3, 1.2, p, 0.5) for p in (5e5, 8e5)])
    assert result.warnings == []
    assert result.full_area == pytest.approx(FULL, abs=result.full_area_half_band)
    assert result.full_area_half_band < 0.002 * FULL
    assert result.curve[-1, 2] == result.full_area
    assert 2e-3 < result.curve[-1, 0] < 7e-3  # open at 3 ms, samples each 1 ms
    assert result.collapse.agree


def valve_of_a_low_critical_ratio(ratio):
    """ISO 6358 with b = 0.3, scaled to the nozzle's choked flow."""
    return psi(0.0) * sqrt(max(1.0 - (max(ratio - 0.3, 0.0) / 0.7) ** 2, 0.0))


def test_a_valve_that_closes_again_gives_no_curve_but_a_reason_and_figures(tmp_path, capsys):
    record = record_of(0.5e-3, 1.2, 8e5, 0.12, closes=20e-3)
    path = tmp_path / "p.csv"
    rows = np.column_stack((1e3 * record.times, record.pressures / 1e3))
    np.savetxt(path, rows, "%.9g", ",", header="time [ms],pressure [kPa abs]", comments="")
    out = tmp_path / "curve.csv"
    out.write_text("an old one")
    options = {"out": out, "overwrite": True}
    assert command(Common(Console(as_json=True)), [path], "0.5 L", **options) == INCOMPLETE
    data = json.loads(capsys.readouterr().out)
    assert data["effective_area_mm2"] is data["opens_ms"] is data["curve"] is None
    assert "close again" in data["no_curve"]
    assert "wire" in data["no_curve"]
    assert len(data["figures"]) == 4
    assert out.read_text() == "an old one"


KNOTS = np.arange(41) * 1e-3


def fit_of(area, half_band=2e-7):
    return AreaFit(KNOTS, area, np.full(41, half_band), (half_band / 2.0) ** 2 * np.eye(41), np.zeros(1), [], 1.0)


def test_the_plateau_is_that_of_the_choked_part_where_the_rest_is_another():
    area = FULL * np.clip(KNOTS / 3e-3, 0.0, 1.0)
    whole = find_plateau(fit_of(area), 40e-3, 15e-3)
    assert whole.end == 40e-3
    assert whole.area == pytest.approx(FULL)
    falls = np.where(KNOTS > 15e-3, 0.7 * FULL, area)
    choked = find_plateau(fit_of(falls), 40e-3, 15e-3)
    assert choked.end == 15e-3
    assert choked.area == pytest.approx(FULL)
    assert not leaves_band(fit_of(falls), choked)
    assert leaves_band(fit_of(falls), Plateau(20, 40e-3, 0.7 * FULL, 1e-8))
    assert cut(fit_of(falls), 15e-3).area.max() == pytest.approx(FULL)


def test_a_low_critical_ratio_moves_neither_area_nor_curve_and_is_told():
    record = record_of(0.1e-3, 0.0, 9e5, 0.2, rate=5e3, nozzle=valve_of_a_low_critical_ratio)
    result = discharge(vessel(0.1e-3), [record])
    assert any("choked" in warning for warning in result.warnings)
    assert result.full_area == pytest.approx(FULL, rel=0.01)
