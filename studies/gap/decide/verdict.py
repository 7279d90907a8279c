"""The verdict: what is missing, if anything, and how sure that is.

One table decides, `TABLE`. It is read from top to bottom, and the first row that applies gives the verdict, its reason
and the explanation that is named. Whatever takes a verdict back stands in a row above it.

There is a gap only if two conditions hold: noise alone leaves as much with a chance below `ALARM`, and the gap is at
least as large as the tolerance where it is largest. Where one of them fails, the verdict is CALIBRATION if the fit of
the calibrated machine pulls a nuisance beyond `MAX_PULL` prior standard deviations, and else NO_GAP: a nuisance that
far off may have taken up a gap. Either is said only where no single channel, no run held out and no repeat contradicts.

Numbers of the machine file that count as exact are tried beside the effects: where they alone explain the gap, nothing
is missing, and the verdict is CALIBRATION, too.

Where both hold, a name has to be worth its penalty, has to be distinguishable from every other explanation, and has to
close the gap on runs that it was not fitted to. What fails in this is refused or ambiguous. Of an ambiguous gap it is
still said what all explanations share, where the data are sure of that.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from apesim.studies.gap.decide.facts import Facts
from apesim.studies.gap.decide.inclusion import find_sure
from apesim.studies.gap.reasons import Reason, ReasonKind, Verdict
from apesim.studies.gap.search.model_selection import PricedModel


class Decision(NamedTuple):
    """A verdict, with the explanation that it names and the reason for it."""

    verdict: Verdict
    best: PricedModel | None
    """The explanation that is named, or that comes nearest; None where there is no gap, or where no explanation is
    worth its penalty."""
    rivals: tuple[PricedModel, ...]
    """Explanations that these data do not distinguish from `best`, the one of least penalised cost first, without
    `best` itself."""
    reason: Reason
    sure: tuple[tuple[str, ...], ...] = ()
    """Effects that are sure though the gap is ambiguous, each with what the data do not distinguish from it."""


Explained = tuple[PricedModel | None, tuple[PricedModel, ...]]
"""Fields `best` and `rivals` of a decision."""


def _name_best(facts: Facts) -> Explained:
    """The best choice, and what the data do not distinguish from it."""
    return facts.best, facts.rivals


def _name_best_and_smaller(facts: Facts) -> Explained:
    """The best choice, and first among its rivals what would do without the effect that is in doubt."""
    if len(facts.effects) == 1:
        without = [choice for choice in facts.choices or () if not facts.effects & set(choice.names)]
    else:
        without = [choice for choice in facts.choices or () if len(choice.names) == len(facts.effects) - 1]
    return facts.best, (*without[:1], *(choice for choice in facts.rivals if choice not in without[:1]))


def _name_calibration(facts: Facts) -> Explained:
    """The calibrated machine where the fit pulls a nuisance far, else nothing."""
    return (PricedModel(facts.base, 0.0) if facts.base.pulled else None), ()


def _name_nothing(facts: Facts) -> Explained:
    """No explanation."""
    return None, ()


def _name_without_table(facts: Facts) -> Explained:
    """What the rows below name: that is what the table is compared with."""
    decision = decide(replace(facts, likelier_table=None))
    return decision.best, decision.rivals


def _tell_table(facts: Facts) -> Reason:
    """The balance of the table that explains more."""
    return ReasonKind.TABLE_TAKES_MORE.with_facts(balance=facts.likelier_table)


def _tell_odd(facts: Facts) -> Reason:
    """The channel that is explained worst."""
    channel = max(facts.odd_unexplained, key=lambda each: each.size)
    return ReasonKind.ODD_CHANNEL.with_facts(sensor=channel.sensor, file=channel.file, rms=channel.rms)


def _tell_left(facts: Facts) -> Reason:
    """The gap that is left on runs held out though a nuisance is pulled far."""
    assert facts.judged_calibration
    return ReasonKind.GAP_LEFT.with_facts(size=facts.judged_calibration.size_after)


def _tell_repeats(facts: Facts) -> Reason:
    """The files that differ from their repeats."""
    return ReasonKind.ODD_REPEAT.with_facts(file=" and ".join(facts.odd_repeats))


def _tell_far(facts: Facts) -> Reason:
    """The nuisance that is pulled farthest."""
    number = facts.base.pulled[0]
    key, x = facts.base.residuals.parameters[number].key, facts.base.fitted.x[number]
    return ReasonKind.FAR_NUISANCE.with_facts(key=key, x=x)


def _tell_noise(facts: Facts) -> Reason:
    """The chance of noise alone."""
    return ReasonKind.NOISE_ALONE.with_facts(chance=facts.noise_chance)


def _tell_size(facts: Facts) -> Reason:
    """The size of the gap."""
    return ReasonKind.TOO_SMALL.with_facts(size=facts.size)


def _of_files(kind: ReasonKind) -> Callable[[Facts], Reason]:
    """A reason that tells the files that the best choice has a fault of."""
    return lambda facts: kind.with_facts(file=" and ".join(facts.files))


def _tell_refusal(facts: Facts) -> Reason:
    """The reason for which the best choice is refused, where it is."""
    assert facts.refusal
    return facts.refusal


def _tell_doubt(facts: Facts) -> Reason:
    """The reason for which an effect is in doubt, where one is."""
    assert facts.doubt
    return facts.doubt.with_facts()


class Row(NamedTuple):
    """A row of the table of verdicts."""

    name: str
    """The case, in words."""
    applies: Callable[[Facts], object]
    """Condition; it may rely on those of all rows above not to hold."""
    verdict: Verdict
    reason: ReasonKind | Callable[[Facts], Reason]
    """Reason, or how its numbers are found."""
    names: Callable[[Facts], Explained] = _name_best
    """Explanation that is named, and its rivals."""


TABLE: tuple[Row, ...] = (
    # Whatever is blamed has to explain more than a table that has no name.
    Row("table explains more", lambda f: f.likelier_table, Verdict.REFUSED, _tell_table, _name_without_table),
    # Nothing is missing: noise alone leaves as much, or the gap is too small to matter. What contradicts comes first.
    Row("odd channel", lambda f: f.is_clear and f.odd_unexplained, Verdict.REFUSED, _tell_odd, _name_calibration),
    Row("nuisance refuted", lambda f: f.is_clear and f.is_far_refuted, Verdict.REFUSED, _tell_left, _name_calibration),
    Row("odd repeat", lambda f: f.is_clear and f.odd_repeats, Verdict.AMBIGUOUS, _tell_repeats, _name_nothing),
    Row("far nuisance", lambda f: f.is_clear and f.base.pulled, Verdict.CALIBRATION, _tell_far, _name_calibration),
    Row("noise alone", lambda f: f.choices is None, Verdict.NO_GAP, _tell_noise, _name_nothing),
    Row("too small", lambda f: f.is_clear, Verdict.NO_GAP, _tell_size, _name_nothing),
    # From here on something is missing.
    Row("no gain", lambda f: f.has_no_gain, Verdict.REFUSED, ReasonKind.NOTHING_EARNS_ITS_PLACE, _name_nothing),
    # A fault of a file explains best. No other run tells anything of it, so all that is known has to speak for it: were
    # it physics outside the library that shows most in one run, something would be left.
    Row("faint file", lambda f: f.files and f.is_faint, Verdict.REFUSED, ReasonKind.FAINT),
    Row("file or other", lambda f: f.files and f.is_file_or_other, Verdict.AMBIGUOUS, ReasonKind.FILE_OR_EFFECT),
    Row("odd file", lambda f: f.files and f.is_file_odd, Verdict.REFUSED, _of_files(ReasonKind.FILE_NOT_EXPLAINED)),
    Row("rest refused", lambda f: f.files and f.is_rest_refused, Verdict.REFUSED, _of_files(ReasonKind.FILE_NOT_ALONE)),
    Row("file", lambda f: f.files, Verdict.MEASUREMENT, _of_files(ReasonKind.ODD_FILE)),
    # Effects explain best: they have to hold on runs held out, with plausible numbers, and to leave noise alone.
    Row("nothing held out", lambda f: f.judged is None, Verdict.AMBIGUOUS, ReasonKind.NOTHING_HELD_OUT),
    Row("fails or implausible", lambda f: f.refusal, Verdict.REFUSED, _tell_refusal),
    Row("more than noise left", lambda f: f.is_more_left, Verdict.REFUSED, ReasonKind.MORE_THAN_NOISE_LEFT),
    Row("faint effects", lambda f: f.is_faint, Verdict.REFUSED, ReasonKind.FAINT),
    Row("effect or file", lambda f: f.is_file_or_other, Verdict.AMBIGUOUS, ReasonKind.FILE_OR_EFFECT),
    # One effect, or one number of the machine file that is wrong: its rivals have to explain the same part of the gap;
    # beside a far nuisance it has to be sure, too.
    Row("several singles", lambda f: f.is_single and f.is_tied, Verdict.AMBIGUOUS, ReasonKind.SEVERAL_SINGLES),
    Row("doubtful effect", lambda f: f.is_single_faint, Verdict.AMBIGUOUS, _tell_doubt, _name_best_and_smaller),
    Row("class", lambda f: f.is_single and f.rivals, Verdict.NAMED_CLASS, ReasonKind.ONE_OF_A_CLASS),
    Row("one number", lambda f: f.is_single and not f.missing, Verdict.CALIBRATION, ReasonKind.DISTINGUISHABLE),
    Row("one effect", lambda f: f.is_single, Verdict.NAMED, ReasonKind.DISTINGUISHABLE),
    # Several effects, or wrong numbers of the machine file beside them: their rivals have to differ by one effect that
    # looks alike, and each has to be sure.
    Row("several sets", lambda f: f.is_tied, Verdict.AMBIGUOUS, ReasonKind.SEVERAL_SETS),
    Row("doubtful set", lambda f: f.doubt, Verdict.AMBIGUOUS, _tell_doubt, _name_best_and_smaller),
    Row("numbers alone", lambda f: not f.missing, Verdict.CALIBRATION, ReasonKind.DISTINGUISHABLE),
    Row("effect and numbers", lambda f: f.missing == 1, Verdict.NAMED, ReasonKind.DISTINGUISHABLE),
    Row("two effects", lambda f: f.missing == 2, Verdict.TWO_EFFECTS, ReasonKind.DISTINGUISHABLE),
    Row("three effects or more", lambda f: True, Verdict.SEVERAL, ReasonKind.DISTINGUISHABLE),
)
"""All verdicts with their conditions: the first row that applies decides."""


def find_row(facts: Facts) -> Row:
    """Find the first row of `TABLE` that applies."""
    return next(row for row in TABLE if row.applies(facts))


def decide(facts: Facts) -> Decision:
    """Decide what is said of the gap: the verdict, the explanation that is named, and the reason.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> found = explain_example()
    >>> decision = decide(Facts(found.best, noise_chance=0.4))
    >>> str(decision.verdict), str(decision.reason)
    ('NO_GAP', 'noise alone leaves as much with a chance of 0.4')
    >>> facts = Facts(found.calibrated, 0.0, choices=tuple(found.ranked), size=0.5, judged=found.judged)
    >>> str(decide(facts).verdict), str(decide(replace(facts, tolerance=1.0)).verdict)
    ('NAMED', 'CALIBRATION')
    """
    row = find_row(facts)
    reason = row.reason.with_facts() if isinstance(row.reason, ReasonKind) else row.reason(facts)
    best, rivals = row.names(facts)
    sure: tuple[tuple[str, ...], ...] = ()
    if row.verdict == Verdict.AMBIGUOUS and best and facts.is_held:
        sure = find_sure(facts.base, facts.choices or (), (best, *rivals), facts.foreseen)
    return Decision(row.verdict, best, rivals, reason, sure)
