"""What a changed dimension leaves behind is named; what it does not touch is not."""

import pytest

from apesim.engine.machine import Machine
from apesim.engine.proportions import PROPORTIONS
from apesim.quantities.settings import schema

KEYS = {leaf.key for leaf in schema(Machine)}


def unscaled(**values):
    return {row.key for row in Machine().with_(**values).find_unscaled_keys()}


def test_the_default_machine_leaves_nothing_behind():
    assert Machine().find_unscaled_keys() == []


def test_a_smaller_valve_leaves_mass_clearance_springs_and_groove_behind():
    assert unscaled(valve_stroke="6 mm") >= {
        "valve.moving_mass",
        "valve.clearance_volume",
        "valve.spring_rate",
        "groove.effective_area",
        "groove.lap",
    }


def test_a_smaller_engine_leaves_its_exhaust_and_receiver_behind_and_no_key_of_the_valves_piston():
    left = unscaled(engine_bore="50 mm")
    assert left >= {"engine.exhaust.effective_area", "engine.receiver.volume", "groove.effective_area"}
    assert not any(key.startswith("valve.") for key in left)


def test_a_key_that_was_given_is_not_named():
    assert "valve.moving_mass" not in unscaled(valve_stroke="6 mm", valve_moving_mass="0.05 kg")


def test_a_key_that_another_key_replaces_is_not_named():
    curve = [[0.0, 0.0], [6e-3, 1e-4]]
    assert not {"groove.effective_area", "groove.lap"} & unscaled(valve_stroke="6 mm", groove_area_curve=curve)


def test_a_cam_with_the_default_valves_stroke_beside_another_stroke_is_named():
    assert "engine.cam.lift" not in unscaled(valve_stroke="6 mm")
    assert "engine.cam.lift" in unscaled(valve_stroke="6 mm", engine_cam_lift="9 mm")


def test_a_valve_that_is_not_at_work_leaves_nothing_of_its_own_behind():
    assert not any(key.startswith("valve.") for key in unscaled(valve_stroke="6 mm", engine_intake="cam"))


def test_each_row_says_what_was_changed_and_why_it_matters():
    [row] = [row for row in Machine().with_(valve_stroke="6 mm").find_unscaled_keys() if row.key == "groove.lap"]
    assert (row.value, row.changed) == ("1 mm", ("valve.stroke",))
    assert row.reason


@pytest.mark.parametrize("row", PROPORTIONS, ids=lambda row: row.key)
def test_the_table_names_keys_of_the_machine(row):
    assert {row.key, *row.belongs_to} <= KEYS
    assert row.key not in row.belongs_to
