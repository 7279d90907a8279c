"""What sensors and runs could show: sizes against the simulator itself, classes, and that residuals play no part."""

import json
import pickle

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.design.isolability import find_isolability
from apesim.studies.measured import read_measured
from tests.gap_bench import AMBIENT, write_bench
from tests.truth.simulator.cylinder import Cylinder, Record, write_folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_bench(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def isolability(folder):
    return find_isolability(Machine(), read_measured(folder, AMBIENT))


@pytest.fixture(scope="module")
def found(isolability):
    assert isolability.warnings == []
    return {row["effect"]: row for row in isolability.effects}, isolability.noise


def test_an_isolability_can_be_pickled(isolability):
    again = pickle.loads(pickle.dumps(isolability))
    assert repr(again) == repr(isolability) and json.dumps(again.to_dict()) == json.dumps(isolability.to_dict())


@pytest.mark.parametrize(
    ("name", "key"), [("side_force", "force"), ("ring_leakage", "area"), ("coulomb_friction", "force")]
)
def test_an_effect_of_the_least_size_is_five_deviations_once_all_else_is_fitted(folder, found, name, key):
    rows, noise = found
    machine = Machine()
    measured = read_measured(folder, AMBIENT)
    base, _ = calibrate(machine, measured)
    nuisances = base.residuals.parameters
    at = np.zeros(len(nuisances))
    limit = rows[name]
    shown = f"effects.{name}.{key}={limit['limit']:.12g} {limit['unit']}"
    errors = [
        WhitenedResiduals(Machine.load(None, settings), measured.of("fit"), nuisances, noise).at(at)
        for settings in ([shown], [])
    ]
    apart = errors[0] - errors[1]
    plain = WhitenedResiduals(machine, measured.of("fit"), nuisances, noise)
    slopes = np.column_stack([plain.column(at, j, 0.05) for j in range(len(at))])
    left = apart + slopes @ np.linalg.lstsq(slopes, -apart, rcond=None)[0]
    assert np.linalg.norm(left) == pytest.approx(5.0, rel=0.05)
    assert np.linalg.norm(left) / np.linalg.norm(apart) == pytest.approx(limit["kept"], rel=0.1)


def test_classes_are_mutual_and_of_what_is_seen(found):
    rows, _ = found
    for name, row in rows.items():
        assert name not in row["class"]
        assert all(name in rows[other]["class"] for other in row["class"])
        assert row["limit"] is not None or not row["class"]
    assert any(row["class"] for row in rows.values())
    assert any(row["limit"] is None for row in rows.values())


def test_help_is_told_where_it_is_needed_and_does_help(found):
    rows, _ = found
    for row in rows.values():
        if row["limit"] is not None and not row["class"]:
            assert row["helped_by"] is None
        elif row["helped_by"] and row["class"]:
            assert row["helped_by"]["cosine"] <= 0.9
        elif row["helped_by"]:
            assert row["helped_by"]["limit_of_range"] <= 1.0
    assert any(row["helped_by"] for row in rows.values())


def test_what_is_hidden_in_the_data_plays_no_part(found, tmp_path):
    rows, _ = found
    other = find_isolability(Machine(), read_measured(write_bench(tmp_path, "0 N"), AMBIENT)).effects
    for row in other:
        mine = rows[row["effect"]]
        assert row["class"] == mine["class"]
        if row["limit"] is not None and mine["limit"] is not None:
            assert row["limit"] == pytest.approx(mine["limit"], rel=0.05)


def test_the_command_prints_a_table_and_json(apesim, folder):
    code, out, err = apesim("gap", "isolability", str(folder), "--quiet")
    assert (code, err) == (0, "")
    assert "visible from (5 sigmas)" in out
    assert "discharge_coefficient_slope" in out
    code, out, err = apesim("gap", "isolability", str(folder), "--without", "side_force", "--json")
    told = json.loads(out)
    assert (code, err) == (0, "")
    assert told["wall_time_s"] > 0.0
    names = [row["effect"] for row in told["effects"]]
    assert "leakage_a" in names
    assert "side_force" not in names
    assert {"parameter", "unit", "limit", "kept", "class", "helped_by"} < told["effects"][0].keys()
    assert set(told["priors"][0]) == {"key", "value", "unit", "known_to", "stated_in", "reason"}


def test_bad_input_is_told_in_a_line(apesim, folder):
    for arguments, wrong in (((folder / "none",), "measured.toml"), ((folder, "--without", "fairies"), "fairies")):
        code, out, err = apesim("gap", "isolability", *map(str, arguments))
        assert (code, out, len(err.splitlines())) == (2, "", 1)
        assert wrong in err


def test_the_result_says_how_many_effects_could_be_isolated(isolability):
    assert "side_force" in isolability.visible
    assert set(isolability.isolable) <= set(isolability.visible)
    text = f"{len(isolability.visible)} of {len(isolability.effects)} effects could be seen"
    assert text in repr(isolability)
    assert text in isolability._repr_html_()
    assert set(isolability.to_dict()) == {"effects", "priors", "noise", "warnings", "wall_time_s"}


def test_what_is_known_of_the_rig_is_told(apesim, isolability, folder):
    assert [row["key"] for row in isolability.priors] == [
        "valve.viscous_friction",
        "valve.solenoid.effective_area",
        "valve.solenoid.dead_time",
        "supply.pressure",
        "supply.temperature",
        "air.heat_capacity_ratio",
        "sensor.lift.offset",
        "sensor.lift.gain",
    ]
    assert all(row["reason"] in isolability._repr_html_() for row in isolability.priors)
    code, out, err = apesim("gap", "isolability", str(folder), "--quiet")
    assert (code, err) == (0, "")
    assert "known to (1 sigma)" in out
    assert "sensor.lift.gain" in out


def test_less_is_retained_of_an_effect_that_looks_like_what_is_uncertain(found, tmp_path):
    rows, _ = found
    toml = write_bench(tmp_path) / "measured.toml"
    stated = '[known_to]\n"valve.spring_rate" = "10 %"\n"sensor.lift.gain" = "exact"\n'
    toml.write_text(toml.read_text().replace("[[run]]", f"{stated}[[run]]", 1))
    less = find_isolability(Machine(), read_measured(tmp_path, AMBIENT))
    kept = {row["effect"]: row["kept"] for row in less.effects}
    assert kept["spring_rate_error"] < 0.7 * rows["spring_rate_error"]["kept"]
    assert kept["side_force"] > 0.9 * rows["side_force"]["kept"]
    assert {row["key"]: row["known_to"] for row in less.priors if row["stated_in"] == "measured.toml"} == {
        "valve.spring_rate": "10 %",
        "sensor.lift.gain": "exact",
    }


def test_records_of_a_cylinder_at_more_pressures_show_less_friction(tmp_path):
    sizes = []
    for bars in ((3,), (1, 3, 5)):
        folder = tmp_path / f"{len(bars)}"
        folder.mkdir()
        write_folder(folder, Cylinder(), [Record(bar, "fit") for bar in bars], seed=15)
        rows = {row["effect"]: row for row in find_isolability(Machine().with_(rig_bore="25.7 mm"), folder).effects}
        assert set(rows) == {"coulomb_friction", "stribeck_friction", "seal_friction", "quadratic_drag", "side_force"}
        assert "stribeck_friction" in rows["coulomb_friction"]["class"]
        sizes.append([rows[name]["limit"] for name in ("coulomb_friction", "seal_friction")])
    assert sizes[1][0] < 0.5 * sizes[0][0]
    assert sizes[1][1] < 0.5 * sizes[0][1]
