from functools import cache
from math import log, sqrt

import cantera
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from apesim.air import (
    ANR_DENSITY,
    AREA_OF_CONDUCTANCE,
    CANTERA,
    Air,
    critical_ratio,
    enthalpy,
    exergy,
    flow_between,
    flow_function,
    full_admission_work,
    gas_of,
    heat_capacity,
    heat_capacity_ratio,
    internal_energy,
    isentropic_work,
    iso6358_flow,
    temperature_of,
)

IDEAL_GAS = gas_of(Air())
PERFECT_GAS = gas_of(Air(model=CANTERA))
GASES = pytest.mark.parametrize("gas", [IDEAL_GAS, PERFECT_GAS], ids=["ideal", "cantera"])
RATIOS = st.floats(1.1, 1.67)
JOULES_PER_KWH = 3.6e6


@cache
def cantera_air():
    return cantera.Solution("air.yaml")


# --- psi(r), Eq. 8 ---


def naive_flow_function(r, k):
    """Eq. 8 as it is printed, with its two powers."""
    if r <= (2.0 / (k + 1.0)) ** (k / (k - 1.0)):
        return sqrt(k) * (2.0 / (k + 1.0)) ** ((k + 1.0) / (2.0 * (k - 1.0)))
    return sqrt(2.0 * k / (k - 1.0) * (r ** (2.0 / k) - r ** ((k + 1.0) / k)))


@settings(deadline=None)
@given(st.floats(0.0, 0.999), RATIOS)
def test_psi_is_equation_8(r, k):
    # The difference of two numbers below 1 and 1e-3 apart at most loses 3 to 4 of 16 digits.
    assert flow_function(gas_of(Air(heat_capacity_ratio=k)), r, 287.0) == pytest.approx(
        naive_flow_function(r, k), rel=1e-11
    )


@settings(deadline=None)
@given(RATIOS)
def test_psi_is_continuous_where_its_formula_changes(k):
    gas = gas_of(Air(heat_capacity_ratio=k))
    for seam in (critical_ratio(k), 0.999):
        below, above = (flow_function(gas, seam * (1.0 + side), 287.0) for side in (-1e-12, 1e-12))
        # Its slope is below psi(0.999)/0.001 < 100 everywhere.
        assert below == pytest.approx(above, abs=1e-10)


@settings(deadline=None)
@given(st.floats(0.0, 1.0), RATIOS)
def test_psi_is_linear_above_0_999_and_zero_at_equal_pressure(share, k):
    gas = gas_of(Air(heat_capacity_ratio=k))
    r = 0.999 + 0.001 * share
    assume(r > 0.999)
    expected = naive_flow_function(0.999, k) * (1.0 - r) / 0.001
    assert flow_function(gas, r, 287.0) == pytest.approx(expected, rel=1e-11, abs=1e-13)
    assert flow_function(gas, 1.0, 287.0) == 0.0


@settings(deadline=None)
@given(st.floats(0.0, 0.999), st.floats(200.0, 800.0))
def test_psi_of_thermally_perfect_air_takes_k_upstream(r, temperature):
    k = heat_capacity_ratio(PERFECT_GAS, temperature)
    assert flow_function(PERFECT_GAS, r, temperature) == pytest.approx(naive_flow_function(r, k), rel=1e-11)


# --- flow between two volumes, Eq. 7 ---

PRESSURES, TEMPERATURES = st.floats(1e3, 3e6), st.floats(150.0, 600.0)


@GASES
@settings(deadline=None)
@given(p1=PRESSURES, t1=TEMPERATURES, p2=PRESSURES, t2=TEMPERATURES)
def test_flow_is_antisymmetric_and_runs_to_the_lower_pressure_with_the_upstream_enthalpy(gas, p1, t1, p2, t2):
    mass, energy = flow_between(gas, 1e-5, p1, t1, p2, t2)
    assert flow_between(gas, 1e-5, p2, t2, p1, t1) == (-mass, -energy)
    assert np.sign(mass) == np.sign(p1 - p2)
    assert energy == mass * enthalpy(gas, t1 if p1 > p2 else t2)


@GASES
def test_nothing_flows_at_equal_pressure_or_through_no_area(gas):
    assert flow_between(gas, 1e-5, 1e5, 300.0, 1e5, 400.0) == (0.0, 0.0)
    assert flow_between(gas, 0.0, 2e5, 300.0, 1e5, 300.0) == (0.0, 0.0)


@settings(deadline=None)
@given(PRESSURES, TEMPERATURES, st.floats(0.0, 0.99))
def test_flow_is_equation_7(pressure, temperature, ratio):
    mass, _ = flow_between(IDEAL_GAS, 3e-6, pressure, temperature, ratio * pressure, 290.0)
    expected = 3e-6 * naive_flow_function(ratio, 1.4) * pressure / sqrt(287.05 * temperature)
    assert mass == pytest.approx(expected, rel=1e-11)


# --- ISO 6358 ---


def test_the_golden_value_of_iso_6358():
    flow = iso6358_flow(2e-8, 0.3, 0.5e6, 0.4e6)
    assert flow / ANR_DENSITY * 60e3 == pytest.approx(419.9, abs=0.05)


def test_iso_6358_chokes_below_its_critical_ratio_and_falls_with_temperature():
    choked = iso6358_flow(2e-8, 0.3, 0.5e6, 0.15e6)
    assert choked == 2e-8 * ANR_DENSITY * 0.5e6
    assert iso6358_flow(2e-8, 0.3, 0.5e6, 0.0) == choked
    assert iso6358_flow(2e-8, 0.3, 0.5e6, 0.15e6 * (1.0 + 1e-9)) == pytest.approx(choked, rel=1e-12)
    assert iso6358_flow(2e-8, 0.3, 0.5e6, 0.0, 4 * 293.15) == pytest.approx(choked / 2.0)
    assert iso6358_flow(2e-8, 0.3, 0.5e6, 0.5e6) == 0.0


def test_an_effective_area_of_5_02_mm2_passes_the_choked_flow_of_1_dm3_per_s_and_bar():
    mass, _ = flow_between(IDEAL_GAS, 1e-8 * AREA_OF_CONDUCTANCE, 6e5, 293.15, 1e5, 293.15)
    assert mass == pytest.approx(iso6358_flow(1e-8, 0.3, 6e5, 1e5), rel=0.005 / 5.02)


# --- work of ideal machines ---


@pytest.mark.parametrize(
    ("pressure", "full", "isentropic", "isothermal"),
    [(0.6e6, 51.3, 30.5, 23.9), (1.0e6, 47.5, 25.4, 18.6), (2.0e6, 45.0, 21.3, 14.3), (3.0e6, 44.3, 19.7, 12.6)],
)
def test_the_air_an_ideal_machine_takes_for_a_kilowatt_hour(pressure, full, isentropic, isothermal):
    ratio = pressure / 1e5
    for work, consumption in ((full_admission_work, full), (isentropic_work, isentropic), (exergy, isothermal)):
        assert JOULES_PER_KWH / work(IDEAL_GAS, 293.15, ratio) == pytest.approx(consumption, abs=0.05)


@GASES
def test_no_machine_beats_exergy_and_expansion_beats_full_admission(gas):
    for ratio in (1.5, 5.0, 30.0):
        works = [work(gas, 293.15, ratio) for work in (full_admission_work, isentropic_work, exergy)]
        assert works == sorted(works)
        assert works[0] > 0.0


# --- thermally perfect air, against Cantera ---

NASA_RANGE = st.floats(120.0, 900.0)
"""Cantera, too, extrapolates its polynomial below 300 K."""


@settings(deadline=None)
@given(NASA_RANGE)
def test_cp_is_canteras(temperature):
    air = cantera_air()
    air.TP = temperature, 1e5
    assert heat_capacity(PERFECT_GAS, temperature) == pytest.approx(air.cp_mass, rel=1e-9)
    assert heat_capacity_ratio(PERFECT_GAS, temperature) == pytest.approx(air.cp_mass / air.cv_mass, rel=1e-9)


@settings(deadline=None)
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
@settings(deadline=None)
@given(temperature=NASA_RANGE)
def test_the_temperature_of_an_internal_energy_is_its_inverse(gas, temperature):
    assert temperature_of(gas, internal_energy(gas, temperature)) == pytest.approx(temperature, rel=1e-12)


@settings(deadline=None)
@given(st.floats(250.0, 600.0), st.floats(1.1, 30.0))
def test_isentropic_work_with_cp_of_t_keeps_canteras_entropy(temperature, ratio):
    air = cantera_air()
    air.TP = temperature, ratio * 1e5
    h, s = air.enthalpy_mass, air.entropy_mass
    air.SP = s, 1e5
    # Cantera solves for the entropy to 1e-9 of it, some 7000 J/(kg K), which is 1e-5 * T of enthalpy.
    near = 7e-6 * temperature + 1e-9 * h if h > 0 else 7e-6 * temperature + 1e-3
    assert isentropic_work(PERFECT_GAS, temperature, ratio) == pytest.approx(h - air.enthalpy_mass, abs=near)


def test_isentropic_work_with_constant_cp_is_the_textbook_formula():
    work = 1.4 / 0.4 * 287.05 * 300.0 * (1.0 - (1.0 / 8.0) ** (0.4 / 1.4))
    assert isentropic_work(IDEAL_GAS, 300.0, 8.0) == pytest.approx(work, rel=1e-14)
    assert exergy(IDEAL_GAS, 300.0, 8.0) == pytest.approx(287.05 * 300.0 * log(8.0), rel=1e-14)
