"""A march that goes on from any checkpoint ends as the one that was never left, to the last bit."""

import numpy as np
import pytest

import apesim
from apesim.engine.angles import DEGREE
from apesim.engine.drivetrain.checkpoint import CHECKPOINT, checkpoint_of, resume_march
from apesim.engine.drivetrain.preparing import Course, prepare
from apesim.engine.drivetrain.run import begin_march, march_pieces, run_drivetrain, run_of

OWN = [{}, {"valve.moving_mass": "60 g"}, {"groove.effective_area": "150 mm^2"}]
RAMP = Course(speeds=np.array([[0.0, 30.0], [0.8, 150.0]]))
CASES = {
    "free, from rest": (apesim.Machine().with_(load_quadratic="2.85e-3 N m s^2"), 30.0, Course(), 0.9),
    "three cylinders": (
        apesim.Machine().with_(engine_cylinders=3, cylinder=OWN, **{"load.kind": "hoist", "load.constant": "4 N m"}),
        20.0,
        Course(loads=np.array([[0.4, 9.0]]), supplies=np.array([[0.5, 0.7e6]])),
        0.9,
    ),
    "imposed speed": (apesim.Machine(), 0.0, RAMP, 0.8),
}


@pytest.mark.parametrize("case", CASES)
def test_a_march_goes_on_from_each_of_its_pieces_to_the_same_bits(case):
    machine, angle, course, duration = CASES[case]
    start, times = prepare(machine, angle * DEGREE, course), np.arange(0.0, duration, 1e-3)
    whole = run_drivetrain(start, duration, times)
    kept = [checkpoint_of(marched) for marched in march_pieces(start, begin_march(start, times), duration)]
    assert len(kept) > 2 and len(whole.revolutions["start"]) > 2
    for arrays in kept:
        assert {name: values.ndim for name, values in arrays.items()} == {n: len(d) for n, d in CHECKPOINT.items()}
        again = prepare(machine, angle * DEGREE, course)
        resumed = resume_march(again, times, arrays)
        for piece in march_pieces(again, resumed, duration):
            resumed = piece
        assert_same(whole, run_of(resumed))


def assert_same(whole, resumed):
    """All that two runs hold is the same to the last bit, NaN for NaN."""
    for mine, other in zip(whole, resumed, strict=True):
        if isinstance(mine, dict):
            assert mine.keys() == other.keys()
            assert all(np.array_equal(mine[name], other[name], equal_nan=True) for name in mine)
        elif isinstance(mine, np.ndarray):
            assert np.array_equal(mine, other, equal_nan=True)
        else:
            assert mine == other
