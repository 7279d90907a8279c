"""Runs that differ from one another and from their record, by data of the independent simulator."""

from functools import cache

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.gap.design.isolability import find_isolability
from apesim.studies.gap.report.run_scatter import describe_scatter
from apesim.studies.gap.search.run_faults import find_files
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import Measured
from tests.gap_bench import AMBIENT, BUT_RIVALS, NOISE, RIVALS, record
from tests.truth.simulator.terms import force
from tests.truth.simulator.valve import Bench

TIMES = np.linspace(0.0, 0.1, 401)
POINTS = {0.2e6: 2, 0.4e6: 3, 0.7e6: 2}
"""Repeats at each supply pressure."""
HELD = 4.0
"""Force to the open stop that the model lacks [N]."""


def one_run(rng, bench, gauge, role, number, wrong=1.0):
    """A run of a bench whose friction, dead time and supply are a little other ones each time."""
    rig = bench._replace(
        supply_pressure=AMBIENT + gauge * (1.0 + 0.003 * rng.normal()) * wrong,
        supply_temperature=287.0 + 0.5 * rng.normal(),
        viscous_friction=bench.viscous_friction * (1.0 + 0.03 * rng.normal()),
        dead_time=bench.dead_time + 0.03e-3 * rng.normal(),
    )
    return record(rig, rng, gauge, role, TIMES, f"{number}.csv")


def measure(hidden=False, wrong=1.0, seed=7, points=POINTS):
    """Seven runs to fit and one to check; the supply of the last one to fit is not what is recorded."""
    rng = np.random.default_rng(seed)
    bench = Bench(terms=(force(lambda now: HELD),)) if hidden else Bench()
    order = [(gauge, "fit") for gauge, repeats in points.items() for _ in range(repeats)] + [(0.55e6, "check")]
    runs = [
        one_run(rng, bench, gauge, role, number, wrong if number == len(order) - 2 else 1.0)
        for number, (gauge, role) in enumerate(order)
    ]
    return Measured("", NOISE, tuple(runs))


@cache
def explained(**how):
    return explain(Machine(), measure(**how), without=BUT_RIVALS)


@pytest.mark.slow
def test_where_nothing_is_hidden_scatter_is_no_gap():
    found = explained()
    assert found.verdict == "NO_GAP"
    told = {row["key"]: row for row in describe_scatter(found.calibrated.residuals)}
    assert "valve.viscous_friction" in told
    assert told["valve.viscous_friction"]["differences"] == 4
    left = found.calibrated.fitted.data_residuals
    assert np.sqrt(np.mean(left**2)) == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
def test_a_hidden_effect_is_named_beside_it():
    found = explained(hidden=True)
    assert found.verdict in ("NAMED", "NAMED_CLASS")
    assert found.best.names == ("side_force",)
    assert abs(found.best.machine().effects.side_force.force) == pytest.approx(HELD, rel=0.25)


@pytest.mark.slow
def test_a_run_whose_supply_is_wrong_by_more_than_scatter_is_found():
    found = explained(wrong=1.05)
    assert found.verdict == "MEASUREMENT"
    assert find_files(found.best.candidates) == ["6.csv"]


# --- stated ---

ALONE = dict.fromkeys((0.2e6, 0.3e6, 0.4e6, 0.55e6, 0.7e6), 1)
"""Points without repeats."""
STATED = {
    "supply.pressure": Uncertainty(0.003, True),
    "supply.temperature": Uncertainty(0.5),
    "valve.viscous_friction": Uncertainty(0.03, True),
    "valve.solenoid.dead_time": Uncertainty(0.03e-3),
}


@pytest.mark.slow
def test_without_repeats_a_scatter_that_is_stated_is_no_gap():
    measured = measure(points=ALONE)
    assert explain(Machine(), measured, without=BUT_RIVALS).gap_test.alarm
    found = explain(Machine(), measured._replace(scatter=STATED), without=BUT_RIVALS)
    assert found.verdict == "NO_GAP"
    told = {row["key"]: row for row in describe_scatter(found.calibrated.residuals)}
    assert {key: row["deviation"] for key, row in told.items()} == {
        "supply.pressure": "0.3 %",
        "supply.temperature": "0.5 K",
        "valve.viscous_friction": "3 %",
        "valve.solenoid.dead_time": "0.03 ms",
    }
    assert {row["differences"] for row in told.values()} == {None}


def test_a_scatter_that_is_stated_counts_in_what_data_could_show():
    one = Measured("", NOISE, tuple(run for run in measure(points=ALONE).runs if run.role == "fit"))
    without = [*BUT_RIVALS, *(name for name in RIVALS if name != "quadratic_drag")]
    limits = [
        find_isolability(Machine(), measured, without=without).effects[0]["limit"]
        for measured in (one, one._replace(scatter=STATED))
    ]
    assert limits[1] > 1.4 * limits[0]  # friction scatters, too
