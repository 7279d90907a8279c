"""State vectors: what is written by name is read by name, and no two parts of a vector share an element."""

import numpy as np
import pytest

from apesim.air import GasContent
from apesim.engine.cycle import state as cycle
from apesim.restriction import Flow
from apesim.valve import bench
from apesim.valve.ledger import (
    ControlLedger,
    ValveStates,
    gas_of_volume,
    update_control_ledger,
    update_motion,
    update_part,
    valve_states,
)

CONTROL = ControlLedger(Flow(20.0, 21.0), Flow(22.0, 23.0), Flow(24.0, 25.0), 26.0)


def test_the_engine_s_parts_fill_its_vector_without_a_gap_or_an_overlap():
    y = np.full(cycle.SIZE, np.nan)
    volumes = tuple(GasContent(first, first + 1.0) for first in (6.0, 8.0, 10.0, 12.0))
    valve, control, let_in = ValveStates(*range(6)), CONTROL, Flow(27.0, 28.0)
    engine = cycle.EngineLedger(*(Flow(first, first + 1.0) for first in (30.0, 32.0, 34.0, 36.0)), 38, 39, 40)
    cycle.update_states(y, valve, volumes)
    cycle.update_ledgers(y, control, let_in, engine)
    assert not np.isnan(y).any()
    assert len(set(y)) == cycle.SIZE
    assert valve_states(y) == valve
    assert (
        tuple(read(y) for read in (cycle.cylinder_gas, cycle.receiver_gas, cycle.line_gas, cycle.pipe_gas)) == volumes
    )
    assert cycle.control_ledger(y) == control
    assert cycle.effects_ledger(y) == let_in
    assert cycle.engine_ledger(y) == engine


def test_the_bench_s_parts_fill_its_vector_without_a_gap_or_an_overlap():
    y = np.full(bench.SIZE, np.nan)
    parts = {0: ValveStates(*range(6)), bench.LINE: (6.0, 7.0), bench.EFFECTS_LEDGER: Flow(27.0, 28.0)}
    for first, values in parts.items():
        update_part(y, first, values)
    update_control_ledger(y, bench.LEDGER, CONTROL)
    assert not np.isnan(y).any()
    assert len(set(y)) == bench.SIZE
    assert valve_states(y) == parts[0]
    assert gas_of_volume(y, bench.LINE) == parts[bench.LINE]
    assert bench.bench_ledger(y) == CONTROL
    assert bench.effects_ledger(y) == parts[bench.EFFECTS_LEDGER]


def test_states_that_are_controlled_come_before_those_that_may_be_absent():
    """A march of a machine without line and pipe controls the first elements only."""
    assert len(cycle.SCALE) == cycle.STATES == cycle.LINE
    assert cycle.LINE < cycle.PIPE < cycle.LEDGER
    assert len(ValveStates._fields) == bench.LINE


@pytest.mark.parametrize("size", [bench.SIZE, cycle.SIZE])
def test_a_motion_leaves_the_gas_as_it_is(size):
    y = np.arange(float(size))
    update_motion(y, 9e-3, -0.5)
    assert (valve_states(y).position, valve_states(y).speed) == (9e-3, -0.5)
    assert (y[2:] == np.arange(2.0, size)).all()
