"""The words of a decision: the verdict, and the reason for it."""

from enum import StrEnum
from typing import Any, NamedTuple


class Verdict(StrEnum):
    """What is said of the gap between a machine and measured data."""

    NO_GAP = "NO_GAP"
    """Nothing is missing that the data could show; `apesim.studies.gap.decide.verdict` decides it."""
    NAMED = "NAMED"
    """One effect is missing."""
    NAMED_CLASS = "NAMED_CLASS"
    """One effect of a class is missing; the data do not distinguish the effects of the class."""
    TWO_EFFECTS = "TWO_EFFECTS"
    """Two effects are missing."""
    AMBIGUOUS = "AMBIGUOUS"
    """Several explanations are left, of a gap or of a file that differs from its repeats."""
    CALIBRATION = "CALIBRATION"
    """A number of the machine or a reading is wrong, and nothing is missing."""
    MEASUREMENT = "MEASUREMENT"
    """The record of one file is wrong; what the other files say is explained without it."""
    SEVERAL = "SEVERAL"
    """Three effects or more are missing."""
    REFUSED = "REFUSED"
    """There is a gap, and no effect of the library closes it."""


NAMING = frozenset(
    {
        Verdict.NAMED,
        Verdict.NAMED_CLASS,
        Verdict.TWO_EFFECTS,
        Verdict.SEVERAL,
        Verdict.CALIBRATION,
        Verdict.MEASUREMENT,
    }
)
"""Verdicts that report what closes the gap."""
BLAMING = NAMING | {Verdict.AMBIGUOUS}
"""Verdicts that come with one or several explanations."""


class ReasonKind(StrEnum):
    """Why a verdict is given; each is a sentence with the numbers left open."""

    NOISE_ALONE = "noise alone leaves as much with a chance of {chance:.2g}"
    TOO_SMALL = "the gap is {size:.2g} of the noise where it is largest: too small to matter"
    FAR_NUISANCE = "{key} is {x:+.1f} prior sigmas from what the machine says"
    DISTINGUISHABLE = "distinguishable from every other explanation, and confirmed on runs held out"
    ONE_OF_A_CLASS = "one of a class that these data do not distinguish"
    SEVERAL_SINGLES = "several explanations are as good"
    SEVERAL_SETS = "several sets of effects are as good"
    ONE_IS_FAINT = "one of the effects hardly earns its place"
    EFFECT_IS_FAINT = "beside a number of the machine that is wrong, the effect hardly earns its place"
    NOTHING_HELD_OUT = "there is one operating point alone: nothing can be held out"
    NOTHING_EARNS_ITS_PLACE = "no effect of the library earns its place"
    FAINT = "the best explanation hardly earns its place"
    MORE_THAN_NOISE_LEFT = "what the best explanation leaves is more than noise"
    MANY_FAR_NUMBERS = "the best explanation needs {number} numbers of the machine beyond {limit:g} prior sigmas"
    NUMBER_TOO_FAR = "the best explanation needs {key} more than {limit:g} prior sigmas away"
    BEYOND_ITS_RANGE = "the best explanation needs {key} beyond its range"
    REMOVES_NOTHING = "on runs that it was not fitted to, the best explanation removes nothing"
    GAP_STILL_THERE = "on runs that it was not fitted to, {percent:.0f} % of the gap is still there"
    GAP_LEFT = "on runs that it was not fitted to, a gap of {size:.2g} of the noise is left"
    ODD_FILE = "{file} alone is wrong, and no effect of the library explains that"
    ODD_CHANNEL = "{sensor} of {file} leaves {rms:.3g} of the noise, where noise alone leaves 1"
    ODD_REPEAT = "{file} differs from its repeats by more than the scatter of the others explains"
    FILE_OR_EFFECT = "a fault of one file and an effect explain the gap equally well"
    FILE_NOT_EXPLAINED = "no fault of measurement and no effect explains {file}, where the fit is worst"
    FILE_NOT_ALONE = "without {file}, where the fit is worst, a gap is left that nothing explains"
    TABLE_TAKES_MORE = "an unknown {balance} without a name takes more of the gap"

    def with_facts(self, **facts: Any) -> "Reason":
        """The reason with its numbers: the facts that its sentence leaves open, by their names in it."""
        return Reason(self, self.value.format(**facts))


class Reason(NamedTuple):
    """A reason of some kind, with its numbers."""

    kind: ReasonKind
    text: str

    def __str__(self) -> str:
        return self.text
