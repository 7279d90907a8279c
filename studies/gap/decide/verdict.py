"""The verdict: what is missing, if anything, and how sure that is.

There is a gap only if two conditions hold: noise alone leaves as much with a chance below `ALARM`, and the gap is at
least as large as the tolerance where it is largest. Where one of them fails, the verdict is CALIBRATION if the fit of
the calibrated machine pulls a nuisance beyond `MAX_PULL` prior standard deviations, and else NO_GAP: a nuisance that
far off may have taken up a gap.

Where both hold, a name has to be worth its penalty, has to be distinguishable from every other explanation, and has to
close the gap on runs that it was not fitted to. What fails in this is refused or ambiguous.
"""

from collections.abc import Sequence
from math import log
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.gap.decide.held_out import HeldOut
from apesim.studies.gap.decide.inclusion import find_inclusions, find_log_odds
from apesim.studies.gap.decide.odd_files import OddChannel, list_odd_files
from apesim.studies.gap.reasons import Reason, ReasonKind, Verdict
from apesim.studies.gap.search.model_selection import Choice
from apesim.studies.gap.search.plausibility import find_implausible
from apesim.studies.gap.search.run_faults import find_files
from apesim.studies.gap.search.score_test import find_cosine
from apesim.studies.gap.thresholds import (
    ALARM,
    ALIKE,
    AMBIGUOUS_COST,
    MAX_LEFT,
    MIN_LOG_ODDS,
    MIN_REMOVED,
    MIN_TWIN_ODDS,
    TOLERANCE,
)


class Decision(NamedTuple):
    """A verdict, with the explanation that it names and the reason for it."""

    verdict: Verdict
    best: Choice | None
    """The explanation that is named, or that comes nearest; None where there is no gap, or where no explanation is
    worth its penalty."""
    rivals: tuple[Choice, ...]
    """Explanations that these data do not distinguish from `best`, the one of least penalised cost first, without
    `best` itself."""
    reason: Reason


def find_explained_gap(base: Model, model: Model) -> np.ndarray:
    """Find the part of the gap that a model takes away: residuals of the calibrated machine less those of the model.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    model : apesim.studies.estimation.model.Model
        The machine with what was added.

    Returns
    -------
    (n,) float array
        Whitened, without the pulls of the priors [standard deviations].

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> gap = find_explained_gap(explanation.calibrated, explanation.best)
    >>> round(float(np.sqrt(gap @ gap)))
    9
    """
    return base.fitted.data_residuals - model.fitted.data_residuals


def decide_without_alarm(base: Model, p_value: float) -> Decision:
    """The verdict where noise alone explains what the calibrated machine leaves: NO_GAP or CALIBRATION.

    CALIBRATION comes first: it is given where a nuisance is pulled beyond `MAX_PULL` prior standard deviations.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    p_value : float
        Chance of noise alone to give as large a score, `ALARM` or more.

    Returns
    -------
    Decision

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> decision = decide_without_alarm(explain_example().best, p_value=0.4)
    >>> str(decision.verdict), str(decision.reason)
    ('NO_GAP', 'noise alone leaves as much with a chance of 0.4')
    """
    if base.pulled:
        return _blame_calibration(base)
    return Decision(Verdict.NO_GAP, None, (), ReasonKind.NOISE_ALONE.with_facts(chance=p_value))


def _blame_calibration(base: Model) -> Decision:
    """The verdict CALIBRATION, for the nuisances that the fit pulls far from their priors.

    It is given where what is left is noise, or is too small to matter, but only because a nuisance went beyond
    `MAX_PULL` prior standard deviations.
    """
    number = base.pulled[0]
    key, x = base.residuals.parameters[number].key, base.fitted.x[number]
    reason = ReasonKind.FAR_NUISANCE.with_facts(key=key, x=x)
    return Decision(Verdict.CALIBRATION, Choice(base, 0.0), (), reason)


def _find_best_and_rivals(choices: list[Choice]) -> tuple[Choice, tuple[Choice, ...]]:
    """Find the best choice, and its rivals: the choices that the data do not distinguish from it.

    A rival is within `AMBIGUOUS_COST` of the least penalised cost. A model that contains the best one and more is none.

    Parameters
    ----------
    choices : list of apesim.studies.gap.search.model_selection.Choice
        At least one, the least penalised cost first.

    Returns
    -------
    best : apesim.studies.gap.search.model_selection.Choice
    rivals : tuple of apesim.studies.gap.search.model_selection.Choice
        The least penalised cost first; empty where the best choice is distinguishable from all others.
    """
    best, *others = choices
    near = (choice for choice in others if choice.cost - best.cost < AMBIGUOUS_COST)
    return best, tuple(choice for choice in near if not set(best.names) <= set(choice.names))


def decide_with_alarm(
    base: Model,
    choices: list[Choice],
    size: float,
    judged: HeldOut | None,
    p_value: float = 1.0,
    tolerance: float = TOLERANCE,
    odd: Sequence[OddChannel] = (),
    odd_before: Sequence[OddChannel] = (),
) -> Decision:
    """The verdict where noise alone does not explain what the calibrated machine leaves.

    The first rule that applies decides:

    1. The gap is smaller than the tolerance: CALIBRATION where a nuisance is pulled beyond `MAX_PULL` prior standard
       deviations, else NO_GAP. The gap of all runs together does not matter where the best choice has a fault of a file
       that was odd by itself.
    2. No choice has a penalised cost below the cost of the calibrated machine: REFUSED.
    3. The best choice has a fault of a file: MEASUREMENT where each rival has a fault of the same file, the best choice
       leaves no more than noise, and nothing of the file is odd any more; else AMBIGUOUS or REFUSED.
    4. No runs can be held out: AMBIGUOUS.
    5. The best choice fails on the runs held out (see `find_refusal`), needs implausible numbers, leaves more than
       noise (a chance below `ALARM`), or is less than `AMBIGUOUS_COST` better than the calibrated machine: REFUSED.
    6. The best choice is one effect: NAMED without rivals, NAMED_CLASS where all rivals are effects and explain the
       same part of the gap (a cosine above `ALIKE`), else AMBIGUOUS. Where nuisances are pulled far beside it, the
       effect has to be sure over all models, see `find_doubt`.
    7. The best choice is a pair of effects: TWO_EFFECTS where its rivals share an effect with it and explain the same
       part of the gap, and where each of its effects is sure over all models, see `find_doubt`; else AMBIGUOUS. A set
       of three is SEVERAL by the same rules; its rivals share two effects with it.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    choices : list of apesim.studies.gap.search.model_selection.Choice
        Single effects, faults of files, and sets of them, the least penalised cost first.
    size : float
        Root mean square of the gap over the noise, in the signal and phase where it is largest.
    judged : apesim.studies.gap.decide.held_out.HeldOut or None
        The best choice on runs that it was not fitted to; None: there are none.
    p_value : float
        Chance of noise alone to leave as much as the best choice does.
    tolerance : float
        Size of a gap, over the noise, that does not matter.
    odd : sequence of apesim.studies.gap.decide.odd_files.OddChannel
        Channels of single files that the best choice still leaves odd.
    odd_before : sequence of apesim.studies.gap.decide.odd_files.OddChannel
        Channels of single files that the calibrated machine leaves odd.

    Returns
    -------
    Decision

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> fits, judged = explanation.ranked, explanation.judged
    >>> str(decide_with_alarm(explanation.calibrated, fits, size=0.5, judged=judged).verdict)
    'NAMED'
    >>> str(decide_with_alarm(explanation.calibrated, fits, size=0.5, judged=judged, tolerance=1.0).verdict)
    'CALIBRATION'
    """
    blamed = find_files(choices[0].model.candidates) if choices else []
    if size < tolerance and not set(blamed) & set(list_odd_files(odd_before)):
        if base.pulled:
            return _blame_calibration(base)
        return Decision(Verdict.NO_GAP, None, (), ReasonKind.TOO_SMALL.with_facts(size=size))
    if not choices or choices[0].cost >= base.cost:
        return Decision(Verdict.REFUSED, None, (), ReasonKind.NOTHING_EARNS_ITS_PLACE.with_facts())
    best, rivals = _find_best_and_rivals(choices)
    files = find_files(best.model.candidates)
    if files:
        return _blame_files(base, best, rivals, odd, p_value)
    if judged is None:
        return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.NOTHING_HELD_OUT.with_facts())
    refused = find_refusal(judged, tolerance) or find_implausible(best.model)
    if not refused and p_value < ALARM:
        refused = ReasonKind.MORE_THAN_NOISE_LEFT.with_facts()
    if not refused and best.cost > base.cost - AMBIGUOUS_COST:
        refused = ReasonKind.FAINT.with_facts()
    if refused:
        return Decision(Verdict.REFUSED, best, rivals, refused)
    explained = find_explained_gap(base, best.model)
    alike = all(find_cosine(explained, find_explained_gap(base, choice.model)) > ALIKE for choice in rivals)
    if any(find_files(choice.model.candidates) for choice in rivals):
        return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.FILE_OR_EFFECT.with_facts())
    effects = set(best.names)
    doubt = find_doubt(base, best, choices) if len(effects) > 1 or best.model.pulled else None
    if len(effects) == 1:
        if rivals and not alike:
            return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.SEVERAL_SINGLES.with_facts())
        if doubt is ReasonKind.EFFECT_IS_FAINT:
            others = [choice for choice in choices if not effects & set(choice.names)]
            rivals = (*others[:1], *(choice for choice in rivals if choice not in others[:1]))
            return Decision(Verdict.AMBIGUOUS, best, rivals, doubt.with_facts())
        if rivals:
            return Decision(Verdict.NAMED_CLASS, best, rivals, ReasonKind.ONE_OF_A_CLASS.with_facts())
        return Decision(Verdict.NAMED, best, (), ReasonKind.DISTINGUISHABLE.with_facts())
    shared = len(effects) - 1
    if rivals and not (alike and all(len(effects & set(choice.names)) >= shared for choice in rivals)):
        return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.SEVERAL_PAIRS.with_facts())
    if doubt:
        smaller = [choice for choice in choices if len(choice.names) == shared]
        rivals = (*smaller[:1], *(choice for choice in rivals if choice not in smaller[:1]))
        return Decision(Verdict.AMBIGUOUS, best, rivals, doubt.with_facts())
    verdict = Verdict.TWO_EFFECTS if shared == 1 else Verdict.SEVERAL
    return Decision(verdict, best, rivals, ReasonKind.DISTINGUISHABLE.with_facts())


def _blame_files(
    base: Model, best: Choice, rivals: tuple[Choice, ...], odd: Sequence[OddChannel], p_value: float
) -> Decision:
    """The verdict where a fault of a file is in what explains best.

    No other run tells anything of such a fault, so all that is known has to speak for it: were it physics outside the
    library that shows most in one run, something would be left.
    """
    files = find_files(best.model.candidates)
    if best.cost > base.cost - AMBIGUOUS_COST:
        return Decision(Verdict.REFUSED, best, rivals, ReasonKind.FAINT.with_facts())
    if not all(set(files) & set(find_files(choice.model.candidates)) for choice in rivals):
        return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.FILE_OR_EFFECT.with_facts())
    named = " and ".join(files)
    if p_value < ALARM or set(files) & set(list_odd_files(odd)):
        return Decision(Verdict.REFUSED, best, rivals, ReasonKind.FILE_NOT_EXPLAINED.with_facts(file=named))
    return Decision(Verdict.MEASUREMENT, best, rivals, ReasonKind.ODD_FILE.with_facts(file=named))


def find_doubt(base: Model, best: Choice, choices: Sequence[Choice]) -> ReasonKind | None:
    """The reason for which a set of effects is not named: one of them is not sure enough over all models.

    With its twins each effect has to have log odds of `MIN_LOG_ODDS` (see
    `apesim.studies.gap.decide.inclusion.find_inclusions`), and without them odds of `MIN_TWIN_ODDS`.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    best : apesim.studies.gap.search.model_selection.Choice
        A set of effects.
    choices : sequence of apesim.studies.gap.search.model_selection.Choice
        All that were fitted, the least penalised cost first.

    Returns
    -------
    apesim.studies.gap.reasons.ReasonKind or None
        None: there is no doubt.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> pair = next(choice for choice in explanation.fits if len(choice.names) == 2)
    >>> choices = [pair._replace(cost=0.0), Choice(explanation.best, 10.0)]
    >>> find_doubt(explanation.calibrated, choices[0], choices).name
    'SECOND_IS_FAINT'
    """
    effects = set(best.names)
    for each in find_inclusions(base, choices):
        if not set(each.names) & effects:
            continue
        if each.log_odds < MIN_LOG_ODDS:
            return ReasonKind.SECOND_IS_FAINT if len(effects) > 1 else ReasonKind.EFFECT_IS_FAINT
        if len(each.names) > 1 and find_log_odds(base, choices, each.names[:1]) < log(MIN_TWIN_ODDS):
            return ReasonKind.SEVERAL_PAIRS
    return None


def find_refusal(judged: HeldOut, tolerance: float = TOLERANCE) -> Reason | None:
    """The reason for which the best explanation is refused on runs that it was not fitted to.

    It is refused where it removes nothing there, where it removes less than the share `MIN_REMOVED` of the gap's
    energy, or where the gap that is left is larger than the tolerance and than `MAX_LEFT` of the gap before.

    Parameters
    ----------
    judged : apesim.studies.gap.decide.held_out.HeldOut
    tolerance : float
        Size of a gap, over the noise, that does not matter.

    Returns
    -------
    apesim.studies.gap.reasons.Reason or None
        None: it is not refused.

    Examples
    --------
    >>> from apesim.studies.gap.decide.held_out import HeldOut
        >>> judged = HeldOut(100, 3.0, 1.2, removed_energy=800.0, remaining_energy=50.0, remaining_sigma=10.0)
    >>> str(find_refusal(judged))
    'on runs that it was not fitted to, a gap of 0.58 of the noise is left'
    >>> find_refusal(judged._replace(remaining_energy=10.0)) is None
    True
    """
    if judged.removed_energy <= 0.0:
        return ReasonKind.REMOVES_NOTHING.with_facts()
    if judged.removed_share < MIN_REMOVED:
        return ReasonKind.GAP_STILL_THERE.with_facts(percent=100.0 * (1.0 - judged.removed_share))
    if judged.size_after > max(tolerance, MAX_LEFT * judged.size_before):
        return ReasonKind.GAP_LEFT.with_facts(size=judged.size_after)
    return None
