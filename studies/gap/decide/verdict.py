"""The verdict: what is missing, if anything, and how sure that is.

Two keys open a case: the chance of noise alone, and the size of the gap against the noise. What is named has to earn
its penalty, has to be told from every other explanation, and has to close the gap on runs that it was not fitted to.
"""

from math import exp
from typing import NamedTuple

from apesim.studies.gap.reasons import Reason, ReasonKind, Verdict
from apesim.studies.gap.search.candidates import TWINS
from apesim.studies.gap.search.model_selection import Choice
from apesim.studies.gap.search.plausibility import implausible, pulled
from apesim.studies.gap.search.refit import release
from apesim.studies.gap.search.score_test import cosine
from apesim.studies.gap.thresholds import (
    ALARM,
    ALIKE,
    AMBIGUOUS_COST,
    BEHIND,
    MAX_LEFT,
    MAX_OUTSIDE,
    MIN_OUTSIDE,
    MIN_REMOVED,
    MIN_STANDING,
    OUTSIDE_FAINT,
    TOLERANCE,
)


class Decision(NamedTuple):
    """A verdict, and what it rests on."""

    verdict: Verdict
    best: Choice | None
    """Choice that is named or comes nearest; None where there is no gap."""
    rivals: tuple[Choice, ...]
    """Choices that these data do not tell from it, the best first, without it."""
    reason: Reason


def explained(base, choice):
    """What a model takes away of what the calibrated machine leaves [standard deviations], shape (n,)."""
    return base.fitted.left - choice.model.fitted.left


def without_alarm(base, p_value):
    """The verdict where noise alone explains what is left."""
    if pulled(base):
        return far_off(base)
    return Decision(Verdict.NO_GAP, None, (), ReasonKind.NOISE_ALONE.with_facts(chance=p_value))


def far_off(base):
    """The verdict where a nuisance, pulled beyond `MAX_PULL`, takes all of the gap that matters."""
    number = pulled(base)[0]
    key, x = base.problem.parameters[number].key, base.fitted.x[number]
    reason = ReasonKind.FAR_NUISANCE.with_facts(key=key, x=x)
    return Decision(Verdict.CALIBRATION, Choice(release(base, number), 0.0), (), reason)


def ambiguous(choices):
    """The best choice, and those that are not told from it: no larger model that contains it.

    A number that is far from its prior, and the effect that says the same, are one choice: the effect.
    """
    near = [choice for choice in choices if choice.cost - choices[0].cost < AMBIGUOUS_COST]
    twins = [choice for choice in near if choice.names == (TWINS.get(near[0].model.released),)]
    best = (twins or near)[0]
    return best, tuple(
        choice
        for choice in near
        if choice is not best
        and not set(best.names) < set(choice.names)
        and TWINS.get(choice.model.released) not in best.names
    )


def with_alarm(base, choices, size, judged, left=1.0, tolerance=TOLERANCE):
    """The verdict where noise alone does not explain what is left.

    Parameters
    ----------
    base : Model
        The calibrated machine.
    choices : list of Choice
        Singles, pairs and released priors, the least penalised cost first.
    size : float
        Of the gap where it is largest, over the noise.
    judged : apesim.studies.gap.decide.held_out.HeldOut or None
        The best choice on runs that it was not fitted to; None: there are none.
    left : float
        Chance of noise alone to leave as much as the best choice does.
    tolerance : float
        Size of a gap, over the noise, that does not matter.

    Returns
    -------
    Decision
    """
    if size < tolerance:
        if pulled(base):
            return far_off(base)
        return Decision(Verdict.NO_GAP, None, (), ReasonKind.TOO_SMALL.with_facts(size=size))
    if not choices or choices[0].cost >= base.cost:
        return Decision(Verdict.REFUSED, None, (), ReasonKind.NOTHING_EARNS_ITS_PLACE.with_facts())
    best, rivals = ambiguous(choices)
    if judged is None:
        return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.NOTHING_HELD_OUT.with_facts())
    refused = refusal(judged, tolerance) or implausible(best.model)
    if not refused and left < ALARM:
        refused = ReasonKind.MORE_THAN_NOISE_LEFT.with_facts()
    if not refused and best.cost > base.cost - AMBIGUOUS_COST:
        refused = ReasonKind.FAINT.with_facts()
    if refused:
        return Decision(Verdict.REFUSED, best, rivals, refused)
    if best.model.released:
        verdict = Verdict.CALIBRATION if not rivals else Verdict.AMBIGUOUS
        return Decision(verdict, best, rivals, ReasonKind.WRONG_NUMBER.with_facts())
    own = explained(base, best)
    alike = all(cosine(own, explained(base, choice)) > ALIKE for choice in rivals)
    if len(best.names) == 1:
        if not rivals:
            return Decision(Verdict.NAMED, best, (), ReasonKind.TOLD.with_facts())
        if alike:
            return Decision(Verdict.NAMED_CLASS, best, rivals, ReasonKind.ONE_OF_A_CLASS.with_facts())
        return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.SEVERAL_SINGLES.with_facts())
    singles = [choice for choice in choices if len(choice.names) == 1]
    if singles[0].cost < best.cost + BEHIND and not contains(base, best, singles):
        rivals = (singles[0], *(choice for choice in rivals if choice is not singles[0]))
        return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.PAIR_WITHOUT_BEST_SINGLE.with_facts())
    if rivals and not (alike and all(set(best.names) & set(choice.names) for choice in rivals)):
        return Decision(Verdict.AMBIGUOUS, best, rivals, ReasonKind.SEVERAL_PAIRS.with_facts())
    if standing(best, rivals, singles) < MIN_STANDING:
        kind = ReasonKind.SEVERAL_PAIRS if rivals else ReasonKind.SECOND_IS_FAINT
        rivals = (singles[0], *(choice for choice in rivals if choice is not singles[0]))
        return Decision(Verdict.AMBIGUOUS, best, rivals, kind.with_facts())
    return Decision(Verdict.TWO_EFFECTS, best, rivals, ReasonKind.TOLD.with_facts())


def standing(pair, rivals, singles):
    """The weight of a pair among its rivals by penalised likelihood, less what is taken off for a faint second effect.

    A measure by which pairs are named or not; it is not calibrated, and no probability.

    Parameters
    ----------
    pair : Choice
    rivals : sequence of Choice
    singles : sequence of Choice
        The best first.

    Returns
    -------
    float
        Below 1.
    """
    weights = [exp(-0.5 * (choice.cost - pair.cost)) for choice in (pair, *rivals)]
    fall = max(singles[0].cost - pair.cost, 1.0)
    return (1.0 - min(MAX_OUTSIDE, MIN_OUTSIDE + OUTSIDE_FAINT / fall)) / sum(weights)


def contains(base, pair, singles):
    """Whether a pair contains the best single effect, or one that these data do not tell from it."""
    own = explained(base, singles[0])
    return any(
        choice.names[0] in pair.names
        and choice.cost - singles[0].cost < AMBIGUOUS_COST
        and cosine(own, explained(base, choice)) > ALIKE
        for choice in singles
    )


def refusal(judged, tolerance=TOLERANCE):
    """Why the best explanation is refused on runs that it was not fitted to; None where it is not."""
    if judged.removed <= 0.0:
        return ReasonKind.REMOVES_NOTHING.with_facts()
    if judged.share < MIN_REMOVED:
        return ReasonKind.GAP_STILL_THERE.with_facts(percent=100.0 * (1.0 - judged.share))
    if judged.size > max(tolerance, MAX_LEFT * judged.size_before):
        return ReasonKind.GAP_LEFT.with_facts(size=judged.size)
    return None
