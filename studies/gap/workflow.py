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
from apesim.studies.calls import public
from apesim.studies.estimation.arguments import Tell, open_measured
from apesim.studies.estimation.scatter import Scatter, list_odd_repeats
from apesim.studies.execution.pool import Team
from apesim.studies.gap.decide.consistency import compare_points, select_significant
from apesim.studies.gap.decide.held_out import (
    compare_residuals,
    find_all_held_out_residuals,
    judge_by_runs,
    judge_held_out,
    leave_one_out,
    settle,
)
from apesim.studies.gap.decide.odd_files import OddChannel, find_odd_channels
from apesim.studies.gap.decide.operating_points import find_points, label_point
from apesim.studies.gap.decide.verdict import Decision, decide_with_alarm, decide_without_alarm, find_explained_gap
from apesim.studies.gap.design.next_test import find_next_test
from apesim.studies.gap.explanation import Explanation
from apesim.studies.gap.input_checks import check_roles
from apesim.studies.gap.reasons import BLAMING, ReasonKind, Verdict
from apesim.studies.gap.search.calibrated_gap import CalibratedGap, find_gap
from apesim.studies.gap.search.candidate_fits import compare_model_with_noise, fit_candidates
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.intervals import find_profiles, has_shape
from apesim.studies.gap.search.library import find_faults, select_effects
from apesim.studies.gap.search.localisation import localise
from apesim.studies.gap.search.model_selection import Choice
from apesim.studies.gap.search.run_faults import find_files, find_run_faults, leave_out
from apesim.studies.gap.tables.balance import weigh_balances
from apesim.studies.gap.tables.tabulate import Tables, find_likelier_table, tabulate
from apesim.studies.gap.thresholds import MAX_LEFT, TOLERANCE
from apesim.studies.gap.work import Work
from apesim.studies.measured import CHECK, GATE, Measured
from apesim.studies.measured.plausibility import refuse_faults
from apesim.studies.operating_conditions import JOBS

SIZE = Quantity("", 0, 1000, "a call")


@public
def explain(
    machine: Machine,
    measured: Measured | str | PathLike[str],
    *,
    without: Sequence[str] = (),
    tolerance: float = TOLERANCE,
    jobs: int | None = 1,
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
    jobs : int, optional
        Processes that share the work; None: as many as it is worth. What is found does not depend on it. With more than
        one, a script has to protect its own code by ``if __name__ == "__main__":``.
    progress : callable, optional
        Called with the name of the stage, what is done of it and what there is to do.

    Returns
    -------
    Explanation

    Raises
    ------
    InputError
        An argument is out of range, the data cannot be what they are said to be, or nothing can be concluded from
        them.
    NotConverged
        The machine itself cannot be simulated.

    Examples
    --------
    Lift of a valve with a side force of 3 N that the machine lacks, by a small part of the library; of your own data,
    give the folder. ``explanation.write("explained")`` then writes the report.

    >>> import apesim
    >>> from apesim.studies.gap.example_bench import list_left_out, read_example
    >>> explanation = apesim.explain(apesim.Machine(), read_example(), without=list_left_out())
    >>> str(explanation.verdict), explanation.best.names
    ('NAMED', ('side_force',))
    """
    start = time.perf_counter()
    machine, measured, numbers = open_measured(
        "explain",
        machine,
        measured,
        faults=find_faults(without, machine),
        tolerance=(tolerance, SIZE),
        jobs=(jobs, JOBS),
    )
    with Team(jobs and int(numbers["jobs"])) as team:
        explanation = _run_workflow(machine, measured, without, numbers["tolerance"], Work(team, progress))
    return replace(explanation, wall_time_s=time.perf_counter() - start)


def _run_workflow(
    machine: Machine,
    measured: Measured,
    without: Sequence[str],
    tolerance: float,
    work: Work,
    scatter: Scatter | None = None,
) -> Explanation:
    """Run all stages of the workflow, see `explain`, beside a scatter that more repeats than these have told."""
    check_roles(measured)
    warnings = refuse_faults(machine, measured)
    candidates = find_candidates(machine, measured.bench, select_effects(measured.bench, without, machine))
    faults = find_run_faults(measured)
    gap, solver_error, more = find_gap(machine, measured, candidates, work, faults, scatter)
    odd = find_odd_channels(gap.calibrated.residuals, gap.calibrated.fitted.data_residuals)
    is_searched = gap.gap_test.alarm or bool(odd)
    fits: list[Choice] = []
    if is_searched:
        gap, fits = fit_candidates(gap, len(candidates) + len(faults), work, measured.of(GATE) + measured.of(CHECK))
    explanation = Explanation(
        measured=measured,
        calibrated=gap.calibrated,
        sensitivities=gap.sensitivities,
        scores=gap.scores,
        gap_test=gap.gap_test,
        solver_error=solver_error,
        tolerance=tolerance,
        cells=localise(gap.calibrated.residuals, gap.marks, gap.calibrated.fitted.data_residuals, holds_noise=True),
        decision=decide_without_alarm(gap.calibrated, gap.gap_test.p_value),  # what a search finds takes its place
        left_p_value=gap.gap_test.p_value,
        warnings=[*more, *warnings],  # what makes all numbers doubtful comes first
    )
    if is_searched:
        explanation = decide(explanation, gap, fits, odd, len(candidates), work)
        explanation = _profile_intervals(explanation, work)
    explanation = refuse_what_is_not_held(explanation, work)
    if explanation.verdict == Verdict.MEASUREMENT:
        others = leave_out(measured, find_files(explanation.best.candidates))
        rest = _run_workflow(machine, others, without, tolerance, work, explanation.best.residuals.scatter)
        explanation = _explain_rest(explanation, rest)
    explanation = check_on_unused_runs(explanation, work)
    return replace(explanation, next_test=find_next_test(explanation))


def _explain_rest(explanation: Explanation, rest: Explanation) -> Explanation:
    """The explanation with what the other files say, or a refusal where those are not explained either."""
    if rest.verdict != Verdict.REFUSED:
        return replace(explanation, rest=rest)
    file = " and ".join(find_files(explanation.best.candidates))
    decision = explanation.decision._replace(
        verdict=Verdict.REFUSED, reason=ReasonKind.FILE_NOT_ALONE.with_facts(file=file)
    )
    return replace(explanation, decision=decision)


def refuse_what_is_not_held(explanation: Explanation, work: Work) -> Explanation:
    """Refuse NO_GAP and CALIBRATION where one file is odd, or where runs held out contradict.

    Every channel of every run that is fitted or a gate has to pass `find_odd_channels`. A number of the machine that is
    said to be wrong has to hold on the gate runs, or on operating points left out one at a time, like a name. Where a
    file differs from its repeats by more than the scatter of the others explains, neither is said: a faulty record and
    runs that scatter more than these few show are AMBIGUOUS.

    Parameters
    ----------
    explanation : Explanation
    work : apesim.studies.gap.work.Work

    Returns
    -------
    Explanation

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> refuse_what_is_not_held(explain_example(), Work()) is explain_example()  # an effect is named
    True
    """
    decision, calibrated, best = explanation.decision, explanation.calibrated, explanation.best
    if decision.verdict not in (Verdict.NO_GAP, Verdict.CALIBRATION):
        return explanation
    odd = find_odd_channels(best.residuals, best.fitted.data_residuals)
    gates, judged = explanation.measured.of(GATE), explanation.judged
    if gates:
        residuals, errors, settled = settle(best, gates, explanation.noise)
        odd += find_odd_channels(residuals, settled.residuals[: len(errors) - len(settled.x)])
    reason = None
    if odd:
        channel = max(odd, key=lambda each: each.size)
        reason = ReasonKind.ODD_CHANNEL.with_facts(sensor=channel.sensor, file=channel.file, rms=channel.rms)
    elif decision.verdict == Verdict.CALIBRATION and judged is None:
        judged = judge_by_runs(calibrated, best, gates, explanation.noise, work) if gates else None
        judged = judged or leave_one_out(calibrated, best, work)
        if judged and judged.size_after > max(explanation.tolerance, MAX_LEFT * judged.size_before):
            reason = ReasonKind.GAP_LEFT.with_facts(size=judged.size_after)
    repeats = list_odd_repeats(best.residuals.scatter)
    if reason:
        decision = decision._replace(verdict=Verdict.REFUSED, reason=reason)
    elif repeats:
        reason = ReasonKind.ODD_REPEAT.with_facts(file=" and ".join(repeats))
        decision = Decision(Verdict.AMBIGUOUS, None, (), reason)
    return replace(explanation, decision=decision, judged=judged, odd=odd)


def decide(
    explanation: Explanation,
    gap: CalibratedGap,
    fits: list[Choice],
    odd: list[OddChannel],
    library_size: int,
    work: Work,
) -> Explanation:
    """Judge the models that were fitted by runs held out, and name what is missing, or add a table in its place.

    Parameters
    ----------
    explanation : Explanation
    gap : apesim.studies.gap.search.calibrated_gap.CalibratedGap
    fits : list of apesim.studies.gap.search.model_selection.Choice
        The best first.
    odd : list of apesim.studies.gap.decide.odd_files.OddChannel
        Channels of single files that the calibrated machine leaves odd.
    library_size : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    Explanation

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example, find_example_gap
    >>> decided = decide(explain_example(), find_example_gap(), explain_example().fits, [], 3, Work())
    >>> decided.decision.best.names, decided.gap_size > 0.15
    (('side_force',), True)
    """
    calibrated, measured, cells, chance = explanation.calibrated, explanation.measured, explanation.cells, 1.0
    ranked, judged = judge_held_out(calibrated, fits, measured, work)
    if ranked and ranked[0].cost < calibrated.cost:
        cells = localise(
            calibrated.residuals, gap.marks, find_explained_gap(calibrated, ranked[0].model), holds_noise=False
        )
        chance = compare_model_with_noise(ranked[0].model, gap).p_value
    size = max(cell.size for cell in cells)
    left = find_odd_channels(ranked[0].model.residuals, ranked[0].model.fitted.data_residuals) if ranked else []
    decision = decide_with_alarm(calibrated, ranked, size, judged, chance, explanation.tolerance, left, odd)
    tables = Tables(calibrated, weigh_balances(calibrated, select_effects(measured.bench), work), work)
    if decision.verdict in BLAMING and (judged or decision.verdict == Verdict.MEASUREMENT):
        decision = _refuse_for_table(decision, tables, library_size)
    tabulated = tabulate(tables, measured, explanation.noise) if decision.verdict == Verdict.REFUSED else None
    if tabulated and not (ranked and ranked[0].model.cost < tabulated.model.cost):
        cells = localise(
            calibrated.residuals, gap.marks, find_explained_gap(calibrated, tabulated.model), holds_noise=False
        )
    return replace(
        explanation,
        fits=fits,
        ranked=ranked,
        judged=judged,
        left_p_value=chance,
        cells=cells,
        gap_size=size,
        decision=decision,
        balances=tables.ranked,
        tabulated=tabulated,
    )


def _refuse_for_table(decision: Decision, tables: Tables, library_size: int) -> Decision:
    """The decision, or a refusal where a table without a name makes the data more probable."""
    better = find_likelier_table(tables, decision.best.model, library_size) if decision.best else None
    if not better:
        return decision
    reason = ReasonKind.TABLE_TAKES_MORE.with_facts(balance=better.balance)
    return decision._replace(verdict=Verdict.REFUSED, reason=reason)


def _profile_intervals(explanation: Explanation, work: Work) -> Explanation:
    """The explanation with intervals by profile likelihood, where the curvature at the optimum does not give them."""
    decision, warnings, before = explanation.decision, explanation.warnings, explanation.decision.best
    if decision.verdict not in BLAMING or before is None or not has_shape(before.model):
        return explanation
    model, simulations = find_profiles(before.model, work)
    work.simulations.add(simulations)
    if model.profiles is None:
        warnings = [*warnings, f"no interval is given of {' and '.join(model.names)}: its fit has too many minima"]
    best = Choice(model, before.cost + model.cost - before.model.cost)
    return replace(explanation, decision=decision._replace(best=best), warnings=warnings)


def check_on_unused_runs(explanation: Explanation, work: Work) -> Explanation:
    """The explanation, compared with the check runs, which are opened once, here.

    Parameters
    ----------
    explanation : Explanation
    work : apesim.studies.gap.work.Work

    Returns
    -------
    Explanation
        With ``checked``, ``consistency``, ``simulations`` and further ``warnings``.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> checked = check_on_unused_runs(explain_example(), Work()).checked
    >>> checked.rms_before > checked.rms_after
    True
    """
    best, calibrated, runs = explanation.best, explanation.calibrated, explanation.measured.of(CHECK)
    warnings = []
    if best is not calibrated and not best.fitted.converged:
        warnings.append("the fit of what is reported did not converge")
    if best.beyond:
        warnings.append(f"{', '.join(best.beyond)}: fitted beyond the range, and written as the end of it")
    warnings += explanation.warnings
    consistency, ambient = compare_points(best), best.residuals.machine.ambient.pressure
    warnings += [
        f"{each.parameter.key}: {label_point(each.run, ambient)} alone gives another value than all runs together, "
        f"by {abs(each.n_sigma):.0f} sigmas"
        for each in select_significant(consistency, len(find_points(best.residuals.runs)))
    ]
    if explanation.rest:
        checked = explanation.rest.checked
    elif not runs:
        checked = None
    elif explanation.tabulated:
        checked = explanation.tabulated.judged
    elif best is calibrated:
        residuals = find_all_held_out_residuals(calibrated, [best], runs, explanation.noise, work)
        checked = compare_residuals([(each, each) for each in residuals])
    else:
        checked = judge_by_runs(calibrated, best, runs, explanation.noise, work)
    return replace(
        explanation,
        consistency=consistency,
        warnings=warnings,
        checked=checked,
        simulations=work.simulations.number,
    )
