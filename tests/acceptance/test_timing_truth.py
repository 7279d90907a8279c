"""Corrected commands, tried out by the independent simulator: the valve opens and closes at its targets.

``python -m pytest -m slow tests/acceptance/test_timing_truth.py`` tries the whole default map over speed and pressure.
"""

import pytest

from tests.acceptance.independent_simulator import timing_misses

NEAR = 0.1
"""Miss that a controller can hope for [deg]; measured: within 1e-4 deg."""


@pytest.mark.parametrize(("rpm", "supply"), [(600.0, 1.0), (1000.0, 1.0), (1500.0, 0.6), (2100.0, 1.4)])
def test_the_truth_opens_and_closes_at_the_targets(rpm, supply):
    assert timing_misses(rpm, supply=supply) == pytest.approx((0.0, 0.0), abs=NEAR)


@pytest.mark.slow
def test_with_control_air_from_the_receiver_too():
    assert timing_misses(1000.0, receiver=1.0, control_air="receiver") == pytest.approx((0.0, 0.0), abs=NEAR)


@pytest.mark.slow
@pytest.mark.parametrize("supply", [0.6, 1.0, 1.4])
@pytest.mark.parametrize("temperature", [250.0, 287.0, 322.0])
@pytest.mark.parametrize("rpm", [300.0, 600.0, 900.0, 1200.0, 1500.0, 1800.0, 2100.0, 2400.0])
def test_the_truth_opens_and_closes_at_the_targets_all_over_the_default_map(rpm, temperature, supply):
    assert timing_misses(rpm, supply=supply, temperature=temperature) == pytest.approx((0.0, 0.0), abs=NEAR)
