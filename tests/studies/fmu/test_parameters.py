"""Which keys of a machine an importer may change, and what follows them."""

from functools import partial

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities.trees import with_value
from apesim.studies.fmu import engine_model, valve_model
from apesim.studies.fmu.flat import flatten
from apesim.studies.fmu.parameters import find_orders, find_parameters

engine_numbers = partial(engine_model.numbers_of, is_free=False)


def followed(base, parameters, values):
    """Numbers of a machine with other values for its parameters, as the FMU computes them."""
    numbers = base.copy()
    for each in parameters:
        for number, factor, is_value in each.effects:
            change = values[each.key] - each.value
            numbers[number] = values[each.key] if is_value else numbers[number] + factor * change
    return numbers


@pytest.mark.parametrize("numbers_of", [valve_model.numbers_of, engine_numbers], ids=["valve", "engine"])
def test_changed_parameters_give_the_numbers_of_the_changed_machine(numbers_of):
    machine = Machine()
    parameters, _ = find_parameters(machine, numbers_of, ("supply.pressure",), engine_model.AT_EXPORT)
    rng = np.random.default_rng(1)
    values = {each.key: each.value * rng.uniform(0.9, 1.2) for each in parameters}
    changed = machine
    for key, value in values.items():
        changed = with_value(changed, key, value)
    expected = flatten(numbers_of(changed))
    found = followed(flatten(numbers_of(machine)), parameters, values)
    is_same = expected.view(np.int64) == found.view(np.int64)
    assert is_same.mean() > 0.9
    np.testing.assert_allclose(found[~is_same], expected[~is_same], rtol=1e-9)


def test_what_follows_a_curve_is_fixed():
    parameters, fixed = find_parameters(Machine(), engine_numbers)
    free, kept = {each.key for each in parameters}, {each.key for each in fixed}
    assert {"valve.stroke", "valve.solenoid.dead_time", "engine.friction.constant", "shaft.inertia"} <= free
    assert {"engine.bore", "air.gas_constant", "engine.compression_ratio"} <= kept
    assert not any(key.startswith(("effects.", "groove.ports.")) for key in free | kept)


def test_of_two_keys_that_multiply_each_other_one_is_fixed():
    machine = Machine().with_(effects_spring_rate_error_share="0.2")
    parameters, fixed = find_parameters(machine, valve_model.numbers_of)
    assert "valve.spring_rate" in {each.key for each in parameters}
    assert "effects.spring_rate_error.share" in {each.key for each in fixed}
    assert {each.key: each.effects[0].factor for each in parameters}["valve.spring_rate"] == pytest.approx(1.2)


def test_a_table_keeps_its_rows_in_order():
    example = valve_model.numbers_of(Machine())
    parameters, _ = find_parameters(Machine(), valve_model.numbers_of)
    numbers = flatten(example)
    orders = find_orders(example, parameters)
    assert all(numbers[order.low] < numbers[order.high] for order in orders)
    assert ("groove.lap", "valve.stroke") in [order.keys for order in orders]
