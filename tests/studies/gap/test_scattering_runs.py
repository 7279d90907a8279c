"""Runs that differ from one another and from their record, by data of the independent simulator."""

from functools import cache

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.gap.report.run_scatter import describe_scatter
from apesim.studies.gap.search.run_faults import find_files
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import Measured
from tests.gap_bench import AMBIENT, BUT_RIVALS, NOISE, record
from tests.truth.terms import force
from tests.truth.valve import Bench

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


@cache
def explained(hidden=False, wrong=1.0, seed=7):
    """What is said of seven runs to fit and one to check; the supply of the last one to fit is not what is recorded."""
    rng = np.random.default_rng(seed)
    bench = Bench(terms=(force(lambda now: HELD),)) if hidden else Bench()
    order = [(gauge, "fit") for gauge, repeats in POINTS.items() for _ in range(repeats)] + [(0.55e6, "check")]
    runs = [
        one_run(rng, bench, gauge, role, number, wrong if number == len(order) - 2 else 1.0)
        for number, (gauge, role) in enumerate(order)
    ]
    return explain(Machine(), Measured("", NOISE, tuple(runs)), without=BUT_RIVALS)


def test_where_nothing_is_hidden_scatter_is_no_gap():
    found = explained()
    assert found.verdict == "NO_GAP"
    told = {row["key"]: row for row in describe_scatter(found.calibrated.residuals)}
    assert "valve.viscous_friction" in told
    assert told["valve.viscous_friction"]["differences"] == 4
    left = found.calibrated.fitted.data_residuals
    assert np.sqrt(np.mean(left**2)) == pytest.approx(1.0, abs=0.03)


def test_a_hidden_effect_is_named_beside_it():
    found = explained(hidden=True)
    assert found.verdict in ("NAMED", "NAMED_CLASS")
    assert found.best.names == ("side_force",)
    assert abs(found.best.machine().effects.side_force.force) == pytest.approx(HELD, rel=0.25)


def test_a_run_whose_supply_is_wrong_by_more_than_scatter_is_found():
    found = explained(wrong=1.05)
    assert found.verdict == "MEASUREMENT"
    assert find_files(found.best.candidates) == ["6.csv"]
