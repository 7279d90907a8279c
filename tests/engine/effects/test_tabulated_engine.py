"""Tables of the engine in place of laws, against the laws that they contain."""

import numpy as np
import pytest

from apesim.engine.effects.groove_area_error import GrooveAreaError
from apesim.engine.effects.seat_leak import SeatLeak
from apesim.engine.effects.tabulated_cylinder_leak import TabulatedCylinderLeak
from apesim.engine.effects.tabulated_groove import TabulatedGroove
from apesim.valve.effects.tabulated_force import TabulatedForce
from tests.engine.effects.test_engine_effects import with_effects
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
