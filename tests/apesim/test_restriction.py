from math import sqrt

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from apesim.air import ANR_DENSITY, THERMALLY_PERFECT, Air, GasState, enthalpy, gas_of, heat_capacity_ratio
from apesim.flow_function import NEARLY_EQUAL, critical_ratio, subsonic_flow_function, subsonic_slope
from apesim.restriction import (
    AREA_OF_CONDUCTANCE,
    CHOKED,
    NEAR,
    NO_FLOW,
    ROOM,
    ROOM_TO_TURN,
    SHUT,
    SUBSONIC,
    Sides,
    beyond_regime,
    flow_between,
    flow_function,
    flow_function_in,
    flow_in,
    iso6358_flow,
    next_regime,
    regime_between,
)

IDEAL_GAS = gas_of(Air())
PERFECT_GAS = gas_of(Air(model=THERMALLY_PERFECT))
GASES = pytest.mark.parametrize("gas", [IDEAL_GAS, PERFECT_GAS], ids=["ideal", "thermally perfect"])
RATIOS = st.floats(1.1, 1.67)


# --- psi(r), Eq. 8 ---


def naive_flow_function(r, k):
    """Eq. 8 as it is printed, with its two powers."""
    if r <= (2.0 / (k + 1.0)) ** (k / (k - 1.0)):
        return sqrt(k) * (2.0 / (k + 1.0)) ** ((k + 1.0) / (2.0 * (k - 1.0)))
    return sqrt(2.0 * k / (k - 1.0) * (r ** (2.0 / k) - r ** ((k + 1.0) / k)))


@given(st.floats(0.0, 0.999), RATIOS)
def test_psi_is_equation_8(r, k):
    # The difference of two numbers below 1 and 1e-3 apart at most loses 3 to 4 of 16 digits.
    assert flow_function(gas_of(Air(heat_capacity_ratio=k)), r, 287.0) == pytest.approx(
        naive_flow_function(r, k), rel=1e-11
    )


@given(RATIOS)
def test_psi_is_continuous_where_its_formula_changes(k):
    gas = gas_of(Air(heat_capacity_ratio=k))
    for seam in (critical_ratio(k), 0.999):
        below, above = (flow_function(gas, seam * (1.0 + side), 287.0) for side in (-1e-12, 1e-12))
        # Its slope is below psi(0.999)/0.001 < 100 everywhere.
        assert below == pytest.approx(above, abs=1e-10)


@given(st.floats(0.0, 1.0), RATIOS)
def test_psi_is_linear_above_0_999_and_zero_at_equal_pressure(share, k):
    gas = gas_of(Air(heat_capacity_ratio=k))
    r = 0.999 + 0.001 * share
    assume(r > 0.999)
    expected = naive_flow_function(0.999, k) * (1.0 - r) / 0.001
    assert flow_function(gas, r, 287.0) == pytest.approx(expected, rel=1e-11, abs=1e-13)
    assert flow_function(gas, 1.0, 287.0) == 0.0


@given(st.floats(0.0, 0.999), st.floats(200.0, 800.0))
def test_psi_of_thermally_perfect_air_takes_k_upstream(r, temperature):
    k = heat_capacity_ratio(PERFECT_GAS, temperature)
    assert flow_function(PERFECT_GAS, r, temperature) == pytest.approx(naive_flow_function(r, k), rel=1e-11)


# --- flow between two volumes, Eq. 7 ---

PRESSURES, TEMPERATURES = st.floats(1e3, 3e6), st.floats(150.0, 600.0)


@GASES
@given(p1=PRESSURES, t1=TEMPERATURES, p2=PRESSURES, t2=TEMPERATURES)
def test_flow_is_antisymmetric_and_runs_to_the_lower_pressure_with_the_upstream_enthalpy(gas, p1, t1, p2, t2):
    one, other = GasState(p1, t1), GasState(p2, t2)
    mass, energy = flow_between(gas, 1e-5, Sides(one, other))
    assert flow_between(gas, 1e-5, Sides(other, one)) == (-mass, -energy)
    assert np.sign(mass) == np.sign(p1 - p2)
    assert energy == mass * enthalpy(gas, t1 if p1 > p2 else t2)


@GASES
def test_nothing_flows_at_equal_pressure_or_through_no_area(gas):
    assert flow_between(gas, 1e-5, Sides(GasState(1e5, 300.0), GasState(1e5, 400.0))) == NO_FLOW
    assert flow_between(gas, 0.0, Sides(GasState(2e5, 300.0), GasState(1e5, 300.0))) == NO_FLOW


@given(PRESSURES, TEMPERATURES, st.floats(0.0, 0.99))
def test_flow_is_equation_7(pressure, temperature, ratio):
    sides = Sides(GasState(pressure, temperature), GasState(ratio * pressure, 290.0))
    mass, _ = flow_between(IDEAL_GAS, 3e-6, sides)
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
    sides = Sides(GasState(6e5, 293.15), GasState(1e5, 293.15))
    mass, _ = flow_between(IDEAL_GAS, 1e-8 * AREA_OF_CONDUCTANCE, sides)
    assert mass == pytest.approx(iso6358_flow(1e-8, 0.3, 6e5, 1e5), rel=0.005 / 5.02)


# --- regimes ---

STATES = st.builds(GasState, PRESSURES, TEMPERATURES)
FORWARD = [CHOKED, SUBSONIC, NEAR, -NEAR, -SUBSONIC, -CHOKED]


def beside(ratio, regime):
    """Both sides of a restriction at a pressure ratio in the direction of a regime."""
    high, low = GasState(1e6, 300.0), GasState(ratio * 1e6, 250.0)
    return Sides(high, low) if regime > 0 else Sides(low, high)


@GASES
@given(sides=st.builds(Sides, STATES, STATES))
def test_the_law_in_the_regime_of_its_pressures_is_the_law(gas, sides):
    regime = regime_between(gas, sides)
    assert flow_in(gas, regime, 1e-5, sides) == flow_between(gas, 1e-5, sides)
    assert beyond_regime(gas, regime, sides) <= -(ROOM_TO_TURN if abs(regime) == NEAR else ROOM)


@GASES
def test_as_the_pressure_ratio_rises_and_falls_the_regimes_follow_one_another(gas):
    """A march lives by this: each regime ends where the next has begun, there and back, and none chatters."""
    before = GasState(1e6, 300.0)
    pressures = np.concatenate((np.linspace(0.2e6, 1.1e6, 90001), np.linspace(1.1e6, 5e6, 40001)))
    for ascending in (True, False):
        path = pressures if ascending else pressures[::-1]
        regime = regime_between(gas, Sides(before, GasState(path[0], 250.0)))
        met = [regime]
        for pressure in path:
            sides = Sides(before, GasState(pressure, 250.0))
            for _ in range(6):
                if beyond_regime(gas, regime, sides) <= 0.0:
                    break
                regime = next_regime(gas, regime, sides)
                met.append(regime)
            assert beyond_regime(gas, regime, sides) <= 0.0
        assert met == (FORWARD if ascending else FORWARD[::-1])


@pytest.mark.parametrize("k", [1.2, 1.4, 1.6])
def test_the_subsonic_law_goes_on_smoothly_beyond_both_its_ends(k):
    gas = gas_of(Air(heat_capacity_ratio=k))
    nudge = 1e-7
    slope = (subsonic_flow_function(NEARLY_EQUAL + nudge, k) - subsonic_flow_function(NEARLY_EQUAL - nudge, k)) / (
        2.0 * nudge
    )
    assert subsonic_slope(NEARLY_EQUAL, k) == pytest.approx(slope, rel=1e-6)
    beyond = flow_function_in(gas, SUBSONIC, NEARLY_EQUAL + 0.01, 300.0)
    assert beyond == pytest.approx(subsonic_flow_function(NEARLY_EQUAL, k) + 0.01 * slope, rel=1e-6)
    below = critical_ratio(k) - 0.01
    assert flow_function_in(gas, SUBSONIC, below, 300.0) == pytest.approx(subsonic_flow_function(below, k), rel=1e-15)
    # psi has its maximum at the critical ratio, so that both laws meet there with slope 0.
    assert subsonic_slope(critical_ratio(k), k) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("regime", FORWARD)
def test_a_flow_held_in_a_regime_takes_the_upstream_side_of_that_regime(regime):
    sides = beside(0.9995, regime)
    mass, energy = flow_in(IDEAL_GAS, regime, 1e-5, sides)
    assert np.sign(mass) == np.sign(regime)
    assert energy == mass * enthalpy(IDEAL_GAS, 300.0)


def test_a_flow_turns_far_nearer_to_equal_pressures_than_any_regime_is_held():
    """With the room of a regime, the air behind a wide valve made a cylinder change by 1e-4 from cycle to cycle; with
    a hundredth of it, by 1e-5 in a slow engine. Rounding is no turn."""
    for regime in (NEAR, -NEAR):
        assert beyond_regime(IDEAL_GAS, regime, beside(1.0 + 1e-10, regime)) > 0.0
        assert beyond_regime(IDEAL_GAS, regime, beside(1.0 + 1e-14, regime)) < 0.0
    assert beyond_regime(IDEAL_GAS, NEAR, beside(NEARLY_EQUAL - 2e-7, NEAR)) < 0.0
    assert beyond_regime(IDEAL_GAS, SUBSONIC, beside(NEARLY_EQUAL + 2e-7, SUBSONIC)) < 0.0


def test_what_is_shut_neither_passes_anything_nor_leaves_its_regime():
    sides = Sides(GasState(1e6, 300.0), GasState(1e5, 300.0))
    assert flow_in(IDEAL_GAS, SHUT, 1e-5, sides) == NO_FLOW
    assert beyond_regime(IDEAL_GAS, SHUT, sides) < 0.0
