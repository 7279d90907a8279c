"""Intervals of effects that have a shape, from data of the independent simulator."""

import re
from functools import lru_cache

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate
from apesim.studies.gap.report.effect_rows import describe_effects, find_ends, format_interval, format_value
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.intervals import find_profiles
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.search.refit import refit
from apesim.studies.gap.stage_work import Work
from apesim.studies.measured import Measured, MeasuredRun
from tests.truth.scoring.score import clopper_pearson
from tests.truth.simulator.valve import Bench, noise, simulate

AMBIENT = 101325.0
TIMES = np.arange(0.0, 0.1, 0.2e-3)
PULSE = 50e-3
NOISE = {"lift": 0.03e-3, "pressure_a": 2e3, "pressure_b": 2e3}
RIG = Bench(viscous_friction=117.0, effective_area=8.8e-6, dead_time=1.55e-3, supply_temperature=288.0)
"""A little off from what the machine file says."""


def measured(seed, **friction):
    """Two pressures of the valve's bench with dry friction."""
    rng, runs = np.random.default_rng(seed), []
    for gauge in (0.16e6, 0.40e6):
        rig = RIG._replace(supply_pressure=1.004 * gauge + AMBIENT, **friction)
        states = simulate(rig, PULSE, float(TIMES[-1])).states(TIMES)
        seen = {"lift": rig.stroke - states[0], "pressure_a": states[2], "pressure_b": states[4]}
        channels = {name: seen[name] + noise(len(TIMES), NOISE[name], rng) for name in NOISE}
        runs.append(MeasuredRun(f"{gauge:g}", "", gauge + AMBIENT, 287.0, PULSE, "fit", TIMES, channels))
    return Measured("", NOISE, tuple(runs))


@lru_cache
def friction(seed, force, breakaway):
    """Coulomb friction fitted to it: as the curvature has it, and with profiles."""
    machine = Machine()
    base, _ = calibrate(machine, measured(seed, dry_friction=force, breakaway=breakaway))
    (candidate,) = [
        one for one in find_candidates(machine, "valve", select_effects("valve")) if one.name == "coulomb_friction"
    ]
    model = refit(base, (candidate,), (candidate.switch_on(0, 0.5, (0.1,)),))
    return model, find_profiles(model, Work())[0]


def rows_of(model):
    return {row["parameter"]: row for row in describe_effects(model)}


def test_a_breakaway_that_does_nothing_below_the_friction_is_held_from_above_alone():
    """The cause of an interval of 10 to 36 N where 9 N were hidden: the curvature does not know of the flat below."""
    fitted, found = friction(1, 9.0, 9.0)
    assert fitted.identifiable[-1]
    row = rows_of(found)["breakaway"]
    assert row["open_ends"] == ["low"]
    assert row["interval_95"][0] == 0.0
    assert 20.0 < row["interval_95"][1] < 40.0
    shown = format_value(row)
    assert re.fullmatch(r"at most \d\d N", shown)  # known to some newtons: no digit behind the point
    assert float(shown.split()[2]) == pytest.approx(row["interval_95"][1], abs=1.0)
    assert format_interval(row) == f"{shown} (95 %)"


def test_a_breakaway_is_held_from_above_where_the_best_one_does_nothing():
    fitted, found = friction(3, 9.0, 9.0)
    assert not fitted.identifiable[-1]
    row = rows_of(found)["breakaway"]
    assert row["open_ends"] == ["low"]
    assert 9.0 < row["interval_95"][1] < 40.0


def test_a_breakaway_that_shows_is_held_on_both_sides():
    row = rows_of(friction(8, 6.0, 20.0)[1])["breakaway"]
    assert row["open_ends"] == []
    assert 6.0 < row["interval_95"][0] < 20.0 < row["interval_95"][1] < 40.0


def test_the_interval_of_a_friction_counts_that_some_of_it_may_be_breakaway():
    """If the best breakaway does nothing the curvature takes it to be so: from 6.2 N on where 6 N were hidden."""
    fitted, found = friction(6, 6.0, 20.0)
    assert not fitted.identifiable[-1]
    half = 1.96 * np.sqrt(np.diag(fitted.fitted.covariance)[-2])
    assert fitted.residuals.parameters[-2].value(fitted.fitted.x[-2] - half) > 6.0
    low, high = rows_of(found)["force"]["interval_95"]
    assert low < 6.0 < high


def test_what_an_error_is_above_the_curvature_comes_to_an_interval_by_profiles_in_quadrature(monkeypatch):
    monkeypatch.setattr("apesim.studies.gap.report.effect_rows.WIDENING", 1.0)
    _, found = friction(8, 6.0, 20.0)
    force = len(found.fitted.x) - 2
    own = float(np.sqrt(found.fitted.covariance[force, force]))
    best = found.fitted.x[force]
    for plain, wider in zip(find_ends(found, force, own), find_ends(found, force, 2.0 * own), strict=True):
        added = 1.96 * np.sqrt(3.0) * own
        assert abs(wider.at - best) == pytest.approx(np.hypot(plain.at - best, added), rel=1e-4)
    beyond = find_ends(found, force, 1e3 * own)
    assert [end.is_open for end in beyond] == [True, True]


def test_no_interval_is_told_of_a_shape_where_none_was_sought():
    rows = rows_of(friction(1, 9.0, 9.0)[0])
    assert rows["breakaway"]["interval_95"] is rows["force"]["interval_95"] is None
    assert format_interval(rows["force"]) == "interval not sought"


@pytest.mark.slow
@pytest.mark.parametrize(("force", "breakaway"), [(9.0, 9.0), (6.0, 20.0)])
def test_over_40_noises_the_intervals_hold_what_was_hidden(force, breakaway):
    held: dict = {"force": [], "breakaway": []}
    for seed in range(200, 240):
        rows = rows_of(friction(seed, force, breakaway)[1])
        for name, true in (("force", force), ("breakaway", breakaway)):
            low, high = rows[name]["interval_95"]
            held[name].append(low <= true <= high)
    for hits in map(sum, held.values()):
        assert clopper_pearson(hits, 40, 0.99)[1] >= 0.95, held
