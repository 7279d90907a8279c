"""Identification, from data that an independent simulator has made: nothing here is fitted with what made it."""

import json
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from apesim.archive import ArchiveError
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.commands.options import Common
from apesim.studies.commands.valve.fit import _shown, fit_valve
from apesim.studies.estimation.noise.process import Noise, Whitening, white
from apesim.studies.identify import find_time_shift, identify, judge
from apesim.studies.identify.estimate import fit as fit_measured
from apesim.studies.identify.free import free_parameters, si_unit
from apesim.studies.identify.gate import Judgement
from apesim.studies.measured import Measured, MeasuredRun
from apesim.studies.measured.prediction import predict, run_of
from apesim.studies.terminal.console import Console
from tests.machines import AMBIENT, machine
from tests.truth.simulator.valve import POSITION, PRESSURE_A, Bench, noise, simulate

BETA = "valve.viscous_friction"
TRUE = 111.08
TIMES = np.arange(0.0, 0.1, 5e-5)
NOISE = 3e-5
DEFAULT = machine()


@lru_cache
def states(supply, until=0.1, **values):
    """What is true at `TIMES`; supply in MPa gauge."""
    return simulate(Bench(AMBIENT + supply * 1e6, **values), 50e-3, until).states(TIMES)


def measured_run(seed, supply=0.4, colour=0.0, role="fit", name="", pressures=False, deviation=NOISE, **values):
    """A run with noise of 0.03 mm, at 287 K, of a pulse of 50 ms."""
    true, rng = states(supply, **values), np.random.default_rng(seed)
    channels = {"lift": 9e-3 - true[POSITION] + noise(len(TIMES), deviation, rng, colour)}
    if pressures:
        channels["pressure_a"] = true[PRESSURE_A] + noise(len(TIMES), 2e3, rng, colour)
    return MeasuredRun(name or f"{seed}", f"{seed}.csv", AMBIENT + supply * 1e6, 287.0, 50e-3, role, TIMES, channels)


def fit(*runs, free=(BETA,), method="least-squares", stated=None, of=DEFAULT):
    return identify(of, Measured("", stated or {}, runs), free_parameters(of, free, method), method)


def holds(found, true=TRUE, key=BETA):
    low, high = found.interval_95[key]
    return low <= true <= high


# --- the paper's parameter, from the paper's data ---


def test_missing_cells_leave_the_estimate_as_sure_as_the_others_make_it():
    fitted, gate = (measured_run(seed, role=role, pressures=True) for seed, role in ((0, "fit"), (1, "gate")))
    for run, first in ((fitted, 3), (gate, 5)):
        for values in run.channels.values():
            values[first::7] = np.nan
    found = fit(fitted)
    assert found.parameters[BETA] == pytest.approx(TRUE, abs=1.0) and holds(found)
    free = free_parameters(DEFAULT, (BETA,), "least-squares")
    [judged] = judge(found, Measured("", {}, (fitted, gate)), free, [gate])
    assert not judged.contradicted and abs(judged.time_shift_s) < judged.noise_limit_s


@pytest.mark.parametrize("start", [20.0, 80.0, TRUE, 200.0])
def test_the_default_recovers_friction_in_fewer_than_60_simulations_from_anywhere(start):
    found = fit(measured_run(0), of=machine(valve__viscous_friction=start))
    assert found.parameters[BETA] == pytest.approx(TRUE, abs=1.0)
    assert found.evaluations < 60
    assert found.converged and not found.warnings and holds(found)
    assert found.objective == pytest.approx(NOISE * np.sqrt(len(TIMES)) / (len(TIMES) - 1), rel=0.05)
    assert found.machine.valve.viscous_friction == found.parameters[BETA]


def test_the_genetic_algorithm_recovers_it_with_1600():
    pytest.importorskip("pymoo")
    found = fit(measured_run(0), method="ga")
    assert found.parameters[BETA] == pytest.approx(TRUE, abs=1.0)
    assert found.parameters[BETA] == pytest.approx(fit(measured_run(0)).parameters[BETA], abs=0.02)
    assert 1600 <= found.evaluations <= 1601
    assert found.interval_95 == {BETA: None}


@pytest.mark.slow
def test_over_200_seeds_both_methods_recover_it_within_1():
    for seed in range(2000, 2200):
        for method in ("least-squares", "ga"):
            assert fit(measured_run(seed), method=method).parameters[BETA] == pytest.approx(TRUE, abs=1.0)


def test_the_genetic_algorithm_says_what_it_lacks(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pymoo.algorithms.soo.nonconvex.ga", None)
    with pytest.raises(InputError, match=r"--method: the genetic algorithm needs pymoo; pip install 'apesim\[ga\]'"):
        fit(measured_run(0), method="ga")


@pytest.mark.slow
def test_the_intervals_hold_the_truth_in_90_to_98_of_100_noises():
    found = [fit(measured_run(seed), stated={"lift": NOISE}) for seed in range(200)]
    assert 0.90 <= np.mean([holds(one) for one in found]) <= 0.98
    assert max(one.evaluations for one in found) < 60
    assert np.abs([one.parameters[BETA] - TRUE for one in found]).max() < 1.0


# --- noise ---


def test_coloured_noise_widens_the_interval_and_it_still_holds_the_truth():
    found = [fit(measured_run(seed, colour=0.9), stated={"lift": NOISE}) for seed in range(100, 200)]
    assert 0.88 <= np.mean([holds(one) for one in found]) <= 1.0
    assert max(one.evaluations for one in found) < 60
    widths = [high - low for one in found for low, high in [one.interval_95[BETA]]]
    low, high = fit(measured_run(0), stated={"lift": NOISE}).interval_95[BETA]
    assert np.median(widths) > 2.0 * (high - low)
    assert np.median([one.noise["lift"][0.0].colour for one in found]) == pytest.approx(0.9, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("colour", [0.0, 0.5, 0.9, 0.97])
def test_over_400_seeds_the_intervals_hold_the_truth_in_fewer_than_60_simulations(colour):
    found = [fit(measured_run(seed, colour=colour), stated={"lift": NOISE}) for seed in range(1000, 1400)]
    assert 0.92 <= np.mean([holds(one) for one in found]) <= 0.98
    assert max(one.evaluations for one in found) < 60
    assert all(one.converged for one in found)


def test_unstated_noise_is_found():
    found = fit(measured_run(3, colour=0.5)).noise["lift"][0.0]
    assert found.deviation == pytest.approx(NOISE, rel=0.1)
    assert found.colour == pytest.approx(0.5, abs=0.06)


def test_noise_from_repeats_shows_that_the_model_lacks_something():
    repeats = [measured_run(seed, name="p", moving_mass=0.2) for seed in (1, 2, 3)]
    found = fit(*repeats)
    assert any("off by" in warning for warning in found.warnings)
    assert found.noise["lift"][0.0].deviation > 1.1 * NOISE
    low, high = found.interval_95[BETA]
    right = fit(*[measured_run(seed, name="p") for seed in (1, 2, 3)])
    assert not right.warnings
    assert high - low > 1.5 * (right.interval_95[BETA][1] - right.interval_95[BETA][0])


def test_noise_that_is_no_autoregressive_process_is_told():
    run = measured_run(1)
    run.channels["lift"] += 3e-5 * np.sin(2.0 * np.pi * 1700.0 * TIMES)
    assert any("not the noise that it is taken for" in warning for warning in fit(run).warnings)


def test_whitening_takes_the_colour_off_and_keeps_the_deviation():
    coloured = noise(100_000, 3e-5, np.random.default_rng(2), 0.9)
    times = np.arange(len(coloured)) * 1e-4

    def whiten(values, times, correlation):
        spread = np.array([1.0, np.sqrt(1.0 - correlation**2)])
        known = Noise(3e-5, (np.zeros(0), np.array([correlation])), spread, "stated")
        return Whitening(known, times).whiten(values[:, None])[:, 0]

    white = whiten(coloured, times, 0.9)
    assert white.std() == pytest.approx(1.0, abs=0.01)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.01
    thinned = whiten(coloured[::2], times[::2], 0.81)
    assert thinned.std() == pytest.approx(1.0, abs=0.02)
    keep = np.random.default_rng(3).random(len(times)) < 0.5
    uneven = whiten(coloured[keep], times[keep], 0.9 ** (np.median(np.diff(times[keep])) / 1e-4))
    assert uneven.std() == pytest.approx(1.0, abs=0.02)


# --- what the data cannot tell ---


def test_parameters_that_cannot_be_told_apart_warn():
    """The gas gets in and out at a rate of area times the root of temperature, and nothing else shows either."""
    keys = "valve.solenoid.effective_area", "supply.temperature"
    found = fit(measured_run(0), free=keys)
    assert abs(found.correlation[0, 1]) > 0.99
    assert any("are indistinguishable" in warning and all(key in warning for key in keys) for warning in found.warnings)
    assert any("runs into a bound" in warning for warning in found.warnings)
    low, high = found.interval_95["supply.temperature"]
    assert (low, high) == pytest.approx((150.0, 600.0))


@pytest.mark.parametrize("key", ["engine.bore", "groove.lap", "command.release", "effects.blow_by.area"])
def test_a_key_that_has_no_part_in_the_bench_is_refused(key):
    with pytest.raises(InputError, match=f"{key} has no part in the valve's bench"):
        free_parameters(DEFAULT, [BETA, key])


@pytest.mark.parametrize("key", ["effects.stribeck_friction.speed", "effects.chamber_wall_heat.wall_temperature"])
def test_a_parameter_that_changes_nothing_is_refused(key):
    with pytest.raises(InputError, match=f"{key} changes nothing"):
        fit(measured_run(0), free=[BETA, key])


def test_keys_of_the_bench_are_not_refused():
    assert len(free_parameters(DEFAULT, ["valve.stroke", "effects.ring_leakage.area", "ambient.pressure"])) == 3


SPRING, FIVE = (
    "valve.spring_rate",
    {
        "valve.spring_rate": 1828.0,
        "valve.moving_mass": 0.1145,
        BETA: TRUE,
        "valve.clearance_volume": 11.382e-6,
        "valve.solenoid.effective_area": 9e-6,
    },
)


def coarse(seed):
    """A run of 200 samples, 0.5 ms apart."""
    run = measured_run(seed)
    return run._replace(times=TIMES[::10], channels={"lift": run.channels["lift"][::10]})


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_five_parameters_of_one_run_warn_all_together_though_the_optimum_is_right(seed):
    """No two of them need be strongly correlated: four make up for one."""
    found = fit(coarse(seed), free=FIVE, stated={"lift": NOISE})
    [warning] = [warning for warning in found.warnings if "are indistinguishable" in warning]
    assert all(f"{key} (±" in warning for key in FIVE)
    assert "most of them do" in warning and "more supply pressures" in warning
    true = np.linalg.norm(coarse(seed).channels["lift"] - (9e-3 - states(0.4)[POSITION, ::10])) / 199
    assert found.objective < true
    assert found.evaluations < 3200


@pytest.mark.parametrize("seed", [2, 3])
def test_intervals_of_five_parameters_hold_what_the_likelihood_cannot_refuse(seed):
    """The truth, where even all five at once lie within the 3.84 that 95 % of each one allow; spring near its bound."""
    run = coarse(seed)
    found = fit(run, free=FIVE, stated={"lift": NOISE})
    truth = np.sum((run.channels["lift"] - (9e-3 - states(0.4)[POSITION, ::10])) ** 2)
    assert truth - (199.0 * found.objective) ** 2 < 3.84 * NOISE**2
    assert all(holds(found, true, key) for key, true in FIVE.items())
    assert found.converged and found.evaluations < 2500


def test_five_parameters_are_told_apart_by_chamber_pressures():
    found = fit(measured_run(0, pressures=True), free=FIVE)
    assert not found.warnings
    assert all(holds(found, true, key) for key, true in FIVE.items())


def test_three_parameters_of_one_run_do_not_warn():
    assert not fit(measured_run(0), free=[BETA, SPRING, "valve.moving_mass"]).warnings


def test_one_parameter_badly_known_is_named():
    found = fit(coarse(0), free=[BETA, SPRING, "valve.moving_mass"], stated={"lift": NOISE})
    [warning] = found.warnings
    low, high = found.interval_95[SPRING]
    assert f"{SPRING} (± {50.0 * (high - low) / found.parameters[SPRING]:.0f} %) is badly known" in warning


def test_a_fit_ends_with_a_warning_as_its_simulations_are_spent(monkeypatch):
    monkeypatch.setattr("apesim.studies.identify.fit.MAX_SIMULATIONS", 15)
    keys = [BETA, SPRING]
    found = fit(measured_run(0), free=keys)
    assert any(f"stopped after {found.evaluations} simulations" in warning for warning in found.warnings)
    assert not found.converged and 30 <= found.evaluations < 54
    monkeypatch.undo()
    whole = fit(measured_run(0), free=keys)
    assert whole.converged and whole.evaluations > found.evaluations
    for key in keys:
        assert found.interval_95[key] == pytest.approx(whole.interval_95[key], rel=0.05)


def test_two_parameters_that_can_be_told_apart_do_not_warn():
    found = fit(measured_run(0), measured_run(1, supply=0.2), free=[BETA, "valve.spring_rate"])
    assert not found.warnings
    assert holds(found) and holds(found, 1828.0, "valve.spring_rate")
    assert found.correlation.shape == (2, 2)


def test_friction_is_known_to_four_only_where_the_supply_is_free():
    low, high = fit(measured_run(0), free=[BETA, "supply.pressure"]).interval_95[BETA]
    assert 2.0 < 0.5 * (high - low) < 4.5


def test_chamber_pressures_narrow_it():
    keys = [BETA, "supply.pressure"]
    alone, both = (
        fit(measured_run(0, pressures=pressures), free=keys).interval_95[BETA] for pressures in (False, True)
    )
    assert both[1] - both[0] < 0.7 * (alone[1] - alone[0])
    assert both[0] < TRUE < both[1]


def test_only_runs_to_be_fitted_are_looked_at():
    others = [measured_run(1, role=role, viscous_friction=150.0) for role in ("gate", "check")]
    assert fit(measured_run(0), *others).parameters == fit(measured_run(0)).parameters


# --- check runs, the command, bad input ---


def test_check_runs_shift_by_no_more_than_their_noise():
    found = fit(measured_run(0))
    for supply in (0.16, 0.49):
        told = find_time_shift(found, measured_run(int(100 * supply), supply, role="check"))
        assert 0.0 < abs(told["time_shift_s"]) < told["noise_limit_s"] < 0.2e-3


@pytest.mark.parametrize("late", [-0.5e-3, 1.2e-3])
def test_a_time_shift_is_found(late):
    found, run = fit(measured_run(0)), measured_run(1, deviation=1e-9)
    run.channels["lift"][:] = np.interp(TIMES - late, TIMES, run.channels["lift"])
    assert find_time_shift(found, run)["time_shift_s"] == pytest.approx(late, abs=0.03e-3)


def test_a_check_run_that_never_flies_has_no_shift():
    told = find_time_shift(fit(measured_run(0)), measured_run(1)._replace(pulse=2e-3, channels={"lift": 0.0 * TIMES}))
    assert np.isnan(told["time_shift_s"])


# --- gates ---


def judged(*runs, stated=None, free=(BETA,), of=DEFAULT):
    """What the runs with the role gate say, and the fit."""
    measured, keys = Measured("", stated or {}, runs), free_parameters(of, free, "least-squares")
    found = identify(of, measured, keys)
    return judge(found, measured, keys, measured.of("gate")), found


@pytest.mark.parametrize("colour", [0.0, 0.9])
@pytest.mark.parametrize("stated", [{"lift": NOISE}, {}])
def test_gates_of_the_right_model_pass(colour, stated):
    for seed in range(8):
        others = [measured_run(100 + seed, supply, colour, "gate") for supply in (0.16, 0.49)]
        gates, _ = judged(measured_run(seed, colour=colour), *others, stated=stated)
        assert not any(gate.contradicted for gate in gates)
        assert all(gate.residual_over_noise == pytest.approx(1.0, abs=0.12) for gate in gates)


@pytest.mark.parametrize("wrong", [{"moving_mass": 0.2}, {"effective_area": 8.9e-6}, {"dead_time": 1.45e-3}])
def test_a_gate_of_another_valve_refuses_and_changes_no_parameter(wrong):
    others = [measured_run(1, 0.16, role="gate"), measured_run(2, 0.49, role="gate", **wrong)]
    (right, refused), found = judged(measured_run(0), *others)
    assert refused.contradicted and refused.residual_over_noise > refused.limit > 1.1
    assert not right.contradicted
    assert found.parameters == fit(measured_run(0)).parameters


def test_a_fit_that_is_itself_off_is_refused_by_its_gate_although_its_own_rest_is_as_large():
    runs = [measured_run(seed, role=role, moving_mass=0.2) for seed, role in enumerate(("fit", "gate"))]
    [gate], found = judged(*runs, stated={"lift": NOISE})
    assert any("off by" in warning for warning in found.warnings)
    assert gate.contradicted


def test_a_gate_allows_what_the_parameters_are_not_known_to():
    keys = BETA, "valve.spring_rate", "valve.moving_mass"
    short = measured_run(3, deviation=1e-3)  # so noisy that it tells the parameters badly
    [gate], found = judged(short, measured_run(4, 0.16, role="gate"), free=keys, stated={"lift": 1e-3})
    assert not gate.contradicted
    exact = {"lift": NOISE}  # against a good sensor, the same fit is off by far more than noise
    measured, free = Measured("", exact, (short, measured_run(4, 0.16, role="gate"))), free_parameters(DEFAULT, keys)
    [strict] = judge(
        found._replace(sensor_noise={"lift": {0.0: white(NOISE, "stated")}}), measured, free, measured.of("gate")
    )
    raw = predict(run_of(found.machine, measured.runs[1]), measured.runs[1], ("lift",)).channels["lift"]
    off = np.sqrt(np.mean((raw - measured.runs[1].channels["lift"]) ** 2)) / NOISE
    assert off > strict.limit > strict.residual_over_noise


def test_a_fitted_supply_holds_in_gates_of_the_same_supply_only():
    keys = (BETA, "supply.pressure")
    actual = measured_run(0, 0.42)._replace(supply=AMBIENT + 0.4e6)  # its gauge reads too little
    gates = [measured_run(1, 0.42, role="gate")._replace(supply=AMBIENT + 0.4e6), measured_run(2, 0.2, role="gate")]
    told, found = judged(actual, *gates, free=keys)
    assert found.parameters["supply.pressure"] == pytest.approx(AMBIENT + 0.42e6, rel=0.02)
    assert not any(gate.contradicted for gate in told)
    assert all(abs(gate.time_shift_s) < 1.5 * gate.noise_limit_s for gate in told)


def test_the_command_refuses_and_still_tells_the_parameters(folder, capsys):
    lift = measured_run(1, 0.16, moving_mass=0.2).channels["lift"] * 1e3
    rows = "".join(f"{t * 1e3:.2f},{value:.5f}\n" for t, value in zip(TIMES, lift, strict=True))
    (folder / "1.csv").write_text("time [ms],lift [mm]\n" + rows)
    (folder / "3.csv").write_text("time [ms],velocity [m/s]\n" + rows)
    toml = (folder / "measured.toml").read_text().replace("check", "gate", 1)
    more = '[[run]]\ndata = "3.csv"\nsupply = "0.3 MPa gauge"\npulse = "50 ms"\nrole = "gate"\n'
    (folder / "measured.toml").write_text(toml + more)
    assert fit_valve(Common(Console(as_json=True)), folder=folder, free=[BETA]) == 3
    out, err = capsys.readouterr()
    data = json.loads(out)
    assert data["refused"] and data["parameters"][BETA] == pytest.approx(TRUE, abs=1.0)
    assert [gate["contradicted"] for gate in data["gates"]] == [True, False]
    assert "1.csv: refuses the model: what is left is" in err
    # The lift's numbers under a velocity's head are too fast for the machine, which is said as well.
    assert [warning.partition(",")[0] for warning in data["warnings"]] == [
        "3.csv: velocity: is up to 9.051 m/s",
        "3.csv: a gate without lift or chamber pressures judges nothing",
    ]
    assert fit_valve(Common(Console()), folder=folder, free=[BETA]) == 3
    assert "Gate runs, not fitted" in capsys.readouterr().out


@pytest.fixture
def folder(tmp_path):
    """A folder of a run to fit and two to check."""
    toml = 'bench = "valve"\n[sensor.lift]\nnoise = "0.03 mm"\n'
    for seed, (supply, role) in enumerate(((0.4, "fit"), (0.16, "check"), (0.49, "check"))):
        toml += f'[[run]]\ndata = "{seed}.csv"\nsupply = "{supply} MPa gauge"\npulse = "50 ms"\nrole = "{role}"\n'
        lift = measured_run(seed, supply).channels["lift"] * 1e3
        rows = "".join(f"{t * 1e3:.2f},{value:.5f}\n" for t, value in zip(TIMES, lift, strict=True))
        (tmp_path / f"{seed}.csv").write_text("time [ms],lift [mm]\n" + rows)
    (tmp_path / "measured.toml").write_text(toml)
    return tmp_path


def test_the_command_prints_one_json_object(folder, capsys):
    assert fit_valve(Common(Console(as_json=True)), folder=folder, free=[BETA]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["parameters"][BETA] == pytest.approx(TRUE, abs=1.0)
    low, high = data["interval_95"][BETA]
    assert low < data["parameters"][BETA] < high
    assert data["evaluations"] < 60 and data["objective"] > 0.0 and data["warnings"] == []
    assert data["correlation"] == [[pytest.approx(1.0)]]
    assert data["units"] == {BETA: "N s/m"}
    assert [check["run"] for check in data["checks"]] == ["1.csv", "2.csv"]
    assert 0.0 < data["wall_time_s"] < 30.0


def test_the_command_prints_tables(folder, capsys):
    fit_valve(Common(Console()), folder=folder, free=[f"{BETA}=100 N s/m:120 N s/m"], method="least-squares")
    out = capsys.readouterr().out
    assert BETA in out and "N s/m" in out and "largest time shift" in out and "simulations" in out
    assert "a positive time shift: the measured piston is later" in out


def test_the_command_writes_numbers_the_fitted_machine_and_a_figure(folder, tmp_path, capsys):
    out = tmp_path / "fitted"
    assert fit_valve(Common(Console(as_json=True)), folder=folder, free=[BETA], out=out) == 0
    data, kept = json.loads(capsys.readouterr().out), json.loads((out / "fit.json").read_text())
    assert [Path(file).name for file in data["files"]] == ["fit.json", "machine.toml", "fit_1.png", "fit_1.pdf"]
    assert kept["parameters"] == data["parameters"] and len(kept["lineage"]["parent_machine_sha256"]) == 64
    assert Machine.load(out / "machine.toml").valve.viscous_friction == kept["parameters"][BETA]
    above = (out / "machine.toml").read_text().split("\nviscous_friction = ")[0].splitlines()[-1]
    assert above.startswith("# fitted; 95 % from ") and "N s/m" in above
    with pytest.raises(ArchiveError):
        fit_valve(Common(Console()), folder=folder, free=[BETA], out=out)


def test_a_check_beyond_its_limit_is_marked_and_what_the_mark_says_stands_below():
    judged = [Judgement(f"{left}.csv", 2e-4, 1e-4, left, 1.1, left > 1.1) for left in (1.0, 3.0)]
    fit = SimpleNamespace(parameters={}, gates=[], checks=judged, objective=0.0, evaluations=1)
    table, lines = list(_shown(fit))[1], list(_shown(fit))[2:]
    assert list(table.columns[3].cells) == ["1", "3 !"] and list(table.columns[1].cells) == ["+0.2", "+0.2"]
    assert any(line.startswith("! beyond its limit") for line in lines)
    fit.checks = judged[:1]
    assert not any(line.startswith("!") for line in list(_shown(fit))[2:])


@pytest.mark.parametrize(
    ("free", "line"),
    [
        ([], "command line: --free: is not given; write --free valve.viscous_friction"),
        (["valve.friction"], "'valve.friction' is no key of a quantity; give one, e.g. valve.viscous_friction"),
        (["engine.intake"], "'engine.intake' is no key of a quantity; give one, e.g. valve.viscous_friction"),
        ([BETA, BETA], f"{BETA} is given twice; give it once"),
        ([f"{BETA}=1 N s/m"], "'1 N s/m' are no bounds; write valve.viscous_friction=LOW:HIGH"),
        ([f"{BETA}=2 N s/m:1 N s/m"], "the first is not below the second; write valve.viscous_friction=LOW:HIGH"),
        ([f"{BETA}=1:2"], "'1' has no unit; write e.g. \"1 N s/m\""),
    ],
)
def test_a_wrong_free_parameter_is_told(free, line):
    with pytest.raises(InputError) as caught:
        free_parameters(DEFAULT, free)
    assert line in str(caught.value)


def test_a_free_supply_must_be_one_in_all_runs():
    with pytest.raises(InputError, match=r"supply\.pressure: differs between the runs; fit runs of one value"):
        fit(measured_run(0), measured_run(1, 0.2), free=["supply.pressure"])


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("valve.spring_rate", "N/m"),
        ("valve.solenoid.effective_area", "m^2"),
        ("supply.pressure", "Pa abs"),
        ("valve.solenoid.dead_time", "s"),
        ("effects.bounce.restitution", "-"),
    ],
)
def test_units_are_those_of_the_values_in_si(key, name):
    [free] = free_parameters(DEFAULT, [key])
    assert si_unit(free.declaration) == name


def test_nothing_to_fit_is_told():
    with pytest.raises(InputError, match="no run of the role fit has lift or chamber pressures"):
        fit(measured_run(0, role="check"))


# --- from Python ---


def test_a_fit_from_python_is_what_the_command_prints(folder, capsys):
    assert fit_valve(Common(Console(as_json=True)), folder=folder, free=[BETA]) == 0
    told, found = json.loads(capsys.readouterr().out), fit_measured(folder, [BETA])
    assert {**told, "wall_time_s": 0.0} == {**json.loads(json.dumps(found.to_dict())), "wall_time_s": 0.0}
    assert found[BETA] == found.parameters[BETA] == told["parameters"][BETA]
    assert found.fitted_machine.valve.viscous_friction == found[BETA]
    assert BETA in repr(found)
    assert "N s/m" in found._repr_html_()


@pytest.mark.parametrize(
    ("given", "wrong"),
    [({"method": "guess"}, "guess"), ({"free": ["valve.colour"]}, "valve.colour"), ({"free": []}, "free")],
)
def test_wrong_arguments_of_a_fit_are_refused(folder, given, wrong):
    with pytest.raises(InputError, match=wrong):
        fit_measured(folder, **{"free": [BETA]} | given)
