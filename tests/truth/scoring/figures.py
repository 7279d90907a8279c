"""The benchmark's figures: counts of what was right, beside their floors and goals."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from tests.truth.sealed.library import ENGINE, VALVE
from tests.truth.sealed.schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE
from tests.truth.sealed.second_case import ALIKE
from tests.truth.sealed.second_schedule import FAULTY, TRIPLE

from .forecasts import judge
from .score import (
    BAD_INPUT,
    BLAMING,
    CLEAR,
    CLEARING,
    CONFIDENT,
    NO_VERDICT,
    PLAIN,
    SEEN,
    clopper_pearson,
)

SMALLEST_GAP = 0.02
"""Over the noise; a smaller one counts as this."""
JUDGED = {
    "slope": ("slope of the reliability line", "0.7–1.4", "0.9–1.1"),
    "z": ("Spiegelhalter's Z", "−2 to 2", ""),
    "error": ("debiased calibration error", "", ""),
}
"""What judges stated probabilities, see `truth.scoring.forecasts`: its name, floor and goal."""


class Figure(NamedTuple):
    """One line of the table."""

    what: str
    hits: int | None
    """None: it is no share."""
    cases: int
    floor: str = ""
    goal: str = ""
    value: float | None = None
    """In place of a share: a median, or another number; None: there are too few cases for it."""
    around: tuple | None = None
    """Its own interval, 95 %."""

    @property
    def interval(self):
        """Interval of 95 %: Clopper and Pearson's of a share, another number's own; None: there is none."""
        return clopper_pearson(self.hits, self.cases) if self.is_share else self.around

    @property
    def is_share(self):
        """Whether it is a share of some cases."""
        return self.hits is not None and self.cases > 0


def shrinks(gap, settled=False):
    """Factor by which a gap shrinks, the noise taken off; settled: the parameters' uncertainty, too."""
    keys = [f"settled_{when}" if settled else when for when in ("before", "after")]
    if not gap or any(gap.get(key) is None for key in keys):
        return None
    floor = gap.get("noise_floor", 1.0)
    before, after = (sqrt(max(gap[key] ** 2 - floor**2, 0.0)) for key in keys)
    return max(before, SMALLEST_GAP) / max(after, SMALLEST_GAP)


def brier(statements):
    """Mean square of stated probabilities less the truth, 0 or 1."""
    stated, true = np.array(statements, dtype=float).T
    return float(np.mean((stated - true) ** 2))


def share(what, among, wanted, floor="", goal=""):
    """A figure that counts."""
    return Figure(what, sum(map(bool, map(wanted, among))), len(among), floor, goal)


def number(what, values, of, floor="", goal=""):
    """A figure that is one number of many values."""
    values = [value for value in values if value is not None]
    return Figure(what, None, len(values), floor, goal, float(of(values)) if values else None)


def judged(of, claims):
    """Figures that judge stated probabilities; `claims` are cases' numbers, what is stated, and whether it is so."""
    measures = judge(*zip(*claims, strict=True)) if claims else {}
    for name, (what, floor, goal) in JUDGED.items():
        value, interval = measures.get(name, (None, None))
        yield Figure(f"{what}, {of}", None, len(claims), floor, goal, value, interval)


def figures(scored):
    """All figures of a set of cases.

    Parameters
    ----------
    scored : sequence of truth.scoring.score.Scored

    Returns
    -------
    list of Figure
    """
    return [*nothing_hidden(scored), *detected(scored), *named(scored), *wrong(scored), *sizes(scored), *speed(scored)]


def of_kind(scored, *kinds):
    """Cases of some kinds."""
    return [one for one in scored if one.kind in kinds]


def is_plain(one):
    """Whether a case has nothing but noise, and a rig that is off in what is uncertain."""
    off = one.answer.get("geometry", {}).get("deviations", 0.0) >= SEEN
    return not (one.clutter or one.answer.get("scatter") or off)


def alarmed(one):
    """Whether the first condition for a gap holds."""
    return one.verdict.get("alarm")


def noticed(one):
    """Whether anything is said to be there."""
    return alarmed(one) or one.said not in ("NO_GAP", NO_VERDICT)


def nothing_hidden(scored):
    """Figures of cases with nothing hidden."""
    nones = of_kind(scored, NONE)
    off = [one for one in nones if one.answer.get("geometry", {}).get("deviations", 0.0) >= SEEN]
    return [
        share("alarms, nothing hidden, at a nominal 1 %", filter_plain(nones), alarmed, "≤ 2 %", "0.5–1.5 %"),
        share("alarms, nothing but clutter", [one for one in nones if one.clutter], alarmed),
        share("alarms, nothing but scatter of the runs", [one for one in nones if scatters(one)], alarmed),
        share("alarms, nothing but a geometry that is off and not stated", off, alarmed),
        share("names given, nothing hidden", nones, lambda one: one.named, "≤ 1 %", "0 of 200"),
        share(
            "the same, names of a geometry that is truly off not counted",
            nones,
            lambda one: one.named and not one.right,
        ),
        share("data without a fault refused as impossible", [one for one in scored if not one.fault], impossible),
        share("no verdict within the time", scored, lambda one: one.said == NO_VERDICT),
    ]


def filter_plain(nones):
    """Those of some cases with nothing hidden that are plain."""
    return [one for one in nones if is_plain(one)]


def scatters(one):
    """Whether runs differ from one another, and nothing else is."""
    return one.answer.get("scatter") and not one.clutter


def impossible(one):
    """Whether the program takes the data for impossible."""
    return one.said == BAD_INPUT


def cleared(one):
    """Whether nothing is said to be missing, and no file that was masked is told of."""
    return one.said in CLEARING and not one.masked


def detected(scored):
    """Figures of what is noticed at all, and of faulty files."""
    hidden = [one for one in scored if one.hidden and one.kind not in (NONE, FAULTY)]
    whole = [(one, min(one.deviations, one.answer["deviations"])) for one in hidden]
    clear = [one for one, deviations in whole if deviations >= CLEAR]
    faint = [one for one, deviations in whole if SEEN <= deviations < CLEAR]
    faulty = [one for one in of_kind(scored, FAULTY) if one.faulty]
    beside = [one for one in faulty if not one.hidden or one.visible]
    anything = [one for one in scored if one.kind != NONE]
    strict = [one for one in anything if one.faulty or (one.hidden and one.answer["deviations"] >= CLEAR)]
    return [
        share(
            "NO_GAP or CALIBRATION, though a fault or an effect of ≥ 10 sigmas is there",
            [one for one in anything if one.faulty or one.visible],
            lambda one: cleared(one) and not one.calibrated,
            "≤ 1 %",
            "0 of 100",
        ),
        share(
            "the same, gaps below the tolerance counted, too", strict, lambda one: cleared(one) and not one.calibrated
        ),
        share("detected, ≥ 10 sigmas", clear, noticed, "98 %", "100 %"),
        share("detected, 5–10 sigmas", faint, noticed, "85 %", "95 %"),
        share("faulty file pointed at, ≥ 10 sigmas", faulty, lambda one: one.pointed, "85 %", "95 %"),
        share("the same, refused as impossible", faulty, lambda one: one.pointed and impossible(one)),
        share("the same, faults with a name", [one for one in faulty if one.fault["name"]], lambda one: one.pointed),
        share("the same, without", [one for one in faulty if not one.fault["name"]], lambda one: one.pointed),
        share("the physics beside it right", beside, lambda one: one.besides, "80 %", "92 %"),
        share("the same, an effect hidden", [one for one in beside if one.hidden], lambda one: one.besides),
        share("another file blamed", scored, lambda one: set(one.files) - {(one.fault or {}).get("file")}),
    ]


def named(scored):
    """Figures of names."""
    single, double, outside = of_kind(scored, SINGLE), of_kind(scored, DOUBLE), of_kind(scored, REMOVED, FOREIGNER)
    clear = [one for one in single if one.deviations >= CLEAR]
    pairs = [one for one in double if one.deviations >= CLEAR]
    apart = [one for one in pairs if one.answer["cosine"] <= ALIKE]
    alike = [one for one in pairs if one.answer["cosine"] > ALIKE]
    triples = [one for one in of_kind(scored, TRIPLE) if one.deviations >= CLEAR]
    near = [one for one in outside if one.answer.get("near")]
    placed = [one for one in (*clear, *pairs, *outside) if one.localised is not None]

    def one_name(one):
        return one.calibrated or (one.said == "NAMED" and one.right)

    def both(one):
        return one.named and set(one.first) == set(one.hidden)

    def unnamed(one):
        return not one.named

    return [
        share("right class first, single, ≥ 10 sigmas", clear, lambda one: one.class_first, "96 %", "99 %"),
        share("exactly one name, and right, ≥ 10 sigmas", clear, one_name, "90 %", "97 %"),
        share("best pair is the true one, both ≥ 10 sigmas", pairs, lambda one: set(one.first) == set(one.hidden)),
        share("the same, or among those said to be indistinguishable from it", pairs, lambda one: one.listed),
        share("both named, both ≥ 10 sigmas, cosine below 0.9", apart, both, "80 %", "92 %"),
        share("both named, both ≥ 10 sigmas, cosine above 0.9", alike, both, "40 %", "70 %"),
        share("three at once, or two and that more is left", triples, lambda one: one.several, "50 %", "80 %"),
        share("outside the library: not named", outside, unnamed, "88 %", "97 %"),
        share("outside the library, but near it: not named", near, unnamed),
        share(
            "largest part of the gap in the right signal and phase", placed, lambda one: one.localised, "92 %", "98 %"
        ),
    ]


def wrong(scored):
    """Figures of what was said that is not so, and of stated probabilities."""
    hidden = [one for one in scored if one.kind != NONE]
    library = of_kind(scored, SINGLE, DOUBLE, TRIPLE)
    stated = [one for one in scored if one.probability is not None and one.right is not None]
    statements = [(case, *statement) for case, one in enumerate(scored) for statement in one.statements]
    claims = [(one.probability, one.right) for one in stated]

    def is_wrong(one):
        return one.wrong

    def astray(one):
        return one.wrong and one.said != "REFUSED"

    def refused(one):
        return one.wrong and one.said == "REFUSED"

    def confident(one):
        return one.wrong and one.probability >= CONFIDENT

    return [
        share("wrong name or all-clear, of cases with something hidden", hidden, astray, "≤ 2.5 %", "≤ 0.8 %"),
        share("wrong name or all-clear, of all cases", scored, astray),
        share("refused, though the library has what is hidden", library, refused),
        share("wrong in any statement, of cases with something hidden", hidden, is_wrong),
        share("wrong in any statement, of all cases", scored, is_wrong),
        share(
            "wrong and stated at 0.9 or more, of statements with a probability, something hidden",
            [one for one in stated if one.kind != NONE],
            confident,
            "≤ 1 %",
            "≤ 0.3 %",
        ),
        share("wrong and stated at 0.9 or more, of all statements with a probability", stated, confident),
        number("Brier score of the verdicts' probabilities", claims, brier),
        *judged("all stated probabilities", statements),
        *judged("the verdicts' alone", [(case, *claim) for case, claim in enumerate(claims)]),
    ]


def sizes(scored):
    """Figures of intervals, and of how far gaps shrink."""
    outside = of_kind(scored, REMOVED, FOREIGNER)
    strengths = [held for one in scored for held in one.intervals]
    seconds = [held for one in scored for held in one.second_intervals]
    tabulated = [one.verdict["tabulated"].get("held_out") for one in outside if one.verdict.get("tabulated")]
    right = [one for one in of_kind(scored, SINGLE, DOUBLE, TRIPLE) if one.named and one.right]
    plain = [one.verdict.get("held_out") for one in right if one.answer["deviations"] >= PLAIN]
    held = "95 % intervals that hold the truth"
    return [
        number(
            "outside: the tabulated effect shrinks the held-out gap, median",
            [shrinks(one, settled=True) for one in tabulated],
            np.median,
            "5×",
            "8×",
        ),
        number(
            "outside: the same, the parameters' uncertainty not taken off", list(map(shrinks, tabulated)), np.median
        ),
        Figure(f"{held}, strengths", sum(strengths), len(strengths), "92–98 %", "94–96 %"),
        Figure(f"{held}, second parameters", sum(seconds), len(seconds), "88–99 %", "93–97 %"),
        number(
            "held-out gap shrinks, over the noise floor, named, ≥ 20 sigmas, median",
            list(map(shrinks, plain)),
            np.median,
            "10×",
            "18×",
        ),
    ]


def speed(scored):
    """Figures of time."""
    return [
        number(
            f"seconds a data set, {bench}, median",
            [one.verdict.get("wall_time_s") for one in scored if one.answer["bench"] == bench],
            np.median,
        )
        for bench in (VALVE, ENGINE)
    ]


def rightly_named(one):
    """Whether a verdict blames something, and rightly; where a file is faulty, what is said of the rig counts."""
    physics = one.physics
    return physics.said in BLAMING and bool(physics.right)
