"""The size from which an effect is visible, with the direction in which the effect grows."""

import numpy as np
import pytest

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.studies.gap.search.candidates import Probe, find_candidates
from apesim.studies.gap.search.detection_limits import find_detection_limits, format_limit
from apesim.studies.gap.search.score_test import Sensitivity

CANDIDATES = find_candidates(Machine(), "engine", ALL_EFFECTS)
CHANGE = np.array([6.0, 8.0])
"""What a probe does to the data: 10 sigmas, of which 5 are visible."""


def limit_of(candidate, x):
    probe = Probe(candidate, candidate.switch_on(0, x, [0.1] * len(candidate.shapes)), 0)
    return find_detection_limits([Sensitivity(probe, CHANGE, CHANGE, 1.0)])[candidate.name]


@pytest.mark.parametrize("candidate", CANDIDATES, ids=lambda candidate: candidate.name)
def test_half_of_a_probe_is_visible_and_the_side_is_that_on_which_the_effect_is_larger(candidate):
    parameter = candidate.strengths[0]
    small, limit, large = (abs(parameter.value(x) - parameter.origin) for x in (0.1, 0.125, 0.2))
    row = limit_of(candidate, 0.25)
    assert row["limit"] == pytest.approx(parameter.shown(limit))
    assert row["grows"] == ("up" if large > small else "down")
    assert format_limit(row).endswith(" and below") == (large < small)


def test_an_effect_that_is_off_at_a_value_of_its_own_says_how_far_from_it():
    row = limit_of(next(candidate for candidate in CANDIDATES if candidate.name == "critical_ratio"), 0.25)
    assert format_limit(row) == "0.041 away from 0.528"
