"""Slider and crank: the volume and its slope, against the geometry drawn by hand."""

from math import asin, atan2, cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.engine.kinematics import clearance_volume, crank_of, cylinder_volume, piston_face, swept_volume
from tests.machines import machine

ANGLES = st.floats(-4.0 * pi, 4.0 * pi)


@st.composite
def cranks(draw):
    """A crank with a rod of 1.2 to 4 strokes and a pin offset of up to a third of it."""
    stroke = draw(st.floats(0.02, 0.5))
    return crank_of(
        machine(
            engine__bore=draw(st.floats(0.02, 0.5)),
            engine__stroke=stroke,
            engine__rod_length=stroke * draw(st.floats(1.2, 4.0)),
            engine__pin_offset=stroke * draw(st.floats(-0.33, 0.33)),
            engine__compression_ratio=draw(st.floats(2.0, 40.0)),
        ).engine
    )


@given(cranks(), ANGLES)
def test_slope_is_the_derivative_of_the_volume(crank, angle):
    """Central difference: its error is h^2 of the swept volume, 1e-8, and rounding over h."""
    h = 1e-4
    ahead, behind = cylinder_volume(crank, angle + h)[0], cylinder_volume(crank, angle - h)[0]
    swept = 2.0 * crank.radius * crank.face
    assert cylinder_volume(crank, angle)[1] == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-7 * swept)


@given(cranks(), ANGLES)
def test_piston_pin_is_a_rod_s_length_from_the_crank_pin(crank, angle):
    """The crank pin is up at 0 and moves to positive x; the cylinder's axis stands at x = offset."""
    volume, _ = cylinder_volume(crank, angle)
    pin = crank.offset, crank.highest - (volume - crank.clearance) / crank.face
    crank_pin = crank.radius * sin(angle), crank.radius * cos(angle)
    assert pin[1] > crank_pin[1]
    assert hypot(pin[0] - crank_pin[0], pin[1] - crank_pin[1]) == pytest.approx(crank.rod, rel=1e-12)


@given(cranks())
def test_clearance_is_reached_where_crank_and_rod_are_in_line(crank):
    top = asin(crank.offset / (crank.rod + crank.radius))
    volume, slope = cylinder_volume(crank, top)
    swept = 2.0 * crank.radius * crank.face
    assert volume == pytest.approx(crank.clearance, abs=1e-12 * swept)
    assert slope == pytest.approx(0.0, abs=1e-12 * swept)
    others = [cylinder_volume(crank, angle)[0] for angle in np.linspace(0.0, 2.0 * pi, 181)]
    assert min(others) >= crank.clearance - 1e-12 * swept


@given(cranks(), ANGLES)
def test_offset_to_the_other_side_mirrors_the_motion(crank, angle):
    there, slope_there = cylinder_volume(crank, angle)
    back, slope_back = cylinder_volume(crank._replace(offset=-crank.offset), -angle)
    swept = 2.0 * crank.radius * crank.face
    assert back == pytest.approx(there, abs=1e-13 * swept)
    assert slope_back == pytest.approx(-slope_there, abs=1e-13 * swept)


def test_without_offset_the_volumes_are_those_of_bore_stroke_and_compression_ratio():
    engine = machine().engine
    crank = crank_of(engine)
    swept = 0.25 * pi * 0.085**2 * 0.088
    assert swept_volume(engine) == pytest.approx(swept, rel=1e-14)
    assert clearance_volume(engine) == pytest.approx(swept / 17.0, rel=1e-14)
    assert cylinder_volume(crank, 0.0)[0] == pytest.approx(swept / 17.0, rel=1e-13)
    assert cylinder_volume(crank, pi)[0] == pytest.approx(swept * 18.0 / 17.0, rel=1e-13)


def test_with_offset_the_stroke_is_longer_and_the_clearance_still_the_nominal_one():
    """The stroke of an offset crank: sqrt((l + r)^2 - e^2) - sqrt((l - r)^2 - e^2)."""
    engine = machine(engine__pin_offset=20e-3).engine
    crank = crank_of(engine)
    bottom = pi + asin(0.020 / (0.150 - 0.044))
    stroke = sqrt(0.194**2 - 0.020**2) - sqrt(0.106**2 - 0.020**2)
    assert stroke > engine.stroke
    assert cylinder_volume(crank, bottom)[0] == pytest.approx(
        clearance_volume(engine) + piston_face(engine) * stroke, rel=1e-13
    )


def test_positive_offset_is_to_the_side_to_which_the_crank_pin_moves_after_zero():
    """So the highest position comes after 0, and the way down takes more than half a turn."""
    crank = crank_of(machine(engine__pin_offset=5e-3).engine)
    angles = np.linspace(-pi, pi, 36001)
    volumes = np.array([cylinder_volume(crank, angle)[0] for angle in angles])
    top, bottom = angles[volumes.argmin()], angles[volumes.argmax()] % (2.0 * pi)
    assert top == pytest.approx(atan2(5e-3, sqrt(0.194**2 - 5e-3**2)), abs=2e-4)
    assert bottom - top > pi
