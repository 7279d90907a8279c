from functools import cache
from math import log

import cantera
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.air import (
    CANTERA,
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

IDEAL_GAS = gas_of(Air())
PERFECT_GAS = gas_of(Air(model=CANTERA))
GASES = pytest.mark.parametrize("gas", [IDEAL_GAS, PERFECT_GAS], ids=["ideal", "cantera"])
RATIOS = st.floats(1.1, 1.67)
JOULES_PER_KWH = 3.6e6


@cache
def cantera_air():
    return cantera.Solution("air.yaml")


NASA_RANGE = st.floats(120.0, 900.0)
"""Cantera, too, extrapolates its polynomial below 300 K."""


@given(NASA_RANGE)
def test_cp_is_canteras(temperature):
    air = cantera_air()
    air.TP = temperature, 1e5
    assert heat_capacity(PERFECT_GAS, temperature) == pytest.approx(air.cp_mass, rel=1e-9)
    assert heat_capacity_ratio(PERFECT_GAS, temperature) == pytest.approx(air.cp_mass / air.cv_mass, rel=1e-9)


def test_the_heat_capacity_ratio_of_real_air_is_canteras_in_a_room():
    air = cantera_air()
    air.TP = 293.15, 1e5
    assert PERFECT_GAS.heat_capacity_ratio == pytest.approx(air.cp_mass / air.cv_mass, rel=1e-9)


@given(NASA_RANGE, NASA_RANGE)
def test_differences_of_enthalpy_and_internal_energy_are_canteras(cold, hot):
    air = cantera_air()
    air.TP = cold, 1e5
    h, u = air.enthalpy_mass, air.int_energy_mass
    air.TP = hot, 1e5
    # cp to 1e-9, times the difference of temperature; 1e-5 J/kg for the rounding of h at 1e6 J/kg.
    near = 1e-9 * 1200.0 * abs(hot - cold) + 1e-5
    assert enthalpy(PERFECT_GAS, hot) - enthalpy(PERFECT_GAS, cold) == pytest.approx(air.enthalpy_mass - h, abs=near)
    rise = internal_energy(PERFECT_GAS, hot) - internal_energy(PERFECT_GAS, cold)
    assert rise == pytest.approx(air.int_energy_mass - u, abs=near)


@GASES
@given(temperature=NASA_RANGE)
def test_the_temperature_of_an_internal_energy_is_its_inverse(gas, temperature):
    assert temperature_of(gas, internal_energy(gas, temperature)) == pytest.approx(temperature, rel=1e-12)


@GASES
@given(temperature=NASA_RANGE)
def test_the_temperature_at_an_enthalpy_is_its_inverse(gas, temperature):
    assert temperature_at_enthalpy(gas, enthalpy(gas, temperature)) == pytest.approx(temperature, rel=1e-9)


@given(st.floats(1001.0, 20_000.0))
def test_above_1000_kelvin_cp_stays_what_it_is_there(temperature):
    """Enthalpy and entropy are its integrals, and the temperature is found again."""
    cp = heat_capacity(PERFECT_GAS, 1000.0)
    assert heat_capacity(PERFECT_GAS, temperature) == cp
    rise = enthalpy(PERFECT_GAS, temperature) - enthalpy(PERFECT_GAS, 1000.0)
    assert rise == pytest.approx(cp * (temperature - 1000.0), rel=1e-9)
    rise = thermal_entropy(PERFECT_GAS, temperature) - thermal_entropy(PERFECT_GAS, 1000.0)
    assert rise == pytest.approx(cp * log(temperature / 1000.0), rel=1e-9)
    assert temperature_of(PERFECT_GAS, internal_energy(PERFECT_GAS, temperature)) == pytest.approx(
        temperature, rel=1e-12
    )


@given(NASA_RANGE, NASA_RANGE)
def test_differences_of_thermal_entropy_are_canteras_at_constant_pressure(cold, hot):
    air = cantera_air()
    air.TP = cold, 1e5
    s = air.entropy_mass
    air.TP = hot, 1e5
    rise = thermal_entropy(PERFECT_GAS, hot) - thermal_entropy(PERFECT_GAS, cold)
    assert rise == pytest.approx(air.entropy_mass - s, abs=1e-5)
