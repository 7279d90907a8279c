"""Tables of the engine in place of laws, against the laws that they contain."""

import numpy as np
import pytest

from apesim.effect import law
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.state import effects_ledger, engine_ledger
from apesim.engine.cylinder import MASS, TERMS
from apesim.engine.effects.groove_area_error import GrooveAreaError
from apesim.engine.effects.seat_leak import SeatLeak
from apesim.engine.effects.tabulated_cylinder_leak import TabulatedCylinderLeak
from apesim.engine.effects.tabulated_groove import TabulatedGroove
from apesim.engine.exhaust import SecondExhaust
from apesim.valve.effects.tabulated_force import TabulatedForce
from tests.engine.effects.test_engine_effects import cylinder, with_effects
from tests.machines import settled
from tests.valve.effects.test_valve_effects import run_with
from tests.valve.test_bench import numbers


def test_tables_compiled_in_and_far_below_rounding_change_no_bit():
    idle = TabulatedForce(1e-300)
    assert np.array_equal(numbers(run_with(tabulated_force=idle)), numbers(run_with()))
    plain, beside = (settled(with_effects(**own), 800.0) for own in ({}, {"tabulated_force": idle}))
    assert np.array_equal(plain.end, beside.end)


def test_tables_of_the_engine_are_the_laws_that_they_contain():
    def end(**effects):
        return settled(with_effects(**effects), 800.0).end

    area = 0.4e-6
    found = end(tabulated_cylinder_leak=TabulatedCylinderLeak(*[0.0] * 12, *[area] * 4))
    assert found == pytest.approx(end(seat_leak=SeatLeak(area)), rel=1e-6, abs=1e-9)
    found = end(tabulated_groove=TabulatedGroove(*[0.1] * 5))
    assert found == pytest.approx(end(groove_area_error=GrooveAreaError(0.1)), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("angle", "own", "taken"),
    [(100.0, 500e-6, 0.0), (250.0, 500e-6, 20e-6), (250.0, 15e-6, 15e-6), (177.5, 15e-6, 7.5e-6)],
)
def test_what_a_leak_below_zero_takes_off_the_exhaust_valve(angle, own, taken):
    """Nothing where it is shut, no more than its own area elsewhere: a choked flow at 5 bar and 280 K by hand."""
    state = cylinder(5e5, 280.0, 200e-6)
    engine = state.engine._replace(exhaust=state.engine.exhaust._replace(effective_area=own))
    balance = np.zeros(TERMS)
    law(TabulatedCylinderLeak(*[-20e-6] * 12), state._replace(engine=engine, angle=angle * DEGREE), balance)
    assert balance[MASS] == pytest.approx(taken * 0.684731 * 5e5 / np.sqrt(287.05 * 280.0), rel=1e-6)


@pytest.mark.parametrize(("angle", "taken"), [(177.5, 7.5e-6), (230.0, 18e-6), (345.0, 3e-6)])
def test_a_leak_below_zero_takes_no_more_than_both_exhaust_valves_have(angle, taken):
    """The first one, 15 mm^2 from 165 to 340 deg, is half open, open and shut; the second opens at 220 deg."""
    state = cylinder(5e5, 280.0, 200e-6)
    second = SecondExhaust(3e-6, 220.0 * DEGREE, 355.0 * DEGREE, 5.0 * DEGREE)
    engine = state.engine._replace(exhaust=state.engine.exhaust._replace(effective_area=15e-6), exhaust_2=second)
    balance = np.zeros(TERMS)
    law(TabulatedCylinderLeak(*[-20e-6] * 12), state._replace(engine=engine, angle=angle * DEGREE), balance)
    assert balance[MASS] == pytest.approx(taken * 0.684731 * 5e5 / np.sqrt(287.05 * 280.0), rel=1e-6)


def test_a_leak_below_zero_shuts_an_exhaust_valve_and_does_no_more():
    a_machine = with_effects(tabulated_cylinder_leak=TabulatedCylinderLeak(*[-20e-6] * 12))
    exhaust = a_machine.engine.exhaust._replace(effective_area=15e-6)
    end = settled(a_machine._replace(engine=a_machine.engine._replace(exhaust=exhaust)), 800.0).end
    left = engine_ledger(end).exhaust.mass
    assert abs(left) > 1e-6
    assert effects_ledger(end).mass == pytest.approx(left, rel=1e-9)
