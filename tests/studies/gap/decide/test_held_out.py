"""Explanations judged by runs that nothing was fitted to."""

from apesim.studies.gap.decide.held_out import judge_held_out
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
