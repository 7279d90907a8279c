"""Cases of the second benchmark: what they are drawn from, how large faults and scatter are, and how all is scored."""

import json
import tomllib

import numpy as np
import pytest
from scipy.stats import kurtosis

from tests.truth.scoring.figures import brier, figures
from tests.truth.scoring.score import BAD_INPUT, Scored
from tests.truth.scoring.tables import report
from tests.truth.sealed.cases import write
from tests.truth.sealed.challenge import make
from tests.truth.sealed.faults import LARGEST, Fault, deviations_of, draw_fault
from tests.truth.sealed.laboratories import GEOMETRY, assumed, draw_heavy, rig_nuisances, run_scatter, stated_lines
from tests.truth.sealed.library import ENGINE, LIBRARY, VALVE
from tests.truth.sealed.look_alikes import change_of
from tests.truth.sealed.nuisances import NUISANCES, of_valve
from tests.truth.sealed.observation import Laboratory
from tests.truth.sealed.schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE
from tests.truth.sealed.second_case import confusable_pair, cosine, draw_second
from tests.truth.sealed.second_schedule import FAULTY, KINDS, SECOND, SECOND_SCHEDULE, TRIPLE, second_plan
from tests.truth.sealed.setting import AMBIENT, Noise, Point, Setting
from tests.truth.simulator.effects import EFFECTS, Rig

POINTS = tuple(Point("fit", AMBIENT + gauge, 287.0, 45e-3) for gauge in (0.2e6, 0.5e6, 0.7e6))
WHITE = Noise(1.0, "white", 0.0, 0.0, True)
SETTING = Setting(VALVE, "chambers", POINTS, WHITE, 201, 0.0)


def first_seed(wanted):
    """First seed of the block whose plan is wanted."""
    return next(SECOND + number for number, plan in enumerate(SECOND_SCHEDULE) if wanted(plan))


def test_a_block_holds_what_is_asked_for_and_every_stretch_of_it_its_share():
    block = SECOND_SCHEDULE
    least = {NONE: 200, SINGLE: 175, DOUBLE: 100, TRIPLE: 40, FAULTY: 100, REMOVED: 40, FOREIGNER: 25}
    counts = {kind: sum(plan.kind == kind for plan in block) for kind in KINDS}
    assert all(counts[kind] >= number for kind, number in least.items())
    assert counts[FAULTY] >= len(block) / 5
    assert 0 < sum(bool(plan.effects) for plan in block if plan.fault) < counts[FAULTY]
    assert sum(plan.bench == ENGINE for plan in block) >= len(block) / 3
    assert sum(plan.confusable for plan in block) >= 40
    for flag in ("clutter", "scatter", "stated"):
        assert sum(bool(getattr(plan, flag)) for plan in block) == pytest.approx(len(block) / 2, rel=0.05)
    for first in range(0, len(block) - 100, 50):
        stretch = block[first : first + 100]
        for kind in KINDS:
            asked = 100 * counts[kind] / len(block)
            assert abs(sum(plan.kind == kind for plan in stretch) - asked) <= 3
    assert second_plan(SECOND + len(block)) == second_plan(SECOND) == block[0]


def test_rigs_are_off_by_twice_the_priors_with_heavier_tails_and_in_their_geometry():
    rng = np.random.default_rng(1)
    usual = {one.name: one.deviation for one in NUISANCES}
    drawn = {one.name: one for one in rig_nuisances(ENGINE, SETTING.channels, stated=True)}
    assert {one.name for one in GEOMETRY} < set(drawn)
    for name in ("supply.temperature", "supply.pressure"):
        values = np.array([draw_heavy(rng, drawn[name]) for _ in range(4000)]) / usual[name]
        assert np.std(values) == pytest.approx(2.0, rel=0.07)
        assert kurtosis(values) > 0.7  # 0 of normal ones
        assert 0.5 < np.mean(np.abs(values) > 6.0) / 0.016 < 2.0


def test_what_a_laboratory_states_is_what_its_rig_is_drawn_from_and_else_nothing_is_known_of_the_geometry():
    stated = tomllib.loads("\n".join(stated_lines(rig_nuisances(VALVE, SETTING.channels, stated=True))))["known_to"]
    assert stated["valve.clearance_volume"] == "2 %"
    assert stated["valve.solenoid.dead_time"] == "0.2 ms"
    assert stated["sensor.pressure_a.offset"] == "4 kPa"
    assert stated["sensor.lift.gain"] == "1 %"
    nuisances = rig_nuisances(VALVE, SETTING.channels, stated=False)
    known = assumed(nuisances, stated=False)
    assert known["valve.clearance_volume"] == 0.0
    assert known["valve.viscous_friction"] == 0.1
    assert next(one.deviation for one in nuisances if one.name == "valve.clearance_volume") == 0.005


@pytest.mark.slow
def test_an_effect_counts_less_where_runs_scatter_and_the_more_repeats_the_less_it_loses():
    def size(repeats, scatter):
        points = tuple(point._replace(repeats=repeats) for point in POINTS[:2])
        lab = Laboratory(SETTING._replace(points=points), scatter=scatter)
        return np.linalg.norm(lab.left(Rig(), lambda rig: EFFECTS["seal_friction"](rig, 2e-5), points, linear=True))

    once, scattered = size(1, ()), size(1, run_scatter())
    assert scattered < 0.8 * once
    # Of three repeats noise and scatter fall alike, and only the priors, which repeats do not tell, stay as they are.
    assert scattered < size(3, run_scatter()) < np.sqrt(3.0) * scattered


def test_the_scatter_of_a_run_is_a_nuisance_of_that_run():
    """What one prior deviation of scatter does to one run costs one deviation at most, as it is a priori likely."""
    lab, point = Laboratory(SETTING, scatter=run_scatter()), POINTS[0]
    friction = run_scatter()[2]

    def more(rig):
        return of_valve("viscous_friction")(rig, friction.deviation)

    change = lab.changed(Rig(), more, (point,))
    bare = Laboratory(SETTING).changed(
        Rig(), lambda rig: of_valve("viscous_friction")(rig, friction.deviation), (point,)
    )
    assert np.linalg.norm(change) < 1.0 < np.linalg.norm(bare)


@pytest.mark.slow
def test_a_fault_of_one_of_three_repeats_counts_as_if_it_were_a_run_of_its_own():
    fault = Fault("drift", "lift", 0.1e-3)
    sizes = []
    for points in (POINTS, (POINTS[0]._replace(repeats=3), *POINTS[1:])):
        lab = Laboratory(SETTING._replace(points=points))
        sizes.append(deviations_of(lab, Rig(), points, fault, 0))
    alone = 0.1e-3 / 0.03e-3 * np.linalg.norm(np.linspace(0.0, 1.0, len(SETTING.grid(POINTS[0]))))
    assert 0.5 * alone < sizes[0] < sizes[1] <= alone  # the other repeats hold the nuisances better


@pytest.mark.parametrize("kind", ["offset", "clock", "supply", "spikes"])
def test_a_fault_is_as_large_as_is_asked_for_unless_its_range_ends(kind):
    fault, at, deviations = draw_fault(np.random.default_rng(4), Laboratory(SETTING), Rig(), POINTS, kind, 20.0)
    assert 0 <= at < 3
    assert deviations == pytest.approx(20.0, rel=0.06) or abs(fault.size) == pytest.approx(LARGEST[kind])


def test_faults_of_records_do_to_a_record_what_they_are_called():
    channels = {"lift": np.linspace(0.0, 1.0, 11), "pressure_a": np.full(11, 2.0), "pressure_b": np.full(11, 3.0)}
    assert Fault("swap", "", 1.0).spoil(channels)["pressure_a"][0] == 3.0
    stuck = Fault("stuck", "lift", 0.3, (0.5,)).spoil(channels)["lift"]
    assert [*stuck[4:9]] == pytest.approx([0.4, 0.5, 0.5, 0.5, 0.8])
    spiky = Fault("spikes", "lift", 5.0, (0.2, 0.9)).spoil(channels)["lift"] - channels["lift"]
    assert [*spiky] == pytest.approx([0, 0, 5, 0, 0, 0, 0, 0, 0, -5, 0])
    assert Fault("drift", "lift", 1.0).spoil(channels)["lift"] == pytest.approx(2.0 * channels["lift"])
    assert Fault("clock", "", 0.01).grid(np.array([1.01])) == pytest.approx(1.0)
    assert channels["lift"][-1] == 1.0  # the record itself is left alone


def test_a_pair_that_is_to_be_confusable_does_nearly_the_same_to_the_data():
    lab, points = Laboratory(SETTING._replace(suite="lift", samples=101)), POINTS[1:2]
    pair = confusable_pair(np.random.default_rng(2), lab, Rig(), points, "leakage_a")
    first, second = (lab.left(Rig(), change_of(LIBRARY[name], 0.1), points, linear=True) for name in pair)
    assert pair[0] != pair[1]
    assert cosine(first, second) > 0.8
    assert "leakage_a" in pair


@pytest.fixture(scope="module")
def faulty(tmp_path_factory):
    """A case with a fault and scatter, and its folder."""
    folder = tmp_path_factory.mktemp("second")
    seed = first_seed(
        lambda plan: (
            plan.fault == "drift" and plan.bench == VALVE and plan.scatter and not plan.clutter and not plan.effects
        )
    )
    return seed, make(seed, folder), folder


@pytest.mark.slow
def test_a_case_can_be_made_again_and_keeps_its_fault_to_one_file(faulty, tmp_path):
    seed, answer, folder = faulty
    assert answer["kind"] == FAULTY and answer["fault"]["deviations"] >= 5.0
    assert "fault" not in (folder / "case" / "measured.toml").read_text()
    case = draw_second(seed)
    assert json.loads(json.dumps(case.answer)) == json.loads((folder / "answer.json").read_text())
    begin = case.rng.bit_generator.state
    for name, changes in (("again", {}), ("without", {"fault": None, "at": -1})):
        case.rng.bit_generator.state = begin
        write(case._replace(**changes), tmp_path / name)
        differ = [
            path.name
            for path in sorted((folder / "case").iterdir())
            if path.read_bytes() != (tmp_path / name / "case" / path.name).read_bytes()
        ]
        assert differ == ([answer["fault"]["file"]] if changes else [])


@pytest.mark.slow
def test_runs_that_scatter_are_told_by_repeats(faulty):
    _, answer, folder = faulty
    measured = tomllib.loads((folder / "case" / "measured.toml").read_text())
    fits = [run for run in measured["run"] if run["role"] == "fit"]
    assert answer["scatter"] and len(fits) > len({run["name"] for run in fits})
    assert ("known_to" in measured) is answer["stated"]
    fine, *others = (run["data"] for run in fits if run["name"] == fits[-1]["name"])
    traces = [np.loadtxt(folder / "case" / file, delimiter=",", skiprows=1) for file in (fine, *others)]
    noise = answer["setting"]["noise"]["scale"]
    assert not np.allclose(traces[0], traces[1], atol=1e-6 * noise)


def scored(kind, said, hidden=(), fault=None, first=(), rest=None, **more):
    """A case of one's own: hidden names with their deviations, and what is said of it."""
    told = [{"name": n, "parameter": "force", "value": 2.0, "unit": "N", "deviations": d} for n, d in hidden]
    deviations = float(np.linalg.norm([d for _, d in hidden]))
    answer = {
        "seed": SECOND,
        "kind": kind,
        "bench": VALVE,
        "hidden": told,
        "fault": fault and {"kind": fault, "name": None if fault == "drift" else fault, "file": "run02.csv"},
        "deviations": deviations,
        "rms": 1.0,
        "class": [name for name, _ in hidden],
        "gap": [],
        "cosine": 0.5,
        "setting": {"suite": "lift", "noise": {"scale": 1.0, "colour": "white"}, "points": []},
    }
    if fault:
        answer["fault"] |= {"deviations": 15.0}
    answer |= more.pop("facts", {})
    effects = [
        {"name": name, "parameter": "force", "value": 2.1, "unit": "N", "interval_95": [1.9, 2.3]} for name in first
    ]
    return Scored(answer, {"verdict": said, "alarm": True, "effects": effects, "rest": rest} | more)


def table(*cases):
    """Counts of all figures."""
    return {one.what: (one.hits, one.cases) for one in figures(cases)}


REST = {
    "verdict": "NAMED",
    "effects": [{"name": "bounce", "parameter": "force", "unit": "N", "interval_95": [1.0, 3.0]}],
}
FILE = ["run02.csv"]


@pytest.mark.parametrize(
    ("said", "more", "pointed", "besides", "right"),
    [
        ("MEASUREMENT", {"files": FILE, "rest": REST}, True, True, True),
        ("MEASUREMENT", {"files": FILE, "rest": {"verdict": "NO_GAP"}}, True, False, False),
        ("MEASUREMENT", {"files": FILE, "rest": {"verdict": "AMBIGUOUS"}}, True, False, True),
        ("MEASUREMENT", {"files": ["run01.csv"], "rest": REST}, False, False, False),
        ("REFUSED", {"reason": "run02.csv alone is wrong"}, True, False, False),
        ("REFUSED", {"odd_channels": [{"file": "run02.csv"}, {"file": "run03.csv"}]}, False, False, False),
        (BAD_INPUT, {"reason": "exit code 2: x/run02.csv: pressure_a: swapped"}, True, False, None),
        ("NO_GAP", {}, False, False, False),
        ("CALIBRATION", {}, False, False, False),
    ],
)
def test_a_faulty_file_is_pointed_at_and_what_is_said_beside_it_judged(said, more, pointed, besides, right):
    one = scored(FAULTY, said, [("bounce", 20.0)], "gain", **more)
    assert (one.pointed, one.besides, one.right) == (pointed, besides, right)
    found = table(one)
    assert found["faulty file pointed at, ≥ 10 sigmas"] == (pointed, 1)
    assert found["the physics beside it right"] == (besides, 1)
    cleared = said in ("NO_GAP", "CALIBRATION")
    assert found["NO_GAP or CALIBRATION, though a fault or an effect of ≥ 10 sigmas is there"] == (cleared, 1)
    assert "| gain |" in report([one], {})


def test_spikes_that_were_masked_and_told_of_may_be_followed_by_no_gap():
    silent = scored(FAULTY, "NO_GAP", fault="spikes")
    told = scored(FAULTY, "NO_GAP", fault="spikes", warnings=["run02.csv: 3 samples masked"])
    assert (silent.right, told.right) == (False, True)
    key = "NO_GAP or CALIBRATION, though a fault or an effect of ≥ 10 sigmas is there"
    assert table(silent, told)[key] == (1, 2)
    assert not scored(FAULTY, "NO_GAP", fault="drift", warnings=["run02.csv: 3 samples masked"]).right


def test_a_calibration_is_right_of_a_number_that_is_off_and_where_nothing_else_is():
    blames = {"nuisances": [{"key": "supply.pressure"}]}
    for pull, right in ((3.0, True), (1.0, False)):
        facts = {"pulls": {"supply.pressure": pull}}
        assert scored(NONE, "CALIBRATION", facts=facts, **blames).right is right
        assert not scored(SINGLE, "CALIBRATION", [("bounce", 30.0)], facts=facts, **blames).right


def test_a_name_beside_a_number_that_is_wrong_is_right_where_the_number_is_off():
    numbers = [{"key": "supply.pressure", "name": "supply.pressure"}]
    for pull, right in ((5.0, True), (1.0, False)):
        facts = {"pulls": {"supply.pressure": pull}}
        one = scored(SINGLE, "NAMED", [("bounce", 30.0)], first=["bounce"], facts=facts, numbers=numbers)
        assert one.right is right
        assert one.is_there(["supply.pressure"]) is right


def test_a_name_of_a_geometry_that_is_off_is_a_name_where_nothing_is_hidden_and_yet_not_wrong():
    for size, right in ((7.0, True), (3.0, False)):
        facts = {"geometry": {"deviations": size, "by": {"valve.clearance_volume": size}}}
        one = scored(NONE, "NAMED", first=["dead_volume"], facts=facts)
        assert one.right is right
        assert table(one)["names given, nothing hidden"] == (1, 1)


THREE = [("bounce", 20.0), ("side_force", 15.0), ("leakage_a", 12.0)]


@pytest.mark.parametrize(
    ("said", "first", "reason", "counts"),
    [
        ("SEVERAL", ["bounce", "side_force", "leakage_a"], "", True),
        ("TWO_EFFECTS", ["bounce", "side_force"], "", False),
        ("REFUSED", ["bounce", "side_force"], "what the best explanation leaves is more than noise", True),
        ("REFUSED", ["bounce", "slow_ramp"], "what the best explanation leaves is more than noise", False),
        ("SEVERAL", ["bounce", "side_force", "slow_ramp"], "", False),
    ],
)
def test_three_at_once_count_where_all_are_named_or_two_and_that_more_is_left(said, first, reason, counts):
    one = scored(TRIPLE, said, THREE, first=first, reason=reason)
    assert table(one)["three at once, or two and that more is left"] == (counts, 1)


def test_confusable_pairs_and_near_foreigners_are_strata():
    pairs = [
        scored(DOUBLE, "TWO_EFFECTS", THREE[:2], first=["bounce", "side_force"], facts={"cosine": c})
        for c in (0.95, 0.3)
    ]
    near = scored(FOREIGNER, "NAMED", [("snag", 20.0)], first=["bounce"], facts={"near": True})
    found = table(*pairs, near)
    assert found["both named, both ≥ 10 sigmas, cosine above 0.9"] == (1, 1)
    assert found["both named, both ≥ 10 sigmas, cosine below 0.9"] == (1, 1)
    assert found["outside the library, but near it: not named"] == (0, 1)
    assert near.wrong


def test_no_gap_of_a_pair_is_wrong_where_the_pair_is_plain_though_its_smaller_effect_is_not():
    assert not scored(DOUBLE, "NO_GAP", [("bounce", 40.0), ("side_force", 6.0)]).right
    masking = scored(DOUBLE, "NO_GAP", [("bounce", 40.0), ("side_force", 40.0)], facts={"deviations": 3.0})
    assert masking.right


def test_a_class_is_right_where_one_of_its_effects_alone_would_leave_nothing_that_is_seen():
    hidden, cosine = [("bounce", 30.0), ("side_force", 10.0)], {"cosine": 0.96}
    alone = scored(DOUBLE, "NAMED", hidden, first=["side_force"], facts=cosine)
    assert not alone.right  # 8 sigmas of the other one are left
    other, third = ["side_force", "bounce"], ["side_force", "blow_by"]
    for members, right in ((other, True), (third, False)):
        told = {"facts": cosine, "class": members}
        assert scored(DOUBLE, "NAMED_CLASS", hidden, first=members[:1], **told).right is right
    assert scored(SINGLE, "NAMED_CLASS", hidden[:1], first=["side_force"], **{"class": other}).right


def test_intervals_of_strengths_and_of_second_parameters_are_counted_apart():
    effects = [
        {"name": "supply_droop", "parameter": "feed_area", "unit": "mm^2", "interval_95": [4.5, 5.0]},
        {"name": "supply_droop", "parameter": "volume", "unit": "L", "interval_95": [0.05, 0.4]},
    ]
    one = scored(SINGLE, "NAMED", [("supply_droop", 20.0)], effects=effects)
    (told,) = one.answer["hidden"]
    told |= {
        "parameter": "feed_area",
        "value": 4.0,
        "unit": "mm^2",
        "parameters": {"feed_area": 4e-6, "volume": 0.1e-3},
    }
    assert (one.intervals, one.second_intervals) == ([False], [True])


def test_stated_probabilities_are_held_against_what_is_so():
    inclusion = {"bounce": 0.9, "side_force": 0.2}
    one = scored(SINGLE, "NAMED", [("bounce", 20.0)], first=["bounce"], probability=0.8, inclusion=inclusion)
    assert one.statements == [(0.8, True), (0.9, True), (0.2, False)]
    assert scored(REMOVED, "REFUSED", [("bounce", 20.0)], inclusion={"bounce": 0.9}).statements == [(0.9, False)]
    assert scored(NONE, "NO_GAP", probability=None).statements == []
    assert brier([(0.8, True), (0.2, True)]) == pytest.approx(0.5 * (0.04 + 0.64))
