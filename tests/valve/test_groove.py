from itertools import pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.valve.groove import Groove, area_table, lap_of, piece_line, piece_of

STROKE = 9e-3


@st.composite
def tables(draw):
    steps = draw(st.lists(st.floats(1e-4, 3e-3), min_size=1, max_size=4))
    lifts = draw(st.floats(0.0, 2e-3)) + np.append(0.0, np.cumsum(steps))
    areas = draw(st.lists(st.floats(0.0, 3e-4), min_size=len(steps), max_size=len(steps)))
    return np.column_stack([lifts, [0.0, *areas]])


@given(tables(), st.floats(-1e-3, 20e-3))
def test_the_area_is_linear_between_the_rows_and_constant_outside(table, lift):
    area, slope, low, high = piece_line(table, piece_of(table, lift))
    assert low <= lift <= high
    # Line at lift 0 plus slope times lift: rounded at the size of its terms, 3e-4/1e-4 * 15e-3 m2.
    assert area + slope * lift == pytest.approx(np.interp(lift, *table.T), abs=1e-16)


@given(tables())
def test_neighbouring_pieces_meet_at_a_row(table):
    pieces = [piece_line(table, piece) for piece in range(len(table) + 1)]
    assert (pieces[0][2], pieces[-1][3]) == (-inf, inf)
    for row, (below, above) in zip(table, pairwise(pieces), strict=True):
        assert below[3] == above[2] == row[0]
        for area, slope, _, _ in (below, above):
            assert area + slope * row[0] == pytest.approx(row[1], abs=1e-16)


def test_by_default_the_area_rises_linearly_from_the_lap_to_full_lift():
    table = area_table(Groove(), STROKE)
    lifts, areas = [0.0, 1e-3, 5e-3, 9e-3], [0.0, 0.0, 75e-6, 150e-6]
    lines = [piece_line(table, piece_of(table, lift)) for lift in lifts]
    assert [line[0] + line[1] * lift for line, lift in zip(lines, lifts, strict=True)] == pytest.approx(
        areas, abs=1e-18
    )
    assert lap_of(table) == 1e-3


def test_a_table_replaces_lap_and_area():
    curve = np.array([[0.2e-3, 0.0], [2e-3, 0.0], [4e-3, 40e-6]])
    table = area_table(Groove(area_curve=curve), STROKE)
    assert table.tolist() == curve.tolist()
    assert lap_of(table) == 2e-3


def test_a_curve_must_start_closed_and_stay_above_zero():
    def faults(*rows):
        return [key for key, *_ in Groove(area_curve=np.array(rows)).faults()]

    assert faults([0.0, 0.0], [1e-3, 1e-5]) == []
    assert faults([0.0, 1e-6], [1e-3, 1e-5]) == ["area_curve"]
    assert faults([-1e-3, 0.0], [1e-3, 1e-5]) == ["area_curve"]
    assert faults([0.0, 0.0], [1e-3, -1e-5], [2e-3, 1e-5]) == ["area_curve"]
    assert not list(Groove().faults())
