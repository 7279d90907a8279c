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
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.estimation.scatter import Scatter, list_odd_repeats
from apesim.studies.execution.calls import public
from apesim.studies.execution.pool import Team
from apesim.studies.gap.decide.consistency import compare_points, select_significant
from apesim.studies.gap.decide.facts import Facts, find_explained_gap
from apesim.studies.gap.decide.held_out import (
    HeldOut,
    compare_residuals,
    find_all_held_out_residuals,
    find_baseline,
    judge_by_runs,
    judge_held_out,
    leave_one_out,
    settle,
)
from apesim.studies.gap.decide.left import is_good_enough
from apesim.studies.gap.decide.odd_files import OddChannel, find_odd_channels
from apesim.studies.gap.decide.operating_points import find_points, label_point
from apesim.studies.gap.decide.standard_errors import find_variances_between
from apesim.studies.gap.decide.verdict import decide
from apesim.studies.gap.design.next_test import find_next_test
from apesim.studies.gap.explanation import Explanation
from apesim.studies.gap.input_checks import check_roles
from apesim.studies.gap.reasons import BLAMING, Verdict
from apesim.studies.gap.search.calibrated_gap import CalibratedGap, find_gap
from apesim.studies.gap.search.candidate_fits import compare_model_with_noise, fit_candidates
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.file_numbers import find_file_numbers
from apesim.studies.gap.search.intervals import find_profiles, has_shape
from apesim.studies.gap.search.library import find_faults, select_effects
from apesim.studies.gap.search.localisation import Cell, localise
from apesim.studies.gap.search.model_selection import Foreseen, PricedModel
from apesim.studies.gap.search.run_faults import find_run_faults, leave_out
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.tables.balance import weigh_balances
from apesim.studies.gap.tables.tabulate import Tables, find_likelier_table, tabulate
from apesim.studies.gap.thresholds import TOLERANCE
from apesim.studies.gap.tolerance import find_odd_type, read_tolerance
from apesim.studies.measured import CHECK, GATE, Measured
from apesim.studies.measured.arguments import Tell, open_measured
from apesim.studies.measured.plausibility import refuse_faults
from apesim.studies.run.operating_conditions import JOBS


@public
def explain(
    machine: Machine,
    measured: Measured | str | PathLike[str],
    *,
    without: Sequence[str] = (),
    tolerance: float | str = TOLERANCE,
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
        Effects of the library, and keys of numbers of the machine file, that are not to be considered.
    tolerance : float or str
        Size of a gap, over the noise, that does not matter; or how far the model may be off in the unit of a channel,
        as ``"0.3 N"`` or ``"0.02 mm, 2 kPa"``: what is named then is right to within that.
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
        faults=[*find_faults(without, machine), *find_odd_type(tolerance)],
        jobs=(jobs, JOBS),
    )
    share, discrepancy = read_tolerance(tolerance, measured, ("explain()", "tolerance"))
    measured = measured._replace(discrepancy=discrepancy)
    with Team(jobs and int(numbers["jobs"])) as team:
        explanation = _run_workflow(machine, measured, without, share, Work(team, progress))
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
    candidates += find_file_numbers(machine, measured, candidates, without)
    faults = find_run_faults(measured)
    gap, solver_error, more = find_gap(machine, measured, candidates, work, faults, scatter)
    odd = find_odd_channels(gap.calibrated.residuals, gap.calibrated.fitted.data_residuals)
    is_searched = gap.gap_test.alarm or bool(odd)
    fits: list[PricedModel] = []
    foreseen: list[Foreseen] = []
    if is_searched:
        held_out = measured.of(GATE) + measured.of(CHECK)
        gap, fits, foreseen = fit_candidates(gap, len(candidates) + len(faults), work, held_out)
    facts = Facts(gap.calibrated, gap.gap_test.p_value, tolerance, foreseen=tuple(foreseen))
    explanation = Explanation(
        measured=measured,
        calibrated=gap.calibrated,
        sensitivities=gap.sensitivities,
        scores=gap.scores,
        gap_test=gap.gap_test,
        solver_error=solver_error,
        tolerance=tolerance,
        cells=localise(gap.calibrated.residuals, gap.marks, gap.calibrated.fitted.data_residuals, holds_noise=True),
        decision=decide(facts),  # what a search finds takes its place
        foreseen=foreseen,
        left_p_value=gap.gap_test.p_value,
        warnings=[*more, *warnings],  # what makes all numbers doubtful comes first
    )
    # The table of verdicts is read anew with each kind of evidence, as the dear kinds are sought only where it asks.
    if is_searched:
        explanation, facts = _add_search(explanation, facts, gap, fits, odd, len(candidates), work)
        explanation = _profile_intervals(explanation, work)
    if explanation.verdict in (Verdict.NO_GAP, Verdict.CALIBRATION):
        explanation, facts = _add_contradictions(explanation, facts, work)
    if explanation.verdict == Verdict.MEASUREMENT:
        others = leave_out(measured, facts.files)
        rest = _run_workflow(machine, others, without, tolerance, work, explanation.best.residuals.scatter)
        explanation = _add_rest(explanation, facts, rest)
    explanation = _average_models(explanation, len(candidates) + len(faults))
    explanation = check_on_unused_runs(explanation, work)
    return replace(explanation, next_test=find_next_test(explanation))


def _add_search(
    explanation: Explanation,
    facts: Facts,
    gap: CalibratedGap,
    fits: list[PricedModel],
    odd: list[OddChannel],
    library_size: int,
    work: Work,
) -> tuple[Explanation, Facts]:
    """The explanation and its facts with what a search has found, judged by runs held out and beside tables."""
    measured, noise = explanation.measured, explanation.noise
    facts, cells = _judge_fits(explanation, facts, gap, fits, odd, work)
    tables = Tables(facts.base, weigh_balances(facts.base, select_effects(measured.bench), work), work)
    facts = replace(facts, likelier_table=_find_likelier_balance(facts, tables, library_size))
    decision, ranked = decide(facts), list(facts.choices or ())
    # Where the library is refused, a table takes its place, and the gap lives where that shows it.
    tabulated = tabulate(tables, measured, noise) if decision.verdict == Verdict.REFUSED else None
    if tabulated and not (ranked and ranked[0].model.cost < tabulated.model.cost):
        cells = _localise_explained(gap, tabulated.model, gap.calibrated)
    found = replace(explanation, decision=decision, fits=fits, ranked=ranked, judged=facts.judged, cells=cells)
    found = replace(found, foreseen=facts.foreseen)
    found = replace(found, left_p_value=facts.left_chance, gap_size=facts.size, balances=tables.ranked)
    return replace(found, tabulated=tabulated), facts


def _judge_fits(
    explanation: Explanation,
    facts: Facts,
    gap: CalibratedGap,
    fits: list[PricedModel],
    odd: list[OddChannel],
    work: Work,
) -> tuple[Facts, list[Cell]]:
    """The facts with the models that were fitted, judged by runs held out, and where the gap lives."""
    ranked, judged = judge_held_out(facts.base, fits, explanation.measured, work)
    facts = replace(facts, choices=tuple(ranked), judged=judged, odd_before=tuple(odd))
    cells = counted = explanation.cells
    # What was foreseen is counted from the best choice, which is another one where gates have changed the order.
    if ranked:
        behind = next(choice.cost for choice in fits if choice.names == ranked[0].names) - fits[0].cost
        nearer = (each._replace(excess=max(0.0, each.excess - behind)) for each in facts.foreseen)
        facts = replace(facts, foreseen=tuple(nearer))
    # The gap is what the best model takes of the residuals; where none earns its place, they are all there is.
    if not facts.has_no_gain:
        best = facts.best.model
        start = _find_start_of_gap(facts)
        cells = _localise_explained(gap, best, facts.base)
        counted = cells if start is facts.base else _localise_explained(gap, best, start)
        facts = replace(facts, left_chance=1.0 if is_good_enough(best) else compare_model_with_noise(best, gap).p_value)
    if ranked:
        best = ranked[0].model
        facts = replace(facts, odd_after=tuple(find_odd_channels(best.residuals, best.fitted.data_residuals)))
    return replace(facts, size=max(cell.size for cell in counted)), cells


def _localise_explained(gap: CalibratedGap, model: Model, start: Model) -> list[Cell]:
    """The shares of signals and phases in the part of the gap that a model takes away, counted from `start`."""
    explained = find_explained_gap(start, model)
    return localise(gap.calibrated.residuals, gap.marks, explained, holds_noise=False)


def _find_start_of_gap(facts: Facts) -> Model:
    """The machine without effects from which the gap is counted, see `find_baseline`.

    A calibration that has pulled a number far leaves little of what is missing, where the best choice is clearly better
    without: the number has only taken it up.
    """
    baseline = facts.base if facts.is_faint else find_baseline(facts.base, facts.best.model)
    before = None if baseline is facts.base else unless_ended(facts.base.residuals.at, baseline.fitted.x)
    if before is None:
        return facts.base
    return baseline._replace(fitted=baseline.fitted._replace(residuals=before))


def _find_likelier_balance(facts: Facts, tables: Tables, library_size: int) -> str | None:
    """The balance of a table that explains more than what is blamed.

    None where no run has judged it, and where it is good enough by a discrepancy that is stated.
    """
    decision = decide(facts)
    is_judged = facts.judged is not None or decision.verdict == Verdict.MEASUREMENT
    if decision.verdict not in BLAMING or not is_judged or decision.best is None:
        return None
    # A model that may be off by what it leaves is not refused for what a table takes of that.
    if is_good_enough(decision.best.model):
        return None
    better = find_likelier_table(tables, decision.best.model, library_size)
    return better.balance if better else None


def _add_contradictions(explanation: Explanation, facts: Facts, work: Work) -> tuple[Explanation, Facts]:
    """The explanation and its facts with what may contradict that nothing is missing."""
    calibrated, gates = explanation.calibrated, explanation.measured.of(GATE)
    # Every channel of every run that is fitted or a gate has to be explained.
    odd = find_odd_channels(calibrated.residuals, calibrated.fitted.data_residuals)
    if gates:
        residuals, errors, settled = settle(calibrated, gates, explanation.noise)
        odd += find_odd_channels(residuals, settled.residuals[: len(errors) - len(settled.x)])
    # A number that is said to be wrong has to hold on runs held out, like a name; no search may have judged it yet.
    judged = None
    if not odd and explanation.verdict == Verdict.CALIBRATION and facts.judged is None:
        judged = _judge_calibration(explanation, work)
    # A file that differs from its repeats may be a faulty record, or show that runs scatter more than these few tell.
    repeats = tuple(list_odd_repeats(calibrated.residuals.scatter))
    facts = replace(facts, odd_unexplained=tuple(odd), judged_calibration=judged, odd_repeats=repeats)
    return replace(explanation, decision=decide(facts), judged=facts.judged or judged, odd=odd), facts


def _judge_calibration(explanation: Explanation, work: Work) -> HeldOut | None:
    """The calibrated machine on the gate runs, or on operating points left out one at a time."""
    calibrated, gates = explanation.calibrated, explanation.measured.of(GATE)
    judged = judge_by_runs(calibrated, calibrated, gates, explanation.noise, work) if gates else None
    return judged or leave_one_out(calibrated, calibrated, work)


def _add_rest(explanation: Explanation, facts: Facts, rest: Explanation) -> Explanation:
    """The explanation with what the other files say, or a refusal where those are not explained either."""
    is_refused = rest.verdict == Verdict.REFUSED
    decision = decide(replace(facts, is_rest_refused=is_refused))
    decision = decision._replace(best=explanation.decision.best)  # the same, but with intervals
    return replace(explanation, decision=decision, rest=None if is_refused else rest)


def _profile_intervals(explanation: Explanation, work: Work) -> Explanation:
    """The explanation with intervals by profile likelihood, where the curvature at the optimum does not give them."""
    decision, warnings, before = explanation.decision, explanation.warnings, explanation.decision.best
    if decision.verdict not in BLAMING or before is None or not has_shape(before.model):
        return explanation
    model, simulations = find_profiles(before.model, work)
    work.simulations.add(simulations)
    if model.profiles is None:
        warnings = [*warnings, f"no interval is given of {' and '.join(model.names)}: its fit has too many minima"]
    best = PricedModel(model, before.cost + model.cost - before.model.cost)
    return replace(explanation, decision=decision._replace(best=best), warnings=warnings)


def _average_models(explanation: Explanation, library_size: int) -> Explanation:
    """The explanation with what other models within reach add to the variances of what it adds to the machine."""
    decision, best = explanation.decision, explanation.decision.best
    if best is None or best.model is explanation.calibrated:
        return explanation
    between = find_variances_between(best, explanation.ranked, explanation.sensitivities, library_size)
    best = best._replace(model=best.model._replace(between=between))
    return replace(explanation, decision=decision._replace(best=best))


def check_on_unused_runs(explanation: Explanation, work: Work) -> Explanation:
    """The explanation, compared with the check runs, which are opened once, here.

    It comes back with ``checked``, ``consistency``, ``simulations`` and further ``warnings``.
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
