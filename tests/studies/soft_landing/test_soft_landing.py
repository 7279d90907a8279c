"""Brakes land the piston softly, within their cost and what the solenoids can do; an independent solver agrees."""

import functools
import json
from pathlib import Path

import numpy as np
import pytest
import xarray

from apesim.archive import write
from apesim.archive.inspection import verify
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps
from apesim.studies.soft_landing import study
from apesim.studies.soft_landing.braking import (
    ADDED,
    APART,
    BRAKE,
    RELEASE,
    SPEED,
    SWITCHED,
    front_of,
    search,
    widest_soft,
)
from apesim.studies.soft_landing.figures import soft_landing_figures
from apesim.studies.soft_landing.landing import (
    BOTH,
    CLOSING,
    ONLY_A,
    ONLY_B,
    OPENING,
    SOLENOIDS,
    STROKES,
    Task,
    apart_of,
    land,
)
from apesim.studies.soft_landing.results import archive_of
from apesim.studies.soft_landing.strokes import (
    FACTORS,
    LIMITS,
    OFFSETS,
    SPACING,
    conditions_of,
    faults_of,
    soft_landings,
)
from apesim.valve.effects.bounce import Bounce
from tests.machines import AMBIENT, machine
from tests.processes import without_stages
from tests.truth.simulator.valve import POSITION, Bench, simulate
from tests.truth.simulator.valve import SPEED as VELOCITY

DWELL, COST, CLOSE = 50e-3, 1e-3, 0.6e-3
CONTACT_ERROR, SPEED_ERROR = 1e-6, 5e-5
"""Against the independent solver [s], [m/s]; 10 nm take a piston that lands at 0.02 m/s 0.5 µs."""


@functools.cache
def found_once(pressures, *arguments):
    """Results for the default machine; fixtures and commands that ask for the same share them."""
    return soft_landings(Machine(), pressures, *arguments)


def found_for(spacing, solenoids=SOLENOIDS):
    """Opening and closing at 1.0 MPa gauge, for solenoids whose edges may be a time apart."""
    return found_once((AMBIENT + 1e6,), 287.0, DWELL, spacing, COST, None, tuple(solenoids))


@pytest.fixture(scope="module")
def results():
    """Results for solenoids whose edges may be 0.6 ms apart."""
    return found_for(CLOSE)


@pytest.fixture(scope="module")
def of_the_paper():
    """Results for solenoids that follow 120 Hz."""
    return found_for(SPACING)


@pytest.fixture(scope="module")
def at_once():
    """Results for brakes that switch both solenoids at once."""
    return found_for(SPACING, (BOTH,))


def switched(task, row):
    """The task whose brakes switch the solenoids that a row of brakes tells of."""
    return task._replace(solenoids=SOLENOIDS[int(row[SWITCHED])])


def truth_of(task, brake):
    """Contact after the command [s], highest speed at or after it [m/s], least share of the stroke kept after it."""
    bench = Bench(task.machine.supply.pressure, task.machine.supply.temperature)
    until = task.command + task.dwell
    run = simulate(bench, task.dwell, until, *task.edges(brake))
    stroke = getattr(run, task.stroke)
    contact = stroke.delay + stroke.stroke_time
    times = np.arange(task.command + contact + 1e-6, until, 1e-5)
    states = run.states(times)
    towards, off = (-1.0, states[POSITION]) if task.stroke == OPENING else (1.0, bench.stroke - states[POSITION])
    return contact, max(stroke.seating_speed, (towards * states[VELOCITY]).max()), 1.0 - off.max() / bench.stroke


# --- landings ---


@pytest.mark.parametrize(
    ("stroke", "solenoids", "brake", "stays"),
    [
        (OPENING, BOTH, (), True),
        (OPENING, BOTH, (9.17e-3, 9.89e-3), True),
        (OPENING, BOTH, (9.6e-3, 13.8e-3), False),  # thrown off the stop
        (OPENING, ONLY_B, (8.6e-3, 12.8e-3), True),
        (OPENING, ONLY_A, (9.0e-3, 9.8e-3), True),
        (CLOSING, BOTH, (8.6e-3, 9.1e-3), True),
        (CLOSING, BOTH, (9.2e-3, 12.0e-3), False),
        (CLOSING, ONLY_A, (8.2e-3, 12.4e-3), True),
    ],
)
def test_a_landing_is_that_of_an_independent_solver(stroke, solenoids, brake, stays):
    task = Task(machine(), DWELL, stroke, solenoids)
    landing = land(task, brake)
    contact, speed, kept = truth_of(task, brake)
    assert landing.contact == pytest.approx(contact, abs=CONTACT_ERROR)
    assert landing.stays == stays == (kept > 0.99)
    if stays:
        assert landing.speed == pytest.approx(speed, abs=SPEED_ERROR)


def test_a_blow_on_the_stop_it_came_from_counts():
    # Braked as soon as it has left, the piston is thrown back on the closed stop before it opens.
    task = Task(machine(supply=1.6), DWELL, OPENING)
    brake = (6e-3, 11e-3)
    run = simulate(Bench(AMBIENT + 1.6e6), DWELL, DWELL, brake)
    states = run.states(np.arange(0.0, DWELL, 1e-6))
    off = states[POSITION] < 9e-3
    [back] = states[VELOCITY, :-1][off[:-1] & ~off[1:]]
    assert back > run.opening.seating_speed
    assert land(task, brake).speed == pytest.approx(back, abs=5e-3)  # the last sample is up to 1 µs before contact


def test_a_stroke_that_is_not_completed_has_no_contact():
    assert np.isnan(land(Task(machine(), DWELL, OPENING), (), within=8e-3).contact)
    assert np.isnan(land(Task(machine(), 8e-3, OPENING)).contact)


def test_a_small_rebound_is_no_falling_off():
    bouncing = machine()._replace(effects=machine().effects._replace(bounce=Bounce(0.3)))
    landing = land(Task(bouncing, DWELL, OPENING))
    assert landing.stays
    assert landing.speed == pytest.approx(land(Task(machine(), DWELL, OPENING)).speed)


# --- fronts ---


def test_a_front_holds_all_that_no_other_beats_and_nothing_else():
    rng = np.random.default_rng(1)
    brakes = rng.uniform(size=(300, 6))
    front = front_of(brakes, 0.3, 0.8)
    allowed = brakes[(brakes[:, APART] >= 0.3) & (brakes[:, ADDED] <= 0.8)]
    beaten = [np.any((allowed[:, ADDED] <= row[ADDED]) & (allowed[:, SPEED] < row[SPEED])) for row in allowed]
    expected = allowed[~np.array(beaten)]
    np.testing.assert_array_equal(front, expected[np.argsort(expected[:, ADDED])])
    assert len(front_of(brakes, 2.0)) == 0


@pytest.mark.parametrize("number", [0, 1], ids=STROKES)
def test_what_is_found_keeps_the_spacing_and_the_cost(results, number):
    result = results[number]
    brakes = result.brakes
    assert np.all(brakes[:, SPEED] < result.unbraked.speed)
    gaps = np.stack((brakes[:, BRAKE], brakes[:, RELEASE] - brakes[:, BRAKE], DWELL - brakes[:, RELEASE]))
    assert brakes[:, APART] == pytest.approx(gaps.min(axis=0), abs=1e-12)
    assert front_of(brakes, CLOSE)[:, APART].min() >= CLOSE
    for limit, spacing in zip(LIMITS, (CLOSE, 0.0), strict=True):
        for kind in ("softest", "sturdy"):
            row = result.choices[limit, kind].row
            assert row[ADDED] <= COST and row[APART] >= spacing
            assert row[SPEED] < 0.5 * result.unbraked.speed
    [wide] = widest_soft(brakes, result.unbraked, COST)
    assert wide[APART] >= result.choices["any_spacing", "softest"].row[APART]
    assert wide[SPEED] <= 0.5 * result.unbraked.speed and wide[ADDED] <= COST


@pytest.mark.parametrize("number", [0, 1], ids=STROKES)
@pytest.mark.parametrize("kind", ["softest", "sturdy"])
def test_a_chosen_brake_lands_as_softly_in_an_independent_solver(results, number, kind):
    result = results[number]
    row = result.choices["within_spacing", kind].row
    contact, speed, kept = truth_of(switched(result.task, row), row[:2])
    plain, unbraked, _ = truth_of(result.task, ())
    assert contact - plain == pytest.approx(row[ADDED], abs=CONTACT_ERROR)
    assert speed == pytest.approx(row[SPEED], abs=SPEED_ERROR)
    assert kept > 0.99
    assert speed < 0.5 * unbraked and contact - plain < COST


def test_brakes_drawn_at_random_are_not_softer(results):
    rng = np.random.default_rng(2)
    unbraked = results[0].unbraked
    softest = results[0].choices["any_spacing", "softest"].row[SPEED]
    tasks = [results[0].task._replace(solenoids=solenoids) for solenoids in SOLENOIDS]
    near = np.column_stack((rng.uniform(8.7e-3, 9.7e-3, 400), rng.uniform(0.3e-3, 1.2e-3, 400)))
    landings = [land(task, (start, start + length)) for start, length in near for task in tasks]
    allowed = [found.speed for found in landings if found.stays and found.contact - unbraked.contact <= COST]
    assert len(allowed) > 50
    assert min(allowed) > softest - 0.02


# --- what 120 Hz allows ---


@pytest.mark.slow
@pytest.mark.parametrize(("number", "alone"), [(0, ONLY_B), (1, ONLY_A)], ids=STROKES)
def test_at_120_hz_the_solenoid_that_drives_lands_the_piston_softly_alone(of_the_paper, number, alone):
    # B drives the opening, A the closing: shut off, it takes the push away, and the piston stays at its stop.
    result = of_the_paper[number]
    choice = result.choices["within_spacing", "softest"]
    begin, release = choice.row[:2]
    assert choice.solenoids == alone
    assert min(begin, release - begin, DWELL - release) >= SPACING - 1e-9
    contact, speed, kept = truth_of(switched(result.task, choice.row), (begin, release))
    plain, unbraked, _ = truth_of(result.task, ())
    assert speed == pytest.approx(choice.row[SPEED], abs=SPEED_ERROR)
    assert speed < 0.3 * unbraked and contact - plain <= COST and kept > 0.99


def test_both_at_once_do_not_land_softly_at_120_hz_within_a_millisecond(at_once):
    for result in at_once:
        assert all(result.choices["within_spacing", kind] is None for kind in ("softest", "sturdy"))
        assert len(front_of(result.brakes, SPACING)) == 0
    task, unbraked = at_once[0].task, at_once[0].unbraked
    for start in np.arange(SPACING, unbraked.contact, 0.1e-3):
        for longer in (0.0, 1e-3, 4e-3):
            brake = (start, start + SPACING + longer)
            landing = land(task, brake)
            assert apart_of(task, brake) >= SPACING - 1e-9
            # Too late to act, too late to be in time, or off the stop again.
            late = landing.contact - unbraked.contact > COST
            assert late or not landing.stays or landing.speed >= unbraked.speed


def test_out_of_reach_is_told_with_what_it_would_take(of_the_paper, at_once):
    assert faults_of(of_the_paper, SPACING, COST) == []
    lines = faults_of(at_once, SPACING, COST, (BOTH,))
    assert len(lines) == 2
    assert (
        lines[0].startswith("1 MPa gauge, opening: out of reach: no brake of both solenoids at once")
        and "one halves it" in lines[0]
    )


def test_a_brake_of_120_hz_helps_a_heavy_piston():
    # A brake of 4.17 ms slows a piston of 5 kg, and does not turn it back.
    heavy = machine(valve__moving_mass=5.0)
    task = Task(heavy, 0.2, OPENING)
    unbraked = land(task)
    brakes = search(task, unbraked, SPACING, 2e-3)
    assert front_of(brakes, SPACING, 2e-3)[-1, SPEED] < 0.7 * unbraked.speed


# --- robustness ---


def test_robustness_is_the_same_brake_under_other_conditions(results):
    result = results[0]
    choice = result.choices["within_spacing", "softest"]
    assert choice.landings[4].speed == choice.row[SPEED] and choice.added[4] == choice.row[ADDED]
    other = machine(supply=FACTORS[2], temperature=287.0 + OFFSETS[0])
    expected, plain = (land(switched(Task(other, DWELL, OPENING), choice.row), brake) for brake in (choice.row[:2], ()))
    assert choice.landings[6].speed == pytest.approx(expected.speed, rel=1e-6)
    assert choice.added[6] == pytest.approx(expected.contact - plain.contact, abs=1e-9)


@pytest.mark.parametrize("number", [0, 1], ids=STROKES)
def test_a_sturdy_brake_holds_under_all_conditions_and_is_better_at_the_worst(results, number):
    result = results[number]
    softest, sturdy = (result.choices["any_spacing", kind] for kind in ("softest", "sturdy"))
    assert all(landing.stays for landing in sturdy.landings)
    assert max(sturdy.added) <= COST
    worst = max(landing.speed for landing in sturdy.landings)
    assert worst < max(landing.speed for landing in softest.landings)
    assert sturdy.row[SPEED] >= softest.row[SPEED]
    # None of a coarse grid of brakes is sturdier.
    conditions = conditions_of(result.task)
    for row in result.brakes[:: max(1, len(result.brakes) // 60)]:
        found = [(land(switched(task, row), row[:2]), plain) for task, plain in conditions]
        if all(landing.stays and landing.contact - plain.contact <= COST for landing, plain in found):
            assert max(landing.speed for landing, _ in found) >= worst


# --- archive, figures, command ---


def test_the_archive_is_whole_and_its_fronts_are_those_found(results, tmp_path):
    archive = archive_of(machine(), results, CLOSE, COST)
    path = write(archive, tmp_path / "soft.h5")
    assert verify(path) == []
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert data["opening_any_spacing_sturdy_speed_at"].dims == ("run", "pressure_factor", "temperature_offset")
        at_cost = data["closing_within_spacing_front_speed"].sel(run=0, added_time=COST, method="nearest")
        assert float(at_cost) == results[1].choices["within_spacing", "softest"].row[SPEED]
        assert float(data["opening_seating_speed"][0]) == results[0].unbraked.speed
        braked, plain = data["braked_lift"].isel(run=0), data["unbraked_lift"].isel(run=0)
        assert float(np.abs(braked - plain).max()) > 0.2e-3
        rising = np.gradient(plain, data["time"]) > 0.5
        assert (data["unbraked_velocity"].isel(run=0).values[rising] > 0.0).all() and rising.any()
        assert data["closing_within_spacing_softest_release"].attrs["units"] == "s"


def test_a_dictionary_of_brakes_holds_numbers_of_pythons_own(results):
    def leaves(data):
        if isinstance(data, dict | list):
            for part in data.values() if isinstance(data, dict) else data:
                yield from leaves(part)
        else:
            yield data

    archive = archive_of(machine(), results, CLOSE, COST)
    options = {"spacing": CLOSE, "cost": COST, "solenoids": "any", "strokes": tuple(results)}
    data = study.SoftLanding.of(archive, ambient_pressure=AMBIENT, **options).to_dict()
    assert isinstance(data["points"][0]["within_spacing"]["softest"]["seating_speed_m_s"], float)
    assert {type(leaf).__module__ for leaf in leaves(data)} == {"builtins"}


@pytest.mark.slow
def test_figures_are_drawn_with_brakes_and_for_a_piston_that_does_not_move(results, tmp_path):
    still = soft_landings(machine(), [AMBIENT + 1e4], 287.0, DWELL)
    for number, found in enumerate((results, still)):
        archive = archive_of(machine(), found, SPACING, COST)
        paths = soft_landing_figures(archive, AMBIENT, tmp_path / str(number))
        names = {path.stem for path in paths}
        assert names == {"fronts", "spacing", "robustness", "traces_opening", "traces_closing"}


@pytest.fixture
def soft_landing(apesim, monkeypatch):
    """The command in an empty folder; returns exit code, standard output and standard error."""

    def found(machine, pressures, kelvin, dwell, spacing, cost, report, solenoids, jobs):
        assert dumps(machine) == dumps(Machine())
        rounded = (float(f"{value:.12g}") for value in (kelvin, dwell, spacing, cost))
        return found_once(tuple(map(float, pressures)), *rounded, None, tuple(solenoids))

    monkeypatch.setattr(study, "soft_landings", found)
    return functools.partial(apesim, "valve", "soft-landing")


def test_the_command_gives_patterns_whose_edges_repeat_its_numbers(soft_landing):
    code, out, err = soft_landing("--pressure", "1 MPa gauge", "--spacing", "0.6 ms", "--json", "--no-figures")
    data = json.loads(out)
    assert code == 0 and without_stages(err) == "" and data["reachable"]
    opening, closing = data["points"]
    edges_a, edges_b = (), ()
    for point, command in ((opening, 0.0), (closing, DWELL)):
        pattern = point["within_spacing"]["softest"]
        found = [1e-3 * edge for edge in pattern["edges_ms"]]
        assert np.diff(found).min() >= CLOSE - 1e-9 and found[0] == 0.0
        own = tuple(command + edge for edge in found[1:])
        edges_a += own if pattern["solenoids"] in ("both", "a") else ()
        edges_b += own if pattern["solenoids"] in ("both", "b") else ()
        run = simulate(Bench(), DWELL, 2.0 * DWELL, edges_a, edges_b)
        stroke = getattr(run, point["stroke"])
        assert stroke.seating_speed == pytest.approx(pattern["seating_speed_m_s"], abs=SPEED_ERROR)
        added = stroke.delay + stroke.stroke_time - 1e-3 * point["unbraked"]["contact_ms"]
        assert added == pytest.approx(1e-3 * pattern["added_ms"], abs=CONTACT_ERROR)
        energy = 0.5 * 0.1145 * point["unbraked"]["seating_speed_m_s"] ** 2
        assert point["unbraked"]["seating_energy_J"] == pytest.approx(energy)
        assert len(pattern["robustness"]) == 9
        front = point["front"]["any_spacing"]
        assert all(np.diff([row["added_ms"] for row in front]) > 0.0)
        assert all(np.diff([row["seating_speed_m_s"] for row in front]) < 0.0)


def test_out_of_reach_ends_with_3_and_keeps_the_rest(soft_landing):
    code, out, err = soft_landing("--pressure", "1 MPa gauge", "--solenoids", "both", "--out", "s.h5")
    assert code == 3
    assert err.count("out of reach") == 2
    assert "none lowers the seating speed" in out and "sturdy" in out
    assert Path("s.h5").exists() and Path("s.figures/fronts.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--cost", "1"], ["--cost", "no unit"]),
        (["--solenoids", "c"], ["--solenoids", "both"]),
        (["--spacing", "1 mm"], ["--spacing", "ms"]),
        (["--pressure", "1 MPa"], ["--pressure", "gauge"]),
        (["--temperature", "287"], ["--temperature", "K"]),
        (["--out", ".", "--overwrite"], ["is a folder"]),
    ],
)
def test_bad_input_ends_with_2(soft_landing, arguments, told):
    code, out, err = soft_landing("--pressure", "0.03 MPa gauge", "--pulse", "5 ms", *arguments)
    assert code == 2 and out == "" and len(err.strip().splitlines()) == 1
    assert all(part in err for part in told)
