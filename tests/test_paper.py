"""The claims of doi 10.1631/jzus.A0820373: what the model says to each, and that a verdict can be otherwise."""

import json
from dataclasses import replace

import numpy as np
import pytest

from engine.machine import Machine
from studies.figures.paper import CAPTIONS, paper_figures
from studies.paper import delay, design, stroke
from studies.paper.claim import CALIBRATED, CONTRADICTED, NOT_COMPUTABLE, REPRODUCED, grid_of
from studies.paper.claims import all_claims
from studies.paper.page import write_page
from studies.valve_map import map_valve

AMBIENT = Machine().ambient.pressure


@pytest.fixture(scope="module")
def archive():
    return map_valve(Machine(), AMBIENT + 1e6 * np.arange(0.1, 2.0, 0.2), np.arange(250.0, 323.0, 8.0))


@pytest.fixture(scope="module")
def judged(archive):
    return {claim.key: claim for claim in all_claims(Machine(), archive)}


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
        ("rebound", CONTRADICTED),
        ("stroke_time_over_pressure", CONTRADICTED),
        ("seating_speed_over_pressure", REPRODUCED),
        ("stroke_time_over_temperature", REPRODUCED),
        ("opening_and_closing_alike", CONTRADICTED),
        ("working_frequency", REPRODUCED),
        ("engine_speed", CONTRADICTED),
        ("gauge_pressures", CONTRADICTED),
        ("sign_of_outflow", CONTRADICTED),
        ("friction_is_negligible", REPRODUCED),
        ("springs_soften_the_impact", REPRODUCED),
        ("viscous_friction", NOT_COMPUTABLE),
        ("time_error", NOT_COMPUTABLE),
    ],
)
def test_each_claim_is_judged(judged, key, verdict):
    assert judged[key].verdict == verdict
    assert judged[key].claim and judged[key].paper and judged[key].ours and judged[key].values


def test_there_is_no_claim_without_a_test(judged):
    assert len(judged) == 20


def test_numbers_agree_with_the_independent_solution(judged):
    # Opening delays of tests/acceptance/reference-valve.csv at 287 K and over 250 to 322 K [ms].
    values = judged["size_of_temperature"].values
    assert values["change_ms"] == pytest.approx(6.06076 - 5.65764, abs=2e-3)
    levels = judged["delay_levels_off"].values
    assert levels["below_ms_per_MPa"] == pytest.approx((5.74617 - 4.85172) / 0.6, rel=0.02)
    assert levels["above_ms_per_MPa"] == pytest.approx((5.83472 - 5.74617) / 1.2, rel=0.05)
    alike = judged["opening_and_closing_alike"].values
    assert alike["largest_difference"] == pytest.approx(1.57746 / 1.42826 - 1.0, rel=1e-3)


def test_a_pressure_at_rest_is_reached_in_a_time_that_falls_with_the_root_of_temperature(judged):
    values = judged["temperature_scaling"].values
    assert values["time_s_at_250_K"] / values["time_s_at_322_K"] == pytest.approx(np.sqrt(322.0 / 250.0), rel=2e-4)


def test_gauge_pressure_in_eq_10_gives_a_quarter_too_much_area(judged):
    values = judged["gauge_pressures"].values
    assert values["exponent"] == pytest.approx(-1.0)
    assert values["area_ratio"] == pytest.approx(501.325 / 400.0)


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
    ],
)
def test_the_opposite_trend_gets_the_opposite_verdict(archive, name, judge, verdict):
    assert judge(turned_round(archive, name)).verdict == verdict


def test_a_curved_or_turning_grid_is_noticed(archive):
    grid = grid_of(archive, AMBIENT)
    bent = grid._replace(opening=grid.opening | {"delay_s": grid.opening["delay_s"] ** 40})
    assert delay.delay_is_linear(bent).verdict == CONTRADICTED
    turning = grid._replace(opening=grid.opening | {"reverses": np.ones_like(grid.opening["reverses"])})
    assert stroke.piston_rebounds(turning).verdict == REPRODUCED


def test_a_sticky_piston_is_not_called_free(monkeypatch):
    parameters = design.CoulombFriction
    monkeypatch.setattr(design, "CoulombFriction", lambda *_: parameters(12.0, 12.0))
    assert design.friction_is_small(Machine()).verdict == CONTRADICTED


def test_the_page_shows_every_claim_and_figure(archive, judged, tmp_path):
    drawn = paper_figures(Machine(), archive, tmp_path)
    assert {path.stem for path in drawn} == set(CAPTIONS)
    text = write_page(list(judged.values()), CAPTIONS, tmp_path).read_text()
    assert all(f"{name}.png" in text for name in CAPTIONS)
    assert text.count('class="verdict') == len(judged)


def test_the_command_leaves_page_and_claims(tmp_path, monkeypatch, capsys):
    import sys

    from studies.cli import app
    from studies.console import main_of

    out = tmp_path / "paper"
    monkeypatch.setattr(sys, "argv", ["apesim", "paper", "--out", str(out), "--json"])
    assert main_of(app) == 0
    assert json.loads(capsys.readouterr().out)["claims"] == json.loads((out / "claims.json").read_text())
    assert (out / "index.html").exists()
    assert main_of(app) == 2
    assert "--overwrite" in capsys.readouterr().err
