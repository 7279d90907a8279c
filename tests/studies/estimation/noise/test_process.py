"""The noise of measured channels."""

from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from apesim.studies.estimation.noise.estimation import (
    AT_REST,
    TAKEN_FOR_WHITE,
    from_what_nothing_explains,
    hum_of_what_nothing_explains,
    may_hum,
    noise_of,
)
from apesim.studies.estimation.noise.hum import Records, mains_in, with_hum
from apesim.studies.estimation.noise.process import (
    Whitening,
    autoregressive,
    beside,
    drifting,
    levinson,
    noise_for,
    sines,
    white,
)
from apesim.studies.estimation.residuals import Block

DEVIATION = 3e-5
TURN = 2.0 * np.pi

FILES = count()


def process(rng, n, *weights):
    """Autoregressive noise of standard deviation `DEVIATION`, settled."""
    long = lfilter([1.0], np.append(1.0, -np.array(weights)), rng.normal(size=n + 500))
    first, second = (*weights, 0.0, 0.0)[:2]
    variance = (1.0 - second) / (1.0 + second) / ((1.0 - second) ** 2 - first**2)
    return DEVIATION * long[500:] / np.sqrt(variance)


def run(name, role):
    """A run in a file of its own."""
    return SimpleNamespace(name=name, role=role, file=f"{next(FILES)}.csv")


def block(values, times, name="p040", sensor="lift", role="fit"):
    return Block(0, run(name, role), sensor, times, values, float(np.median(np.diff(times))))


def test_levinson_solves_the_equations_of_yule_and_walker():
    correlation = np.array([1.0, 0.8, 0.5, 0.3])
    predictors, spread = levinson(correlation)
    matrix = np.array([[correlation[abs(i - j)] for j in range(3)] for i in range(3)])
    weights = np.linalg.solve(matrix, correlation[1:])
    assert predictors[3] == pytest.approx(weights)
    assert spread[3] ** 2 == pytest.approx(1.0 - weights @ correlation[1:])


def test_the_colour_of_noise_is_found():
    rng = np.random.default_rng(1)
    found = autoregressive([process(rng, 4000, 1.2, -0.5) for _ in range(3)], "")
    assert found.order == 2
    assert found.predictors[-1] == pytest.approx([1.2, -0.5], abs=0.05)
    assert found.deviation == pytest.approx(DEVIATION, rel=0.05)


def test_white_noise_has_no_colour():
    rng = np.random.default_rng(2)
    assert autoregressive([rng.normal(size=1000) for _ in range(5)], "").order == 0


def test_whitened_noise_is_white_from_the_first_sample_on():
    rng = np.random.default_rng(3)
    records = np.array([process(rng, 40, 0.9) for _ in range(4000)]).T
    found = autoregressive(list(records.T), "")
    bare = Whitening(found, np.arange(40.0)).whiten(records)
    covariance = bare @ bare.T / records.shape[1]
    assert covariance == pytest.approx(np.eye(40), abs=0.1)


@pytest.mark.parametrize("missing", [(40,), (3, 17, 18, 19, 50, 90), tuple(range(1, 100, 5)), tuple(range(30, 60))])
def test_noise_with_missing_samples_is_white_once_whitened(missing):
    noise = autoregressive([process(np.random.default_rng(1), 4000, 0.9, -0.5)], "repeats")
    places = np.setdiff1d(np.arange(100), missing)
    # The covariance of the process is that which whitening all of its samples takes off.
    filters = Whitening(noise, np.arange(100.0)).whiten(np.eye(100))
    covariance = np.linalg.inv(filters.T @ filters)[np.ix_(places, places)]
    rows = Whitening(noise, 5e-5 * places).whiten(np.eye(len(places)))
    assert rows @ covariance @ rows.T == pytest.approx(np.eye(len(places)), abs=1e-3)


def test_hum_of_a_record_with_missing_samples_is_taken_off():
    noise = process(np.random.default_rng(2), 2000, 0.6)
    known = autoregressive([noise], "repeats")._replace(hums=((50.0, 1e-4),))
    times = 5e-5 * np.delete(np.arange(2000), [100, 700, 701])
    wave = 1e-4 * np.sin(TURN * 50.0 * times)
    left = Whitening(known, times).whiten((np.delete(noise, [100, 700, 701]) + wave)[:, None])
    assert np.std(left) == pytest.approx(1.0, abs=0.05)
    assert np.std(Whitening(known._replace(hums=()), times).whiten(wave[:, None])) > 0.5


def test_hum_is_found_and_joins_the_covariance():
    rng = np.random.default_rng(4)
    times = np.arange(0.0, 0.1, 1e-4)
    records = []
    for _ in range(6):
        hum = 1.5 * DEVIATION * sines(50.0, times + rng.uniform()) @ [1.0, 0.0]
        records.append([(DEVIATION * rng.normal(size=len(times)) + hum, times)])
    channel = Records(records, "", [], False, np.nan)
    found = with_hum(channel, mains_in([channel]))
    ((frequency, size),) = found.hums
    assert frequency == 50.0
    assert size == pytest.approx(1.5 * DEVIATION / np.sqrt(2.0), rel=0.2)
    assert found.deviation == pytest.approx(DEVIATION, rel=0.05)
    bare = np.concatenate([Whitening(found, t).whiten(values[:, None])[:, 0] for ((values, t),) in records])
    assert np.mean(bare**2) == pytest.approx(1.0, abs=0.06)
    # A sine of the mains hardly counts any more, another frequency as before.
    mains, other = (Whitening(found, times).whiten(DEVIATION * sines(f, times)[:, :1]) for f in (50.0, 170.0))
    assert np.linalg.norm(mains) < 0.1 * np.linalg.norm(other)


@pytest.mark.parametrize("weights", [(), (0.9,)])
def test_noise_without_hum_has_none(weights):
    rng = np.random.default_rng(5)
    times = np.arange(0.0, 0.1, 1e-4)
    for _ in range(20):
        records = [[(process(rng, len(times), *weights), times)] for _ in range(4)]
        assert mains_in([Records(records, "", [], False, np.nan)]) == ()


def test_noise_comes_from_repeats_even_where_the_model_is_wrong():
    rng = np.random.default_rng(6)
    times = np.linspace(0.0, 0.1, 1001)
    gap = 1e-3 * np.sin(300.0 * times)
    blocks = [block(gap + process(rng, 1001, 0.7), times) for _ in range(3)]
    found, warnings = noise_of(blocks, [np.zeros(1001)] * 3, {})
    noise = noise_for(found, blocks[0])
    assert noise.source == "repeats"
    assert noise.deviation == pytest.approx(DEVIATION, rel=0.1)
    assert noise.predictors[-1] == pytest.approx([0.7], abs=0.06)
    assert not warnings


@pytest.mark.parametrize("late", [0.0, 1e-3])
def test_what_scatters_between_repeats_is_no_coloured_noise(late):
    """Strokes that begin and take a little longer or shorter, of a model that may be a millisecond late."""
    rng, times = np.random.default_rng(21), np.linspace(0.0, 0.1, 1001)

    def stroke(start, length):
        return 9e-3 * (0.5 + 0.5 * np.tanh((times - start) / length))

    ways = [stroke(0.02 + 5e-5 * shift, 3e-3 * (1.0 + 0.02 * slow)) for shift, slow in rng.normal(size=(4, 2))]
    blocks = [block(way + DEVIATION * rng.normal(size=1001), times) for way in ways]
    (noise,) = noise_of(blocks, [stroke(0.02 + late, 3e-3)] * 4, {})[0]["lift"].values()
    assert noise.order == 0
    assert noise.deviation == pytest.approx(DEVIATION, rel=0.1)


def test_changes_that_a_simulation_foretells_are_taken_off_repeats():
    rng, times = np.random.default_rng(22), np.linspace(0.0, 0.1, 1001)
    change = np.exp(-(((times - 0.07) / 5e-3) ** 2))
    blocks = [block(size * change + DEVIATION * rng.normal(size=1001), times) for size in (0.0, 3e-4, -2e-4)]
    model = [np.zeros(1001)] * 3
    before, after = (noise_of(blocks, model, {}, changes)[0]["lift"] for changes in ((), [change[:, None]] * 3))
    assert next(iter(before.values())).deviation > 1.5 * DEVIATION
    assert next(iter(after.values())).deviation == pytest.approx(DEVIATION, rel=0.1)


def test_without_repeats_it_comes_from_stretches_at_rest():
    rng = np.random.default_rng(7)
    times = np.linspace(-0.02, 0.1, 1201)
    model = np.clip((times - 0.02) / 0.01, 0.0, 1.0) * 9e-3
    wrong = np.clip((times - 0.021) / 0.01, 0.0, 1.0) * 9e-3
    blocks = [block(wrong + process(rng, 1201, 0.5), times, name) for name in "abc"]
    noise = noise_for(noise_of(blocks, [model] * 3, {})[0], blocks[0])
    assert noise.source == "stretches at rest"
    assert noise.deviation == pytest.approx(DEVIATION, rel=0.1)
    assert noise.predictors[-1] == pytest.approx([0.5], abs=0.08)


def test_a_stated_deviation_binds_and_a_contradiction_is_told():
    rng = np.random.default_rng(8)
    times = np.linspace(0.0, 0.1, 1001)
    blocks = [block(process(rng, 1001), times) for _ in range(2)]
    found, warnings = noise_of(blocks, [np.zeros(1001)] * 2, {"lift": 2.0 * DEVIATION})
    assert noise_for(found, blocks[0]).deviation == 2.0 * DEVIATION
    assert len(warnings) == 1 and "lift" in warnings[0]


@pytest.mark.parametrize("is_rest", [False, True])
def test_beside_a_stated_deviation_the_colour_is_one_by_which_new_noise_is_white(is_rest):
    rng, sizes = np.random.default_rng(8), []
    times = np.linspace(0.0, 0.1, 361)
    new = process(rng, 20_000, 0.9)[:, None]
    for _ in range(40):
        blocks = [block(process(rng, 361, 0.9), times, name) for name in ("ab" if is_rest else "aa")]
        found, _ = noise_of(blocks, [np.zeros(361)] * 2, {"lift": DEVIATION})
        noise = noise_for(found, blocks[0])
        assert noise.deviation == DEVIATION and noise.is_stated
        sizes.append(np.mean(Whitening(noise, np.arange(20_000.0)).whiten(new) ** 2))
    assert np.std(sizes) < 0.11  # by the samples' own correlations 0.2 and more
    assert np.mean(sizes) == pytest.approx(1.0, abs=0.05)


def test_what_data_without_noise_show_is_not_the_colour_of_the_one_that_is_stated():
    times = np.linspace(0.0, 0.1, 1001)
    blocks = [block(1e-9 * np.sin(3.0 * np.pi * times / 0.1 + phase), times) for phase in (0.0, 1.0)]
    found, warnings = noise_of(blocks, [np.zeros(1001)] * 2, {"lift": DEVIATION})
    noise = noise_for(found, blocks[0])
    assert (noise.deviation, noise.order, noise.hums) == (DEVIATION, 0, ())
    assert "show" in warnings[0]


def mean(value, name):
    return Block(0, run(name, "fit"), "torque", np.zeros(1), np.array([value]), 0.0)


def test_the_noise_of_a_mean_is_stated_or_from_repeats_or_taken_for_a_share():
    rng = np.random.default_rng(9)
    blocks = [mean(level + 0.3 * rng.normal(), f"{level}") for level in range(20, 60) for _ in range(2)]
    model = [np.zeros(1)] * len(blocks)
    known, warnings = noise_of(blocks, model, {})
    assert noise_for(known, blocks[0]).deviation == pytest.approx(0.3, rel=0.25)
    assert not warnings
    assert noise_for(noise_of(blocks, model, {"torque": 0.5})[0], blocks[0]).deviation == 0.5
    taken, warnings = noise_of(blocks[:1], model[:1], {})
    assert noise_for(taken, blocks[0]).deviation == pytest.approx(1.0, rel=0.1)  # 5 % of 20 N m
    assert "[sensor.torque]" in warnings[0]


def test_noise_is_that_of_the_nearest_sampling_interval():
    found = {"lift": {1e-4: white(1.0, "fine"), 1e-3: white(2.0, "coarse")}}
    times = np.arange(100) * 8e-4
    assert noise_for(found, block(np.zeros(100), times)).source == "coarse"


def test_hum_that_repeats_do_not_differ_by_is_seen_at_rest():
    rng = np.random.default_rng(10)
    times = np.arange(0.0, 0.1, 2e-4)
    hum = 1.5 * DEVIATION * sines(50.0, times)[:, 0]
    repeats = [block(hum + DEVIATION * rng.normal(size=len(times)), times) for _ in range(2)]
    found, _ = noise_of(repeats, [np.zeros(len(times))] * 2, {})
    (noise,) = found["lift"].values()
    assert (noise.source, [frequency for frequency, _ in noise.hums]) == ("repeats", [50.0])
    assert noise.deviation == pytest.approx(DEVIATION, rel=0.1)


def test_where_a_sensor_hums_at_one_sampling_interval_it_hums_at_all():
    rng = np.random.default_rng(11)
    fine, coarse = np.arange(0.0, 0.1, 2e-4), np.arange(0.0, 0.1, 1e-3)
    blocks = [
        block(
            sines(50.0, times + rng.uniform()) @ [size * DEVIATION, 0.0] + DEVIATION * rng.normal(size=len(times)),
            times,
        )
        for times, size in ((fine, 1.5), (coarse, 0.3))
    ]
    found, _ = noise_of(blocks, [np.zeros(len(one.values)) for one in blocks], {})
    assert all(50.0 in dict(noise.hums) for noise in found["lift"].values())


def test_drifts_take_nothing_off_the_colour_of_noise():
    rng, found = np.random.default_rng(12), []
    for _ in range(60):
        stretches = [process(rng, 50, 0.9) + rng.normal() + rng.normal() * np.linspace(0.0, 1.0, 50) for _ in range(6)]
        found.append(drifting(stretches, ""))
    assert [noise.order for noise in found].count(1) >= 57
    assert np.mean([noise.predictors[1][0] for noise in found]) == pytest.approx(0.9, abs=0.02)
    assert np.median([noise.deviation for noise in found]) == pytest.approx(DEVIATION, rel=0.1)


@pytest.mark.parametrize(("samples", "apart", "records"), [(55, 90, 4), (25, 20, 4), (30, 20, 2)])
def test_what_is_taken_off_short_stretches_gives_white_noise_no_colour(samples, apart, records):
    rng, found = np.random.default_rng(16), []
    times = np.arange(2 * samples + apart) * 5e-4
    for _ in range(60):
        hums = [rng.normal(size=len(times)) + 0.6 * np.sin(TURN * 50.0 * times + rng.normal()) for _ in range(records)]
        rests = [[(one[:samples], times[:samples]), (one[-samples:], times[-samples:])] for one in hums]
        found.append(with_hum(Records(rests, AT_REST, [], True, np.nan), (50.0,)))
    assert [noise.order for noise in found].count(0) >= 57
    assert np.sqrt(np.mean([noise.deviation**2 for noise in found])) == pytest.approx(1.0, abs=0.03)


def test_the_colour_is_the_one_that_goes_with_a_stated_deviation():
    rng = np.random.default_rng(13)
    stretches = [process(rng, 40, 0.9) for _ in range(2)]
    found = [drifting(stretches, "", stated=factor * DEVIATION).predictors[1][0] for factor in (0.5, 1.0, 2.0)]
    assert found == sorted(found)
    assert found[0] < found[1] - 0.02


def test_white_noise_on_drifts_is_as_strong_as_it_is():
    rng = np.random.default_rng(14)
    found = [drifting([rng.normal(size=20) + i for i in range(10)], "").deviation for _ in range(200)]
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(1.0, abs=0.015)


def test_where_nothing_tells_the_colour_it_is_that_at_the_nearest_sampling_interval():
    rng = np.random.default_rng(15)
    fitted, gate = np.arange(0.0, 0.1, 1e-4), np.arange(0.0, 0.06, 6e-5)
    values = process(rng, len(fitted), 0.8)
    known = {"lift": {1e-4: white(DEVIATION, TAKEN_FOR_WHITE), 6e-5: white(0.5 * DEVIATION, TAKEN_FOR_WHITE)}}
    one = block(values, fitted)
    noise = from_what_nothing_explains([one], known, [values], [np.ones((len(values), 1))])
    assert not any(n.order for n in known["lift"].values())  # what was given stays as it is
    assert noise_for(noise, one).predictors[-1] == pytest.approx([0.8], abs=0.06)
    other = noise_for(noise, block(np.zeros(len(gate)), gate))
    assert other.predictors == noise_for(noise, one).predictors
    assert other.deviation == noise_for(noise, one).deviation


@pytest.mark.parametrize("correlation", [0.5, 0.9])
def test_slow_columns_that_are_taken_off_take_nothing_off_the_colour(correlation):
    """What a library's columns leave of noise has less at low frequencies, and is taken for whiter than it is."""
    rng = np.random.default_rng(19)
    waves = [TURN * k * np.linspace(0.0, 1.0, 360) for k in range(20)]
    slow = np.column_stack([turn(wave) for wave in waves for turn in (np.cos, np.sin)])
    columns = [slow @ rng.normal(size=(40, 40)) for _ in range(3)]
    base = np.linalg.qr(np.vstack(columns))[0]

    def found():
        noise = np.concatenate([process(rng, 360, correlation) for _ in columns])
        left = np.split(noise - base @ (base.T @ noise), 3)
        return beside(left, columns, ""), autoregressive(left, "")

    def at_low_frequencies(noise):
        return noise.deviation * noise.spread[-1] / (1.0 - noise.predictors[-1].sum())

    right = DEVIATION * np.sqrt(1.0 - correlation**2) / (1.0 - correlation)
    many = np.array([[at_low_frequencies(noise) for noise in found()] for _ in range(40)]) / right
    aware, unaware = np.median(many, axis=0)
    assert aware == pytest.approx(1.0, abs=0.05)
    assert unaware < 0.9


def test_white_noise_beside_columns_is_as_strong_as_it_is():
    rng = np.random.default_rng(20)
    columns = [rng.normal(size=(120, 30)) for _ in range(2)]
    base = np.linalg.qr(np.vstack(columns))[0]
    noises = [rng.normal(size=240) for _ in range(200)]
    found = [beside(np.split(one - base @ (base.T @ one), 2), columns, "") for one in noises]
    assert [one.order for one in found].count(0) > 180
    assert np.sqrt(np.mean([one.deviation**2 for one in found])) == pytest.approx(1.0, abs=0.01)


def test_where_records_are_too_short_to_tell_the_mains_both_are_taken_off():
    rng = np.random.default_rng(16)
    times = np.arange(0.0, 0.03, 1e-4)
    hum = 0.6 * DEVIATION * sines(50.0, times + rng.uniform())[:, 0]
    channel = Records([[(hum + DEVIATION * rng.normal(size=len(times)), times)]], "", [], True, np.nan)
    mains = mains_in([channel])
    assert mains == (50.0, 60.0)
    found = with_hum(channel, mains)
    bare = Whitening(found, times).whiten(hum[:, None])
    assert np.linalg.norm(bare) < 0.3 * np.linalg.norm(hum / DEVIATION)


def test_hum_is_looked_for_in_what_nothing_explains_too():
    rng = np.random.default_rng(17)
    times = np.arange(0.0, 0.1, 1e-4)
    left = [DEVIATION * (sines(50.0, times + rng.uniform())[:, 0] + rng.normal(size=len(times))) for _ in range(2)]
    noise = {"lift": {1e-4: white(DEVIATION, TAKEN_FOR_WHITE)}}
    noise = from_what_nothing_explains(
        [block(values, times) for values in left], noise, left, [np.ones((len(times), 1)) for _ in left]
    )
    (found,) = noise["lift"].values()
    assert dict(found.hums)[50.0] == pytest.approx(DEVIATION / np.sqrt(2.0), rel=0.3)
    assert found.order == 0


@pytest.fixture
def two_strokes():
    """Two records of a model that moves most of the time, and their white noise."""
    rng = np.random.default_rng(18)
    times = np.arange(0.0, 0.1, 2e-4)
    model = 9e-3 * np.clip((times - 0.01) / 0.07, 0.0, 1.0)
    return times, model, [DEVIATION * rng.normal(size=len(times)) for _ in range(2)]


def with_what_is_left(times, model, left):
    """Blocks, their noise from stretches at rest, and whether hum was found in what is left."""
    blocks = [block(model + values, times, name) for name, values in zip("ab", left, strict=True)]
    noise, _ = noise_of(blocks, [model] * 2, {})
    (before,) = noise["lift"].values()
    assert (before.source, before.order, before.hums) == ("stretches at rest", 0, ())
    found = hum_of_what_nothing_explains(blocks, noise, [model] * 2, left)
    (after,) = (found or noise)["lift"].values()
    (kept,) = noise["lift"].values()
    assert kept is before
    return found, before, after


def test_hum_that_goes_on_at_rest_is_known_by_what_is_left_of_whole_records(two_strokes):
    times, model, noise = two_strokes
    left = [
        own + 0.5 * DEVIATION * sines(50.0, times + late)[:, 0] for own, late in zip(noise, (0.003, 0.011), strict=True)
    ]
    found, before, after = with_what_is_left(times, model, left)
    assert found
    assert dict(after.hums)[50.0] == pytest.approx(0.5 * DEVIATION / np.sqrt(2.0), rel=0.4)
    assert after.deviation == before.deviation


def test_what_swings_with_the_mains_but_stops_at_rest_is_no_hum(two_strokes):
    times, model, noise = two_strokes
    moving = (times > 0.01) & (times < 0.08)
    left = [own + 3.0 * DEVIATION * moving * sines(50.0, times)[:, 0] for own in noise]
    found, before, after = with_what_is_left(times, model, left)
    assert not found
    assert after is before


def test_noise_that_leaves_nothing_but_itself_gets_no_hum(two_strokes):
    times, model, noise = two_strokes
    found, before, after = with_what_is_left(times, model, noise)
    assert not found
    assert after is before


def test_a_sensor_whose_hum_is_told_by_some_runs_hums_in_the_others(two_strokes):
    times, model, noise = two_strokes
    left = [own + 0.5 * DEVIATION * sines(50.0, times)[:, 0] for own in noise]
    blocks = [block(model + values, times, name) for name, values in zip("ab", left, strict=True)]
    known = {"lift": {2e-4: white(DEVIATION, AT_REST), 1e-3: white(2.0 * DEVIATION, AT_REST)}}
    found = hum_of_what_nothing_explains(blocks, known, [model] * 2, left)
    fine, coarse = (found["lift"][interval] for interval in (2e-4, 1e-3))
    assert fine.hums == coarse.hums != ()
    assert coarse.deviation == 2.0 * DEVIATION


def test_hum_is_looked_for_again_only_where_rest_told_of_white_noise_and_none():
    rest = white(DEVIATION, AT_REST)
    coloured = rest._replace(predictors=(np.zeros(0), np.array([0.5])), spread=np.array([1.0, 0.9]))
    assert may_hum({"lift": {1e-4: rest}, "torque": {0.0: white(1.0, "stated")}})
    for other in (coloured, rest._replace(hums=((50.0, DEVIATION),))):
        assert not may_hum({"lift": {1e-4: rest}, "pressure_a": {1e-4: other}})
    assert not may_hum({"lift": {1e-4: white(DEVIATION, "repeats")}})
