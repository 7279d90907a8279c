"""Sliders stay where a machine may be, and nothing else of a machine is moved by a page."""

import pytest

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.explore.requests import Asked, as_faults, parse_request, read_request
from apesim.studies.explore.sliders import effect_sliders, is_movable, sliders_of

MACHINES = {
    "default": {},
    "short stroke": {"valve_stroke": "6 mm"},
    "thin air": {"ambient_pressure": "80 kPa abs"},
    "own control air": {"supply_control_pressure": "0.6 MPa gauge"},
    "ideal": {"engine_intake": "ideal"},
    "ports": {"groove_geometry": "ports", "groove_ports_number": 6},
    "endless receiver": {"engine_receiver_volume": "inf"},
}


def text_of(slider, value):
    return f"{value:.10g} {slider.unit}".strip()


def faults_at(machine, slider, value):
    """What is wrong with a machine whose slider stands at a value."""
    try:
        read_request(machine, Asked(1, {"speed": "1000 rpm", slider.key: text_of(slider, value)}))
    except InputError as error:
        return [fault.wrong for fault in error.faults]
    return []


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_may_be_at_both_ends_of_each_slider(name):
    machine = Machine().with_(**MACHINES[name])
    for slider in sliders_of(machine, 1000.0):
        assert slider.low <= slider.value <= slider.high, slider
        for end in (slider.low, slider.high):
            # An angle alone may pass the other end of its window: then both have to move.
            wrong = faults_at(machine, slider, end)
            assert not wrong or (slider.unit == "deg" and "out of range" not in str(wrong)), slider


def test_a_slider_stands_at_what_the_machine_has():
    machine = Machine().with_(supply_pressure="0.8 MPa gauge", valve_stroke="6 mm", ambient_pressure="90 kPa abs")
    sliders = {slider.key: slider for slider in sliders_of(machine, 1500.0)}
    assert (sliders["supply.pressure"].value, sliders["supply.pressure"].unit) == (0.8, "MPa gauge")
    assert sliders["valve.stroke"].value == 6.0 and sliders["speed"].value == 1500.0
    assert sliders["supply.control_pressure"].note == "the supply's"


def test_keys_that_do_nothing_have_no_slider():
    ideal = {slider.key for slider in sliders_of(Machine().with_(engine_intake="ideal"), 1000.0)}
    assert not ideal & {"command.energise", "engine.cam.opens", "valve.moving_mass"}
    ports = {slider.key for slider in sliders_of(Machine().with_(**MACHINES["ports"]), 1000.0)}
    assert "groove.effective_area" not in ports


def test_every_effect_is_switched_on_by_its_sliders():
    machine = Machine()
    effects = effect_sliders(machine)
    assert {"supply_droop", "bounce", "cylinder_wall_heat", "critical_ratio"} <= {effect.name for effect in effects}
    for effect in effects:
        values = {slider.key: text_of(slider, slider.value) for slider in effect.sliders}
        on = read_request(machine, Asked(1, {"speed": "1000 rpm"} | values)).machine
        assert next(each.is_on for each in effect_sliders(on) if each.name == effect.name), effect.name


@pytest.mark.parametrize("key", ["effects.files", "valve.solenoid.opening_curve", "engine.intake", "bore", "effects."])
def test_a_page_gives_no_other_key(key):
    assert not is_movable(Machine(), key)
    with pytest.raises(InputError, match="has no slider"):
        read_request(Machine(), Asked(1, {"speed": "1000 rpm", key: "/etc/passwd"}))


def test_all_that_is_wrong_is_told_by_key():
    with pytest.raises(InputError) as error:
        read_request(Machine(), Asked(1, {"speed": "fast", "engine.bore": "-3 mm", "supply.pressure": "1 MPa"}))
    faults = {fault["key"]: fault for fault in as_faults(error.value)}
    assert set(faults) == {"speed", "engine.bore", "supply.pressure"}
    assert "gauge" in faults["supply.pressure"]["right"]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "3",
        '{"number": -1, "values": {}}',
        '{"number": true, "values": {}}',
        '{"number": 1}',
        "[" * 10_000,
    ],
)
def test_what_is_no_request_is_none(text):
    assert parse_request(text) is None


def test_a_value_that_is_no_text_is_told():
    with pytest.raises(InputError, match="no text of a value"):
        read_request(Machine(), Asked(1, {"speed": "1000 rpm", "engine.bore": 90}))
