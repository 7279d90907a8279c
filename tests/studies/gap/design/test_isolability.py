"""What sensors and runs could show: sizes against the simulator itself, classes, and that residuals play no part."""

import json

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.design.isolability import find_isolability
from apesim.studies.measured import read_measured
from tests.gap_bench import AMBIENT, write_bench


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
    assert set(isolability.to_dict()) == {"effects", "noise", "warnings", "wall_time_s"}
