"""The claims of doi 10.1631/jzus.A0820373: what the model says to each, and that a verdict can be otherwise."""

import json
from dataclasses import replace

import numpy as np
import pytest
from machines import changed

from engine.machine import Machine
from studies.discharge import discharge
from studies.figures.paper import captions_of, paper_figures
from studies.limit import Limit, is_complete
from studies.paper import delay, design, equations, stroke
from studies.paper.claim import CALIBRATED, CONTRADICTED, NOT_COMPUTABLE, REPRODUCED, grid_of
from studies.paper.claims import all_claims
from studies.paper.discharge import area_at, discharge_tests, emptied, vessel_of
from studies.paper.page import write_page
from studies.paper.subject import differences
from studies.valve_map import map_valve

AMBIENT = Machine().ambient.pressure


@pytest.fixture(scope="module")
def archive():
    return map_valve(Machine(), AMBIENT + 1e6 * np.arange(0.1, 2.0, 0.2), np.arange(250.0, 323.0, 8.0))


@pytest.fixture(scope="module")
def found():
    return discharge(*discharge_tests(Machine()))


@pytest.fixture(scope="module")
def judged(archive, found):
    return {claim.key: claim for claim in all_claims(Machine(), archive, found)}


@pytest.mark.parametrize(
    ("key", "verdict"),
    [
        ("delay_over_pressure", REPRODUCED),
        ("delay_levels_off", REPRODUCED),
        ("delay_over_temperature", CONTRADICTED),
        ("temperature_scaling", CONTRADICTED),
        ("size_of_temperature", CALIBRATED),
        ("delay_linear_in_temperature", REPRODUCED),
        ("fluctuation_over_pressure", REPRODUCED),
        ("fluctuation_from_limited_area", REPRODUCED),
        ("pressure_behind_falls_below", CONTRADICTED),
        ("rebound", CONTRADICTED),
        ("stroke_time_over_pressure", CONTRADICTED),
        ("seating_speed_over_pressure", CONTRADICTED),
        ("response_over_pressure", CONTRADICTED),
        ("stroke_time_over_temperature", REPRODUCED),
        ("opening_and_closing_alike", CONTRADICTED),
        ("reaches_30_hz", REPRODUCED),
        ("working_frequency", CONTRADICTED),
        ("engine_speed", CONTRADICTED),
        ("areas_collapse", REPRODUCED),
        ("exponents_of_eq_10", REPRODUCED),
        ("gauge_pressures", CONTRADICTED),
        ("sign_of_outflow", CONTRADICTED),
        ("friction_is_negligible", REPRODUCED),
        ("heat_is_negligible", REPRODUCED),
        ("springs_soften_the_impact", REPRODUCED),
        ("viscous_friction", NOT_COMPUTABLE),
        ("time_error", NOT_COMPUTABLE),
    ],
)
def test_each_claim_is_judged(judged, key, verdict):
    assert judged[key].verdict == verdict
    assert judged[key].claim and judged[key].paper and judged[key].ours and judged[key].values


def test_there_is_no_claim_without_a_test(judged):
    assert len(judged) == 27


def test_numbers_agree_with_the_independent_solution(judged):
    # Opening delays of tests/acceptance/reference-valve.csv at 287 K and over 250 to 322 K [ms].
    values = judged["size_of_temperature"].values
    assert values["change_ms"] == pytest.approx(5.65764 - 6.06076, abs=2e-3)
    assert "a fall" in judged["size_of_temperature"].ours
    levels = judged["delay_levels_off"].values
    assert levels["below_ms_per_MPa"] == pytest.approx((5.74617 - 4.85172) / 0.6, rel=0.02)
    assert levels["above_ms_per_MPa"] == pytest.approx((5.83472 - 5.74617) / 1.2, rel=0.05)
    alike = judged["opening_and_closing_alike"].values
    assert alike["largest_difference"] == pytest.approx(1.57746 / 1.42826 - 1.0, rel=1e-3)
    assert alike["largest_difference_repeated"] < 1e-6
    at_250_k, at_322_k = 6.06076 + 5.95672, 5.65764 + 5.31398
    response = judged["response_over_pressure"].values
    assert at_322_k < response["mean_at_highest_pressure_ms"] < at_250_k
    assert response["highest_step_ms"] < 0.0


def test_the_seating_speed_turns_back_in_cold_air_alone_and_hardly(judged):
    # The independent solution at 1.5 and 1.9 MPa: 1.42822 and 1.42826 m/s at 250 K, 1.53111 and 1.55249 at 287 K.
    values = judged["seating_speed_over_pressure"].values
    assert values["temperatures_not_monotonic"] == 3
    assert 0.0 < values["largest_way_back"] < 0.01
    assert judged["stroke_time_over_pressure"].values["largest_way_back"] == 0.0


def test_what_makes_the_speed_fluctuate(judged):
    """A little at the lowest pressure, by the springs; much at the highest, unless the solenoids are large."""
    soft = design.with_supply(changed(Machine(), {"valve.spring_rate": 0.0}), AMBIENT + 0.1e6, 287.0)
    assert judged["fluctuation_over_pressure"].values["at_lowest_pressure"] > 0.05
    assert stroke.run_bench(soft, 50e-3).opening.fluctuation == 0.0
    wide = changed(Machine(), {"valve.solenoid.effective_area": 36e-6})
    assert stroke.fluctuation_from_limited_area(wide).verdict == CONTRADICTED
    slippery = changed(Machine(), {"valve.viscous_friction": 20.0})
    assert stroke.pressures_cross(slippery).verdict == REPRODUCED


@pytest.mark.parametrize(
    ("limit", "verdicts"),
    [(28.0, (CONTRADICTED, REPRODUCED)), (32.0, (REPRODUCED, REPRODUCED)), (60.0, (REPRODUCED, CONTRADICTED))],
)
def test_reaching_a_rate_is_one_claim_and_ending_there_another(monkeypatch, limit, verdicts):
    monkeypatch.setattr(design, "working_limit", lambda *_: Limit(limit, np.nan, 1))
    assert tuple(claim.verdict for claim in design.working_frequency(Machine())) == verdicts


def test_half_of_the_period_is_the_best_duty():
    supplied = design.with_supply(Machine(), AMBIENT + 0.4e6, 287.0)
    assert [is_complete(supplied, 55.0, duty) for duty in (0.3, 0.4, 0.5, 0.6)] == [False, False, True, False]


def test_a_pressure_at_rest_is_reached_in_a_time_that_falls_with_the_root_of_temperature(judged):
    values = judged["temperature_scaling"].values
    assert values["time_s_at_250_K"] / values["time_s_at_322_K"] == pytest.approx(np.sqrt(322.0 / 250.0), rel=2e-4)


@pytest.mark.parametrize("other", [{"valve.solenoid.effective_area": 3e-6}, {"valve.stroke": 4e-3}])
def test_the_dimensional_argument_holds_on_other_valves(other):
    values = delay.temperature_scaling(changed(Machine(), other)).values
    assert values["spread"] < 2e-4
    assert values["time_s_at_250_K"] > values["time_s_at_322_K"]


def test_the_dimensional_argument_is_not_made_of_a_piston_that_moves():
    sprung = {"valve.spring_rate": 6e4}  # opens at 6e4 N/m 9 mm/1134.1 mm2 = 0.48 MPa between the chambers
    assert np.isnan(delay.temperature_scaling(changed(Machine(), sprung)).values["time_s_at_287_K"])


def test_the_models_vessel_empties_as_choked_flow_does_in_closed_form():
    # Choked, dp/dt = -k psi sqrt(R T_ini) S/V p_ini (p/p_ini)^(8/7) is solved by p = p_ini (1 + Y/5)^-7,
    # with Y = psi sqrt(R T_ini)/V times the integral of S: 9 mm2 for t less 2.25 ms once the valve is open.
    times = np.array([-1e-3, 1.5e-3, 3.0e-3, 8.0e-3, 14.0e-3])
    integral = np.array([0.0, 0.0, 6.75e-9, 51.75e-9, 105.75e-9])
    y = 0.6847315 * np.sqrt(287.05 * 293.15) / 50e-6 * integral
    expected = 901325.0 * (1.0 + 0.2 * y) ** -7.0
    found = emptied(Machine(), vessel_of(Machine()), 901325.0, times)
    assert found == pytest.approx(expected, rel=1e-6)


def test_eq_10_gives_the_area_back_with_absolute_pressures_and_a_quarter_too_much_with_gauge_ones(judged):
    values = judged["gauge_pressures"].values
    assert values["largest_error_absolute"] < 5e-4
    for end in ("start", "end"):
        # Choked on both scales: p^(-8/7) p_ini^(1/7) of the gauge pressures over that of the absolute ones.
        p = values[f"pressure_at_{end}_Pa"]
        ratio = ((p - AMBIENT) / p) ** (-8.0 / 7.0) * (400.0 / 501.325) ** (1.0 / 7.0)
        assert values[f"error_gauge_at_{end}"] == pytest.approx(ratio - 1.0, abs=1e-3)
    assert values["error_gauge_at_start"] > 0.25


def test_the_exponents_are_those_of_k_1_4_whatever_eq_10_says(judged):
    values = judged["exponents_of_eq_10"].values
    assert values["of_pressure"] == pytest.approx(-8.0 / 7.0, abs=1e-4)
    assert values["of_initial_pressure"] == pytest.approx(1.0 / 7.0, abs=1e-4)


def test_a_wrong_law_in_eq_10_is_noticed(monkeypatch):
    right = equations.effective_area
    monkeypatch.setattr(equations, "effective_area", lambda v, start, p, slopes: right(v, start, p, slopes) * p / start)
    assert equations.gauge_pressures(Machine()).values["largest_error_absolute"] > 0.1


def test_chambers_would_hold_twice_what_left_them_too_much(judged):
    # After an opening and a closing the valve is as it was, but for chamber B, which has been vented of its ambient
    # air at 293 K and is now full of colder air: out is a little more than in.
    assert judged["sign_of_outflow"].values["mass_too_much_by_the_sum"] == pytest.approx(2.0, abs=0.2)
    assert judged["sign_of_outflow"].values["mass_closure"] < 1e-12


def test_curves_that_do_not_collapse_are_noticed():
    vessel, records = discharge_tests(Machine())
    wrong = [records[0]._replace(pressures=records[0].pressures - 0.05e6), *records[1:]]
    assert equations.curves_collapse(discharge(vessel, wrong)).verdict == CONTRADICTED


def test_the_model_area_lies_in_the_band(found):
    told = (found.pooled.knots > 0.3e-3) & (found.pooled.knots <= found.end)
    error = np.abs(found.pooled.area - area_at(Machine(), found.pooled.knots))[told]
    assert np.mean(error <= found.pooled.half_band[told]) > 0.85


def turned_round(archive, name):
    """The archive with a measure's order over the grid reversed: each trend is the opposite one."""
    variables = dict(archive.variables)
    for side in ("opening", "closing"):
        variable = variables[f"{side}_{name}"]
        variables[f"{side}_{name}"] = replace(variable, values=variable.values[::-1].copy())
    return grid_of(replace(archive, variables=variables), AMBIENT)


@pytest.mark.parametrize(
    ("name", "judge", "verdict"),
    [
        ("delay_s", delay.delay_rises_with_pressure, CONTRADICTED),
        ("delay_s", delay.delay_levels_off, CONTRADICTED),
        ("delay_s", delay.delay_and_temperature, REPRODUCED),
        ("fluctuation", stroke.fluctuation_rises, CONTRADICTED),
        ("stroke_time_s", stroke.stroke_time_falls_with_temperature, CONTRADICTED),
        ("stroke_time_s", stroke.response_over_pressure, REPRODUCED),
    ],
)
def test_the_opposite_trend_gets_the_opposite_verdict(archive, name, judge, verdict):
    assert judge(turned_round(archive, name)).verdict == verdict


def test_a_curved_or_turning_grid_is_noticed(archive):
    grid = grid_of(archive, AMBIENT)
    bent = grid._replace(opening=grid.opening | {"delay_s": grid.opening["delay_s"] ** 40})
    assert delay.delay_is_linear(bent).verdict == CONTRADICTED
    humped = grid.opening["seating_speed_m_s"] - 2.0 * (np.arange(10)[:, None] > 7)
    turned = grid._replace(opening=grid.opening | {"seating_speed_m_s": humped})
    key = "seating_speed_over_pressure"
    assert stroke.not_monotonic(turned, key, "seating_speed_m_s", "speed", "m/s", 1.0).verdict == REPRODUCED
    turning = grid._replace(opening=grid.opening | {"reverses": np.ones_like(grid.opening["reverses"])})
    assert stroke.piston_rebounds(turning).verdict == REPRODUCED


def test_a_sticky_piston_is_not_called_free(monkeypatch):
    parameters = design.CoulombFriction
    monkeypatch.setattr(design, "CoulombFriction", lambda *_: parameters(12.0, 12.0))
    assert design.friction_is_small(Machine()).verdict == CONTRADICTED


def test_much_heat_is_not_called_negligible(monkeypatch):
    monkeypatch.setattr(design, "HEAT", 1000.0)
    assert design.heat_is_small(Machine()).verdict == CONTRADICTED


def test_the_page_shows_every_claim_and_figure(archive, found, judged, tmp_path):
    drawn = paper_figures(Machine(), archive, found, tmp_path)
    captions = captions_of(vessel_of(Machine()))
    assert [path.stem[:5] for path in drawn[::2]] == [f"fig{n:02}" for n in (3, 4, 6, 7, 8, 9, 10, 11)]
    assert {path.stem for path in drawn} == set(captions)
    assert "model's own discharge tests (50 cm³, 0.5 kPa noise, 50 kHz), not measured" in captions["fig03_discharge"]
    text = write_page(list(judged.values()), captions, [], tmp_path).read_text()
    assert all(f"{name}.png" in text and f"{name}.pdf" in text for name in captions)
    assert text.count('class="verdict') == len(judged)
    assert "Judged on the paper's valve" in text
    assert all(b"/Subtype /Image" not in path.read_bytes() for path in drawn if path.suffix == ".pdf")


def test_another_valve_is_named_and_nothing_is_called_calibrated_on_it(archive, found, judged, tmp_path):
    other = changed(Machine(), {"valve.moving_mass": 0.2, "effects.ring_leakage.area": 1e-7, "engine.bore": 0.09})
    different = differences(other)
    assert different[0] == "valve.moving_mass = 0.2 kg instead of 0.1145 kg"
    assert len(different) == 2 and different[1].startswith("effects.ring_leakage.area = ")
    claims = {claim.key: claim for claim in all_claims(other, archive, found)}
    assert claims["size_of_temperature"].verdict == REPRODUCED
    assert all(claim.judged_on == f"another valve: {', '.join(different)}" for claim in claims.values())
    assert all(claim.judged_on == "the paper's valve" for claim in judged.values())
    text = write_page(list(claims.values()), {}, different, tmp_path).read_text()
    assert "Judged on another valve" in text and different[0] in text


def test_nothing_is_judged_by_strokes_that_are_not_completed(archive, found):
    variables = dict(archive.variables)
    variable = variables["opening_stroke_time_s"]
    values = variable.values.copy()
    values[3] = np.nan
    broken = replace(archive, variables=variables | {"opening_stroke_time_s": replace(variable, values=values)})
    verdicts = {claim.key: claim.verdict for claim in all_claims(Machine(), broken, found)}
    assert verdicts["stroke_time_over_temperature"] == NOT_COMPUTABLE
    assert verdicts["delay_over_pressure"] == REPRODUCED


def test_the_command_leaves_page_and_claims(tmp_path, monkeypatch, capsys):
    import sys

    from studies.cli import app
    from studies.console import main_of

    out = tmp_path / "paper"
    monkeypatch.setattr(sys, "argv", ["apesim", "paper", "--out", str(out), "--json"])
    assert main_of(app) == 0
    assert json.loads(capsys.readouterr().out)["claims"] == json.loads((out / "claims.json").read_text())
    assert (out / "index.html").exists()
    assert (out / "machine.toml").exists()
    assert main_of(app) == 2
    assert "--overwrite" in capsys.readouterr().err
