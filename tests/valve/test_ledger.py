"""State vectors: what is written by name is read by name, and no two parts of a vector share an element."""

import numpy as np
import pytest

from apesim.engine.cycle import state as cycle
from apesim.valve import bench
from apesim.valve.ledger import ControlLedger, ValveStates, gas_of_volume, update_motion, update_part, valve_states


def test_the_engine_s_parts_fill_its_vector_without_a_gap_or_an_overlap():
    y = np.full(cycle.SIZE, np.nan)
    volumes = ((6.0, 7.0), (8.0, 9.0), (10.0, 11.0), (12.0, 13.0))
    valve, control = ValveStates(*range(6)), ControlLedger(*range(20, 29))
    engine = cycle.EngineLedger(*range(30, 41))
    cycle.update_states(y, valve, *volumes)
    cycle.update_ledgers(y, control, engine)
    assert not np.isnan(y).any()
    assert len(set(y)) == cycle.SIZE
    assert valve_states(y) == valve
    assert (
        tuple(read(y) for read in (cycle.cylinder_gas, cycle.receiver_gas, cycle.line_gas, cycle.pipe_gas)) == volumes
    )
    assert cycle.control_ledger(y) == control
    assert cycle.engine_ledger(y) == engine


def test_the_bench_s_parts_fill_its_vector_without_a_gap_or_an_overlap():
    y = np.full(bench.SIZE, np.nan)
    parts = {0: ValveStates(*range(6)), bench.LINE: (6.0, 7.0), bench.LEDGER: ControlLedger(*range(20, 29))}
    for first, values in parts.items():
        update_part(y, first, values)
    assert not np.isnan(y).any()
    assert len(set(y)) == bench.SIZE
    assert valve_states(y) == parts[0]
    assert gas_of_volume(y, bench.LINE) == parts[bench.LINE]
    assert bench.bench_ledger(y) == parts[bench.LEDGER]


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
