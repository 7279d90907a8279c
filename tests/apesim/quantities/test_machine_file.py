"""Every key of the machine file refuses what is wrong, in one line that names file, key and right form."""

import math

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities import Choice, Curve, InputError, Pressure, Quantity
from apesim.quantities.settings import dumps, load, schema

LEAVES = list(schema(Machine))
WITH_UNIT = [leaf for leaf in LEAVES if isinstance(leaf.declaration, Quantity) and leaf.declaration.unit]
BARE = [leaf for leaf in LEAVES if isinstance(leaf.declaration, Quantity) and not leaf.declaration.unit]
AT_ONCE = 20
"""Keys that are wrong in one file: a message names no more unknown ones."""
BINDING = """
air.model ambient.pressure ambient.temperature supply.pressure supply.temperature supply.control_air
supply.control_pressure valve.stroke valve.moving_mass valve.piston_area valve.clearance_volume valve.spring_rate
valve.viscous_friction valve.solenoid.effective_area valve.solenoid.dead_time valve.solenoid.ramp_time
valve.solenoid.opening_curve valve.solenoid.release_dead_time valve.solenoid.release_ramp_time
groove.effective_area groove.lap groove.area_curve engine.bore engine.stroke
engine.rod_length engine.pin_offset engine.compression_ratio engine.intake engine.cam.opens engine.cam.closes
engine.cam.lift engine.cam.flank engine.cam.lift_curve engine.exhaust.effective_area engine.exhaust.opens
engine.exhaust.closes engine.exhaust.flank engine.receiver.volume engine.receiver.feed_area engine.friction.constant
engine.friction.peak_pressure engine.friction.piston_speed engine.friction.piston_speed_squared command.energise
command.release command.open_target command.close_target effects.coulomb_friction.force
effects.coulomb_friction.breakaway effects.ring_leakage.area effects.solenoid_b_delay.time effects.bounce.restitution
effects.cylinder_wall_heat.h effects.blow_by.area effects.release_delay.time effects.exhaust_back_pressure.pressure
""".split()


def write_machine(folder, key, value):
    *sections, name = key.split(".")
    path = folder / "machine.toml"
    header = f"[{'.'.join(sections)}]\n" if sections else ""
    path.write_text(f"{header}{name} = {value}\n")
    return path


def faults_of(path):
    with pytest.raises(InputError) as caught:
        load(Machine, path)
    lines = str(caught.value).splitlines()
    assert len(lines) == len(caught.value.faults)
    assert all(line.startswith(f"{path}: ") for line in lines)
    return {fault.key: fault for fault in caught.value.faults}


def faults_of_all(folder, raws):
    """The fault of each key, in machine files in which some are wrong at once."""
    keys, faults, path = list(raws), {}, folder / "machine.toml"
    for start in range(0, len(keys), AT_ONCE):
        path.write_text("\n".join(f"{key} = {raws[key]}" for key in keys[start : start + AT_ONCE]))
        faults |= faults_of(path)
    assert set(keys) <= set(faults)
    return faults


def test_the_promised_keys_are_there():
    assert set(BINDING) <= {leaf.key for leaf in LEAVES}


def test_every_key_has_a_range_and_a_source():
    for leaf in LEAVES:
        assert leaf.declaration.source.strip(), leaf.key
        assert leaf.declaration.range_text.strip(), leaf.key


def test_a_bare_number_is_refused_where_a_unit_is_due(tmp_path):
    faults = faults_of_all(tmp_path, {leaf.key: "1" for leaf in WITH_UNIT})
    for leaf in WITH_UNIT:
        assert "has no unit" in faults[leaf.key].wrong, leaf.key
        assert leaf.declaration.unit in faults[leaf.key].right, leaf.key


def test_a_unit_of_another_dimension_is_refused(tmp_path):
    faults = faults_of_all(tmp_path, {leaf.key: '"1 kg m K"' for leaf in WITH_UNIT})
    for leaf in WITH_UNIT:
        assert "cannot be converted" in faults[leaf.key].wrong, leaf.key
        assert leaf.declaration.unit in faults[leaf.key].right, leaf.key


@pytest.mark.parametrize("raw", ["true", '"nan"', "nan", "[1, 2]", '"much"', '"1e400"', "{ a = 1 }"])
def test_what_is_no_finite_number_is_refused(raw, tmp_path):
    numbers = WITH_UNIT + BARE
    faults = faults_of_all(tmp_path, {leaf.key: raw for leaf in numbers})
    assert [leaf.key for leaf in numbers if not faults[leaf.key].right] == []


def test_a_value_beyond_the_range_is_refused_and_the_range_told(tmp_path):
    def beyond(declaration):
        value = declaration.low - 1.0 if math.isinf(declaration.high) else declaration.high * 2.0 + 1.0
        kind = " abs" if isinstance(declaration, Pressure) else ""
        return f'"{value!r} {declaration.unit}{kind}"' if declaration.unit else repr(value)

    numbers = WITH_UNIT + BARE
    faults = faults_of_all(tmp_path, {leaf.key: beyond(leaf.declaration) for leaf in numbers})
    for leaf in numbers:
        assert "out of range" in faults[leaf.key].wrong, leaf.key
        assert leaf.declaration.range_text in faults[leaf.key].right, leaf.key


def test_a_pressure_must_say_gauge_or_abs(tmp_path):
    pressures = [leaf.key for leaf in LEAVES if isinstance(leaf.declaration, Pressure)]
    faults = faults_of_all(tmp_path, dict.fromkeys(pressures, '"0.5 MPa"'))
    for key in pressures:
        is_ambient = key == "ambient.pressure"  # gauge pressures stand above it
        assert ("gauge" in faults[key].right) != is_ambient and "abs" in faults[key].right, key


def test_an_unknown_word_is_refused_and_the_words_told(tmp_path):
    choices = [leaf for leaf in LEAVES if isinstance(leaf.declaration, Choice)]
    faults = faults_of_all(tmp_path, {leaf.key: '"something"' for leaf in choices})
    for leaf in choices:
        assert all(option in faults[leaf.key].right for option in leaf.declaration.options), leaf.key


def test_a_curve_that_is_not_there_is_refused(tmp_path):
    curves = [leaf for leaf in LEAVES if isinstance(leaf.declaration, Curve)]
    faults = faults_of_all(tmp_path, {leaf.key: '"nowhere.csv"' for leaf in curves})
    for leaf in curves:
        assert "nowhere.csv" in faults[leaf.key].wrong, leaf.key
        assert ",".join(leaf.declaration.columns) in faults[leaf.key].right, leaf.key


def test_a_misspelt_key_is_refused_with_the_nearest_right_one(tmp_path):
    def misspelt(key):
        section, _, name = key.rpartition(".")
        return f"{section}.{name[0]}{name}".lstrip(".")  # its last letter alone may tell it from its neighbours

    faults = faults_of_all(tmp_path, {misspelt(leaf.key): '"1 mm"' for leaf in LEAVES})
    for leaf in LEAVES:
        fault = faults[misspelt(leaf.key)]
        assert "unknown key" in fault.wrong, leaf.key
        assert leaf.key.rpartition(".")[2] in fault.right, leaf.key


@pytest.mark.parametrize(
    ("key", "value", "blamed"),
    [
        ("engine.rod_length", '"44 mm"', "engine.rod_length"),
        ("groove.lap", '"9 mm"', "groove.lap"),
        ("command.release", '"-5 deg"', "command.release"),
        ("command.close_target", '"400 deg"', "command.close_target"),
        ("engine.cam.flank", '"40 deg"', "engine.cam.flank"),
        ("engine.exhaust.closes", '"165 deg"', "engine.exhaust.closes"),
        (
            "engine.cam.lift_curve",
            '{ "crank_angle [deg]" = [0, 40, 80], "lift [mm]" = [0, 9, 1] }',
            "engine.cam.lift_curve",
        ),
        ("groove.area_curve", '{ "lift [mm]" = [0, 9], "effective_area [mm^2]" = [10, 150] }', "groove.area_curve"),
        (
            "valve.solenoid.opening_curve",
            '{ "time [ms]" = [0, 3], "opening [-]" = [0, 0.9] }',
            "valve.solenoid.opening_curve",
        ),
    ],
)
def test_what_only_several_keys_show_is_refused(key, value, blamed, tmp_path):
    assert faults_of(write_machine(tmp_path, key, value))[blamed].right


def test_ports_that_overlap_round_the_piston_are_refused(tmp_path):
    # A piston of 1134.1 mm2 is 38.0 mm wide and 119.4 mm round: 14 ports of 8 mm find room, 15 do not.
    settings = ["groove.geometry=ports", "groove.ports.diameter=8 mm"]
    assert load(Machine, None, [*settings, "groove.ports.number=14"]).groove.ports.number == 14.0
    with pytest.raises(InputError, match=r"groove.ports.number: 15 ports of 8 mm overlap.* 119.4 mm"):
        load(Machine, None, [*settings, "groove.ports.number=15"])
    load(Machine, write_machine(tmp_path, "groove.ports.number", 15))  # of no matter to a line
    with pytest.raises(InputError, match=r"groove.ports.number: '2.5' is no whole number; write 2 or 3"):
        load(Machine, None, ["groove.ports.number=2.5"])


def test_all_faults_are_told_at_once(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text('[engine]\nbore = 90\nstroke = "88 kg"\nintake = "valve"\nbohr = "1 mm"\n')
    assert set(faults_of(path)) == {"engine.bore", "engine.stroke", "engine.intake", "engine.bohr"}


def test_the_printed_default_reads_back_bit_for_bit(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(dumps(Machine()))
    again = {leaf.key: leaf.default for leaf in schema(Machine, load(Machine, path))}
    for leaf in LEAVES:
        np.testing.assert_array_equal(again[leaf.key], leaf.default, err_msg=leaf.key)


def test_a_lift_curve_reads_back_bit_for_bit_from_a_file_of_its_own_and_from_a_table(tmp_path):
    (tmp_path / "cam.csv").write_text("lift [mm],crank_angle [deg]\n0,-5.3\n9,31.7\n1.1,65\n0,71.9\n")
    path = write_machine(tmp_path, "engine.cam.lift_curve", '"cam.csv"')
    machine = load(Machine, path)
    curve = machine.engine.cam.lift_curve
    assert curve.shape == (4, 2)
    assert curve[:, 0] == pytest.approx(np.radians([-5.3, 31.7, 65.0, 71.9]), rel=1e-15)
    assert curve[:, 1].tolist() == [0.0, 9e-3, 1.1e-3, 0.0]
    path.write_text(dumps(machine))
    assert load(Machine, path).engine.cam.lift_curve.tobytes() == curve.tobytes()


def test_a_table_that_is_present_switches_its_effect_on(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text('[effects.blow_by]\narea = "0.5 mm^2"\n')
    assert load(Machine, path).effects.blow_by.area == 0.5e-6
    path.write_text("[effects.blow_by]\n")
    assert "area" in faults_of(path)["effects.blow_by"].right


CURVES = {
    "area.csv": "lift [mm],effective_area [mm^2]\n1,0\n9,150\n",
    "cam.csv": "crank_angle [deg],lift [mm]\n0,0\n40,5\n80,0\n",
    "x.csv": "time [ms],opening [-]\n1,0\n3,1\n",
    "back.csv": "time [ms],release [-]\n1,0\n4,1\n",
}


@pytest.mark.parametrize(
    ("key", "value", "by"),
    [
        ("groove.ports.number", "6", None),
        ("groove.effective_area", "120 mm^2", ("groove.geometry", "ports")),
        ("groove.effective_area", "120 mm^2", ("groove.area_curve", "area.csv")),
        ("engine.cam.lift", "8 mm", ("engine.cam.lift_curve", "cam.csv")),
        ("valve.solenoid.dead_time", "2 ms", ("valve.solenoid.opening_curve", "x.csv")),
        ("valve.solenoid.release_dead_time", "2 ms", ("valve.solenoid.release_curve", "back.csv")),
    ],
)
def test_a_key_that_is_ignored_is_refused_on_the_command_line_and_told_of_a_file(
    key, value, by, tmp_path, monkeypatch, apesim
):
    for name, text in CURVES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    others = [f"{by[0]}={by[1]}"] if by else []
    with pytest.raises(InputError, match=f"{key}: is ignored"):
        load(Machine, None, [f"{key}={value}", *others])
    section, _, name = key.rpartition(".")
    lines = [f"[{section}]", f"{name} = {value if value.isdigit() else chr(34) + value + chr(34)}"]
    if by:
        head, _, other = by[0].rpartition(".")
        lines += [*([f"[{head}]"] if head != section else []), f'{other} = "{by[1]}"']
    (tmp_path / "m.toml").write_text("\n".join(lines) + "\n")
    code, out, _ = apesim("machine", "--check", "m.toml")
    assert code == 0 and f"m.toml: {key}: is ignored" in out and out.count("ignored") == 1


def test_a_window_that_ends_before_it_begins_is_told_with_both_ends():
    fault = "command.close_target: close_target at -80 deg is 75 deg before open_target at -5 deg; give more than 0 and"
    with pytest.raises(InputError, match=fault):
        load(Machine, assignments=["command.close_target=-80 deg"])
