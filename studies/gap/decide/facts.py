"""The facts that a verdict rests on, and what follows from them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import log

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.gap.decide.held_out import HeldOut
from apesim.studies.gap.decide.inclusion import find_inclusions, find_log_odds
from apesim.studies.gap.decide.odd_files import OddChannel, list_odd_files
from apesim.studies.gap.reasons import Reason, ReasonKind
from apesim.studies.gap.search.model_selection import Foreseen, PricedModel
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


@dataclass(frozen=True, eq=False, repr=False)
class Facts:
    """The facts that a verdict rests on; what is left out speaks against nothing.

    Those from `likelier_table` on take simulations, and are sought only where the verdict that the others give depends
    on them, see `apesim.studies.gap.workflow`.
    """

    base: Model
    """The calibrated machine."""
    noise_chance: float
    """Chance of noise alone to give as large a score as the calibrated machine leaves."""
    tolerance: float = TOLERANCE
    """Size of a gap, over the noise, that does not matter."""
    choices: tuple[PricedModel, ...] | None = None
    """Single effects, faults of files, and sets of them, the least penalised cost first; None: nothing was searched
    for, as noise alone explains what the calibrated machine leaves, in every channel of every file."""
    foreseen: tuple[Foreseen, ...] = ()
    """Sets that were not fitted, as a linear model foresees them."""
    size: float = 0.0
    """Root mean square of the gap over the noise, in the signal and phase where it is largest."""
    judged: HeldOut | None = None
    """The best choice on runs that it was not fitted to; None: there are none."""
    left_chance: float = 1.0
    """Chance of noise alone to leave as much as the best choice does."""
    odd_before: tuple[OddChannel, ...] = ()
    """Channels of single files that the calibrated machine leaves odd."""
    odd_after: tuple[OddChannel, ...] = ()
    """Channels of single files that the best choice still leaves odd."""
    likelier_table: str | None = None
    """Balance of a table without a name that makes the data more probable than what is blamed."""
    odd_unexplained: tuple[OddChannel, ...] = ()
    """Channels of single files, gates among them, that are odd though nothing is said to be missing."""
    judged_calibration: HeldOut | None = None
    """The calibrated machine, with a number pulled far, on runs that it was not fitted to."""
    odd_repeats: tuple[str, ...] = ()
    """Files that differ from their repeats by more than the scatter of the others explains."""
    is_rest_refused: bool = False
    """Whether nothing explains the other files, where the record of one is blamed."""

    @cached_property
    def best(self) -> PricedModel:
        """The choice of least penalised cost; there has to be one."""
        assert self.choices
        return self.choices[0]

    @cached_property
    def rivals(self) -> tuple[PricedModel, ...]:
        """Choices that the data do not distinguish from the best one, the least penalised cost first.

        A rival is within `AMBIGUOUS_COST` of the best. A model that contains the best one and more is none.
        """
        others = self.choices[1:] if self.choices else ()
        near = (choice for choice in others if choice.cost - self.best.cost < AMBIGUOUS_COST)
        return tuple(choice for choice in near if not self.effects <= set(choice.names))

    @cached_property
    def effects(self) -> frozenset[str]:
        """Names of what the best choice adds."""
        return frozenset(self.best.names)

    @cached_property
    def files(self) -> list[str]:
        """Files that the best choice has a fault of."""
        return find_files(self.best.model.candidates) if self.choices else []

    @cached_property
    def is_clear(self) -> bool:
        """Whether nothing has to be missing: noise alone leaves as much, or the gap is too small to matter.

        The gap of all runs together tells nothing where the best choice has a fault of a file that was odd by itself.
        """
        is_of_odd_file = bool(set(self.files) & set(list_odd_files(self.odd_before)))
        return self.choices is None or (self.size < self.tolerance and not is_of_odd_file)

    @cached_property
    def is_far_refuted(self) -> bool:
        """Whether a gap is left on runs held out though the calibration has pulled a number far."""
        judged = self.judged_calibration if self.base.pulled else None
        return judged is not None and _is_gap_left(judged, self.tolerance)

    @cached_property
    def has_no_gain(self) -> bool:
        """Whether no choice has a penalised cost below the cost of the calibrated machine."""
        return not self.choices or self.best.cost >= self.base.cost

    @cached_property
    def is_faint(self) -> bool:
        """Whether the best choice is less than `AMBIGUOUS_COST` better than the calibrated machine."""
        return self.best.cost > self.base.cost - AMBIGUOUS_COST

    @cached_property
    def is_more_left(self) -> bool:
        """Whether the best choice leaves more than noise."""
        return self.left_chance < ALARM

    @cached_property
    def is_file_odd(self) -> bool:
        """Whether a fault of a file does not explain it: more than noise is left, or the file is odd all the same."""
        return self.is_more_left or bool(set(self.files) & set(list_odd_files(self.odd_after)))

    @cached_property
    def is_file_or_other(self) -> bool:
        """Whether the best choice and a rival blame a file and an effect, or two files."""
        blamed = [set(find_files(choice.model.candidates)) for choice in self.rivals]
        return not all(set(self.files) & each for each in blamed) if self.files else any(blamed)

    @cached_property
    def refusal(self) -> Reason | None:
        """The reason for which the best choice fails on the runs held out, or by its own numbers."""
        refused = find_refusal(self.judged, self.tolerance) if self.judged else None
        return refused or find_implausible(self.best.model)

    @cached_property
    def is_held(self) -> bool:
        """Whether the best choice holds on runs held out, with plausible numbers, and leaves noise alone."""
        return self.judged is not None and not self.refusal and not self.is_more_left

    @cached_property
    def is_single(self) -> bool:
        """Whether the best choice is one effect."""
        return len(self.effects) == 1

    @cached_property
    def missing(self) -> int:
        """Number of effects of the best choice; numbers of the machine file that are wrong are none."""
        return sum(not candidate.is_file_number for candidate in self.best.model.candidates)

    @cached_property
    def is_tied(self) -> bool:
        """Whether a rival is another explanation: it takes another part of the gap, or differs by two effects."""
        explained = find_explained_gap(self.base, self.best.model)
        parts = [find_explained_gap(self.base, choice.model) for choice in self.rivals]
        shared = [len(self.effects & set(choice.names)) for choice in self.rivals]
        is_alike = all(find_cosine(explained, part) > ALIKE for part in parts)
        return not (is_alike and all(number >= len(self.effects) - 1 for number in shared))

    @cached_property
    def doubt(self) -> ReasonKind | None:
        """The reason for which an effect is not sure enough; of one alone that is asked beside far numbers only."""
        is_asked = not self.is_single or self.best.model.pulled
        return find_doubt(self.base, self.best, self.choices or (), self.foreseen) if is_asked else None

    @cached_property
    def is_single_faint(self) -> bool:
        """Whether one effect hardly earns its place beside far nuisances; its twins alone make it no less sure."""
        return self.is_single and self.doubt is ReasonKind.EFFECT_IS_FAINT


def find_explained_gap(base: Model, model: Model) -> np.ndarray:
    """The part of the gap that a model takes away, whitened, (n,): the calibrated residuals less its own."""
    return base.fitted.data_residuals - model.fitted.data_residuals


def find_doubt(
    base: Model, best: PricedModel, choices: Sequence[PricedModel], foreseen: Sequence[Foreseen] = ()
) -> ReasonKind | None:
    """The reason for which effects are not named: one is not sure enough over all models; None where each is.

    With its twins each effect of `best` has to have log odds of `MIN_LOG_ODDS` (see
    `apesim.studies.gap.decide.inclusion.find_inclusions`), and without them odds of `MIN_TWIN_ODDS`.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> pair = next(choice for choice in explanation.fits if len(choice.names) == 2)
    >>> choices = [pair._replace(cost=0.0), PricedModel(explanation.best, 10.0)]
    >>> find_doubt(explanation.calibrated, choices[0], choices).name
    'ONE_IS_FAINT'
    """
    effects = set(best.names)
    for each in find_inclusions(base, choices, foreseen):
        if not set(each.names) & effects:
            continue
        if each.log_odds < MIN_LOG_ODDS:
            return ReasonKind.ONE_IS_FAINT if len(effects) > 1 else ReasonKind.EFFECT_IS_FAINT
        if len(each.names) > 1 and find_log_odds(base, choices, each.names[:1], foreseen) < log(MIN_TWIN_ODDS):
            return ReasonKind.SEVERAL_SETS
    return None


def find_refusal(judged: HeldOut, tolerance: float = TOLERANCE) -> Reason | None:
    """The reason for which an explanation is refused on runs that it was not fitted to; None where it is not.

    It is refused where it removes nothing there, where it removes less than the share `MIN_REMOVED` of the gap's
    energy, or where the gap that is left is larger than the tolerance, over the noise, and than `MAX_LEFT` of the gap
    before.

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
    if _is_gap_left(judged, tolerance):
        return ReasonKind.GAP_LEFT.with_facts(size=judged.size_after)
    return None


def _is_gap_left(judged: HeldOut, tolerance: float) -> bool:
    """Whether the gap on runs held out is larger than the tolerance, and than `MAX_LEFT` of the gap before."""
    return judged.size_after > max(tolerance, MAX_LEFT * judged.size_before)
