"""The list of the flows of the gas exchange: numbers, modes and ledger follow it."""

import numpy as np
import pytest

from apesim.engine.cycle.exchange import EXHAUST, FEED, FLOWS, GROOVE, PIPE, Exchange
from apesim.engine.cycle.flows import change_exchange_regime, exchange_events
from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
from apesim.engine.cycle.state import ENGINE_LEDGER, EXCHANGE, GROOVE_BACK, MODES
from apesim.restriction import CHOKED, SHUT
from tests.machines import RPM, machine


def test_the_numbers_of_the_flows_are_their_places_in_the_list():
    assert Exchange(*range(FLOWS)) == Exchange(groove=GROOVE, exhaust=EXHAUST, feed=FEED, pipe=PIPE)
    assert MODES - EXCHANGE == FLOWS
    assert GROOVE_BACK - ENGINE_LEDGER == 2 * FLOWS


@pytest.mark.parametrize("flow", Exchange._fields)
def test_each_flow_has_its_regime_and_its_event_and_leaves_those_of_the_others_alone(flow):
    """Choked from behind is what no pressures of an engine at rest are: the one flow held so has left its regime."""
    p, _, _ = cycle_of(machine(receiver=1.0), 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    i = Exchange._fields.index(flow)
    mode[EXCHANGE:] = SHUT
    mode[EXCHANGE + i] = -CHOKED
    g = np.zeros(FLOWS)
    exchange_events(p, 0.0, y, mode, g, 0)
    assert g[i] > 0.0
    assert (np.delete(g, i) == -1.0).all()
    before = mode.copy()
    change_exchange_regime(p, 0.0, y, i, mode)
    assert mode[EXCHANGE + i] != before[EXCHANGE + i]
    assert (np.delete(mode, EXCHANGE + i) == np.delete(before, EXCHANGE + i)).all()
