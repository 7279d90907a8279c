"""Verdicts held against answers: what was right, and the table of figures with their intervals."""

from math import sqrt
from typing import NamedTuple

import numpy as np
from scipy.stats import beta

from .library import CALIBRATED
from .schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE

NAMES = ("NAMED", "NAMED_CLASS", "TWO_EFFECTS")
BLAMING = (*NAMES, "CALIBRATION")
"""Verdicts that say what it is."""
STATEMENTS = (*BLAMING, "NO_GAP", "REFUSED")
"""Verdicts that claim something; the others leave it open."""
CONFIDENT = 0.9
"""Stated probability from which a wrong statement counts as confident."""
SEEN, CLEAR, PLAIN = 5.0, 10.0, 20.0
"""Deviations of what is hidden."""
TOLERANCE = 0.15
"""Share of the noise; a gap smaller than this may be called none."""
NEARLY = 0.8
"""Share of the largest part of a gap that another part may have and still count as the largest."""
ROUNDING = 1e-9
"""Share of an interval's end that a change of units may take off."""
SMALLEST_GAP = 0.02
"""Over the noise; a smaller one counts as this."""


class Scored(NamedTuple):
    """A case and what was said of it."""

    answer: dict
    verdict: dict

    @property
    def kind(self):
        return self.answer["kind"]

    @property
    def hidden(self):
        """Names of what is hidden."""
        return [one["name"] for one in self.answer["hidden"]]

    @property
    def deviations(self):
        """Deviations of the smallest effect that is hidden; 0: none is."""
        return min((one["deviations"] for one in self.answer["hidden"]), default=0.0)

    @property
    def said(self):
        """The verdict's word."""
        return self.verdict["verdict"]

    @property
    def first(self):
        """Names of the explanation that stands first, named or not."""
        found = self.verdict.get("effects") or self.verdict.get("nearest")
        if found:
            return [one["name"] for one in found]
        return next((list(one["effects"]) for one in self.verdict.get("alternatives", ())), [])

    @property
    def listed(self):
        """Whether what is hidden stands first, or among what is said to be indistinguishable from it."""
        others = (one["effects"] for one in self.verdict.get("alternatives", ()))
        return any(set(names) == set(self.hidden) for names in (self.first, *others))

    @property
    def calibrated(self):
        """Whether the verdict blames a number of the machine or a sensor that is what is hidden."""
        if self.said != "CALIBRATION" or self.kind != SINGLE:
            return False
        keys = [one["key"] for one in self.verdict.get("nuisances", ())[:1]]
        keys += [one["name"] for part in ("effects", "nearest") for one in self.verdict.get(part, ())]
        return any(wanted in key for key in keys for wanted in CALIBRATED.get(self.hidden[0], ()))

    @property
    def named(self):
        """Whether a name is given."""
        return self.said in NAMES

    @property
    def probability(self):
        """That the verdict states for itself; None: it states none."""
        return self.verdict.get("probability")

    @property
    def wrong(self):
        """Whether the verdict claims what is not so."""
        return self.right is False

    @property
    def right(self):
        """Whether the verdict is right in what it claims; None where it claims nothing.

        `REFUSED` claims a gap that nothing of the library closes.
        """
        if self.said not in STATEMENTS:
            return None
        if self.said == "REFUSED":
            return bool(self.hidden) and self.kind not in (SINGLE, DOUBLE)
        if self.said == "NO_GAP":
            return not self.hidden or self.kind == NONE or self.deviations < CLEAR or self.answer["rms"] < TOLERANCE
        if self.said == "CALIBRATION":
            return self.calibrated
        first, hidden = set(self.first), set(self.hidden)
        if self.kind == SINGLE:
            return first == hidden or (self.said == "NAMED_CLASS" and self.hidden[0] in self.verdict.get("class", ()))
        return self.kind == DOUBLE and (first == hidden or (len(first) == 1 and first < hidden and self.unseen(first)))

    def unseen(self, named):
        """Whether the one of two that is not named would not be seen if the other were known."""
        alone = sqrt(max(0.0, 1.0 - self.answer["cosine"] ** 2))
        other = next(one["deviations"] for one in self.answer["hidden"] if one["name"] not in named)
        return other * alone < SEEN

    @property
    def class_first(self):
        """Whether what stands first is the hidden single, or what no data like these tell from it."""
        if self.calibrated:
            return True
        alike = {*self.answer["class"], *self.hidden}
        return len(set(self.first)) == 1 and self.first[0] in alike

    @property
    def localised(self):
        """Whether the largest part of the gap is put where it is; None where nothing is said."""
        place = self.verdict.get("localised") or {}
        parts = self.answer["gap"]
        if not place.get("signal") or not parts:
            return None
        here = (place["signal"], place.get("phase") or "")
        share = next((one["share"] for one in parts if (one["signal"], one["phase"]) == here), 0.0)
        return share >= NEARLY * parts[0]["share"]

    @property
    def intervals(self):
        """Whether each interval of a rightly named parameter holds the truth."""
        if not (self.named and self.right):
            return []
        truth = {(one["name"], one["parameter"]): one for one in self.answer["hidden"]}
        found = []
        for one in self.verdict["effects"]:
            true = truth.get((one["name"], one["parameter"]))
            if true and true["unit"] == one["unit"] and one["interval_95"]:
                low, high = one["interval_95"]
                rounding = ROUNDING * max(abs(low), abs(high))
                found.append(low - rounding <= true["value"] <= high + rounding)
        return found


class Figure(NamedTuple):
    """One line of the table."""

    what: str
    hits: int
    cases: int
    floor: str
    goal: str
    value: float | None = None
    """In place of a share: a median."""

    @property
    def interval(self):
        """Clopper and Pearson's, 95 %."""
        return clopper_pearson(self.hits, self.cases)


def clopper_pearson(hits, cases, level=0.95):
    """Interval of a share."""
    tail = 0.5 * (1.0 - level)
    low = beta.ppf(tail, hits, cases - hits + 1) if hits else 0.0
    high = beta.ppf(1.0 - tail, hits + 1, cases - hits) if hits < cases else 1.0
    return float(low), float(high)


def shrinks(gap, settled=False):
    """Factor by which a gap shrinks, the noise taken off; settled: the parameters' uncertainty, too."""
    keys = [f"settled_{when}" if settled else when for when in ("before", "after")]
    if not gap or any(gap.get(key) is None for key in keys):
        return None
    floor = gap.get("noise_floor", 1.0)
    before, after = (sqrt(max(gap[key] ** 2 - floor**2, 0.0)) for key in keys)
    return max(before, SMALLEST_GAP) / max(after, SMALLEST_GAP)


def figures(scored):
    """All figures of a set of cases.

    Parameters
    ----------
    scored : sequence of Scored

    Returns
    -------
    list of Figure
    """

    def of(*kinds):
        return [one for one in scored if one.kind in kinds]

    def share(what, among, wanted, floor, goal):
        return Figure(what, sum(map(bool, map(wanted, among))), len(among), floor, goal)

    def middle(what, values, floor, goal):
        values = [value for value in values if value is not None]
        return Figure(what, 0, len(values), floor, goal, float(np.median(values)) if values else None)

    plain = [one for one in of(NONE) if not one.hidden]
    cluttered = [one for one in of(NONE) if one.hidden]
    single, double, outside = of(SINGLE), of(DOUBLE), of(REMOVED, FOREIGNER)
    clear = [one for one in single if one.deviations >= CLEAR]
    faint = [one for one in single if SEEN <= one.deviations < CLEAR]
    pairs = [one for one in double if one.deviations >= CLEAR]
    placed = [one for one in (*clear, *pairs, *outside) if one.localised is not None]
    intervals = [held for one in scored for held in one.intervals]
    named = [one for one in (*single, *double) if one.named and one.right and one.answer["deviations"] >= PLAIN]
    tabulated = [one.verdict["tabulated"] for one in outside if one.verdict.get("tabulated")]
    hidden = [one for one in scored if one.kind != NONE]
    stated = [one for one in scored if one.probability is not None and one.right is not None]

    def wrong(one):
        return one.wrong

    def refused(one):
        return one.wrong and one.said == "REFUSED"

    def astray(one):
        return one.wrong and one.said != "REFUSED"

    def confident(one):
        return one.wrong and one.probability >= CONFIDENT

    def detected(one):
        return one.verdict.get("alarm") or one.said == "CALIBRATION"

    return [
        share(
            "alarms, nothing hidden, at a nominal 1 %",
            plain,
            lambda one: one.verdict.get("alarm"),
            "≤ 2 %",
            "0.5–1.5 %",
        ),
        share("alarms, nothing but clutter", cluttered, lambda one: one.verdict.get("alarm"), "", ""),
        share("names given, nothing hidden", of(NONE), lambda one: one.named, "≤ 1 %", "0 of 100"),
        share("detected, ≥ 10 sigmas", clear, detected, "98 %", "100 %"),
        share("detected, 5–10 sigmas", faint, detected, "75 %", "90 %"),
        share("right class first, single, ≥ 10 sigmas", clear, lambda one: one.class_first, "95 %", "99 %"),
        share(
            "exactly one name, and right, ≥ 10 sigmas",
            clear,
            lambda one: one.calibrated or (one.said == "NAMED" and one.right),
            "85 %",
            "95 %",
        ),
        share(
            "best pair is the true one, both ≥ 10 sigmas",
            pairs,
            lambda one: set(one.first) == set(one.hidden),
            "90 %",
            "98 %",
        ),
        share("the same, or among those said to be indistinguishable from it", pairs, lambda one: one.listed, "", ""),
        share(
            "both named, both ≥ 10 sigmas",
            pairs,
            lambda one: one.named and set(one.first) == set(one.hidden),
            "60 %",
            "85 %",
        ),
        share("outside the library: not named", outside, lambda one: not one.named, "90 %", "98 %"),
        share("wrong name or all-clear, of cases with something hidden", hidden, astray, "≤ 2.5 %", "≤ 0.8 %"),
        share("wrong name or all-clear, of all cases", scored, astray, "", ""),
        share("refused, though the library has what is hidden", [*single, *double], refused, "", ""),
        share("wrong in any statement, of cases with something hidden", hidden, wrong, "", ""),
        share("wrong in any statement, of all cases", scored, wrong, "", ""),
        share(
            "wrong and stated at 0.9 or more, of statements with a probability, something hidden",
            [one for one in stated if one.kind != NONE],
            confident,
            "≤ 1 %",
            "≤ 0.3 %",
        ),
        share("wrong and stated at 0.9 or more, of all statements with a probability", stated, confident, "", ""),
        share(
            "largest part of the gap in the right signal and phase", placed, lambda one: one.localised, "90 %", "98 %"
        ),
        middle(
            "outside: the tabulated effect shrinks the held-out gap, median",
            [shrinks(one.get("held_out"), settled=True) for one in tabulated],
            "3×",
            "8×",
        ),
        middle(
            "outside: the same, the parameters' uncertainty not taken off",
            [shrinks(one.get("held_out")) for one in tabulated],
            "",
            "",
        ),
        Figure("95 % intervals that hold the truth", sum(intervals), len(intervals), "90–98 %", "93–97 %"),
        middle(
            "held-out gap shrinks, over the noise floor, named, ≥ 20 sigmas, median",
            [shrinks(one.verdict.get("held_out")) for one in named],
            "8×",
            "15×",
        ),
        middle("seconds a data set, median", [one.verdict.get("wall_time_s") for one in scored], "60 s", "15 s"),
    ]
