"""The independent simulator: it is independent, it repeats the published solution, and the compiled bench agrees."""

import ast

import numpy as np
import pytest

from apesim.valve.bench import run_bench
from tests.acceptance.independent_simulator import MARCHED, bench_deviations, with_effect
from tests.folders import TESTS
from tests.machines import AMBIENT, agrees, machine, reference
from tests.truth.simulator.terms import ring_leakage
from tests.truth.simulator.valve import POSITION, PRESSURE_A, PRESSURE_B, Bench, noise, simulate

PACKAGES = {"apesim", "valve", "engine", "studies"}
FILES = sorted(path for path in (TESTS / "truth").rglob("*.py") if not path.name.startswith("test_"))
ROWS = reference("reference-valve.csv")
ERROR = 2e-5
EFFECTS = {
    "none": ({}, {}),
    "friction": (
        {"dry_friction": 8.0, "breakaway": 20.0},
        {"effects__coulomb_friction__force": 8.0, "effects__coulomb_friction__breakaway": 20.0},
    ),
    "bounce": ({"restitution": 0.5}, {"effects__bounce__restitution": 0.5}),
    "solenoid B": ({"delay_b": 0.7e-3}, {"effects__solenoid_b_delay__time": 0.7e-3}),
    "ring": ({"terms": (ring_leakage(Bench(), 0.2e-6),)}, {"effects__ring_leakage__area": 0.2e-6}),
}


def imported(path):
    """Top-level names that a file imports; a relative import counts as its own package."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.split(".")[0]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_truth_imports_nothing_from_what_it_judges(path):
    assert not PACKAGES & set(imported(path))
    assert not {"__import__", "importlib"} & set(path.read_text().replace("(", " ").split())


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['supply [MPa gauge]']} MPa, {row['temperature [K]']} K")
def test_the_truth_repeats_the_published_solution(row):
    bench = Bench(AMBIENT + 1e6 * float(row["supply [MPa gauge]"]), float(row["temperature [K]"]))
    run = simulate(bench, 50e-3, 100e-3)
    found = [(stroke[0] * 1e3, stroke[1] * 1e3, stroke[2]) for stroke in (run.opening, run.closing)]
    assert all(agrees(a, b, ERROR) for a, b in zip(sum(found, ()), list(row.values())[2:], strict=True))


def assert_agree(found):
    assert found.lift < 1e-6
    assert found.pressure < 1e-4
    assert found.temperature < 1e-4


@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("supply", [0.16, 0.4, 1.9])
def test_the_compiled_bench_agrees_with_the_truth(supply, effect):
    ours, theirs = EFFECTS[effect]
    assert_agree(bench_deviations(machine(supply=supply, **theirs), Bench(AMBIENT + 1e6 * supply, **ours)))


@pytest.mark.parametrize("effect", [name for name in EFFECTS if name != "none"])
def test_an_effect_moves_the_lift_by_more_than_the_packages_err(effect):
    times = np.arange(0.0, 0.1, 5e-5)
    base, moved = (simulate(Bench(AMBIENT + 4e5, **ours), 50e-3, 0.1) for ours in ({}, EFFECTS[effect][0]))
    assert np.abs(base.states(times)[POSITION] - moved.states(times)[POSITION]).max() > 2e-5


@pytest.mark.parametrize("effect", MARCHED, ids=lambda effect: effect.name)
def test_the_compiled_bench_agrees_with_the_truth_on_every_effect(effect):
    assert_agree(bench_deviations(with_effect(effect.name)))


def test_a_breakaway_larger_than_every_force_keeps_the_piston_closed():
    run = simulate(Bench(AMBIENT + 4e5, breakaway=1e3), 50e-3, 0.1)
    assert np.isnan(run.opening.delay)
    assert run.states(np.array([0.0, 0.05, 0.1]))[POSITION] == pytest.approx(9e-3, abs=0.0)


def test_the_compiled_bench_agrees_with_the_truth_on_strokes_that_are_interrupted():
    # Opening: stopped on its way, thrown off the stop later; closing: braked so late that it falls off after contact.
    brakes = (8e-3, 9.5e-3, 20e-3, 25.5e-3, 59e-3, 61.5e-3)
    run = run_bench(machine(supply=1.0), 50e-3, 100e-3, sample=5e-5, brakes=brakes)
    found = simulate(Bench(), 50e-3, 100e-3, brakes)
    lift = 9e-3 - found.states(run.times)[POSITION]
    assert run.opening.contact > 14e-3
    assert lift[(run.times > run.opening.contact) & (run.times < 50e-3)].min() < 8e-3
    assert lift[run.times > run.closing.contact].max() > 0.5e-3
    assert np.abs(run.trace[:, 0] - lift).max() < 1e-6
    # A braked landing is a small rest of a flight at 1.5 m/s, and so is its error.
    assert run.opening.seating_speed == pytest.approx(found.opening.seating_speed, abs=1.5 * ERROR)
    assert run.closing.seating_speed == pytest.approx(found.closing.seating_speed, abs=1.5 * ERROR)


@pytest.mark.parametrize(
    ("dead", "ramp", "brakes"),
    [
        (2.3e-3, 2.5e-3, (8e-3, 10.5e-3, 59e-3, 61.5e-3)),
        # Quicker than energising: the last pulse, of 1 ms, is clipped at first and moves something all the same.
        (0.0, 3e-3, (8e-3, 9.5e-3, 59e-3, 60e-3)),
    ],
)
def test_the_compiled_bench_agrees_with_the_truth_where_release_differs_from_energising(dead, ramp, brakes):
    solenoid = {"valve__solenoid__release_dead_time": dead, "valve__solenoid__release_ramp_time": ramp}
    run = run_bench(machine(supply=1.0, **solenoid), 50e-3, 100e-3, sample=5e-5, brakes=brakes)
    bench = Bench(release_delay=dead - Bench().dead_time, release_ramp_time=ramp)
    states = simulate(bench, 50e-3, 100e-3, brakes).states(run.times)
    assert np.abs(run.trace[:, 0] - (9e-3 - states[POSITION])).max() < 1e-6
    assert np.abs(run.trace[:, 2:4].T / states[[PRESSURE_A, PRESSURE_B]] - 1.0).max() < 1e-4
    alike = run_bench(machine(supply=1.0), 50e-3, 100e-3, sample=5e-5, brakes=brakes)
    assert np.abs(run.trace[:, 0] - alike.trace[:, 0]).max() > 1e-4


@pytest.mark.parametrize("alone", ["a", "b"])
def test_the_compiled_bench_agrees_with_the_truth_where_one_solenoid_is_switched_alone(alone):
    brakes = (8.6e-3, 12.8e-3, 58.5e-3, 62.7e-3)
    own = (brakes, ()) if alone == "a" else ((), brakes)
    run = run_bench(machine(supply=1.0), 50e-3, 100e-3, sample=5e-5, brakes=own[0], brakes_b=own[1])
    found = simulate(Bench(), 50e-3, 100e-3, *own)
    assert np.abs(run.trace[:, 0] - (9e-3 - found.states(run.times)[POSITION])).max() < 1e-6
    assert run.opening.seating_speed == pytest.approx(found.opening.seating_speed, abs=1.5 * ERROR)
    assert run.closing.seating_speed == pytest.approx(found.closing.seating_speed, abs=1.5 * ERROR)
    assert run.opening.seating_speed < 1.4  # unbraked 1.451


def test_a_pulse_too_short_for_a_stroke_has_none():
    run = simulate(Bench(), 4e-3, 30e-3)
    assert np.isnan(run.opening.stroke_time)


def test_noise_has_the_deviation_and_colour_it_says():
    drawn = noise(200_000, 3e-5, np.random.default_rng(1), 0.9)
    assert drawn.std() == pytest.approx(3e-5, rel=0.03)
    assert np.corrcoef(drawn[1:], drawn[:-1])[0, 1] == pytest.approx(0.9, abs=0.01)
