import json

import pytest

import apesim
from apesim.engine.effects import ALL_EFFECTS, ENGINE_EFFECTS
from apesim.studies.commands.cli import app
from apesim.studies.gap.search.library import list_effects
from apesim.studies.terminal.console import main_of
from apesim.valve.effects import VALVE_EFFECTS

CHANNELS = {"lift", "pressure_a", "pressure_b", "cylinder_pressure", "torque", "air_flow", "force"}
STRENGTHS = {
    "coulomb_friction": {"force", "breakaway"},
    "cylinder_wall_heat": {"h", "factor"},
    "groove_area_error": {"share", "taper"},
    "sensor_gain": CHANNELS | {"supply_pressure"},
    "sensor_offset": CHANNELS | {"supply_temperature"},
}


def test_the_library_lists_every_effect_in_the_order_of_the_air():
    layers = [("valve", effect) for effect in VALVE_EFFECTS] + [("engine", effect) for effect in ENGINE_EFFECTS]
    assert [(entry.layer, entry.name) for entry in list_effects().values()] == [(of, each.name) for of, each in layers]


@pytest.mark.parametrize(
    ("name", "benches"),
    [
        ("seal_friction", ("valve", "engine", "cylinder")),
        ("sensor_offset", ("valve", "engine", "cylinder")),
        ("leakage_a", ("valve", "engine")),
        ("blow_by", ("engine",)),
    ],
)
def test_each_effect_says_on_which_benches_it_can_show(name, benches):
    assert list_effects()[name].benches == benches


def test_strengths_come_first_and_are_marked():
    for entry in list_effects().values():
        marked = {parameter.name for parameter in entry.parameters if parameter.strength}
        assert entry.parameters[0].strength
        if entry.name.startswith("tabulated"):
            assert marked == {parameter.name for parameter in entry.parameters}
        else:
            assert marked == STRENGTHS.get(entry.name, {entry.parameters[0].name})


@pytest.mark.parametrize(
    ("effect", "parameter", "expected"),
    [
        ("seal_friction", "coefficient", "0 to 0.0001 N/Pa"),
        ("quadratic_drag", "coefficient", "0 to 40 N s^2/m^2"),
        ("pressure_dependent_delay", "slope", "-2.5 to 2.5 ms/MPa"),
        ("critical_ratio", "b", "0.2 to 0.528"),
        ("groove_area_error", "taper", "-0.4 to 0.4"),
        ("exhaust_timing", "angle", "-45 to 45 deg"),
        ("lift_sensor_lag", "time", "0 to 0.5 ms"),
        ("pressure_sensor_lag", "time", "0 to 0.5 ms"),
        ("time_zero", "time", "-1 to 1 ms"),
        ("tdc_error", "angle", "-2 to 2 deg"),
        ("speed_ripple", "share", "0 to 0.04"),
    ],
)
def test_ranges_are_told_with_their_unit(effect, parameter, expected):
    (entry,) = (entry for entry in list_effects().values() if entry.name == effect)
    (found,) = (found for found in entry.parameters if found.name == parameter)
    assert found.range == expected


def test_the_command_prints_a_table_and_json(apesim):
    code, out, _ = apesim("gap", "effects")
    assert code == 0
    assert all(effect.name in out for effect in ALL_EFFECTS)
    code, out, _ = apesim("gap", "effects", "--json")
    told = json.loads(out)["effects"]
    assert code == 0
    assert [effect["name"] for effect in told] == [effect.name for effect in ALL_EFFECTS]
    assert {"slots", "parameters", "equation", "source", "seen_in", "isolated_by", "off"} < told[0].keys()
    (ratio,) = (effect for effect in told if effect["name"] == "critical_ratio")
    assert (ratio["off"], ratio["slots"], ratio["parameters"][0]["default"]) == (0.528, ["adjust"], "0.528")


def test_the_library_from_python_is_what_the_command_prints(capsys, monkeypatch):
    effects = apesim.list_effects()
    monkeypatch.setattr("sys.argv", ["apesim", "gap", "effects", "--json"])
    assert main_of(app) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(effects.to_dict()))
    assert len(repr(effects).splitlines()) <= 12 and "ring_leakage" in repr(effects)
    assert effects._repr_html_().count("<tr>") == len(effects) + 1
    assert effects.to_pandas().loc[("coulomb_friction", "breakaway"), "unit"] == "N"
