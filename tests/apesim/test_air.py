from math import log

import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.air import (
    COLDEST,
    HOTTEST,
    THERMALLY_PERFECT,
    Air,
    enthalpy,
    gas_of,
    heat_capacity,
    heat_capacity_ratio,
    internal_energy,
    temperature_at_enthalpy,
    temperature_of,
    thermal_entropy,
)
from tests import lemmon_air

IDEAL_GAS = gas_of(Air())
PERFECT_GAS = gas_of(Air(model=THERMALLY_PERFECT))
GASES = pytest.mark.parametrize("gas", [IDEAL_GAS, PERFECT_GAS], ids=["ideal", "thermally perfect"])
TEMPERATURES = st.floats(60.0, HOTTEST)
"""From Lemmon's lowest on: below `COLDEST` cp is constant."""
NEAR = 5e-5
"""What the polynomial of `gas_of` is stated to keep to, of cp."""
JANAF = {
    100.0: (29.104, 29.106),
    200.0: (29.107, 29.126),
    300.0: (29.125, 29.385),
    600.0: (30.110, 32.090),
    1000.0: (32.697, 34.870),
}
"""cp of nitrogen and of oxygen [J/(mol K)]: M. W. Chase, NIST-JANAF Thermochemical Tables, 4th ed., 1998."""
MOLES = 0.7812, 0.2096, 0.0092
"""Nitrogen, oxygen and argon in Lemmon's air."""


@pytest.mark.parametrize("temperature", JANAF)
def test_cp_is_that_of_the_gases_that_air_is_made_of(temperature):
    """Stated error: 2e-4, of the tables and of what is left out (0.04 % of carbon dioxide)."""
    molar = sum(x * cp for x, cp in zip(MOLES, (*JANAF[temperature], 20.786), strict=True))
    assert heat_capacity(PERFECT_GAS, temperature) / PERFECT_GAS.gas_constant == pytest.approx(
        molar / 8.31451, rel=2e-4
    )


@given(TEMPERATURES)
def test_cp_is_lemmons(temperature):
    cp = lemmon_air.heat_capacity(temperature)
    assert heat_capacity(PERFECT_GAS, temperature) == pytest.approx(cp, rel=NEAR)
    k = cp / (cp - lemmon_air.R)
    assert heat_capacity_ratio(PERFECT_GAS, temperature) == pytest.approx(k, rel=NEAR)


def test_cp_hardly_changes_in_the_cold():
    """With the slope of a polynomial that holds from 300 K on it would be 1.2 % lower at 160 K."""
    fall = heat_capacity(PERFECT_GAS, 160.0) / heat_capacity(PERFECT_GAS, 300.0) - 1.0
    assert fall == pytest.approx(-2.5e-3, abs=1e-4)


def test_the_heat_capacity_ratio_of_a_room_is_lemmons():
    cp = lemmon_air.heat_capacity(293.15)
    assert PERFECT_GAS.heat_capacity_ratio == pytest.approx(cp / (cp - lemmon_air.R), rel=NEAR)
    assert PERFECT_GAS.gas_constant == pytest.approx(lemmon_air.R, rel=1e-15)


@given(TEMPERATURES, TEMPERATURES)
def test_differences_of_enthalpy_energy_and_entropy_are_lemmons(cold, hot):
    near = NEAR * 1150.0 * abs(hot - cold) + 1e-6
    rise = lemmon_air.enthalpy(hot) - lemmon_air.enthalpy(cold)
    assert enthalpy(PERFECT_GAS, hot) - enthalpy(PERFECT_GAS, cold) == pytest.approx(rise, abs=near)
    energy = rise - lemmon_air.R * (hot - cold)
    found = internal_energy(PERFECT_GAS, hot) - internal_energy(PERFECT_GAS, cold)
    assert found == pytest.approx(energy, abs=near)
    entropy = lemmon_air.entropy(hot) - lemmon_air.entropy(cold)
    found = thermal_entropy(PERFECT_GAS, hot) - thermal_entropy(PERFECT_GAS, cold)
    assert found == pytest.approx(entropy, abs=NEAR * 1150.0 * abs(log(hot / cold)) + 1e-9)


@GASES
@given(temperature=TEMPERATURES)
def test_the_temperature_of_an_internal_energy_is_its_inverse(gas, temperature):
    assert temperature_of(gas, internal_energy(gas, temperature)) == pytest.approx(temperature, rel=1e-12)


@GASES
@given(temperature=TEMPERATURES)
def test_the_temperature_at_an_enthalpy_is_its_inverse(gas, temperature):
    assert temperature_at_enthalpy(gas, enthalpy(gas, temperature)) == pytest.approx(temperature, rel=1e-9)


@given(st.one_of(st.floats(HOTTEST + 1.0, 20_000.0), st.floats(1.0, COLDEST - 1.0)))
def test_beyond_its_range_cp_stays_what_it_is_at_its_end(temperature):
    """Enthalpy and entropy are its integrals, and the temperature is found again."""
    end = HOTTEST if temperature > HOTTEST else COLDEST
    cp = heat_capacity(PERFECT_GAS, end)
    assert heat_capacity(PERFECT_GAS, temperature) == cp
    rise = enthalpy(PERFECT_GAS, temperature) - enthalpy(PERFECT_GAS, end)
    assert rise == pytest.approx(cp * (temperature - end), rel=1e-9, abs=1e-6)
    rise = thermal_entropy(PERFECT_GAS, temperature) - thermal_entropy(PERFECT_GAS, end)
    assert rise == pytest.approx(cp * log(temperature / end), rel=1e-9)
    assert temperature_of(PERFECT_GAS, internal_energy(PERFECT_GAS, temperature)) == pytest.approx(
        temperature, rel=1e-12
    )


def test_the_old_name_of_the_model_is_read_and_said_to_mean_another_law():
    from apesim.engine.machine import Machine
    from apesim.quantities.old_names import OldNameWarning

    for read in (
        lambda: Machine.load(settings=["air.model=cantera"]),
        lambda: Machine().with_(air_model="cantera"),
    ):
        with pytest.warns(OldNameWarning, match="thermally_perfect"):
            machine = read()
        assert machine.air.model == THERMALLY_PERFECT
        assert 'model = "thermally_perfect"' in machine.to_toml()
