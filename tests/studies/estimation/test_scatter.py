"""Scatter between runs: how much repeats tell of it, and that what it does is white afterwards."""

import numpy as np
import pytest
from scipy.stats import norm, t

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.estimation import scatter as scatters
from apesim.studies.estimation.calibration import calibrate, uncalibrated
from apesim.studies.estimation.scatter import Scatter, find_spread, find_spreads, find_stated_scatter, identify
from apesim.studies.estimation.scatter_sizes import (
    ODD_CHANCE,
    Contrast,
    find_lone,
    find_relief,
    find_sizes,
    list_contrasts,
)
from apesim.studies.measured import Measured, MeasuredRun
from apesim.studies.measured.prediction import predict, run_of, with_value

SLOPES = np.array([[12.0, 5.0], [0.0, 9.0]])


def run(data, values, name="p040"):
    channels = {"lift": np.asarray(values, dtype=float)}
    return MeasuredRun(name, data, 0.5e6, 287.0, 50e-3, "fit", np.arange(len(values)) * 1e-3, channels)


def draw(rng, sizes, number):
    """Contrasts of numbers that scatter by sizes."""
    noise = rng.normal(size=(number, 2))
    shifts = rng.normal(size=(number, 2)) * sizes
    return [
        Contrast((f"{i}a.csv", f"{i}b.csv"), SLOPES @ shift + own, SLOPES)
        for i, (shift, own) in enumerate(zip(shifts, noise, strict=True))
    ]


def test_what_scatters_is_white_once_whitened():
    rng = np.random.default_rng(1)
    columns = rng.normal(size=(6, 2)) * (3.0, 1.0)
    one = run("a.csv", np.zeros(6))
    scatter = Scatter(("a", "b"), (1.0, 1.0), 3, {identify(one): find_spread(columns)})
    whitening = scatter.whiten(identify(one), np.eye(6))
    covariance = whitening @ (np.eye(6) + columns @ columns.T) @ whitening.T
    assert covariance == pytest.approx(np.eye(6), abs=1e-12)


def test_a_run_of_which_nothing_is_known_stays_as_it_is():
    scatter = Scatter(("a",), (1.0,), 3, {identify(run("a.csv", np.zeros(2))): find_spread(np.ones((2, 1)))})
    rows = np.array([[1.0], [2.0]])
    assert scatter.whiten(identify(run("b.csv", np.zeros(2))), rows) is rows


def test_sizes_are_found_where_many_repeats_tell_them_and_reach_as_far_as_heavy_tails():
    sizes, kept = find_sizes(draw(np.random.default_rng(2), (0.3, 0.1), 100))
    assert len(kept) == 100
    assert sizes / (t.ppf(0.975, 4.0) / norm.ppf(0.975)) == pytest.approx([0.3, 0.1], rel=0.2)


def test_noise_alone_is_no_scatter():
    rng = np.random.default_rng(3)
    found = [find_sizes(draw(rng, (0.0, 0.0), 4))[0].any() for _ in range(30)]
    assert np.mean(found) < 0.05


def test_where_repeats_do_not_say_which_number_scatters_it_is_the_one_that_need_not_scatter_much():
    """Both move the samples alike, one of them ten times as much for what is known of it."""
    rng, slopes = np.random.default_rng(4), np.array([[30.0, 3.0]])
    contrasts = [Contrast(("a", "b"), 9.0 * rng.normal(size=1), slopes) for _ in range(20)]
    large, small = find_sizes(contrasts)[0]
    assert 0.3 < large < 0.6
    assert small < 2.0  # what is known of it, with heavy tails


def test_few_repeats_leave_a_size_open_up_to_what_is_known_of_it():
    one = Contrast(("a", "b"), SLOPES @ (0.5, 0.1), SLOPES)
    few, many = (find_sizes([one] * number)[0] for number in (1, 30))
    assert few[1] > 3.0 * many[1]  # 30 that are alike say that the second hardly scatters
    assert np.all(few < 2.0)


@pytest.mark.parametrize("number", [2, 6])
def test_a_repeat_that_scatter_does_not_explain_tells_nothing_of_it(number):
    contrasts = draw(np.random.default_rng(5), (0.3, 0.1), number)
    sound = find_sizes(contrasts)[0]
    odd = Contrast(("x.csv", "y.csv"), SLOPES @ (30.0, 0.0), SLOPES)
    sizes, kept = find_sizes([*contrasts, odd])
    assert [each.files for each in kept] == [each.files for each in contrasts]
    assert sizes == pytest.approx(sound)


@pytest.mark.slow
def test_heavy_tails_are_no_fault_of_a_file():
    rng, left_out = np.random.default_rng(9), 0
    for _ in range(40):
        tails = rng.standard_t(4.0, size=(8, 2)) / np.sqrt(2.0)
        drawn = [Contrast(("a", "b"), SLOPES @ (tail * (0.3, 0.1)) + rng.normal(size=2), SLOPES) for tail in tails]
        left_out += len(find_sizes(drawn)[1]) < 8
    assert left_out <= 40 * ODD_CHANCE


def test_what_repeats_have_in_common_is_in_no_contrast():
    rng = np.random.default_rng(6)
    runs = [run(f"{i}.csv", rng.normal(size=8)) for i in range(3)] + [run("other.csv", np.zeros(8), "p050")]
    columns = [9.0 * rng.normal(size=(8, 2))] * 4
    errors = [each.channels["lift"] for each in runs]
    found = list_contrasts(runs, errors, columns)
    moved = list_contrasts(runs, [each + np.arange(8.0) for each in errors], columns)
    assert [each.files for each in found] == [("0.csv", "1.csv"), ("0.csv", "1.csv", "2.csv")]
    for one, other in zip(found, moved, strict=True):
        assert one.values == pytest.approx(other.values)


def test_a_run_that_lies_far_off_is_as_likely_as_by_students_t():
    for far in (0.0, 2.0, 6.0):
        scale = norm.ppf(0.975) / t.ppf(0.975, 4.0)  # both reach as far
        wanted = 2.0 * (t.logpdf(far, 4.0, scale=scale) - norm.logpdf(far))
        assert find_relief(np.array([far]), np.array([1.0])) == pytest.approx(wanted, abs=0.02 + 0.01 * abs(wanted))
    assert find_relief(np.array([6.0]), np.array([0.0])) == pytest.approx(0.0, abs=1e-12)  # noise has no heavy tails


DEAD_TIME = "valve.solenoid.dead_time"
KNOWN = Scatter((DEAD_TIME,), (0.3,), 5, {})
TIMES = np.arange(0.0, 0.05, 5e-5)


def lift_of(late, name="p040", noise=1e-5):
    """A run of the default valve whose dead time is longer than the machine says [s]."""
    machine = with_value(Machine(), DEAD_TIME, Machine().valve.solenoid.dead_time + late)
    one = MeasuredRun(name, f"{name}.csv", 0.5e6, 293.15, 30e-3, "fit", TIMES, {"lift": 0.0 * TIMES})
    lift = predict(run_of(machine, one), one).channels["lift"]
    lift = lift + noise * np.random.default_rng(7).standard_normal(len(TIMES))
    return one._replace(channels={"lift": lift})


def left_of(scatter, residuals):
    """Root mean square of what is left of the white samples of one run."""
    x = np.zeros(len(residuals.parameters))
    errors = residuals.with_scatter(scatter).at(x)[: len(TIMES)]
    return float(np.sqrt(np.mean(errors**2)))


def test_a_run_far_from_the_others_is_white_about_where_its_own_scatter_has_moved_it(monkeypatch):
    late = lift_of(1.2e-4)  # four standard deviations of the scatter, and a jump of the lift by 0.3 mm at the stops
    residuals, _ = uncalibrated(Machine(), Measured("", {"lift": 1e-5}, (late,), "valve"))
    x = np.zeros(len(residuals.parameters))
    spreads = find_spreads(residuals, x, KNOWN)
    (spread,) = spreads.values()
    assert spread.moves == pytest.approx([1.2], abs=0.02)  # of 0.1 ms
    assert left_of(KNOWN._replace(spreads=spreads), residuals) == pytest.approx(1.0, abs=0.05)
    monkeypatch.setattr(scatters, "ROUNDS", 0)
    assert left_of(KNOWN._replace(spreads=find_spreads(residuals, x, KNOWN)), residuals) > 1.1  # 6 sigmas


@pytest.mark.slow
def test_a_size_that_is_stated_stays_and_the_other_is_told_beside_it():
    drawn = draw(np.random.default_rng(2), (0.3, 0.1), 100)
    free, _ = find_sizes(drawn)
    sizes, _ = find_sizes(drawn, np.array([np.nan, free[1]]))
    assert sizes == pytest.approx(free, rel=0.05)
    assert sizes[1] == free[1]


@pytest.mark.slow
def test_beside_what_is_stated_noise_alone_is_no_further_scatter():
    rng = np.random.default_rng(3)
    stated = np.array([np.nan, 0.1])
    found = [find_sizes(draw(rng, (0.0, 0.1), 4), stated)[0] for _ in range(30)]
    assert np.mean([sizes[0] > 0.0 for sizes in found]) < 0.05
    assert {sizes[1] for sizes in found} == {0.1}


def test_one_pair_of_repeats_is_judged_by_a_scatter_that_is_stated():
    stated, pair = np.array([0.3, 0.1]), Contrast(("a.csv", "b.csv"), SLOPES @ [0.4, 0.1], SLOPES)
    assert find_sizes([pair], stated)[1] == [pair]
    far = pair._replace(values=SLOPES @ [40.0, 0.0])
    assert find_sizes([far], stated)[1] == []
    assert len(find_sizes([far], np.array([0.3, np.nan]))[1]) == 1  # nothing else would tell the other size


def test_sensitivities_whitened_by_a_scatter_are_those_that_are_found_with_it():
    measured = Measured("", {"lift": 1e-5}, (lift_of(4e-5), lift_of(-4e-5, "p050")), "valve")
    residuals, _ = uncalibrated(Machine(), measured)
    x = np.zeros(len(residuals.parameters))
    jacobian, _ = residuals.jacobian(x, residuals.at(x))
    scatter = find_stated_scatter(residuals, jacobian, {DEAD_TIME: 0.3})
    again = residuals.with_scatter(scatter)
    found, _ = again.jacobian(x, again.at(x))
    n = len(found) - len(x)
    changed = residuals.change_scatter(jacobian[:n], scatter)
    assert changed == pytest.approx(found[:n], abs=1e-9)
    assert abs(changed - jacobian[:n]).max() > 1.0


def test_a_stated_scatter_needs_no_repeats():
    stated = {DEAD_TIME: Uncertainty(0.03e-3)}
    measured = Measured("", {"lift": 1e-5}, (lift_of(4e-5), lift_of(-4e-5, "p050")), "valve", scatter=stated)
    scatter = calibrate(Machine(), measured)[0].residuals.scatter
    assert dict(zip(scatter.keys, scatter.sizes, strict=True))[DEAD_TIME] == pytest.approx(0.3)  # of 0.1 ms
    assert scatter.stated == (DEAD_TIME,)
    assert set(scatter.spreads) == {identify(run) for run in measured.runs}


@pytest.mark.parametrize(
    "known_to, machine, right",
    [
        ({DEAD_TIME: Uncertainty(0.0)}, Machine(), "counts as exact by [known_to]; leave one of both out"),
        ({}, with_value(Machine(), DEAD_TIME, 0.0), "is a share of 0; write a number of ms"),
    ],
)
def test_a_scatter_of_what_cannot_scatter_is_refused(known_to, machine, right):
    stated = {DEAD_TIME: Uncertainty(0.02, True)}
    measured = Measured("folder", {}, (lift_of(0.0),), "valve", known_to=known_to, scatter=stated)
    with pytest.raises(InputError) as caught:
        calibrate(machine, measured)
    assert str(caught.value) == f"folder/measured.toml: scatter.{DEAD_TIME}: {right}"


def test_what_more_repeats_have_told_of_a_scatter_is_taken_where_few_are_left():
    measured = Measured("", {"lift": 1e-5}, (lift_of(4e-5), lift_of(-4e-5, "p050")), "valve")
    assert calibrate(Machine(), measured)[0].residuals.scatter is None  # no run is repeated
    scatter = calibrate(Machine(), measured, known=KNOWN)[0].residuals.scatter
    assert scatter.sizes == KNOWN.sizes
    assert set(scatter.spreads) == {identify(run) for run in measured.runs}


def test_a_repeat_that_the_others_do_not_explain_is_told():
    early = [lift_of(late, name) for name in ("p040", "p050") for late in (4e-5, -3e-5, 0.0)]
    runs = [each._replace(data=f"{number}.csv") for number, each in enumerate(early)]
    runs[-1] = lift_of(1e-3, "p050")._replace(data="late.csv")
    model, warnings = calibrate(Machine(), Measured("", {"lift": 1e-5}, tuple(runs), "valve"))
    assert model.residuals.scatter.odd == (("3.csv", "4.csv", "late.csv"),)
    assert [text for text in warnings if text.startswith("late.csv differs from 3.csv and 4.csv")]


@pytest.mark.parametrize("size", [0.1, 0.3, 1.0])
def test_scatter_itself_is_seldom_one_set_of_repeats_that_is_far_apart(size):
    rng = np.random.default_rng(5)
    assert np.mean([bool(find_lone(draw(rng, size, 4))) for _ in range(300)]) < 0.05


def test_one_set_of_repeats_that_is_far_apart_is_told_though_scatter_may_explain_it():
    late = {"p040": 0.0, "p050": 0.0, "p060": 4e-5}
    runs = [
        lift_of(shift, name)._replace(data=f"{name}_{number}.csv")
        for name, far in late.items()
        for number, shift in enumerate((0.0, far))
    ]
    model, warnings = calibrate(Machine(), Measured("", {"lift": 1e-5}, tuple(runs), "valve"))
    assert model.residuals.scatter.lone == ("p060_0.csv", "p060_1.csv")
    assert [text for text in warnings if text.startswith("p060_0.csv and p060_1.csv differ by far more")]
    left = calibrate(Machine(), Measured("", {"lift": 1e-5}, tuple(runs[:4]), "valve"), known=model.residuals.scatter)[
        0
    ]
    assert left.residuals.scatter.lone == ()
