"""The list of the ports of the gas exchange: numbers, modes, ledgers and balances follow it."""

import numpy as np
import pytest

import apesim
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.cylinder_laws import BRANCHED
from apesim.engine.cycle.gas_exchange import airs_from, change_exchange_regime, exchange_events, port_flows, ports_at
from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
from apesim.engine.cycle.state import EXCHANGE, EXHAUSTS, MODES, PORTS, engine_ledger, instant_at
from apesim.engine.indicators import closure
from apesim.engine.steady import run_steady
from apesim.march.adaptive import EVENTS
from apesim.restriction import CHOKED, SHUT
from tests.machines import RPM, machine

OWN_WINDOW = {
    "engine.exhaust_2.effective_area": "200 mm^2",
    "engine.exhaust_2.opens": "190 deg",
    "engine.exhaust_2.closes": "352 deg",
    "engine.exhaust_2.flank": "20 deg",
}
"""Second exhaust valve whose keys all differ from the first one's."""


def test_each_event_of_the_engine_has_room_in_the_march():
    assert BRANCHED < EVENTS


def test_modes_and_lists_have_an_entry_for_each_port():
    p, _, _ = cycle_of(machine(receiver=1.0), 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    ports = ports_at(p, p.start, y, mode)
    flows = port_flows(p, mode, ports, airs_from(p, instant_at(p, 0.0, y), y))
    assert len(ports) == len(flows) == PORTS == MODES - EXCHANGE


@pytest.mark.parametrize("i", range(PORTS))
def test_each_port_has_its_regime_and_its_event_and_leaves_those_of_the_others_alone(i):
    """Choked from behind is what no pressures of an engine at rest are: the one port held so has left its regime."""
    p, _, _ = cycle_of(machine(receiver=1.0), 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    mode[EXCHANGE:] = SHUT
    mode[EXCHANGE + i] = -CHOKED
    g = np.zeros(PORTS)
    exchange_events(p, instant_at(p, 0.0, y), y, mode, g, 0)
    assert g[i] > 0.0
    assert (np.delete(g, i) == -1.0).all()
    before = mode.copy()
    change_exchange_regime(p, instant_at(p, 0.0, y), y, i, mode)
    assert mode[EXCHANGE + i] != before[EXCHANGE + i]
    assert (np.delete(mode, EXCHANGE + i) == np.delete(before, EXCHANGE + i)).all()


def test_the_second_exhaust_valve_opens_its_own_area_in_its_own_window():
    p, _, breakpoints = cycle_of(apesim.Machine().with_(**OWN_WINDOW), 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    first, second = ([ports_at(p, angle * DEGREE, y, mode)[i].area for angle in (180, 200, 345)] for i in EXHAUSTS)
    assert np.array(first) * 1e6 == pytest.approx([500.0 * np.sin(0.3 * np.pi) ** 2, 500.0, 0.0], rel=1e-12)
    assert np.array(second) * 1e6 == pytest.approx([0.0, 100.0, 200.0 * np.sin(0.175 * np.pi) ** 2], rel=1e-12)
    corners = (np.array([190.0, 210.0, 332.0, 352.0]) * DEGREE - p.start) / p.speed
    assert np.abs(breakpoints[:, None] - corners).min(axis=0) == pytest.approx(0.0, abs=1e-12)


def test_an_engine_without_a_second_exhaust_valve_has_no_area_for_one():
    p, _, _ = cycle_of(apesim.Machine(), 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    assert len(p.exhausts) == 1
    assert ports_at(p, 250.0 * DEGREE, y, mode)[EXHAUSTS[1]].area == 0.0


def test_an_engine_with_two_exhaust_valves_closes_its_balances():
    run = run_steady(apesim.Machine().with_(**OWN_WINDOW), 1000.0 * RPM, max_cycles=1, estimate_error=False)
    assert max(closure(run)) < 1e-10
    assert engine_ledger(run.end).exhaust.mass > 0.0


@pytest.mark.compiled
@pytest.mark.slow
@pytest.mark.parametrize(
    "effect",
    [
        {},
        {"effects.exhaust_restriction.share": 0.3},
        {"effects.exhaust_timing.angle": "5 deg"},
        {"effects.exhaust_back_pressure.pressure": "20 kPa"},
    ],
)
def test_two_parts_of_an_exhaust_valve_breathe_as_the_whole(effect):
    parts = {"engine.exhaust.effective_area": "300 mm^2", "engine.exhaust_2.effective_area": "200 mm^2"}
    for rpm in ("600 rpm", "1000 rpm"):
        whole = apesim.run_engine(apesim.Machine().with_(**effect), speed=rpm)
        halves = apesim.run_engine(apesim.Machine().with_(**parts, **effect), speed=rpm)
        for name in ("brake_torque", "engine_air", "exhaust_temperature", "exergy_exhaust_valve", "exergy_closure"):
            assert halves[name] == pytest.approx(whole[name], rel=1e-8, abs=1e-9), name
