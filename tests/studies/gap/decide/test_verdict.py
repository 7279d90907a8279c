"""The rules by which something is named, or is not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from apesim.studies.estimation.parameters import Parameter
from apesim.studies.gap.decide.facts import Facts
from apesim.studies.gap.decide.held_out import HeldOut
from apesim.studies.gap.decide.odd_files import OddChannel
from apesim.studies.gap.decide.operating_points import find_points
from apesim.studies.gap.decide.verdict import TABLE, decide, find_row
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.gap.search.model_selection import Foreseen, PricedModel, find_term_penalty, price_model
from apesim.studies.gap.thresholds import MAX_CORRECTED, MIN_LOG_ODDS
from apesim.studies.measured import MeasuredRun

N = 50
GOOD = HeldOut(1000, 1.2, 1.0, 400.0, 5.0, 14.0)
NO_FILES = {}
NUMBERS = {
    key: (Parameter(key, 0.1, -6.0, 6.0, 1.0, shifts=True, relative=True),) for key in ("valve.stroke", "s.area")
}
"""Numbers of the machine file that count as exact, as parameters of candidates."""


def model(names, gap=None, cost=0.0, pulled=(), pull=5.0, size=0.5, files=NO_FILES):
    """A model that takes a gap of some shape away; files: of faults, and their kinds, by name."""
    errors = np.append(np.zeros(N) if gap is None else -np.asarray(gap, dtype=float), np.zeros(2))
    fitted = SimpleNamespace(
        residuals=errors,
        data_residuals=errors[:N],
        x=np.array([pull if pulled else 0.0, size]),
        covariance=0.01 * np.eye(2),
    )
    effect = Parameter("effects.quadratic_drag.coefficient", 40.0, 0.0, 1.3, reach=1.3)
    nuisance = Parameter("valve.viscous_friction", 0.1, -10.0, 10.0, 111.0, True, True, True)
    residuals = SimpleNamespace(known=np.array([True, False]), parameters=[nuisance, effect])
    return SimpleNamespace(
        names=names,
        fitted=fitted,
        residuals=residuals,
        cost=cost,
        pulled=list(pulled),
        corrected=("valve.viscous_friction",) * len(pulled),
        added=0,
        candidates=tuple(Candidate(name, NUMBERS.get(name, ()), (), *files.get(name, ())) for name in names),
    )


def choice(cost, *names, gap=None, **options):
    return PricedModel(model(names, gap, **options), cost)


BASE = model((), cost=300.0)
FAR = model((), cost=300.0, pulled=[0])
SHAPE = np.sin(np.arange(N))
OTHER = np.cos(np.arange(N))
FAULTS = {"slip": ("a.csv", "run_offset"), "gain": ("a.csv", "run_gain"), "late": ("b.csv", "run_time_zero")}
ODD = (OddChannel("a.csv", "lift", 1.5, 1.1, 12.0),)


def fault(cost, *names):
    return choice(cost, *names, gap=SHAPE, files=FAULTS)


def facts_of(*choices, base=BASE, size=1.0, judged=GOOD, **more):
    """What a search has found; the choices are ranked by their cost."""
    ranked = tuple(sorted(choices, key=lambda one: one.cost))
    return Facts(base, 0.001, choices=ranked, size=size, judged=judged, **more)


def decision_of(*choices, **facts):
    return decide(facts_of(*choices, **facts))


def verdict_of(*choices, **facts):
    return decision_of(*choices, **facts).verdict


STROKE = choice(100.0, "valve.stroke", gap=SHAPE)
A, B, NOT_B = choice(100.0, "a", gap=SHAPE), choice(105.0, "b", gap=SHAPE), choice(105.0, "b", gap=OTHER)
FAR_A, SLIP = choice(92.0, "a", gap=SHAPE, pulled=[0]), fault(100.0, "slip")
PAIR, TRIPLE = choice(100.0, "a", "b", gap=SHAPE), choice(60.0, "a", "b", "c", gap=SHAPE)
FAILED, REFUTED = GOOD._replace(removed_energy=-1.0), HeldOut(100, 3.0, 3.0, 0.0, 50.0, 10.0)
NUISANCE = ("valve.viscous_friction",)
LEFT = "on runs that it was not fitted to, a gap of 0.58 of the noise is left"
BOTH = "a fault of one file and an effect explain the gap equally well"
CONFIRMED = "distinguishable from every other explanation, and confirmed on runs held out"
FAINT = "the best explanation hardly earns its place"
CASES = [
    (
        "table explains more",
        facts_of(A, likelier_table="force"),
        ("REFUSED", "an unknown force without a name takes more of the gap", ("a",), []),
    ),
    (
        "odd channel",
        Facts(BASE, 0.4, odd_unexplained=(ODD[0]._replace(file="b.csv", size=0.9), *ODD)),
        ("REFUSED", "lift of a.csv leaves 1.5 of the noise, where noise alone leaves 1", None, []),
    ),
    ("nuisance refuted", Facts(FAR, 0.4, judged_calibration=REFUTED), ("REFUSED", LEFT, NUISANCE, [])),
    (
        "odd repeat",
        Facts(BASE, 0.4, odd_repeats=("a.csv", "b.csv")),
        (
            "AMBIGUOUS",
            "a.csv and b.csv differs from its repeats by more than the scatter of the others explains",
            None,
            [],
        ),
    ),
    (
        "far nuisance",
        Facts(FAR, 0.4),
        ("CALIBRATION", "valve.viscous_friction is +5.0 prior sigmas from what the machine says", NUISANCE, []),
    ),
    ("noise alone", Facts(BASE, 0.4), ("NO_GAP", "noise alone leaves as much with a chance of 0.4", None, [])),
    (
        "too small",
        facts_of(A, size=0.1),
        ("NO_GAP", "the gap is 0.1 of the noise where it is largest: too small to matter", None, []),
    ),
    ("no gain", facts_of(choice(301.0, "a")), ("REFUSED", "no effect of the library earns its place", None, [])),
    ("faint file", facts_of(fault(295.0, "slip"), judged=None), ("REFUSED", FAINT, ("slip",), [])),
    ("file or other", facts_of(SLIP, B, judged=None), ("AMBIGUOUS", BOTH, ("slip",), [("b",)])),
    (
        "odd file",
        facts_of(SLIP, judged=None, odd_after=ODD),
        (
            "REFUSED",
            "no fault of measurement and no effect explains a.csv, where the fit is worst",
            ("slip",),
            [],
        ),
    ),
    (
        "rest refused",
        facts_of(SLIP, judged=None, is_rest_refused=True),
        ("REFUSED", "without a.csv, where the fit is worst, a gap is left that nothing explains", ("slip",), []),
    ),
    (
        "file",
        facts_of(SLIP, judged=None),
        ("MEASUREMENT", "a.csv alone is wrong, and no effect of the library explains that", ("slip",), []),
    ),
    (
        "nothing held out",
        facts_of(A, judged=None),
        ("AMBIGUOUS", "there is one operating point alone: nothing can be held out", ("a",), []),
    ),
    (
        "fails or implausible",
        facts_of(A, judged=FAILED),
        ("REFUSED", "on runs that it was not fitted to, the best explanation removes nothing", ("a",), []),
    ),
    (
        "more than noise left",
        facts_of(A, left_chance=0.001),
        ("REFUSED", "what the best explanation leaves is more than noise", ("a",), []),
    ),
    ("faint effects", facts_of(choice(295.0, "a", gap=SHAPE)), ("REFUSED", FAINT, ("a",), [])),
    ("effect or file", facts_of(A, fault(103.0, "slip")), ("AMBIGUOUS", BOTH, ("a",), [("slip",)])),
    ("several singles", facts_of(A, NOT_B), ("AMBIGUOUS", "several explanations are as good", ("a",), [("b",)])),
    (
        "doubtful effect",
        facts_of(FAR_A, NOT_B),
        (
            "AMBIGUOUS",
            "beside a number of the machine that is wrong, the effect hardly earns its place",
            ("a",),
            [("b",)],
        ),
    ),
    ("class", facts_of(A, B), ("NAMED_CLASS", "one of a class that these data do not distinguish", ("a",), [("b",)])),
    ("one number", facts_of(STROKE), ("CALIBRATION", CONFIRMED, ("valve.stroke",), [])),
    ("one effect", facts_of(A), ("NAMED", CONFIRMED, ("a",), [])),
    (
        "several sets",
        facts_of(PAIR, choice(105.0, "c", "d", gap=SHAPE)),
        ("AMBIGUOUS", "several sets of effects are as good", ("a", "b"), [("c", "d")]),
    ),
    (
        "doubtful set",
        facts_of(PAIR, B),
        ("AMBIGUOUS", "one of the effects hardly earns its place", ("a", "b"), [("b",)]),
    ),
    (
        "numbers alone",
        facts_of(choice(100.0, *NUMBERS, gap=SHAPE)),
        ("CALIBRATION", CONFIRMED, ("valve.stroke", "s.area"), []),
    ),
    (
        "effect and numbers",
        facts_of(choice(100.0, "a", "valve.stroke", gap=SHAPE)),
        ("NAMED", CONFIRMED, ("a", "valve.stroke"), []),
    ),
    ("two effects", facts_of(PAIR), ("TWO_EFFECTS", CONFIRMED, ("a", "b"), [])),
    ("three effects or more", facts_of(TRIPLE), ("SEVERAL", CONFIRMED, ("a", "b", "c"), [])),
]
"""For each row of the table, facts that lead to it, and what is said then: verdict, reason, best and rivals."""


@pytest.mark.parametrize(("name", "facts", "said"), CASES, ids=[name for name, *_ in CASES])
def test_each_row_says_what_is_missing_and_why(name, facts, said):
    found = decide(facts)
    best = found.best.names if found.best else None
    assert find_row(facts).name == name
    assert (str(found.verdict), str(found.reason), best, [rival.names for rival in found.rivals]) == said


def test_every_row_has_its_case():
    assert [row.name for row in TABLE] == [name for name, *_ in CASES]


FAINT_A, FAINT_SLIP = choice(295.0, "a", gap=SHAPE, pulled=[0]), fault(295.0, "slip")
FARTHER_A = choice(295.0, "a", gap=SHAPE, pulled=[0], pull=11.0)
STEPS = [
    # All that contradicts that nothing is missing, and one of it less at a time.
    ("odd channel", {"likelier_table": None}),
    ("nuisance refuted", {"odd_unexplained": ()}),
    ("odd repeat", {"judged_calibration": None}),
    ("far nuisance", {"odd_repeats": ()}),
    ("noise alone", {"base": BASE}),
    ("too small", {"choices": (choice(300.0, "slip", files=FAULTS),)}),
    ("no gain", {"size": 1.0}),
    # A fault of a file that is faint, as good as an effect, not explained and not alone.
    ("faint file", {"choices": (FAINT_SLIP, FAINT_A._replace(cost=296.0))}),
    ("file or other", {"choices": (SLIP, FAR_A._replace(cost=101.0))}),
    ("odd file", {"choices": (SLIP,)}),
    ("odd file", {"odd_after": ()}),
    ("rest refused", {"left_chance": 1.0}),
    ("file", {"is_rest_refused": False}),
    # An effect that was not held out, and fails in all that it is asked.
    ("nothing held out", {"choices": (FARTHER_A, FAINT_SLIP, NOT_B._replace(cost=296.0)), "left_chance": 0.001}),
    ("fails or implausible", {"judged": FAILED}),
    ("fails or implausible", {"judged": GOOD}),
    ("more than noise left", {"choices": (FAINT_A, FAINT_SLIP, NOT_B._replace(cost=296.0))}),
    ("faint effects", {"left_chance": 1.0}),
    ("effect or file", {"choices": (FAR_A, SLIP, NOT_B._replace(cost=96.0))}),
    ("several singles", {"choices": (FAR_A, NOT_B._replace(cost=96.0))}),
    ("doubtful effect", {"choices": (FAR_A, B._replace(cost=96.0), choice(105.0, "c", gap=OTHER))}),
    ("class", {"choices": (A, B)}),
    ("one effect", {"choices": (A,)}),
    # A pair that is as good as another, and one of whose effects is in doubt.
    ("several sets", {"choices": (PAIR, choice(105.0, "c", "d", gap=SHAPE), B)}),
    ("doubtful set", {"choices": (PAIR, B)}),
    ("two effects", {"choices": (PAIR,)}),
    ("three effects or more", {"choices": (TRIPLE,)}),
]


def test_the_first_row_that_applies_decides():
    """All that may be said at once: taking away what the first row rests on leads to the next one."""
    against = {"likelier_table": "force", "odd_unexplained": ODD, "judged_calibration": REFUTED, "odd_repeats": ("a",)}
    found = {"odd_after": ODD, "left_chance": 0.001, "is_rest_refused": True}
    facts = Facts(FAR, 0.001, **against, **found)
    assert find_row(facts).name == "table explains more"
    for name, change in STEPS:
        facts = replace(facts, **change)
        assert find_row(facts).name == name


def test_a_table_is_compared_with_what_is_named_without_it():
    doubtful = facts_of(FAR_A, NOT_B)
    assert decide(replace(doubtful, likelier_table="heat"))[1:3] == decide(doubtful)[1:3] == (FAR_A, (NOT_B,))


def test_a_far_nuisance_that_holds_is_a_finding():
    held = Facts(FAR, 0.4, judged_calibration=REFUTED._replace(remaining_energy=10.0))
    assert decide(held).verdict == "CALIBRATION"
    assert decide(replace(held, judged_calibration=REFUTED, tolerance=0.6)).verdict == "CALIBRATION"


def test_one_effect_far_ahead_is_named():
    assert verdict_of(A, choice(150.0, "b", gap=OTHER)) == "NAMED"


def test_what_matters_is_for_the_user_to_say():
    assert verdict_of(A, size=0.12, tolerance=0.1) == "NAMED"
    assert verdict_of(A, size=0.3, tolerance=0.4) == "NO_GAP"
    judged = GOOD._replace(samples=10_000, removed_energy=4000.0, remaining_energy=600.0)
    assert "a gap of" in decision_of(A, judged=judged).reason.text
    assert verdict_of(A, judged=judged, tolerance=0.3) == "NAMED"


def test_two_that_look_alike_are_a_class_and_two_that_do_not_are_ambiguous():
    assert verdict_of(choice(100.0, "a", gap=SHAPE), choice(105.0, "b", gap=SHAPE + 0.1 * OTHER)) == "NAMED_CLASS"
    assert verdict_of(choice(100.0, "a", gap=SHAPE), choice(105.0, "b", gap=OTHER)) == "AMBIGUOUS"


def test_a_pair_that_contains_the_best_single_effect_is_no_rival_to_it():
    assert verdict_of(choice(100.0, "a", gap=SHAPE), choice(101.0, "a", "b", gap=SHAPE)) == "NAMED"


def test_a_pair_is_named_where_each_of_its_effects_is_sure_over_all_models():
    pair, far = choice(100.0, "a", "b", gap=SHAPE), 100.0 + 2.0 * MIN_LOG_ODDS
    for other in ("a",), ("c",), ("a", "c"), ("c", "d"):
        assert verdict_of(pair, choice(far + 1.0, *other, gap=SHAPE)) == "TWO_EFFECTS"
        assert verdict_of(pair, choice(far - 1.0, *other, gap=SHAPE)) == "AMBIGUOUS"


def test_many_models_without_an_effect_make_it_less_sure_than_the_best_of_them_alone():
    pair, far = choice(100.0, "a", "b", gap=SHAPE), 101.0 + 2.0 * MIN_LOG_ODDS
    others = [choice(far, "a", name, gap=SHAPE) for name in "cdefgh"]
    assert verdict_of(pair, others[0]) == "TWO_EFFECTS"
    assert verdict_of(pair, *others) == "AMBIGUOUS"


def test_sets_that_were_not_fitted_make_an_effect_less_sure():
    pair, sure = choice(100.0, "a", "b", gap=SHAPE), 2.0 * MIN_LOG_ODDS
    others = tuple(Candidate(name, (), ()) for name in "ac")
    said = [decision_of(pair, foreseen=(Foreseen(others, excess),)) for excess in (sure + 1.0, sure - 1.0)]
    assert [str(each.verdict) for each in said] == ["TWO_EFFECTS", "AMBIGUOUS"]
    assert said[1].reason.kind is ReasonKind.ONE_IS_FAINT
    tied = (pair, choice(101.0, "a", "d", gap=OTHER))
    both = (decision_of(*tied), decision_of(*tied, foreseen=(Foreseen(others[1:], 5.0),)))
    assert [each.sure for each in both] == [(("a",),), ()]


def test_pairs_that_differ_by_what_looks_alike_are_one_finding_unless_they_are_as_good():
    single, pair = choice(290.0, "b", gap=OTHER), choice(100.0, "a", "b", gap=SHAPE)

    def other(cost):
        return choice(cost, "c", "b", gap=SHAPE + 0.1 * OTHER)

    assert verdict_of(pair, other(106.0), single) == "TWO_EFFECTS"
    assert verdict_of(pair, other(102.0), single) == "AMBIGUOUS"
    with_twin = Foreseen(tuple(Candidate(name, (), ()) for name in "bcd"), 2.0)
    assert verdict_of(pair, other(106.0), single, foreseen=(with_twin,)) == "AMBIGUOUS"
    assert verdict_of(pair, choice(106.0, "c", "d", gap=SHAPE), single) == "AMBIGUOUS"


@pytest.mark.parametrize(
    ("judged", "said"),
    [
        (GOOD._replace(removed_energy=-1.0), "removes nothing"),
        (GOOD._replace(remaining_energy=600.0), "is still there"),
        (GOOD._replace(samples=10_000, removed_energy=4000.0, remaining_energy=600.0), "a gap of"),
    ],
)
def test_what_fails_on_runs_left_out_is_refused(judged, said):
    found = decision_of(A, judged=judged)
    assert found.verdict == "REFUSED"
    assert said in found.reason.text


@pytest.mark.parametrize(("size", "word"), [(1.35, "REFUSED"), (1.25, "NAMED")])
def test_a_size_is_to_be_within_its_range_as_far_as_the_data_tell(size, word):
    assert verdict_of(choice(100.0, "a", gap=SHAPE, size=size)) == word


def test_a_name_that_leaves_more_than_noise_is_refused():
    assert verdict_of(A, left_chance=0.02) == "NAMED"
    assert verdict_of(A, left_chance=0.005) == "REFUSED"


def test_what_is_hardly_better_than_nothing_is_no_name():
    assert verdict_of(choice(291.0, "a", gap=SHAPE)) == "REFUSED"
    assert verdict_of(choice(290.0, "a", gap=SHAPE)) == "NAMED"


def test_runs_that_gauges_do_not_tell_apart_are_one_operating_point():
    times = np.zeros(1)
    first = MeasuredRun("", "", 0.4e6, 287.0, 50e-3, "fit", times, {})
    again = first._replace(supply=0.402e6, temperature=287.4, pulse=50.1e-3)
    unknown = first._replace(temperature=np.nan)
    others = [
        first._replace(supply=0.41e6),
        first._replace(temperature=290.0),
        first._replace(pulse=40e-3),
        first._replace(speed=100.0),
        first._replace(speed=110.0),
    ]
    assert find_points([first, again, unknown]) == [first]
    assert find_points([first, *others, again]) == [first, *others]


def test_a_pair_that_hardly_beats_one_of_its_effects_leaves_it_open_whether_there_is_a_second():
    assert verdict_of(PAIR, B) == "AMBIGUOUS"
    assert verdict_of(PAIR, B._replace(cost=99.0)) == "NAMED"
    assert verdict_of(PAIR, B._replace(cost=200.0)) == "TWO_EFFECTS"


"""Values x of a model that pulls a number of the machine by five prior sigmas."""


def test_an_effect_is_named_beside_few_numbers_that_are_off():
    far = choice(100.0, "a", gap=SHAPE, pulled=range(MAX_CORRECTED))
    assert verdict_of(far) == "NAMED"
    found = decision_of(choice(100.0, "a", gap=SHAPE, pulled=range(MAX_CORRECTED + 1)))
    assert (found.verdict, found.reason.kind) == (Verdict.REFUSED, ReasonKind.MANY_FAR_NUMBERS)


@pytest.mark.parametrize(("pull", "word"), [(9.0, "NAMED"), (11.0, "REFUSED")])
def test_beside_a_number_that_is_off_by_too_much_nothing_is_named(pull, word):
    assert verdict_of(choice(100.0, "a", gap=SHAPE, pulled=[0], pull=pull)) == word


def test_beside_a_number_that_is_off_an_effect_has_to_be_sure_over_all_models():
    far, other = choice(92.0, "a", gap=SHAPE, pulled=[0]), choice(110.0, "b", gap=OTHER)
    assert decision_of(far, other).rivals == (other,)
    assert verdict_of(far, other._replace(cost=113.0)) == "NAMED"
    assert verdict_of(choice(92.0, "a", gap=SHAPE), other) == "NAMED"


def test_a_number_that_is_off_costs_what_its_prior_says():
    alone = model((), cost=40.0, pulled=[0])
    assert price_model(alone, 35).cost == 40.0
    assert price_model(model(("a",), cost=40.0, pulled=[0]), 35).cost == 40.0 + find_term_penalty(35)


def test_two_faults_of_one_file_leave_the_file_blamed():
    assert verdict_of(fault(100.0, "slip"), fault(103.0, "gain")) == "MEASUREMENT"


@pytest.mark.parametrize("rival", [choice(103.0, "b", gap=SHAPE), fault(103.0, "late")], ids=["effect", "other file"])
def test_a_file_is_not_blamed_for_what_else_may_be_the_cause(rival):
    assert verdict_of(fault(100.0, "slip"), rival) == "AMBIGUOUS"


@pytest.mark.parametrize(("file", "verdict"), [("a.csv", "MEASUREMENT"), ("other.csv", "NO_GAP")])
def test_a_gap_too_small_to_matter_in_all_runs_may_be_a_fault_of_the_one_that_is_odd(file, verdict):
    odd = (OddChannel(file, "lift", 1.1, 0.4, 12.0),)
    assert verdict_of(SLIP, size=0.1, judged=None, odd_before=odd) == verdict
    assert verdict_of(SLIP, size=0.1) == "NO_GAP"


SHARED, PART, OTHER_PART = (np.sin(k * np.arange(N)) for k in (2.0, 3.0, 4.0))
"""What an effect takes of the gap that all explanations have, and what each of two others takes beside it."""
WITH_B, WITH_C = (choice(cost, "a", n, gap=SHARED + p) for cost, n, p in ((100.0, "b", PART), (103.0, "c", OTHER_PART)))
ALONE = choice(250.0, "a", gap=SHARED)
SURE = [
    ("shared by all", {}, [WITH_B, WITH_C, ALONE], (("a",),)),
    ("beside one in doubt", {}, [WITH_B, ALONE._replace(cost=103.0)], (("a",),)),
    (
        "a rival of little weight has others",
        {},
        [WITH_B, *(WITH_C._replace(cost=100.0 + k) for k in range(4)), choice(109.0, "c", "d", gap=OTHER_PART), ALONE],
        (),
    ),
    ("one model far off has another", {}, [WITH_B, WITH_C, ALONE, choice(110.0, "d", gap=OTHER)], (("a",),)),
    (
        "many models far off have others",
        {},
        [WITH_B, WITH_C, ALONE, *(choice(110.0, n, gap=OTHER) for n in "defgh")],
        (),
    ),
    ("a twin in a rival", {}, [WITH_B, choice(101.0, "a_too", "b", gap=SHARED + PART), WITH_C], (("a", "a_too"),)),
    (
        "a fault of a file in its place",
        {},
        [
            choice(100.0, "a", "b", gap=SHARED + PART),
            choice(103.0, "slip", "b", gap=SHARED + PART, files=FAULTS),
            choice(250.0, "b", gap=PART),
        ],
        (("b",),),
    ),
    ("nothing held out", {"judged": None}, [WITH_B, WITH_C, ALONE], ()),
]
"""What a search has found of an ambiguous gap, and which effects are sure all the same."""


@pytest.mark.parametrize(("more", "choices", "sure"), [case[1:] for case in SURE], ids=[name for name, *_ in SURE])
def test_of_an_ambiguous_gap_that_is_sure_which_all_explanations_and_nearly_all_of_the_weight_have(more, choices, sure):
    found = decision_of(*choices, **more)
    assert (found.verdict, found.sure) == ("AMBIGUOUS", sure)


def test_what_is_named_or_refused_has_nothing_sure_besides():
    named, refused = decision_of(WITH_B, ALONE), decision_of(WITH_B, WITH_C, judged=FAILED)
    assert [(each.verdict, each.sure) for each in (named, refused)] == [("TWO_EFFECTS", ()), ("REFUSED", ())]


def test_three_that_hold_are_several():
    three, two, one = choice(60.0, "a", "b", "c", gap=SHAPE), choice(120.0, "a", "b"), choice(200.0, "a", gap=SHAPE)
    assert verdict_of(three, two, one) == "SEVERAL"
    assert verdict_of(three, choice(62.0, "a", "d", "e", gap=SHAPE), two, one) == "AMBIGUOUS"
