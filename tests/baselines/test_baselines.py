"""What the blind benchmark is compared with finds what it can find, so that its failures are its own."""

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.gap.search.library import select_effects
from apesim.studies.measured import Measured, MeasuredRun
from apesim.studies.measured.prediction import predict, run_of
from tests.baselines.fits import one_parameter_fits
from tests.baselines.selection import select_by_bic

AMBIENT = 101325.0
TIMES = np.arange(0.0, 0.07, 0.1e-3)
RIVALS = [
    effect for effect in select_effects("valve") if effect.name in ("side_force", "seal_friction", "spring_rate_error")
]
NOISE = {"lift": 0.03e-3, "pressure_a": 2e3, "pressure_b": 2e3}


def measured(noise):
    """Runs of a valve with a side force of 6 N, and a share of the usual noise."""
    machine, rng, runs = Machine.load(None, ["effects.side_force.force=6 N"]), np.random.default_rng(7), []
    for gauge in (0.16e6, 0.40e6):
        run = MeasuredRun(f"{gauge:g}", "", gauge + AMBIENT, 287.0, 0.03, "fit", TIMES, dict.fromkeys(NOISE, TIMES))
        seen = predict(run_of(machine, run), run).channels
        runs.append(
            run._replace(channels={k: seen[k] + noise * s * rng.standard_normal(len(TIMES)) for k, s in NOISE.items()})
        )
    return Measured("", NOISE, tuple(runs))


def test_the_best_one_parameter_fit_finds_a_plain_force():
    base, rows = one_parameter_fits(Machine(), measured(1.0), RIVALS)
    cost, name, parameter, x, _ = rows[0]
    assert cost < base
    assert name == "side_force"
    assert parameter.value(x) == pytest.approx(6.0, abs=2.0)


def test_sparse_regression_finds_a_plain_force_where_there_is_no_noise():
    pytest.importorskip("pysindy", reason='python -m pip install -e ".[laboratory]"')
    from tests.baselines.sparse import missing_force

    name, size = missing_force(Machine(), measured(0.0))[0]
    assert name == "side_force"
    assert size == pytest.approx(6.0, rel=0.2)


def test_a_selection_by_bic_finds_a_plain_force_with_all_nuisances_free_and_nothing_in_noise():
    best, tried, nuisances = select_by_bic(Machine(), measured(1.0), RIVALS)
    (added,) = best.effects
    assert added.name == "side_force"
    assert added.strengths[0].value(best.x[-1]) == pytest.approx(6.0, abs=2.0)
    assert len(best.x) == len(nuisances) + 1
    assert best.bic == min(model.bic for model in tried)
    fair, noise = Machine.load(None, ["effects.side_force.force=6 N"]), measured(1.0)
    assert select_by_bic(fair, noise, [one for one in RIVALS if one.name != "side_force"])[0].effects == ()
