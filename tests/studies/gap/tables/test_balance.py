"""What is not in the library: by which balance it is found, added as a table, and verified. Data of the independent
simulator."""

import json

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities.settings import load
from apesim.studies.estimation.calibration import calibrate
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.tables.balance import correlate_nodes, find_most_probable, weigh_balances
from apesim.studies.gap.tables.suggest import fit_sparse
from apesim.studies.gap.tables.tabulate import Tables, tabulate
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import Measured, read_measured
from tests.gap_bench import AMBIENT, BUT_RIVALS, NOISE, STROKE, record
from tests.truth.simulator.terms import force
from tests.truth.simulator.valve import Bench

TIMES = np.linspace(0.0, 0.1, 501)
PRESSURES = {0.16e6: "fit", 0.40e6: "fit", 0.70e6: "fit", 0.55e6: "gate", 0.49e6: "check"}
UNITS = {"lift": "m", "pressure_a": "Pa", "pressure_b": "Pa"}
among = pytest.mark.parametrize("without", [BUT_RIVALS, pytest.param((), marks=pytest.mark.slow)], ids=["few", "all"])
"""Mark of tests among the rivals of what is hidden; among the whole library they are slow, and those of sealed cases
run by default."""


def measured(bench):
    """Lift and both chambers of a bench of the independent simulator."""
    rng, runs = np.random.default_rng(5000), []
    for gauge, role in PRESSURES.items():
        rig = bench._replace(supply_pressure=gauge + AMBIENT, supply_temperature=287.0)
        runs.append(record(rig, rng, gauge, role, TIMES))
    return Measured("", NOISE, tuple(runs))


def hysteretic(now):
    """A spring that rubs the more the further it is bent: 12 N at both stops, nothing in mid stroke."""
    rub = 12.0 * abs(1.0 - 2.0 * now.position / STROKE)
    return rub, rub


def progressive(now):
    """Springs that stiffen towards the ends: 15 N there."""
    return 15.0 * (1.0 - 2.0 * now.position / STROKE) ** 3


def tabulated(data):
    """What tables take of the gap of the calibrated machine, and the table that is added."""
    base = calibrate(Machine(), data)[0]
    work = Work()
    ranked = weigh_balances(base, select_effects("valve"), work)
    return ranked, tabulate(Tables(base, ranked, work), data, base.residuals.noise)


@pytest.mark.slow
def test_an_effect_that_no_library_has_is_found_by_its_balance_and_closes_the_gap():
    ranked, found = tabulated(measured(Bench(rubbing=(hysteretic,))))
    assert ranked[0].name == found.balance.name == "tabulated_force"
    assert ranked[0].gain > 1.5 * max(other.gain for other in ranked if other.balance != "force")
    assert found.judged.size_after < 0.1 * found.judged.size_before
    assert found.judged.removed_share > 0.95
    effect = found.model.machine().effects.tabulated_force
    rub = [
        effect.friction_at_0,
        effect.friction_at_20,
        effect.friction_at_50,
        effect.friction_at_80,
        effect.friction_at_100,
    ]
    assert rub == pytest.approx([12.0, 7.2, 0.0, 7.2, 12.0], abs=4.0)
    assert np.abs(effect[:11]).max() < 1.0
    # 12 N over 4.5 mm.
    (what, rest), term = found.suggestion.split(" ~ "), "N/(mm) |x| sign(v)"
    assert what.startswith("force to closed")
    assert float(rest.split(term)[0]) == pytest.approx(-12.0 / 4.5, rel=0.1)


@pytest.mark.slow
def test_without_runs_to_judge_a_table_is_held_against_operating_points_left_out():
    fitted = measured(Bench(rubbing=(hysteretic,))).of("fit")
    _, found = tabulated(Measured("", NOISE, tuple(fitted)))
    assert found.judged.samples == sum(3 * len(run.times) for run in fitted)
    assert found.judged.removed_share > 0.9
    _, alone = tabulated(Measured("", NOISE, tuple(fitted[:1])))
    assert alone is None or alone.judged is None


def test_where_nothing_is_hidden_no_table_is_worth_its_nodes():
    ranked, found = tabulated(measured(Bench()))
    assert ranked[0].gain < 6.0
    assert found is None or found.judged.size_after < 0.05


def written(folder, data):
    """Data as a folder of files."""
    lines = ['bench = "valve"']
    for name, size in NOISE.items():
        lines += [f"[sensor.{name}]", f'noise = "{size!r} {UNITS[name]}"']
    for number, run in enumerate(data.runs):
        header = ["time [s]", "lift [m]", "pressure_a [Pa abs]", "pressure_b [Pa abs]"]
        rows = np.column_stack((run.times, *run.channels.values()))
        np.savetxt(folder / f"{number}.csv", rows, "%.9g", ",", header=",".join(header), comments="")
        lines += ["[[run]]", f'data = "{number}.csv"', f'supply = "{(run.supply - AMBIENT) / 1e6:.2f} MPa gauge"']
        lines += ['temperature = "287 K"', 'pulse = "50 ms"', f'role = "{run.role}"']
    (folder / "measured.toml").write_text("\n".join(lines) + "\n")
    return folder


@among
@pytest.mark.slow
def test_what_the_library_cannot_name_is_added_without_a_name_and_the_child_lacks_nothing(apesim, tmp_path, without):
    (tmp_path / "data").mkdir()
    folder = written(tmp_path / "data", measured(Bench(terms=(force(progressive),))))
    options = [f"--without={name}" for name in without]
    code, out, _ = apesim("gap", "explain", str(folder), "--out", str(tmp_path / "out"), "--json", *options)
    told = json.loads(out)
    assert code == 0
    assert told["verdict"] == "REFUSED"
    assert told["effects"] == []
    assert told["localised"]["balance"] == "force"
    table = told["tabulated"]
    assert table["kind"] == "tabulated_force"
    assert table["gap"]["before"] > 1.1 > 1.02 > table["gap"]["after"]
    assert table["held_out"]["before"] > 1.1 > 1.03 > table["held_out"]["after"]
    assert table["verified"]
    assert "x^3" in table["suggestion"]
    # What is told of the gap is with what was added.
    assert (told["gap"], told["held_out"]) == (table["gap"], table["held_out"])
    text = (tmp_path / "out/machine.toml").read_text()
    assert "tabulated_force added, no name" in text
    child = load(Machine, tmp_path / "out/machine.toml")
    assert child.effects.tabulated_force.force_at_100 == pytest.approx(15.0, abs=5.0)
    assert explain(child, read_measured(folder, AMBIENT)).verdict == "NO_GAP"


def snag(now):
    """An edge in mid stroke at which a ring catches."""
    rub = 40.0 * np.exp(-(((now.position - 0.5 * STROKE) / 0.4e-3) ** 2))
    return rub, rub


@among
@pytest.mark.slow
def test_a_name_is_refused_where_an_unknown_force_takes_more_of_the_gap(without):
    """Left alone, moving mass with Coulomb friction passes every other rule, or is one of several that do."""
    found = explain(Machine(), measured(Bench(rubbing=(snag,))), without=without)
    assert found.verdict == "REFUSED"
    assert found.balances[0].name == found.tabulated.balance.name == "tabulated_force"
    assert found.tabulated.balance.gain > found.calibrated.cost - found.decision.best.model.cost + 100.0
    effect = found.tabulated.model.machine().effects.tabulated_force
    assert max(effect._asdict(), key=effect._asdict().get) == "friction_at_50"
    assert found.tabulated.judged.size_after < 0.3 * found.tabulated.judged.size_before


@among
@pytest.mark.slow
def test_a_name_that_stands_in_for_what_the_library_lacks_is_refused(without):
    """Stiffer springs look like more mass, which passes every other rule."""
    bench = Bench(spring_rate=1.15 * Bench().spring_rate)
    found = explain(Machine(), measured(bench), without=["spring_rate_error", *without])
    assert found.decision.best.names == ("moving_mass_error",)
    assert found.verdict == "REFUSED"
    assert found.tabulated.balance.balance == "force"


def test_a_table_is_never_a_name():
    names = {candidate.name for candidate in find_candidates(Machine(), "engine", select_effects("engine"))}
    assert "blow_by" in names
    assert not any(name.startswith("tabulated") for name in names)


# --- the prior of the nodes, and the suggested form ---


def test_nodes_that_explain_nothing_are_held_at_nothing():
    rng = np.random.default_rng(3)
    columns, errors = 30.0 * rng.standard_normal((400, 8)) / 20.0, rng.standard_normal(400)
    _, fall, price, moved, _ = find_most_probable(columns, errors, ["a"] * 4 + ["b"] * 4)
    assert fall - price < 6.0
    assert moved < 3.0


def test_of_two_branches_the_one_that_is_there_gets_a_size():
    rng = np.random.default_rng(4)
    columns, true = rng.standard_normal((400, 8)), np.array([0.5, -0.4, 0.6, -0.3, 0.0, 0.0, 0.0, 0.0])
    errors = 3.0 * rng.standard_normal(400) / 3.0 - columns @ true
    sizes, fall, price, _, x = find_most_probable(columns, errors, ["a"] * 4 + ["b"] * 4)
    assert sizes * x == pytest.approx(true, abs=0.2)
    assert sizes[0] > 0.2 > 0.05 > sizes[4]
    assert fall == pytest.approx(errors @ errors - np.sum((errors + columns @ (sizes * x)) ** 2) - x @ x, rel=1e-9)
    assert 0.0 < price < fall


def test_neighbours_are_alike_and_branches_are_not():
    found = correlate_nodes(["a", "a", "a", "b"], 0.5)
    assert found[0, 0] > found[0, 1] > found[0, 2] > found[2, 3] == 0.0
    assert np.linalg.eigvalsh(found).min() > 0.1


def test_a_trend_of_nodes_goes_on_where_nothing_was_measured():
    def beyond(share):
        correlation = correlate_nodes(["a"] * 5, share)
        rising = np.linspace(0.2, 0.8, 3)
        return correlation[3:, :3] @ np.linalg.solve(correlation[:3, :3] + 1e-6 * np.eye(3), rising)

    assert min(beyond(0.5)) > 0.5
    assert beyond(0.99) == pytest.approx([1.1, 1.4], abs=0.1)


def test_a_form_keeps_the_terms_that_make_it_up():
    t = np.linspace(-1.0, 2.0, 200)
    terms = {"": np.ones_like(t), "t": t, "t^2": t**2, "t^3": t**3, "sign": np.sign(t)}
    weights, explained = fit_sparse(4.0 * t**3 - 9.0 * np.sign(t), terms)
    assert weights == pytest.approx({"t^3": 4.0, "sign": -9.0})
    assert explained == pytest.approx(1.0)
    assert fit_sparse(np.zeros(200), terms)[1] == 0.0
