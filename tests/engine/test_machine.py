"""A machine is read, changed and shown from Python, and refused in the words of a machine file."""

import csv
import math

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities import InputError, Quantity
from apesim.quantities.declarations import Choice
from apesim.quantities.trees import schema
from tests.campaigns.draws import draw_machine
from tests.folders import SAMPLES

BAD = {
    "engine.bor": "90 mm",
    "bore": "90 mm",
    "engine.bore": "90",
    "engine.stroke": "9 m",
    "supply.pressure": "8 bar",
    "engine.intake": "kam",
    "groove.lap": "9 mm",  # the groove never opens
    "command.release": "-10 deg",  # before the energising
    "effects.cylinder_wall_heat.wall_temperature": "300 K",  # without what switches it on
    "effects.no_such": "1",
    "engine": "1",
}


def told(function):
    """What is wrong and right in the faults of a refusal, without where."""
    with pytest.raises(InputError) as caught:
        function()
    return [fault[1:] for fault in caught.value.faults]


@pytest.mark.parametrize(("key", "text"), BAD.items())
def test_a_value_is_refused_in_the_same_words_from_python_from_set_and_from_a_file(tmp_path, key, text):
    of_call = told(lambda: Machine().with_(**{key: text}))
    assert of_call == told(lambda: Machine.load(None, [f"{key}={text}"]))
    if key == "engine":  # a file has another word for it
        return
    section, _, name = key.rpartition(".")
    file = tmp_path / "mine.toml"
    file.write_text(f"[{section}]\n" * bool(section) + f'{name} = "{text}"\n')
    assert of_call == told(lambda: Machine.load(file))


def test_a_key_is_written_with_underscores_or_as_in_a_file():
    by_dots = Machine().with_(**{"valve.solenoid.dead_time": "3 ms", "engine.bore": "90 mm"})
    assert Machine().with_(valve_solenoid_dead_time="3 ms", engine_bore=0.09) == by_dots
    assert by_dots.valve.solenoid.dead_time == 3e-3 and by_dots.engine.bore == 90e-3
    right = [("engine.bore", "is given twice", "give it once")]
    assert told(lambda: Machine().with_(engine_bore="90 mm", **{"engine.bore": "80 mm"})) == right
    [(key, _, right)] = told(lambda: Machine().with_(engine_bor="90 mm"))
    assert (key, right) == ("engine.bor", "did you mean engine.bore?")


@pytest.mark.parametrize("value", [-85e-3, math.nan, math.inf, True, None, 1j, [0.085], "-85 mm"])
def test_a_number_that_no_file_could_say_is_refused(value):
    [(key, wrong, right)] = told(lambda: Machine().with_(engine_bore=value))
    assert key == "engine.bore" and wrong and right


def test_every_fault_is_told_at_once():
    keys = [key for key, *_ in told(lambda: Machine().with_(engine_bore=-1.0, engine_stroke="9", supply_pressur=1e6))]
    assert sorted(keys) == ["engine.bore", "engine.stroke", "supply.pressur"]


def test_a_machine_stays_as_it_is_when_another_is_made_of_it():
    machine, before = Machine(), Machine().to_toml()
    other = machine.with_(engine_bore="90 mm").with_(engine_stroke="90 mm")
    assert machine == Machine() and machine.to_toml() == before
    assert (other.engine.bore, other.engine.stroke) == (90e-3, 90e-3)
    assert other._replace(engine=machine.engine) == machine


def test_what_is_changed_is_what_a_file_of_it_would_give(tmp_path):
    curve = np.array([[0.0, 0.0], [1e-3, 0.4], [2e-3, 1.0]])
    machine = Machine().with_(
        ambient_pressure="0.09 MPa abs", supply_pressure="0.5 MPa gauge", valve_solenoid_opening_curve=curve
    )
    assert machine.supply.pressure == 0.59e6  # above the new ambient pressure
    file = tmp_path / "mine.toml"
    file.write_text(machine.to_toml())
    again = Machine.load(file)
    assert np.array_equal(again.valve.solenoid.opening_curve, curve)
    assert again.to_toml() == machine.to_toml()
    assert Machine().with_(effects_ring_leakage_area="0.1 mm^2").effects.ring_leakage.area == 1e-7


HIGH, LOW = "0.8 MPa gauge", "80 kPa abs"
SETTINGS = (f"supply.pressure={HIGH}", f"ambient.pressure={LOW}")


def written(folder, machine):
    """A machine file of a machine."""
    file = folder / "mine.toml"
    file.write_text(machine.to_toml())
    return file


@pytest.mark.parametrize("text", [HIGH, None], ids=["said", "by default"])
def test_a_gauge_pressure_stands_above_the_ambient_pressure_wherever_and_in_whatever_order_both_are_said(
    tmp_path, text
):
    settings = SETTINGS if text else SETTINGS[1:]
    said = {"supply_pressure": text} if text else {}
    ways = [
        Machine.load(None, settings),
        Machine.load(None, settings[::-1]),
        Machine.load(written(tmp_path, Machine.load(None, settings[:-1])), settings[-1:]),
        Machine().with_(**said, ambient_pressure=LOW),
        Machine().with_(**said).with_(ambient_pressure=LOW),
        Machine().with_(ambient_pressure=LOW).with_(**said),
        Machine.load(written(tmp_path, Machine().with_(**said))).with_(ambient_pressure=80e3),
    ]
    ways.append(Machine.load(written(tmp_path, ways[0])))
    assert {machine.supply.pressure for machine in ways} == {0.88e6 if text else 1.08e6}
    assert len({machine.to_toml() for machine in ways}) == 1
    assert {machine.effects.pressure_dependent_delay.reference for machine in ways} == {0.48e6}
    assert [line for line in repr(ways[0]).splitlines() if "ambient" in line] == ["  ambient.pressure = 80 kPa abs"]
    assert ("supply.pressure" in repr(ways[0])) == bool(text)


@pytest.mark.parametrize("pressure", ["0.9 MPa abs", 0.9e6])
def test_an_absolute_pressure_stays_when_the_ambient_pressure_changes_and_is_printed_as_one(tmp_path, pressure):
    machine = Machine().with_(supply_pressure=pressure).with_(ambient_pressure=LOW)
    again = Machine.load(written(tmp_path, machine), ["ambient.pressure=90 kPa abs"])
    assert machine.supply.pressure == again.supply.pressure == 0.9e6
    assert "supply.pressure = 0.9 MPa abs" in repr(machine)
    assert type(machine.supply.control().pressure) is type(machine.supply.engine_air().pressure) is float


def test_a_short_text_names_what_differs_from_the_default_machine():
    assert repr(Machine()) == "Machine(), the default one"
    text = repr(Machine().with_(engine_bore="90 mm", supply_pressure="0.8 MPa gauge", engine_intake="cam"))
    assert text.splitlines()[1:] == [
        "  supply.pressure = 0.8 MPa gauge",
        "  engine.bore = 90 mm",
        "  engine.intake = cam",
    ]
    curve = np.column_stack((np.linspace(0.0, 1e-2, 99), np.linspace(0.0, 1.0, 99)))
    many = Machine().with_(
        valve_solenoid_opening_curve=curve, valve_stroke="8 mm", valve_clearance_volume="3 cm^3",
        valve_moving_mass="0.03 kg", engine_bore="90 mm", engine_stroke="90 mm", engine_rod_length="200 mm",
        engine_pin_offset="1 mm", engine_compression_ratio="9", engine_intake="cam",
    )  # fmt: skip
    lines = repr(many).splitlines()
    assert len(lines) < 12 and "valve.solenoid.opening_curve = a curve of 99 points" in repr(many)
    assert lines[-1] == "  and 3 keys more, see to_toml()"


def test_keys_keep_the_defaults_and_ranges_that_files_and_archives_rely_on():
    """A narrower range refuses machines of archives; another default changes what files leave out."""
    with open(SAMPLES / "machine_keys.csv", newline="") as file:
        kept = {key: rest for key, *rest in csv.reader(file)}
    found = {}
    for leaf in schema(Machine):
        said = leaf.declaration
        if isinstance(said, Quantity):
            found[leaf.key] = [f"{leaf.default}", f"{said.low} to {said.high}", said.unit]
        elif isinstance(said, Choice):
            found[leaf.key] = [f"{leaf.default}", " or ".join(said.options), ""]
    assert {key: found.get(key) for key in kept} == kept, "new keys are added before a release"


def test_a_notebook_shows_in_what_a_machine_differs_in_little_room():
    page = Machine().with_(engine_bore="80 mm")._repr_html_()
    assert "engine.bore" in page and "80 mm" in page and "<script" not in page
    assert Machine()._repr_html_() == "<div>Machine(), the default one</div>"
    many = draw_machine(np.random.default_rng(1), True)._repr_html_()
    assert len(many) < 5000 and "keys more, see to_toml()" in many
