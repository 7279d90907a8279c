"""Chen and Flynn's friction, term by term."""

from math import pi

import pytest

from apesim.engine.friction import Friction, friction_mean_effective_pressure, mean_piston_speed


def test_mean_piston_speed_is_two_strokes_a_turn():
    """88 mm at 1000 r/min."""
    assert mean_piston_speed(0.088, 1000.0 * pi / 30.0) == pytest.approx(2.0 * 0.088 * 1000.0 / 60.0, rel=1e-14)


def test_default_friction_at_a_hand_computed_point():
    """0.4 bar + 0.005 x 11 bar + 0.08 x 3 bar + 0.0008 x 9 bar."""
    assert friction_mean_effective_pressure(Friction(), 11e5, 3.0) == pytest.approx(0.7022e5, rel=1e-14)


@pytest.mark.parametrize(
    ("friction", "expected"),
    [
        (Friction(1.0, 0.0, 0.0, 0.0), 1.0),
        (Friction(0.0, 1.0, 0.0, 0.0), 7.0),
        (Friction(0.0, 0.0, 1.0, 0.0), 3.0),
        (Friction(0.0, 0.0, 0.0, 1.0), 9.0),
        (Friction(0.0, 0.0, 0.0, 0.0), 0.0),
    ],
)
def test_each_constant_stands_before_its_term(friction, expected):
    assert friction_mean_effective_pressure(friction, 7.0, 3.0) == expected
