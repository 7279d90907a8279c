"""Discharge tests: the known area of synthetic ones is found within its band, and the curve runs the valve."""

import json
from functools import cache
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from apesim.air import Air, gas_of
from apesim.archive import ArchiveError
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.quantities.settings import load
from apesim.studies.commands.options import Common
from apesim.studies.commands.valve.discharge import evaluate_discharge
from apesim.studies.discharge import Record, Vessel, discharge, figure_arrays, fit_area, read_test, read_tests
from apesim.studies.discharge.area import integrals
from apesim.studies.discharge.figures import conditions_of_vessel
from apesim.studies.discharge.vessel import Descent, effective_area, fall_per_area
from apesim.studies.terminal.console import DONE, Console
from apesim.valve.bench import run_bench
from tests.machines import AMBIENT
from tests.studies.discharge.vessels import record_of

R, K, ROOM = 287.05, 1.4, 293.15
FULL = 9e-6
GAUGE = (0.4e6, 0.6e6, 0.8e6)


def ramp(t):
    """Dead time 1.5 ms, ramp 1.5 ms, 9 mm2."""
    return FULL * np.clip((t - 1.5e-3) / 1.5e-3, 0.0, 1.0)


def s_curve(t):
    """Smooth from 1 ms to 4 ms."""
    x = np.clip((t - 1e-3) / 3e-3, 0.0, 1.0)
    return FULL * x**2 * (3.0 - 2.0 * x)


def psi(ratio):
    """Eq. 8 of doi 10.1631/jzus.A0820373, written out for its own sake."""
    if ratio <= (2.0 / (K + 1.0)) ** (K / (K - 1.0)):
        return (2.0 / (K + 1.0)) ** (1.0 / (K - 1.0)) * sqrt(2.0 * K / (K + 1.0))
    return sqrt(max(2.0 * K / (K - 1.0) * (ratio ** (2.0 / K) - ratio ** ((K + 1.0) / K)), 0.0))


@cache
def emptying(area, gauge, volume, rate, end):
    """Times [s] and pressures [Pa abs] of a vessel: mass and energy balance, independent of Eqs. 9 and 10."""

    def slopes(t, y):
        p, temperature = y
        out = area(t) * psi(min(AMBIENT / p, 1.0)) * p / sqrt(R * temperature)
        mass = p * volume / (R * temperature)
        warming = -out * (K - 1.0) * temperature / mass  # m cv dT = -out R T dt: the gas that stays does the work
        return p * (warming / temperature - out / mass), warming

    times = np.arange(-5e-3, end, 1.0 / rate)
    after = times > 0.0
    exact = {"max_step": 1e-4, "rtol": 1e-9, "atol": 1e-6}
    solution = solve_ivp(slopes, (0.0, end), (AMBIENT + gauge, ROOM), t_eval=times[after], **exact)
    return times, np.append(np.full(np.sum(~after), AMBIENT + gauge), solution.y[0])


def records_of(area, volume, noise, rate, end, seed=0, gauges=GAUGE, colour=0.0):
    """Records of discharge tests with noise [Pa]."""
    random, records = np.random.default_rng(seed), []
    for gauge in gauges:
        times, pressures = emptying(area, gauge, volume, rate, end)
        e = random.standard_normal(len(times))
        for i in range(1, len(e) if colour else 1):
            e[i] = colour * e[i - 1] + sqrt(1.0 - colour**2) * e[i]
        records.append(Record(f"p{gauge / 1e6:g}.csv", times, pressures + noise * e))
    return records


def vessel(volume, air=None):
    return Vessel(volume, ROOM, AMBIENT, gas_of(air or Air()))


def csv_of(record, header="time [ms],pressure [kPa abs]", offset=0.0):
    rows = (f"{1e3 * t:.6g},{(p - offset) / 1e3:.6f}" for t, p in zip(record.times, record.pressures, strict=True))
    return "\n".join((header, *rows)) + "\n"


@pytest.fixture
def command(tmp_path, capsys):
    """Runs the command on records; returns its data and the path of the curve."""

    def run(records, volume, **options):
        files = []
        for record in records:
            files.append(tmp_path / record.name)
            files[-1].write_text(csv_of(record, "time [ms],pressure [kPa gauge]", AMBIENT))
        common = Common(Console(as_json=True))
        options = {"out": tmp_path / "curve.csv", "figures": False} | options
        assert evaluate_discharge(common, files=files, volume=volume, **options) == DONE
        return json.loads(capsys.readouterr().out), options["out"]

    return run


def test_the_exponents_of_eq_10_follow_from_eqs_7_and_9():
    # dm/dt = -S psi p/sqrt(R T) (Eq. 7), m = p V/(R T), T = T_ini (p/p_ini)^((k-1)/k) (Eq. 9): with both,
    # dm/dp = V/(k R T), so -dp/dt = k S psi p sqrt(R T)/V, and p sqrt(T) ~ p^(1 + (k-1)/(2k)) = p^((3k-1)/(2k)).
    low, high = 0.5e6, 0.8e6  # both choked
    slow, fast = fall_per_area(vessel(1e-4), 0.9e6, np.array([low, high]))
    assert np.log(fast / slow) / np.log(high / low) == pytest.approx((3.0 * K - 1.0) / (2.0 * K), rel=1e-12)
    [other] = fall_per_area(vessel(1e-4), 0.8e6, np.array([high]))
    assert np.log(other / fast) / np.log(0.8 / 0.9) == pytest.approx(-(K - 1.0) / (2.0 * K), rel=1e-12)


def test_eq_10_gives_back_the_area_of_the_flow():
    # A golden case by hand: 0.7 MPa of 0.9 MPa left, 100 cm3, 9 mm2.
    p, initial, volume = 0.7e6, 0.9e6, 1e-4
    temperature = ROOM * (p / initial) ** (0.4 / 1.4)
    flow = FULL * 0.684731 * p / sqrt(R * temperature)  # Eq. 7
    slope = -flow * K * R * temperature / volume
    assert slope == pytest.approx(-16.901e6, rel=1e-4)
    by_hand = -slope * p ** ((1 - 3 * K) / (2 * K)) * initial ** ((K - 1) / (2 * K)) * volume
    by_hand /= K * 0.684731 * sqrt(R * ROOM)
    assert by_hand == pytest.approx(FULL, rel=1e-9)
    assert effective_area(vessel(volume), initial, [p], [slope])[0] == pytest.approx(FULL, rel=2e-6)


def test_eq_10_gives_back_the_area_of_an_emptying_vessel_that_was_integrated_independently():
    times, pressures = emptying(ramp, 0.6e6, 1e-4, 100e3, 30e-3)
    part = (times > 1.6e-3) & (np.abs(times - 3e-3) > 2e-5) & (pressures > 1.02 * AMBIENT)
    areas = effective_area(vessel(1e-4), AMBIENT + 0.6e6, pressures, np.gradient(pressures, times))
    assert areas[part] == pytest.approx(ramp(times[part]), rel=1e-3)


def test_eq_10_with_gauge_pressure_is_silently_wrong():
    times, pressures = emptying(ramp, 0.4e6, 1e-4, 100e3, 30e-3)
    blind = vessel(1e-4)._replace(ambient_pressure=1e-3)  # gauge pressures: atmosphere is 0
    part = (times > 3.1e-3) & (pressures > 1.5 * AMBIENT)
    gauge = pressures - AMBIENT
    slopes = np.gradient(pressures, times)
    wrong = effective_area(blind, 0.4e6, gauge[part], slopes[part]) / FULL
    assert 1.25 < wrong[0] < 1.35  # a quarter to a third too large at first
    assert wrong[-1] > 1.7  # and more later, without a word


def test_the_law_is_that_of_the_air_model():
    constant, polynomial = vessel(1e-4), vessel(1e-4, Air(model=1))
    pressures = np.linspace(0.9e6, 0.2e6, 400)
    ratio = fall_per_area(polynomial, 0.9e6, pressures) / fall_per_area(constant, 0.9e6, pressures)
    assert np.abs(ratio - 1.0).max() < 5e-3
    assert ratio.std() > 1e-5


def test_the_table_and_the_integrals_are_those_of_the_law():
    descent = Descent(vessel(1e-4), 0.7e6)
    passed = np.linspace(0.0, descent.passed[-1], 50)
    pressure, fall = descent.pressure(passed)
    assert fall == pytest.approx(fall_per_area(vessel(1e-4), 0.7e6, pressure), rel=1e-4)
    assert descent.passed_at(pressure) == pytest.approx(passed, abs=1e-5 * passed[-1])
    knots = np.array([0.0, 1.0, 1.5, 4.0])
    curve = np.array([0.0, 2.0, 1.0, 3.0])
    fine = np.linspace(0.0, 4.0, 40001)
    steps = np.interp(fine, knots, curve)
    naive = np.append(0.0, np.cumsum((steps[1:] + steps[:-1]) / 2.0 * np.diff(fine)))
    times = np.array([-1.0, 0.0, 0.3, 1.0, 1.2, 3.9, 4.0])
    assert integrals(times, knots) @ curve[1:] == pytest.approx(np.interp(times, fine, naive), abs=1e-6)


@pytest.mark.parametrize(("area", "volume", "end"), [(ramp, 20e-6, 8e-3), (s_curve, 100e-6, 25e-3)])
def test_without_noise_the_area_is_found_to_a_hundredth(area, volume, end):
    found = discharge(vessel(volume), records_of(area, volume, 0.0, 20e3, end))
    told = found.pooled.knots <= found.end
    assert np.abs(found.pooled.area - area(found.pooled.knots))[told].max() < 0.01 * FULL
    assert found.full_area == pytest.approx(FULL, rel=1e-3)
    assert found.collapse.largest_spread < 0.02


CASES = [  # area, volume [m3], noise [Pa], sampling [Hz], end [s], seeds
    (ramp, 20e-6, 200.0, 100e3, 8e-3, 12),
    (ramp, 20e-6, 2000.0, 5e3, 8e-3, 40),
    (ramp, 100e-6, 500.0, 20e3, 20e-3, 15),
    (s_curve, 100e-6, 2000.0, 20e3, 20e-3, 15),
    (s_curve, 200e-6, 500.0, 5e3, 40e-3, 20),
]
FEW = 4
"""Seeds that already tell a band of half or twice its width, and curves that never collapse; more are slow."""
SEEDED = [(*case[:-1], FEW) for case in CASES] + [pytest.param(*case, marks=pytest.mark.slow) for case in CASES]


@pytest.mark.parametrize(("area", "volume", "noise", "rate", "end", "seeds"), SEEDED)
def test_the_band_holds_the_true_area_as_often_as_it_says(area, volume, noise, rate, end, seeds):
    hits = []
    for seed in range(seeds):
        fit, _ = fit_area(vessel(volume), records_of(area, volume, noise, rate, end, seed))
        times = np.linspace(0.5e-3, 0.95 * end, 40)
        error = np.abs(np.interp(times, fit.knots, fit.area) - area(times))
        hits.append(np.mean(error <= np.interp(times, fit.knots, fit.half_band)))
    # About ten of the points of a curve are independent: binomial, three standard deviations.
    tolerance = 3.0 * sqrt(0.95 * 0.05 / (10 * seeds))
    assert 0.95 - tolerance < np.mean(hits) < min(0.95 + tolerance + 0.02, 0.998)


def test_coloured_noise_widens_the_band():
    hits = []
    for seed in range(10):
        records = records_of(ramp, 50e-6, 500.0, 50e3, 10e-3, seed, colour=0.7)
        fit, _ = fit_area(vessel(50e-6), records)
        hits.append(np.mean(np.abs(fit.area - ramp(fit.knots)) <= fit.half_band))
    assert np.mean(hits) > 0.90


@pytest.mark.parametrize(("seeds", "at_least"), [(FEW, FEW - 1), pytest.param(12, 10, marks=pytest.mark.slow)])
def test_the_three_curves_collapse_and_a_wrong_zero_is_told(seeds, at_least):
    agree = []
    for seed in range(seeds):
        records = records_of(ramp, 50e-6, 300.0, 20e3, 12e-3, seed)
        found = discharge(vessel(50e-6), records)
        agree.append(found.collapse.agree)
    assert sum(agree) >= at_least
    assert found.collapse.within_bands > 0.85
    assert found.collapse.rms < 0.05
    assert found.collapse.largest_spread < 2.0 * found.collapse.expected_spread
    offset = [records[0]._replace(pressures=records[0].pressures + 0.1e6), *records[1:]]
    wrong = discharge(vessel(50e-6), offset)
    assert not wrong.collapse.agree
    warned = " ".join(wrong.warnings)
    assert "differ by more than their noise" in warned


def test_the_area_is_not_told_near_ambient():
    records = records_of(ramp, 20e-6, 500.0, 20e3, 60e-3)
    found = discharge(vessel(20e-6), records)
    times, pressures = emptying(ramp, 0.8e6, 20e-6, 20e3, 60e-3)
    assert np.interp(found.end, times, pressures) > 1.08 * AMBIENT
    assert found.ends == sorted(found.ends)
    assert found.full_area == pytest.approx(FULL, rel=0.01)


def test_the_curve_runs_the_valve(command):
    machine = Machine()
    true = run_bench(machine, 50e-3).opening
    data, path = command(records_of(ramp, 100e-6, 500.0, 20e3, 25e-3), "100 cm^3")
    header = path.read_text().splitlines()[0]
    assert header == "time [ms],opening [-],effective_area [mm^2],low [mm^2],high [mm^2]"
    keys = [
        f"valve.solenoid.opening_curve={path}",
        f"valve.solenoid.effective_area={data['effective_area_mm2']} mm^2",
    ]
    measured = load(Machine, None, keys)
    assert measured.valve.solenoid.effective_area == pytest.approx(FULL, rel=0.01)
    found = run_bench(measured, 50e-3).opening
    assert found.delay == pytest.approx(true.delay, abs=0.05e-3)
    assert found.seating_speed == pytest.approx(true.seating_speed, rel=0.01)


def test_the_command_tells_what_it_did_and_replaces_nothing_unasked(command):
    records = records_of(ramp, 20e-6, 200.0, 20e3, 8e-3)
    data, path = command(records, "20 cm^3")
    assert abs(data["effective_area_mm2"] - 9.0) < 0.05
    assert data["temperature_K"] == ROOM
    assert [test["file"] for test in data["tests"]] == [record.name for record in records]
    assert data["tests"][0]["initial_pressure_Pa"] == pytest.approx(AMBIENT + 0.4e6, rel=1e-3)
    assert data["tests"][0]["noise_Pa"] == pytest.approx(200.0, rel=0.3)
    assert set(data["collapse"]) == {"rms", "largest_spread", "expected_spread", "within_bands", "agree"}
    before = path.read_text()
    with pytest.raises(ArchiveError, match="exists already"):
        command(records[:1], "20 cm^3")
    assert path.read_text() == before
    alone, _ = command(records[:1], "20 cm^3", overwrite=True, temperature="290 K")
    assert alone["collapse"] is None
    assert alone["temperature_K"] == 290.0


def test_the_terminal_shows_a_table_and_the_rule(tmp_path, capsys):
    file = tmp_path / "p.csv"
    file.write_text(csv_of(records_of(ramp, 20e-6, 200.0, 20e3, 8e-3, gauges=(0.6e6,))[0]))
    assert evaluate_discharge(Common(Console()), [file], "20 cm^3", out=tmp_path / "c.csv", figures=False) == DONE
    out = capsys.readouterr().out
    assert "cut-off: reported while p > 1.1 p_ambient" in out
    assert "effective area 9" in out or "effective area 8.9" in out


def test_the_command_draws_pressures_and_areas_for_one_test_and_for_three(command, tmp_path):
    records = records_of(ramp, 20e-6, 200.0, 20e3, 8e-3)
    for number, some in enumerate((records, records[:1])):
        data, _ = command(some, "20 cm^3", out=tmp_path / f"{number}.csv", figures=True)
        drawn = {
            tmp_path / f"{number}.figures" / f"{n}.{e}" for n in ("pressure", "effective_area") for e in ("png", "pdf")
        }
        assert {Path(path) for path in data["figures"]} == drawn
        assert all(path.stat().st_size > 5000 for path in drawn)
    assert command(records, "20 cm^3")[0]["figures"] == []


def test_a_figure_gets_arrays_of_one_length():
    found = discharge(vessel(20e-6), records_of(ramp, 20e-6, 200.0, 20e3, 8e-3))
    arrays = figure_arrays(found)
    for test in arrays["tests"]:
        assert test["time"].shape == test["pressure"].shape == test["fitted"].shape
        assert np.sqrt(np.mean((test["pressure"] - test["fitted"]) ** 2)) == pytest.approx(200.0, rel=0.2)
    for band in (*arrays["tests"], arrays["pooled"]):
        assert band["knots"].shape == band["area"].shape == band["low"].shape == band["high"].shape
        assert np.all(band["low"] <= band["high"])


def faults(tmp_path, text):
    path = tmp_path / "p.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_test(path, AMBIENT)
    [line] = str(caught.value).replace(f"{tmp_path}/", "").splitlines()
    return line


GOOD = records_of(ramp, 20e-6, 0.0, 20e3, 20e-3, gauges=(0.4e6,))[0]


@pytest.mark.parametrize(
    ("header", "right"),
    [
        ("time [ms],pressure [kPa]", "pressure: 'kPa' says neither gauge nor abs; write \"pressure [kPa abs]\""),
        ("time [ms],pressure", 'pressure: has no unit; write "pressure [kPa abs]"'),
        ("time [ms],p [kPa abs]", 'pressure: there is no such column; write "pressure [kPa abs]"'),
        ("time [ms],pressure [K abs]", "pressure: 'K abs' is no unit of pressure; "),
        ("time,pressure [kPa abs]", 'time: has no unit; write "time [ms]"'),
        ("t [ms],pressure [kPa abs]", 'time: there is no such column; write "time [ms]"'),
        ("time [parsnips],pressure [kPa abs]", "time: 'parsnips' is no known unit; "),
    ],
)
def test_a_wrong_header_is_told(tmp_path, header, right):
    assert faults(tmp_path, csv_of(GOOD, header)).startswith(f"p.csv: {right}")


def test_a_wrong_record_is_told(tmp_path):
    text = csv_of(GOOD)
    lines = text.splitlines(keepends=True)
    wrong = {
        "time: does not rise in row 40": "".join([*lines[:40], lines[39], *lines[40:]]),
        "time: 101 rows until the valve is switched at t = 0, 8 after": "".join(lines[:110]),
        "time: 1 rows until the valve is switched": "".join([lines[0], *lines[101:]]),
        "pressure: does not fall after t = 0": "".join([*lines[:102], *(f"{i},501.325\n" for i in range(1, 60))]),
        "pressure: falls to 1.325 kPa abs, below the ambient 101.3": csv_of(GOOD, offset=1e5),
        "pressure: starts at 61.3": csv_of(GOOD, offset=0.44e6),
    }
    for start, content in wrong.items():
        assert faults(tmp_path, content).startswith(f"p.csv: {start}"), start
    assert "pressure [kPa gauge]" in faults(tmp_path, csv_of(GOOD, offset=AMBIENT))
    assert "there is nothing; give a file with rows of numbers" in faults(tmp_path, "")


def test_a_missing_cell_costs_that_sample_alone(tmp_path):
    text = csv_of(GOOD)
    lines = text.splitlines(keepends=True)
    path = tmp_path / "p.csv"
    for row in (",500\n", lines[30].split(",")[0] + ",nan\n", lines[30].split(",")[0] + ",-\n"):
        path.write_text(text.replace(lines[30], row))
        record = read_test(path, AMBIENT)
        assert len(record.times) == len(GOOD.times) - 1
        assert record.pressures == pytest.approx(np.delete(GOOD.pressures, 29), rel=1e-6)
        assert record.times == pytest.approx(np.delete(GOOD.times, 29))
        assert any(word in record.notes[0] for word in ("left out", "1 of 500 cells"))


@pytest.mark.parametrize("rate", [20e3, 1e3])
def test_one_wrong_sample_is_masked_and_its_row_is_named(tmp_path, rate):
    good = record_of(0.5e-3, 0.0, 7e5, 60e-3, rate)
    times = good.times
    at = int(np.argmin(np.abs(times + 2.5e-3)))
    wrong = good._replace(pressures=np.where(np.arange(len(times)) == at, 0.0, good.pressures))
    for record, masked in ((good, 0), (wrong, 1)):
        (tmp_path / "p.csv").write_text(csv_of(record))
        read = read_test(tmp_path / "p.csv", AMBIENT)
        assert len(read.times) == len(times) - masked
        assert len(read.warnings) == masked
        assert not masked or (f"row {at + 1}," in read.warnings[0] and "masked" in read.warnings[0])
    assert read.pressures == pytest.approx(np.delete(good.pressures, at), rel=1e-6)


def test_a_folder_says_how_the_files_of_a_laboratory_are_written(tmp_path):
    rows = (f"{t + 0.1:.7f};x;{p / 1e5:.7f}\n" for t, p in zip(*GOOD[1:3], strict=True))
    (tmp_path / "a.txt").write_text("Labor\nZeit (s);Name;Ch1\n" + "".join(rows).replace(".", ","))
    about = ['bench = "discharge"', "[read]", "skip_rows = 1", 'columns = { time = "Zeit (s)", pressure = "Ch1" }']
    about += ['unit.pressure = "bar abs"', "ignore_others = true", 'start = "100 ms"', "[[run]]", 'data = "a.txt"']
    toml = tmp_path / "measured.toml"
    toml.write_text("\n".join(about))
    for given in (tmp_path, toml):
        [record] = read_tests([given], AMBIENT)
        assert record.name == "a.txt"
        assert record.times == pytest.approx(GOOD.times, abs=1e-9)
        assert record.pressures == pytest.approx(GOOD.pressures, rel=1e-6)
        assert any("semicolon" in note for note in record.notes)
    toml.write_text("\n".join([*about, 'date = "today"', "[[run]]"]).replace("skip_rows", "skip_row"))
    with pytest.raises(InputError) as caught:
        read_tests([tmp_path, tmp_path / "none.csv"], AMBIENT)
    found = [(fault.key, fault.right) for fault in caught.value.faults]
    assert ("read.skip_row", "did you mean skip_rows?") in found
    assert [key for key, _ in found] == ["read.skip_row", "run 1.date", "run 2.data", ""]
    toml.write_text('bench = "valve"')
    with pytest.raises(InputError, match='write bench = "discharge"'):
        read_tests([tmp_path], AMBIENT)


def test_a_file_alone_is_read_as_it_comes_and_a_fault_says_where_read_stands(tmp_path):
    path = tmp_path / "p.csv"
    path.write_text(csv_of(GOOD).replace(",", ";").replace(".", ","))
    assert read_test(path, AMBIENT).pressures == pytest.approx(GOOD.pressures, rel=1e-6)
    assert 'bench = "discharge"' in faults(tmp_path, csv_of(GOOD, "time [ms],p"))


def test_units_and_gauge_are_converted_and_other_columns_left_alone(tmp_path):
    rows = "".join(
        f"{t:.17g},20,{(p - AMBIENT) / 1e5:.17g}\n" for t, p in zip(*map(np.ndarray.tolist, GOOD[1:3]), strict=True)
    )
    path = tmp_path / "p.csv"
    path.write_text("time [s],temperature [degC],pressure [bar gauge]\n" + rows)
    record = read_test(path, AMBIENT)
    assert record.times == pytest.approx(GOOD.times)
    assert record.pressures == pytest.approx(GOOD.pressures)


def test_all_faulty_files_are_told_at_once(tmp_path):
    (tmp_path / "a.csv").write_text(csv_of(GOOD, "time [ms],pressure [kPa]"))
    files = [tmp_path / "a.csv", tmp_path / "b.csv"]
    with pytest.raises(InputError) as caught:
        evaluate_discharge(Common(Console()), files, "20 cm^3", out=tmp_path / "c.csv")
    assert [fault.key for fault in caught.value.faults] == ["pressure", ""]
    with pytest.raises(InputError, match="no discharge test"):
        evaluate_discharge(Common(Console()), [], "20 cm^3", out=tmp_path / "c.csv")
    with pytest.raises(InputError, match="--volume"):
        evaluate_discharge(Common(Console()), files, "20", out=tmp_path / "c.csv")


def test_hopeless_noise_is_told():
    records = records_of(ramp, 200e-6, 200e3, 5e3, 20e-3, gauges=(0.4e6,))
    with pytest.raises(InputError, match="too noisy"):
        discharge(vessel(200e-6), records)


def test_a_discharge_test_s_conditions_are_those_of_its_vessel():
    told = conditions_of_vessel(Vessel(50e-6, 293.15, 101325.0, None))
    assert told == "vessel of 50 cm³, 293.15 K at the switch, into 101.3 kPa abs"
