"""The groove over round ports: areas against their quadrature, the engine against a fine table of the same area."""

from itertools import pairwise
from math import inf, pi

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from apesim.engine.indicators import indicators
from apesim.valve.groove import PORTS, area_table, lap_of
from apesim.valve.ports import Ports, ports_area, ports_table, segment_area
from tests.machines import machine, settled

SIZES = st.floats(1e-3, 12e-3)


def uncovered(ports, travel):
    """Area of one port between the groove's edges: its chords added up, over half the angle at which they are seen."""
    low, high = max(0.0, travel - ports.groove_width), min(ports.diameter, travel)
    if high <= low:
        return 0.0
    ends = (np.arctan2(np.sqrt(x), np.sqrt(ports.diameter - x)) for x in (low, high))
    return quad(lambda angle: (ports.diameter * np.sin(2.0 * angle)) ** 2, *ends, epsabs=1e-30, epsrel=1e-10)[0]


@settings(max_examples=50)
@example(number=1, diameter=0.0078125, width=0.0078125, share=1e-12)
@given(number=st.integers(1, 12), diameter=SIZES, width=SIZES, share=st.floats(-0.2, 1.2))
def test_the_area_is_that_of_the_ports_between_the_grooves_edges(number, diameter, width, share):
    ports = Ports(float(number), diameter, width, inf, 0.6)
    travel = share * (diameter + width)
    # A segment is a difference of areas of the port's size: rounded at 1e-16 of it, some times over.
    expected = 0.6 * number * uncovered(ports, travel)
    assert ports_area(ports, travel) == pytest.approx(expected, rel=1e-7, abs=1e-12 * number * diameter**2)


def test_half_a_port_is_half_its_area():
    assert segment_area(4e-3, 8e-3) == pytest.approx(0.5 * pi * 16e-6, rel=1e-15)
    assert segment_area(9e-3, 8e-3) == pytest.approx(pi * 16e-6, rel=1e-15)
    assert segment_area(-1e-3, 8e-3) == 0.0


@settings(max_examples=50)
@example(diameter=1e-3, width=1.0000000000000002e-3, cap=1.0, lap=0.001953125, stroke=0.015625)
@given(diameter=SIZES, width=SIZES, cap=st.floats(0.1, 1.5), lap=st.floats(0.0, 3e-3), stroke=st.floats(4e-3, 30e-3))
def test_between_two_rows_the_area_is_theirs_or_the_uncapped_law_and_bends_nowhere(diameter, width, cap, lap, stroke):
    passage = cap * 4.0 * 0.25 * pi * diameter**2
    ports = Ports(4.0, diameter, width, passage, 1.0)
    table = ports_table(ports, lap, stroke)
    assert (table[0, 0], table[0, 1], table[-1, 0]) == (lap, 0.0, pytest.approx(stroke))
    assert np.all(np.diff(table[:, 0]) > 0.0)
    for (low, area_low), (high, area_high) in pairwise(table):
        lifts = np.linspace(low, high, 21)[1:-1]
        law = np.array([ports_area(ports, lift - lap) for lift in lifts])
        if area_low == area_high:
            assert np.minimum(law, passage) == pytest.approx(area_low, rel=1e-9)
        else:
            assert np.all(law <= passage * (1.0 + 1e-9))
            assert np.all(np.diff(law) * (area_high - area_low) >= -1e-18)


@given(diameter=SIZES, wider=st.floats(1e-4, 5e-3))
def test_ports_that_are_wholly_open_have_one_area_to_the_last_bit(diameter, wider):
    lift, area = ports_table(Ports(4.0, diameter, diameter + wider, inf, 0.6), 0.0, 30e-3).T
    is_open = (lift >= diameter) & (lift <= diameter + wider)
    assert set(area[is_open]) == {0.6 * 4.0 * 0.25 * pi * diameter**2}


@pytest.mark.parametrize("ports", [{}, {"groove_width": 3e-3}, {"passage_area": 60e-6}])
@pytest.mark.parametrize("intake", ["epv", "cam"])
@pytest.mark.compiled
def test_the_engine_breathes_through_ports_as_through_a_fine_table_of_them(ports, intake):
    values = {f"groove__ports__{name}": value for name, value in ports.items()}
    a_machine = machine(intake=intake, groove__geometry=PORTS, **values)
    groove = a_machine.groove
    cap = groove.ports.discharge_coefficient * groove.ports.passage_area
    # Finer near the lap, where the area rises from zero with the power 3/2.
    lifts = groove.lap + 8e-3 * np.linspace(0.0, 1.0, 600) ** 2
    areas = np.array([min(cap, ports_area(groove.ports, lift - groove.lap)) for lift in lifts])
    tabulated = machine(intake=intake, groove__area_curve=np.column_stack((lifts, areas)))
    exact, fine = (indicators(one, settled(one, 1000.0)) for one in (a_machine, tabulated))
    for name in ("indicated_torque_Nm", "engine_air_kg_per_cycle"):
        assert exact[name] == pytest.approx(fine[name], rel=2e-5)
    assert exact["valve_open_deg"] == pytest.approx(fine["valve_open_deg"], abs=1e-6)


def test_a_table_replaces_the_ports():
    curve = np.array([[2e-3, 0.0], [9e-3, 100e-6]])
    one, other = (machine(groove__geometry=g, groove__area_curve=curve) for g in (0, PORTS))
    assert lap_of(area_table(other.groove, 9e-3)) == 2e-3
    assert settled(one, 1000.0).end.tolist() == settled(other, 1000.0).end.tolist()
