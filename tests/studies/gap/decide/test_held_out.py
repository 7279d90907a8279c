"""Explanations judged by runs that nothing was fitted to."""

import numpy as np

from apesim.studies.gap.decide.held_out import find_baseline, judge_held_out
from apesim.studies.gap.example_bench import TIMES, explain_example
from apesim.studies.gap.stage_work import Work
from apesim.studies.measured import FIT, GATE

STILL = TIMES < 5e-3
"""Before the piston moves."""


def judge_by_gates(change):
    """Judge the example's explanation by its gate run, changed in some way; give the result."""
    explanation = explain_example()
    runs = [change(run) if run.role == GATE else run for run in explanation.measured.runs]
    measured = explanation.measured._replace(runs=runs)
    _, judged = judge_held_out(explanation.calibrated, explanation.fits, measured, Work())
    return judged


def still(run):
    """A run that ends before the piston moves."""
    return run._replace(times=run.times[STILL], channels={"lift": run.channels["lift"][STILL]})


def test_a_gate_that_shows_the_effect_judges_alone():
    assert judge_by_gates(lambda run: run).samples == len(TIMES)


def test_a_gate_that_hardly_shows_the_effect_is_one_part_among_the_operating_points():
    """Alone it would refuse the name: what does not move there takes nothing of the gap."""
    judged = judge_by_gates(still)
    fitted = len(explain_example().measured.of(FIT))
    assert judged.samples == STILL.sum() + fitted * len(TIMES)
    assert judged.removed_share > 0.9


def pull(model, x=8.0):
    """A model that has pulled its first number far."""
    fitted = model.fitted
    return model._replace(fitted=fitted._replace(x=np.append(x, fitted.x[1:])))


def test_a_number_that_has_taken_up_the_gap_is_no_part_of_what_a_name_is_held_against():
    explanation = explain_example()
    far, best = pull(explanation.calibrated), explanation.best
    assert 0 in far.pulled
    assert not best.pulled
    assert find_baseline(far, best).fitted.x.tolist() == best.fitted.x[: len(far.fitted.x)].tolist()
    assert find_baseline(far, pull(best)) is far


def test_the_gate_judges_from_the_numbers_of_the_explanation_where_the_calibration_has_pulled_one_far():
    explanation = explain_example()
    fits, measured = explanation.fits, explanation.measured
    plain, far = (
        judge_held_out(base, fits, measured, Work())[1]
        for base in (explanation.calibrated, pull(explanation.calibrated))
    )
    assert far.rms_after == plain.rms_after
    assert 1.0 < far.rms_before < 2.0  # with a number that is 8 sigmas off it would be far more
    assert far.removed_share > 0.9
