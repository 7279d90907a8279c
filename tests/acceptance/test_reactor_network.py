"""The cylinder against a reactor network of Cantera that is given the same flows.

Stated error: 2e-5 of pressure and temperature, 1e-4 of the work, which is a difference of larger ones.
"""

import pytest

from apesim.engine.cycle.state import engine_ledger
from tests import lemmon_air
from tests.acceptance.reactor_network import CASES, compared, lemmons_air

ERROR, WORK_ERROR = 2e-5, 1e-4


@pytest.mark.parametrize("case", CASES)
def test_cylinder_agrees_with_a_reactor_network(case):
    found = compared(*CASES[case])
    ledger = engine_ledger(found.run.end)
    if case == "back-flow":
        assert ledger.groove_back > 0.02 * ledger.groove.mass
        assert ledger.exhaust_back > 0.02 * ledger.groove.mass
    assert found.pressure < ERROR
    assert found.temperature < ERROR
    assert found.work < WORK_ERROR


@pytest.mark.parametrize("temperature", [110.0, 160.0, 287.0, 500.0, 900.0])
def test_the_network_s_air_is_lemmons(temperature):
    air, room = lemmons_air(temperature, 2e5), lemmons_air(300.0, 1e5)
    assert air.cp_mass == pytest.approx(lemmon_air.heat_capacity(temperature), rel=1e-6)
    rise = lemmon_air.enthalpy(temperature) - lemmon_air.enthalpy(300.0)
    assert air.enthalpy_mass - room.enthalpy_mass == pytest.approx(rise, rel=1e-6)
    rise = lemmon_air.entropy(temperature, 2e5) - lemmon_air.entropy(300.0)
    assert air.entropy_mass - room.entropy_mass == pytest.approx(rise, rel=1e-5, abs=1e-3)
