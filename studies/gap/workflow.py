"""The missing-effect workflow, from measured data to an explanation.

In this order: check the input, calibrate the machine and test for a gap, fit candidates, check them on runs held out,
decide, try tables in place of laws, profile intervals, check on runs that were not used yet, and say what these data
could show and what to test next.
"""

import time
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike

from apesim.engine.machine import Machine
from apesim.quantities import Quantity
from apesim.studies.estimation.arguments import Tell, open_measured
from apesim.studies.execution.pool import Team
from apesim.studies.gap.decide.consistency import compare_points, too_far
from apesim.studies.gap.decide.held_out import all_left_over, compared, held_out, judge_held_out
from apesim.studies.gap.decide.operating_points import label_of, points_of
from apesim.studies.gap.decide.verdict import Decision, explained, with_alarm, without_alarm
from apesim.studies.gap.design.next_test import next_test
from apesim.studies.gap.explanation import Explanation
from apesim.studies.gap.input_checks import check_input
from apesim.studies.gap.reasons import BLAMING, ReasonKind, Verdict
from apesim.studies.gap.search.calibrated_gap import CalibratedGap, find_gap
from apesim.studies.gap.search.candidate_fits import compare_left_over, fit_candidates
from apesim.studies.gap.search.candidates import candidates_of
from apesim.studies.gap.search.intervals import is_shaped, with_profiles
from apesim.studies.gap.search.library import effects_on, faults_of
from apesim.studies.gap.search.localisation import localise
from apesim.studies.gap.search.model_selection import Choice
from apesim.studies.gap.tables.balance import balances
from apesim.studies.gap.tables.tabulate import Tables, likelier, tabulate
from apesim.studies.gap.thresholds import TOLERANCE
from apesim.studies.gap.work import Work
from apesim.studies.measured import CHECK, Measured
from apesim.studies.operating_conditions import JOBS

SIZE = Quantity("", 0, 1000, "a call")


def explain(
    machine: Machine,
    measured: Measured | str | PathLike[str],
    *,
    without: Sequence[str] = (),
    tolerance: float = TOLERANCE,
    jobs: int = 1,
    progress: Tell | None = None,
) -> Explanation:
    """Find what is missing between a machine and measured data.

    Parameters
    ----------
    machine : Machine
    measured : Measured or path
        Measured data, see `read_measured`, or their folder.
    without : sequence of str
        Effects of the library that are not to be considered.
    tolerance : float
        Size of a gap, over the noise, that does not matter.
    jobs : int
        Processes that share the work; what is found does not depend on it. With more than one, a script has to
        protect its own code by ``if __name__ == "__main__":``.
    progress : callable, optional
        Called with the name of the stage, what is done of it and what there is to do.

    Returns
    -------
    Explanation

    Raises
    ------
    InputError
        An argument is out of range, or nothing can be concluded from the data.
    EndedEarly
        The machine itself cannot be simulated.

    Examples
    --------
    Lift of a valve with a side force of 3 N that the machine lacks (a folder with one run to be fitted and one to judge
    the fit)::

        explanation = apesim.explain(apesim.Machine(), "my_bench")
        explanation.verdict, explanation.probability, explanation.effects
        explanation.write("explained")
    """
    start = time.perf_counter()
    measured, given = open_measured(
        "explain",
        machine,
        measured,
        faults=faults_of(without, machine),
        tolerance=(tolerance, SIZE),
        jobs=(jobs, JOBS),
    )
    with Team(int(given["jobs"])) as team:
        explanation = run_workflow(machine, measured, without, given["tolerance"], Work(team, progress))
    return replace(explanation, wall_time_s=time.perf_counter() - start)


def run_workflow(
    machine: Machine, measured: Measured, without: Sequence[str], tolerance: float, work: Work
) -> Explanation:
    """Run all stages of the workflow, see `explain`."""
    warnings = check_input(measured)
    candidates = candidates_of(machine, measured.bench, effects_on(measured.bench, without, machine))
    gap, solver_error, more = find_gap(machine, measured, candidates, work)
    explanation = Explanation(
        measured=measured,
        calibrated=gap.calibrated,
        sensitivities=gap.sensitivities,
        scores=gap.scores,
        gap_test=gap.gap_test,
        solver_error=solver_error,
        tolerance=tolerance,
        cells=localise(gap.calibrated.residuals, gap.marks, gap.calibrated.fitted.data_residuals, holds_noise=True),
        decision=without_alarm(gap.calibrated, gap.gap_test.p_value),
        warnings=[*warnings, *more],
    )
    if gap.gap_test.alarm:
        fits = fit_candidates(gap, len(candidates), work)
        explanation = decide(explanation, gap, fits, len(candidates), work)
        explanation = profile_intervals(explanation, work)
    explanation = check_on_unused_runs(explanation, work)
    return replace(explanation, next_test=next_test(explanation))


def decide(
    explanation: Explanation, gap: CalibratedGap, fits: list[Choice], library_size: int, work: Work
) -> Explanation:
    """Judge the models that were fitted by runs held out, and name what is missing, or add a table in its place.

    Parameters
    ----------
    explanation : Explanation
    gap : apesim.studies.gap.search.calibrated_gap.CalibratedGap
    fits : list of apesim.studies.gap.search.model_selection.Choice
        The best first.
    library_size : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    Explanation
    """
    calibrated, measured, cells, chance = explanation.calibrated, explanation.measured, explanation.cells, 1.0
    ranked, judged = judge_held_out(calibrated, fits, measured, work)
    if ranked and ranked[0].cost < calibrated.cost:
        cells = localise(calibrated.residuals, gap.marks, explained(calibrated, ranked[0]), holds_noise=False)
        chance = compare_left_over(ranked[0].model, gap).p_value
    size = max(cell.size for cell in cells)
    decision = with_alarm(calibrated, ranked, size, judged, chance, explanation.tolerance)
    tables = Tables(calibrated, balances(calibrated, effects_on(measured.bench), work), work)
    if decision.verdict in BLAMING and judged:
        decision = refuse_for_table(decision, tables, library_size)
    tabulated = tabulate(tables, measured, explanation.noise) if decision.verdict == Verdict.REFUSED else None
    if tabulated:
        cells = localise(calibrated.residuals, gap.marks, explained(calibrated, tabulated), holds_noise=False)
    return replace(
        explanation,
        fits=fits,
        ranked=ranked,
        judged=judged,
        cells=cells,
        gap_size=size,
        decision=decision,
        balances=tables.ranked,
        tabulated=tabulated,
    )


def refuse_for_table(decision: Decision, tables: Tables, library_size: int) -> Decision:
    """The decision, or a refusal where a table without a name makes the data more probable."""
    better = likelier(tables, decision.best.model, library_size) if decision.best else None
    if not better:
        return decision
    reason = ReasonKind.TABLE_TAKES_MORE.with_facts(balance=better.balance)
    return decision._replace(verdict=Verdict.REFUSED, reason=reason)


def profile_intervals(explanation: Explanation, work: Work) -> Explanation:
    """The explanation with intervals by profile likelihood, where the curvature at the optimum does not give them."""
    decision, warnings, before = explanation.decision, explanation.warnings, explanation.decision.best
    if decision.verdict not in BLAMING or before is None or not is_shaped(before.model):
        return explanation
    model, simulations = with_profiles(before.model, work)
    work.simulations.add(simulations)
    if model.profiles is None:
        warnings = [*warnings, f"no interval is given of {' and '.join(model.names)}: its fit has too many minima"]
    best = Choice(model, before.cost + model.cost - before.model.cost)
    return replace(explanation, decision=decision._replace(best=best), warnings=warnings)


def check_on_unused_runs(explanation: Explanation, work: Work) -> Explanation:
    """The explanation, held against the check runs, which are opened once, here."""
    best, calibrated, runs = explanation.best, explanation.calibrated, explanation.measured.of(CHECK)
    warnings = [*explanation.warnings]
    if best is not calibrated and not best.fitted.converged:
        warnings.append("the fit of what is told did not converge")
    warnings += [f"{key} is fitted beyond its range, and written as the end of it" for key in best.beyond]
    consistency, ambient = compare_points(best), best.residuals.machine.ambient.pressure
    warnings += [
        f"{one.parameter.key}: {label_of(one.run, ambient)} alone says another value than all runs together, "
        f"by {abs(one.deviations):.1f} deviations"
        for one in too_far(consistency, len(points_of(best.residuals.runs)))
    ]
    if not runs:
        checked = None
    elif explanation.tabulated:
        checked = explanation.tabulated.judged
    elif best is calibrated:
        left_over = all_left_over(calibrated, [best], runs, explanation.noise, work)
        checked = compared([(left, left) for left in left_over])
    else:
        checked = held_out(calibrated, best, runs, explanation.noise, work)
    return replace(
        explanation,
        consistency=consistency,
        warnings=warnings,
        checked=checked,
        simulations=work.simulations.number,
    )
