"""Another spelling of a key: the piston's diameter for its area, in files, on the command line and from Python."""

import tomllib
from math import pi

import pytest

from apesim.engine.machine import Machine
from apesim.quantities import InputError

AREA = 0.25 * pi * 30e-3**2


def loaded(tmp_path, text, *settings):
    path = tmp_path / "m.toml"
    path.write_text(text)
    return Machine.load(path, settings)


def told(make):
    with pytest.raises(InputError) as caught:
        make()
    return caught.value.faults


def test_a_diameter_is_read_as_its_area(tmp_path):
    of_file = loaded(tmp_path, '[valve]\npiston_diameter = "30 mm"\n')
    of_setting = Machine.load(settings=['valve.piston_diameter="3 cm"'])
    of_python = Machine().with_(valve_piston_diameter="30 mm")
    of_number = Machine().with_(**{"valve.piston_diameter": 30e-3})
    for machine in (of_file, of_setting, of_python, of_number):
        assert machine.valve.piston_area == pytest.approx(AREA, rel=1e-15)
    assert len({machine.valve.piston_area for machine in (of_file, of_setting, of_python, of_number)}) == 1


def test_what_is_printed_is_the_area():
    printed = tomllib.loads(Machine().with_(valve_piston_diameter="30 mm").to_toml())["valve"]
    assert "piston_diameter" not in printed
    assert printed["piston_area"].endswith("mm^2")


@pytest.mark.parametrize("area", ['"700 mm^2"', '"706.8583470577034 mm^2"'])
def test_both_in_one_file_are_a_fault(tmp_path, area):
    text = f'[valve]\npiston_diameter = "30 mm"\npiston_area = {area}\n'
    [fault] = told(lambda: loaded(tmp_path, text))
    assert fault.key == "valve.piston_diameter"
    assert "valve.piston_area" in str(fault)


def test_both_in_one_call_are_a_fault():
    both = {"valve_piston_diameter": "30 mm", "valve_piston_area": "700 mm^2"}
    [fault] = told(lambda: Machine().with_(**both))
    assert "valve.piston_area" in str(fault)
    [fault] = told(lambda: Machine.load(settings=["valve.piston_area=700 mm^2", "valve.piston_diameter=30 mm"]))
    assert fault.file == "--set" and "valve.piston_area" in str(fault)


@pytest.mark.parametrize("line", ['piston_area = "700 mm^2"', 'piston_diameter = "25 mm"'])
def test_the_command_line_goes_before_either_spelling_of_the_file(tmp_path, line):
    machine = loaded(tmp_path, f"[valve]\n{line}\n", "valve.piston_diameter=30 mm")
    assert machine.valve.piston_area == pytest.approx(AREA, rel=1e-15)
    assert loaded(tmp_path, f"[valve]\n{line}\n", "valve.piston_area=800 mm^2").valve.piston_area == 800e-6


@pytest.mark.parametrize(
    ("text", "part"), [('"30"', "unit"), ('"0.9 mm"', "1.2 to 350 mm"), ('"30 kg"', "mm"), ("[]", "")]
)
def test_a_wrong_diameter_is_told_at_its_own_key(tmp_path, text, part):
    [fault] = told(lambda: loaded(tmp_path, f"[valve]\npiston_diameter = {text}\n"))
    assert fault.key == "valve.piston_diameter" and part in str(fault)


def test_a_slip_in_its_name_is_told_with_the_right_one():
    [fault] = told(lambda: Machine().with_(**{"valve.piston_diametr": "30 mm"}))
    assert "valve.piston_diameter" in fault.right


def test_a_sweep_names_the_key_to_vary():
    from apesim.studies.sweep.variation import vary

    with pytest.raises(InputError) as caught:
        vary(["valve.piston_diameter=30:40:5 mm"])
    assert "valve.piston_area" in str(caught.value)
