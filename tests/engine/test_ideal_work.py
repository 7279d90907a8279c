from math import log

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from apesim.air import THERMALLY_PERFECT, Air, gas_of
from apesim.engine.ideal_work import full_admission_work, isentropic_work, isothermal_work
from tests import lemmon_air

IDEAL_GAS = gas_of(Air())
PERFECT_GAS = gas_of(Air(model=THERMALLY_PERFECT))
GASES = pytest.mark.parametrize("gas", [IDEAL_GAS, PERFECT_GAS], ids=["ideal", "thermally perfect"])
JOULES_PER_KWH = 3.6e6


@pytest.mark.parametrize(
    ("pressure", "full", "isentropic", "isothermal"),
    [(0.6e6, 51.3, 30.5, 23.9), (1.0e6, 47.5, 25.4, 18.6), (2.0e6, 45.0, 21.3, 14.3), (3.0e6, 44.3, 19.7, 12.6)],
)
def test_the_air_an_ideal_machine_takes_for_a_kilowatt_hour(pressure, full, isentropic, isothermal):
    ratio = pressure / 1e5
    for work, consumption in (
        (full_admission_work, full),
        (isentropic_work, isentropic),
        (isothermal_work, isothermal),
    ):
        assert JOULES_PER_KWH / work(IDEAL_GAS, 293.15, ratio) == pytest.approx(consumption, abs=0.05)


@GASES
def test_isothermal_expansion_beats_isentropic_and_that_beats_full_admission(gas):
    for ratio in (1.5, 5.0, 30.0):
        works = [work(gas, 293.15, ratio) for work in (full_admission_work, isentropic_work, isothermal_work)]
        assert works == sorted(works)
        assert works[0] > 0.0


@given(st.floats(250.0, 600.0), st.floats(1.1, 30.0))
def test_isentropic_work_with_cp_of_t_keeps_lemmons_entropy(temperature, ratio):
    entropy = lemmon_air.entropy(temperature, ratio * 1e5)
    cold = brentq(lambda end: lemmon_air.entropy(end, 1e5) - entropy, 50.0, temperature, xtol=1e-9)
    fall = lemmon_air.enthalpy(temperature) - lemmon_air.enthalpy(cold)
    # The polynomial keeps to 2e-5 of cp, of which the fall of temperature makes both the work and the end of it.
    assert isentropic_work(PERFECT_GAS, temperature, ratio) == pytest.approx(fall, rel=5e-5)


def test_isentropic_work_with_constant_cp_is_the_textbook_formula():
    work = 1.4 / 0.4 * 287.05 * 300.0 * (1.0 - (1.0 / 8.0) ** (0.4 / 1.4))
    assert isentropic_work(IDEAL_GAS, 300.0, 8.0) == pytest.approx(work, rel=1e-14)
    assert isothermal_work(IDEAL_GAS, 300.0, 8.0) == pytest.approx(287.05 * 300.0 * log(8.0), rel=1e-14)
