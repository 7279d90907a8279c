"""The verdict: what is missing, if anything, and how sure that is.

Two keys open a case: the chance of noise alone, and the size of the gap against the noise. What is named has to earn
its penalty, has to be told from every other explanation, and has to close the gap on runs that it was not fitted to.
"""

from math import exp
from typing import NamedTuple

import numpy as np

from apesim.studies.gap.search.candidates import TWINS
from apesim.studies.gap.search.gap_test import ALARM
from apesim.studies.gap.search.model_selection import AMBIGUOUS, Choice
from apesim.studies.gap.search.refit import release
from apesim.studies.gap.search.score_test import ALIKE, cosine

NO_GAP, NAMED, NAMED_CLASS, TWO_EFFECTS, AMBIGUOUS_VERDICT, CALIBRATION, REFUSED = VERDICTS = (
    "NO_GAP",
    "NAMED",
    "NAMED_CLASS",
    "TWO_EFFECTS",
    "AMBIGUOUS",
    "CALIBRATION",
    "REFUSED",
)
TOLERANCE = 0.15
"""Share of the noise: a gap below it, where it is largest, is none, unless the user says otherwise."""
PULL_MOST = 4.0
"""Prior deviations beyond which a nuisance is itself a finding."""
REMOVED_LEAST = 0.6
"""Share of the gap's energy that a name has to take away where nothing was fitted."""
LEFT_MOST = 0.05
"""Share of the gap's size that may be left, where that is more than the tolerance."""
PAIR_LEAST = 0.8
"""Standing from which both effects of a pair are named, see `standing`."""
BEHIND = 100.0
"""Penalised cost by which the best single effect has to be behind a pair that does not contain it, for the pair to be
named: nearer, something else that neither of them is may look like both."""
BEYOND = 3.0
"""Deviations by which a size has to be beyond its range to be implausible."""
TOLD = "told from every other explanation, and held out"
FAINT = "the best explanation hardly earns its place"
OUTSIDE, OUTSIDE_FAINT, OUTSIDE_MOST = 0.02, 10.0, 0.5
"""Taken off a pair's standing for what the library does not have: at least, by how much more where the second effect is
faint, over the square of its deviations, and at most. A rule, not measured."""


class Verdict(NamedTuple):
    """What is said, and why."""

    verdict: str
    best: object
    """`apesim.studies.gap.search.model_selection.Choice` that is named or comes nearest; None where there is no gap."""
    rivals: tuple
    """Choices that these data do not tell from it, the best first, without it."""
    reason: str


def explained(base, choice):
    """What a model takes away of what the calibrated machine leaves [standard deviations], shape (n,)."""
    return base.fitted.left - choice.model.fitted.left


def pulled(model):
    """Numbers of the nuisances beyond `PULL_MOST`, the farthest first."""
    far = [j for j in np.flatnonzero(model.problem.known) if abs(model.fitted.x[j]) > PULL_MOST]
    return sorted(far, key=lambda j: -abs(model.fitted.x[j]))


def without_alarm(base, p_value):
    """The verdict where noise alone explains what is left."""
    if pulled(base):
        return far_off(base)
    return Verdict(NO_GAP, None, (), f"noise alone leaves as much with a chance of {p_value:.2g}")


def far_off(base):
    """The verdict where a nuisance, pulled beyond `PULL_MOST`, takes all of the gap that matters."""
    number = pulled(base)[0]
    key, x = base.problem.parameters[number].key, base.fitted.x[number]
    reason = f"{key} is {x:+.1f} prior deviations from what the machine says"
    return Verdict(CALIBRATION, Choice(release(base, number), 0.0), (), reason)


def ambiguous(choices):
    """The best choice, and those that are not told from it: no larger model that contains it.

    A number that is far from its prior, and the effect that says the same, are one choice: the effect.
    """
    near = [choice for choice in choices if choice.cost - choices[0].cost < AMBIGUOUS]
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
    Verdict
    """
    if size < tolerance:
        if pulled(base):
            return far_off(base)
        return Verdict(NO_GAP, None, (), f"the gap is {size:.2g} of the noise where it is largest: too small to matter")
    if not choices or choices[0].cost >= base.cost:
        return Verdict(REFUSED, None, (), "no effect of the library earns its place")
    best, rivals = ambiguous(choices)
    if judged is None:
        return Verdict(AMBIGUOUS_VERDICT, best, rivals, "there is one operating point alone: nothing can be held out")
    refused = refusal(judged, tolerance) or implausible(best.model)
    if not refused and left < ALARM:
        refused = "what the best explanation leaves is more than noise"
    if not refused and best.cost > base.cost - AMBIGUOUS:
        refused = FAINT
    if refused:
        return Verdict(REFUSED, best, rivals, refused)
    if best.model.released:
        verdict = CALIBRATION if not rivals else AMBIGUOUS_VERDICT
        return Verdict(verdict, best, rivals, "a number of the machine is wrong, and nothing is missing")
    own = explained(base, best)
    alike = all(cosine(own, explained(base, choice)) > ALIKE for choice in rivals)
    if len(best.names) == 1:
        if not rivals:
            return Verdict(NAMED, best, (), TOLD)
        if alike:
            return Verdict(NAMED_CLASS, best, rivals, "one of a class that these data do not tell apart")
        return Verdict(AMBIGUOUS_VERDICT, best, rivals, "several explanations are as good")
    singles = [choice for choice in choices if len(choice.names) == 1]
    if singles[0].cost < best.cost + BEHIND and not contains(base, best, singles):
        rivals = (singles[0], *(choice for choice in rivals if choice is not singles[0]))
        return Verdict(AMBIGUOUS_VERDICT, best, rivals, "the best pair does not contain the best single effect")
    if rivals and not (alike and all(set(best.names) & set(choice.names) for choice in rivals)):
        return Verdict(AMBIGUOUS_VERDICT, best, rivals, "several pairs are as good")
    if standing(best, rivals, singles) < PAIR_LEAST:
        reason = "several pairs are as good" if rivals else "the second effect hardly earns its place"
        rivals = (singles[0], *(choice for choice in rivals if choice is not singles[0]))
        return Verdict(AMBIGUOUS_VERDICT, best, rivals, reason)
    return Verdict(TWO_EFFECTS, best, rivals, TOLD)


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
    return (1.0 - min(OUTSIDE_MOST, OUTSIDE + OUTSIDE_FAINT / fall)) / sum(weights)


def contains(base, pair, singles):
    """Whether a pair contains the best single effect, or one that these data do not tell from it."""
    own = explained(base, singles[0])
    return any(
        choice.names[0] in pair.names
        and choice.cost - singles[0].cost < AMBIGUOUS
        and cosine(own, explained(base, choice)) > ALIKE
        for choice in singles
    )


def implausible(model):
    """Why a model is refused by its own numbers; "" where it is not."""
    far = [model.problem.parameters[j].key for j in pulled(model)]
    if far:
        return f"the best explanation still needs {far[0]} {PULL_MOST:g} prior deviations away"
    deviations = np.sqrt(np.diag(model.fitted.covariance))
    for parameter, x, deviation in zip(model.problem.parameters, model.fitted.x, deviations, strict=True):
        low, high = parameter.ends
        if parameter.reach > 1.0 and (x - BEYOND * deviation > high or x + BEYOND * deviation < low):
            return f"the best explanation needs {parameter.key} beyond its range"
    return ""


def refusal(judged, tolerance=TOLERANCE):
    """Why the best explanation is refused on runs that it was not fitted to; "" where it is not."""
    if judged.removed <= 0.0:
        return "on runs that it was not fitted to, the best explanation removes nothing"
    if judged.share < REMOVED_LEAST:
        return f"on runs that it was not fitted to, {100.0 * (1.0 - judged.share):.0f} % of the gap is still there"
    if judged.size > max(tolerance, LEFT_MOST * judged.size_before):
        return f"on runs that it was not fitted to, a gap of {judged.size:.2g} of the noise is left"
    return ""
