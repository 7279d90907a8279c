"""The missing-effect workflow, from measured data to a verdict."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.calibration import calibrate, elsewhere
from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.estimation import (
    from_what_nothing_explains,
    hum_of_what_nothing_explains,
    is_known,
    may_hum,
)
from apesim.studies.estimation.noise.process import noise_for
from apesim.studies.estimation.noise.sampling import parts_of
from apesim.studies.estimation.nuisance_space import imitated
from apesim.studies.gap.decide.consistency import apart, too_far
from apesim.studies.gap.decide.held_out import HeldOut, all_left_over, compared, held_out, leave_one_out
from apesim.studies.gap.decide.operating_points import label_of, points_of
from apesim.studies.gap.decide.verdict import (
    AMBIGUOUS_VERDICT,
    CALIBRATION,
    NAMED,
    NAMED_CLASS,
    REFUSED,
    TOLERANCE,
    TWO_EFFECTS,
    Verdict,
    explained,
    implausible,
    with_alarm,
    without_alarm,
)
from apesim.studies.gap.input_checks import OWN_ERROR, gate, own_error
from apesim.studies.gap.search.candidates import candidates_of
from apesim.studies.gap.search.gap_test import Detection, detect
from apesim.studies.gap.search.intervals import is_shaped, with_profiles
from apesim.studies.gap.search.library import effects_on
from apesim.studies.gap.search.localisation import localise
from apesim.studies.gap.search.model_selection import (
    AMBIGUOUS,
    Choice,
    alone_again,
    beside,
    pairs,
    released,
    remaining,
    singles,
)
from apesim.studies.gap.search.phases import local_shapes
from apesim.studies.gap.search.score_test import bank, scores
from apesim.studies.gap.tables.balance import balances
from apesim.studies.gap.tables.tabulate import Tables, Tabulated, likelier, tabulate
from apesim.studies.gap.work import Work
from apesim.studies.measured import CHECK, GATE

BLAMING = NAMED, NAMED_CLASS, TWO_EFFECTS, AMBIGUOUS_VERDICT, CALIBRATION
"""Verdicts that one or several names come with."""
DOUBTFUL = 0.25
"""Chance of noise alone to leave what a single effect leaves, below which all others and pairs are tried, too."""


class Look(NamedTuple):
    """The calibrated machine, and what the first key looks at."""

    base: Model
    columns: list
    """The bank."""
    marks: list
    """Instants that divide each run, as the machine file says.

    See `apesim.studies.estimation.residuals.Problem.marks`.
    """
    scores: list
    """The best first."""
    local: np.ndarray
    """See `apesim.studies.gap.search.phases.local_shapes`."""
    detection: Detection


class Findings(NamedTuple):
    """All that was found."""

    measured: object
    base: Model
    """The calibrated machine."""
    columns: list
    """The bank."""
    scores: list
    detection: Detection
    own_error: float
    tolerance: float
    """Size of a gap, over the noise, that does not matter."""
    cells: list
    """Cells that the gap lives in."""
    verdict: Verdict
    warnings: list
    tried: Sequence = ()
    """All that were fitted, before runs held out were looked at."""
    choices: Sequence = ()
    """Penalised, the best first."""
    judged: HeldOut | None = None
    """On the gate runs, or with operating points left out one at a time."""
    size: float = 0.0
    """Size of the gap where it is largest, over the noise."""
    balances: Sequence = ()
    """What each table takes of the gap, the best first; none where there is no gap."""
    tabulated: Tabulated | None = None
    """The table that is added where the library is refused."""
    checked: HeldOut | None = None
    """Judgement of `best` on the check runs; None: there are none."""
    apart: Sequence = ()
    """Parameters of `best` to which each operating point alone leads.

    See `apesim.studies.gap.decide.consistency.apart`.
    """
    simulations: int = 0

    @property
    def noise(self):
        """Noise of each sensor, at each sampling interval."""
        return self.base.problem.noise

    @property
    def best(self):
        """The table that was added, else what explains best; the calibrated machine where nothing does."""
        if self.tabulated:
            return self.tabulated.model
        return self.verdict.best.model if self.verdict.best else self.base


def explain(machine, measured, without=(), work=None, tolerance=TOLERANCE):
    """Find what is missing between a machine and measured data.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
    without : sequence of str
        Effects of the library that are not to be considered.
    work : apesim.studies.gap.work.Work, optional
        Who shares it, and who is told of it; what is found does not depend on it.
    tolerance : float
        Size of a gap, over the noise, that does not matter.

    Returns
    -------
    Findings

    Raises
    ------
    InputError
        See `apesim.studies.gap.input_checks.gate`.
    """
    work = work or Work()
    warnings = gate(measured)
    work.tell("calibrating", 0, 1)
    base, more = calibrate(machine, measured)
    warnings += more
    candidates = candidates_of(machine, measured.bench, effects_on(measured.bench, without))
    base, columns = scored(base, candidates, work)
    problem = base.problem
    marks = problem.marks(np.zeros(len(base.fitted.x)))
    look = looked_at(base, columns, marks)
    deeper = elsewhere(base, work) if look.detection.alarm else base
    if deeper is not base:
        look = looked_at(*scored(deeper, candidates, work), marks)
    base = look.base
    if not base.fitted.converged:
        warnings.append("the calibration did not converge")
    own = own_error(problem, base.fitted.x)
    if own > OWN_ERROR:
        warnings.append(f"the simulator's own error is {own:.2g} of the noise: it may be taken for a gap")
    findings = Findings(
        measured=measured,
        base=base,
        columns=look.columns,
        scores=look.scores,
        detection=look.detection,
        own_error=own,
        tolerance=tolerance,
        cells=localise(problem, marks, base.fitted.left, True),
        verdict=without_alarm(base, look.detection.p_value),
        warnings=warnings,
    )
    if look.detection.alarm:
        findings = profiled(searched(findings, look, len(candidates), work), work)
    return verified(findings, work)


def searched(findings, look, library_size, work):
    """The findings with what explains the gap best, judged by runs that it was not fitted to, or a table in its place.

    Parameters
    ----------
    findings : Findings
    look : Look
    library_size : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    Findings
    """
    base, measured, cells, left = findings.base, findings.measured, findings.cells, 1.0
    tried = explanations(look, library_size, work)
    choices, judged = hold_out(base, tried, measured, findings.noise, work)
    if choices and choices[0].cost < base.cost:
        cells = localise(base.problem, look.marks, explained(base, choices[0]), False)
        left = left_by(choices[0].model, look).p_value
    size = max(cell.size for cell in cells)
    verdict = with_alarm(base, choices, size, judged, left, findings.tolerance)
    tables = Tables(base, balances(base, effects_on(measured.bench), work), work)
    if verdict.verdict in BLAMING and judged:
        better = likelier(tables, verdict.best.model, library_size)
        if better:
            reason = f"an unknown {better.balance} without a name takes more of the gap"
            verdict = verdict._replace(verdict=REFUSED, reason=reason)
    tabulated = tabulate(tables, measured, findings.noise) if verdict.verdict == REFUSED else None
    if tabulated:
        cells = localise(base.problem, look.marks, explained(base, tabulated), False)
    return findings._replace(
        tried=tried,
        choices=choices,
        judged=judged,
        cells=cells,
        size=size,
        verdict=verdict,
        balances=tables.ranked,
        tabulated=tabulated,
    )


def profiled(findings, work):
    """The findings with intervals by profile likelihood for what is blamed, where the curvature does not tell them."""
    verdict = findings.verdict
    if verdict.verdict not in BLAMING or not is_shaped(verdict.best.model):
        return findings
    before, warnings = verdict.best, findings.warnings
    model, simulations = with_profiles(before.model, work)
    findings.base.problem.simulations += simulations
    if model.profiles is None:
        warnings = [*warnings, f"no interval is given of {' and '.join(model.names)}: its fit has too many minima"]
    best = Choice(model, before.cost + model.cost - before.model.cost)
    return findings._replace(verdict=verdict._replace(best=best), warnings=warnings)


def verified(findings, work):
    """The findings with what is added, or the calibrated machine, held against the check runs: opened once, here."""
    best, runs, warnings = findings.best, findings.measured.of(CHECK), [*findings.warnings]
    if best is not findings.base and not best.fitted.converged:
        warnings.append("the fit of what is told did not converge")
    warnings += [f"{key} is fitted beyond its range, and written as the end of it" for key in best.beyond]
    found, ambient = apart(best), best.problem.machine.ambient.pressure
    warnings += [
        f"{one.parameter.key}: {label_of(one.run, ambient)} alone says another value than all runs together, "
        f"by {abs(one.deviations):.1f} deviations"
        for one in too_far(found, len(points_of(best.problem.runs)))
    ]
    findings = findings._replace(apart=found, warnings=warnings)
    if not runs:
        checked = None
    elif findings.tabulated:
        checked = findings.tabulated.judged
    elif best is findings.base:
        checked = compared([(left, left) for left in all_left_over(best, [best], runs, findings.noise, work)])
    else:
        checked = held_out(findings.base, best, runs, findings.noise, work)
    return findings._replace(checked=checked, simulations=findings.base.problem.simulations)


def scored(base, candidates, work):
    """The bank of the candidates; where what nothing explains tells more of the noise, with the noise found so.

    Returns
    -------
    base : Model
    columns : list of Column
    """
    problem, x = base.problem, base.fitted.x
    columns = bank(problem, base.fitted, candidates, work)
    known = is_known(problem.noise)
    if known and not may_hum(problem.noise):
        return base, columns
    space = imitated(np.column_stack([base.fitted.jacobian, *(column.effect for column in columns)]))
    pairs = zip(problem.parted(space.removed(base.fitted.errors)), problem.blocks, strict=True)
    left = [-part * noise_for(problem.noise, block).deviation for part, block in pairs]
    if not known:
        from_what_nothing_explains(problem.blocks, problem.noise, left, problem.parted(space.base))
    elif not hum_of_what_nothing_explains(problem.blocks, problem.noise, problem.predicted(x), left):
        return base, columns
    base = Model((), problem, descend(problem, x))
    return base, bank(problem, base.fitted, candidates, work)


def looked_at(base, columns, marks):
    """What the first key looks at.

    Parameters
    ----------
    base : Model
    columns : list of Column
    marks : list of dict
        Of each run.

    Returns
    -------
    Look
    """
    errors, local = base.fitted.errors, local_shapes(base.problem, marks, imitated(base.fitted.jacobian))
    detection = detect(columns, local, errors, parts_of(base.problem))
    return Look(base, columns, marks, scores(columns, errors), local, detection)


def explanations(look, library_size, work):
    """All models that may explain the gap, penalised, the best first.

    Parameters
    ----------
    look : Look
    library_size : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
    """
    base, ranked = look.base, look.scores
    found = singles(base, ranked, library_size, work) + released(base, library_size, work)
    if doubtful(found, look):
        found += remaining(base, ranked, found, library_size, work)
        if doubtful(found, look):
            alone = with_effects(found)
            couples = pairs(base, look.columns, ranked, alone, library_size, work)
            found += couples
            if couples and couples[0].cost < alone[0].cost:
                found += alone_again(base, couples[0], library_size, work)
    best = {}
    for choice in sorted(found, key=lambda choice: choice.cost):
        best.setdefault(frozenset(choice.names), choice)
    return list(best.values())


def doubtful(found, look):
    """Whether the best model is implausible, or the best with an effect leaves more than noise may well."""
    alone = with_effects(found)
    if not alone:
        return False
    best = min(found, key=lambda choice: choice.cost)
    return bool(implausible(best.model)) or left_by(alone[0].model, look).p_value < DOUBTFUL


def with_effects(found):
    """Choices that add effects, the best first."""
    return sorted((choice for choice in found if choice.model.candidates), key=lambda choice: choice.cost)


def left_by(model, look):
    """What a model leaves, against what noise alone would leave.

    Returns
    -------
    apesim.studies.gap.search.gap_test.Detection
    """
    again, local = beside(look.columns, model), look.local
    wider = imitated(model.fitted.jacobian).removed(np.vstack([local, np.zeros((model.added, local.shape[1]))]))
    return detect(again, wider, model.fitted.errors, parts_of(model.problem))


def hold_out(base, choices, measured, noise, work):
    """Judge the best explanation by the gate runs, or by operating points left out one at a time.

    Where there are gate runs, what each explanation leaves of them counts beside its cost.

    Returns
    -------
    choices : list of Choice
        The best first.
    judged : apesim.studies.gap.decide.held_out.HeldOut or None
        None: there is nothing to hold out.
    """
    runs = measured.of(GATE)
    if not choices or choices[0].cost >= base.cost:
        return choices, None
    if runs:
        single = next((choice for choice in choices if len(choice.names) == 1), None)
        near = [c for c in choices if c is single or c.cost - choices[0].cost < 4.0 * AMBIGUOUS]
        before, *after = all_left_over(base, [base, *(c.model for c in near)], runs, noise, work)
        left = {c.names: own for c, own in zip(near, after, strict=True)}
        near = [Choice(c.model, c.cost + left[c.names].misfit - before.misfit) for c in near]
        choices = sorted(near, key=lambda choice: choice.cost)
        return choices, compared([(before, left[choices[0].names])])
    return choices, leave_one_out(base, choices[0].model, work)
