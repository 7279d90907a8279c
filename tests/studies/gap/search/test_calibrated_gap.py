"""The calibrated machine that a gap is looked for with."""

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.gap.example_bench import explain_example, find_example_gap
from apesim.studies.gap.search import calibrated_gap
from apesim.studies.gap.stage_work import Work


@pytest.mark.parametrize("what", ["pulled", "unconverged", "neither"])
def test_a_calibration_that_has_gone_far_or_not_to_its_end_is_started_elsewhere_though_noise_alone_is_left(
    monkeypatch, what
):
    """A search that went astray may leave noise alone all the same, and blame eight numbers."""
    explanation, tried = explain_example(), []
    far = np.where(np.arange(len(explanation.calibrated.fitted.x)) == 0, 9.0, 0.0)
    x = far if what == "pulled" else 0.0 * far
    fitted = explanation.calibrated.fitted._replace(x=x, converged=what != "unconverged")
    model = explanation.calibrated._replace(fitted=fitted)
    quiet = find_example_gap()._replace(calibrated=model)
    quiet = quiet._replace(gap_test=quiet.gap_test._replace(p_value=0.5))
    assert not quiet.gap_test.alarm
    monkeypatch.setattr(calibrated_gap, "calibrate", lambda *_: (model, []))
    monkeypatch.setattr(calibrated_gap, "score_candidates", lambda *_: ())
    monkeypatch.setattr(calibrated_gap, "check_against_noise", lambda *_: quiet)
    monkeypatch.setattr(calibrated_gap, "find_solver_error", lambda *_: 0.0)
    monkeypatch.setattr(calibrated_gap, "elsewhere", lambda base, work: tried.append(base) or base)
    calibrated_gap.find_gap(Machine(), explanation.measured, [], Work())
    assert bool(tried) == (what != "neither")
