"""Settings: a tree of parameter classes is read and overridden, all faults told, printed without loss."""

import math
import os
import tomllib
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.quantities import NO_CURVE, Choice, Curve, InputError, Pressure, Quantity
from apesim.quantities.settings import dumps, load, overruled, read, schema


class Ambient(NamedTuple):
    """The surroundings."""

    pressure: Annotated[float, Pressure(20, 500, "standard atmosphere", unit="kPa")] = 101325.0
    temperature: Annotated[float, Quantity("K", 200, 350, "20 °C")] = 293.15


class Supply(NamedTuple):
    """The receiver before the valve.

    More of it.
    """

    pressure: Annotated[float, Pressure(0.02, 30, "chosen", show="gauge")] = 1.101325e6
    control_air: Annotated[int, Choice(("regulator", "receiver"), "Fig. 3")] = 0
    control_pressure: Annotated[float, Pressure(0.02, 30, "chosen", text="the supply's", optional=True)] = math.nan
    volume: Annotated[float, Quantity("L", 0, math.inf, "chosen")] = math.inf


class Solenoid(NamedTuple):
    """Two three-way solenoid valves, driven together."""

    effective_area: Annotated[float, Quantity("mm^2", 0.1, 500, "chosen")] = 9.0e-6
    dead_time: Annotated[float, Quantity("ms", 0, 20, "chosen")] = 1.5e-3
    opening_curve: Annotated[np.ndarray, Curve(("time [ms]", "opening [-]"), "a discharge test")] = NO_CURVE

    def faults(self):
        if self.dead_time > 10e-3:
            yield "dead_time", "is longer than a stroke", "at most 10 ms"


class Valve(NamedTuple):
    """The valve."""

    stroke: Annotated[float, Quantity("mm", 1, 50, "Table 1")] = 9e-3
    solenoid: Solenoid = Solenoid()
    lap: Annotated[float, Quantity("mm", 0, 50, "Table 1")] = 2e-3

    def faults(self):
        if self.lap >= self.stroke:
            yield "lap", "is not below the stroke", "less than valve.stroke"


class Leakage(NamedTuple):
    """An effect."""

    strength: Annotated[float, Quantity("", 0, 10, "chosen")] = 1.0
    area: Annotated[float, Quantity("mm^2", 0, 10, "chosen")] = 1e-7


class Machine(NamedTuple):
    """The machine."""

    ambient: Ambient = Ambient()
    supply: Supply = Supply()
    valve: Valve = Valve()
    leakage: Leakage = Leakage(strength=0.0)


def same(a, b):
    """Whether two trees are equal bit for bit."""
    if isinstance(a, tuple):
        return type(a) is type(b) and all(map(same, a, b))
    return type(a) is type(b) and np.asarray(a).tobytes() == np.asarray(b).tobytes()


def faults_of(data="", assignments=(), tmp_path=None):
    path = None
    if data:
        path = tmp_path / "m.toml"
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(InputError) as caught:
        load(Machine, path, assignments)
    assert len(str(caught.value).splitlines()) == len(caught.value.faults)
    all_faults = [c._replace(file=c.file.replace(f"{tmp_path}/", "")) for c in caught.value.faults]
    assert all(c.file and c.wrong and c.right for c in all_faults)
    return all_faults


def test_defaults_hold():
    assert same(load(Machine), Machine())
    assert same(read(Machine, {}, "m.toml"), Machine())


def test_a_file_and_assignments(tmp_path):
    path = tmp_path / "m.toml"
    path.write_text('[valve]\nstroke = "12 mm"\nlap = "3 mm"\n[supply]\ncontrol_air = "receiver"\nvolume = "5 L"\n')
    machine = load(Machine, path, ["valve.stroke=8 mm", ' valve.stroke = "10 mm" ', "valve.solenoid.dead_time='3 ms'"])
    expected = Machine(
        valve=Valve(stroke=10e-3, lap=3e-3, solenoid=Solenoid(dead_time=3e-3)),
        supply=Supply(control_air=1, volume=5e-3),
    )
    assert same(machine, expected)


def test_a_named_section_starts_from_its_own_class():
    assert load(Machine).leakage.strength == 0.0
    assert load(Machine, None, ["leakage.area=2 mm^2"]).leakage == Leakage(strength=1.0, area=2e-6)


def test_gauge_stands_above_the_machines_own_ambient(tmp_path):
    path = tmp_path / "m.toml"
    path.write_text('[supply]\npressure = "0.5 MPa gauge"\n[ambient]\npressure = "90 kPa abs"\n')
    assert load(Machine, path).supply.pressure == 590e3
    assert load(Machine, path, ["ambient.pressure=80 kPa abs"]).supply.pressure == 580e3
    assert load(Machine, None, ["supply.pressure=0.5 MPa gauge"]).supply.pressure == 601325.0
    assert load(Supply, None, ["pressure=0.5 MPa abs"]).pressure == 500e3
    with pytest.raises(InputError, match="no ambient pressure"):
        load(Supply, None, ["pressure=0.5 MPa gauge"])


def test_a_bad_ambient_is_told_once_and_the_rest_is_read(tmp_path):
    data = '[supply]\npressure = "0.5 MPa gauge"\nvolume = 3\n[ambient]\npressure = "0 bar gauge"\n'
    all_faults = faults_of(data, (), tmp_path)
    assert [c.key for c in all_faults] == ["ambient.pressure", "supply.volume"]
    assert all_faults[0].right == 'write e.g. "101.325 kPa abs"'


@pytest.mark.parametrize(
    ("data", "key", "wrong", "right"),
    [
        ("[valve]\nstroke = 90", "valve.stroke", "90 has no unit", 'write e.g. "9 mm"'),
        ("[valve]\nstroke = true", "valve.stroke", "True is no quantity", 'write e.g. "9 mm"'),
        ("[valve]\nstroke = nan", "valve.stroke", "nan has no unit", 'write e.g. "9 mm"'),
        ("[valve]\nstroke = [9]", "valve.stroke", "[9] is no quantity", 'write e.g. "9 mm"'),
        ("[valve]\nstroke = 2001-01-01", "valve.stroke", "is no quantity", 'write e.g. "9 mm"'),
        ('[valve.stroke]\nx = "9 mm"', "valve.stroke", "is no quantity", 'write e.g. "9 mm"'),
        ('[valve]\nstroke = "9 kg"', "valve.stroke", "cannot be converted", 'write e.g. "9 mm"'),
        ('[valve]\nstroke = "90 mm"', "valve.stroke", "out of range", "allowed: 1 to 50 mm"),
        ('[valve]\nstroke = "9 mm\\nx"', "valve.stroke", r"'9 mm\nx' is no", 'write e.g. "9 mm"'),
        ('[supply]\npressure = "1 MPa"', "supply.pressure", "neither", '"1 MPa gauge" or "1 MPa abs"'),
        ("[supply]\npressure = 1", "supply.pressure", "no unit", 'write "1 MPa gauge" or "1 MPa abs"'),
        ("[supply]\ncontrol_pressure = 1", "supply.control_pressure", "no unit", 'write "1 MPa gauge" or "1 MPa abs"'),
        ('[supply]\ncontrol_air = "x"', "supply.control_air", "no option", '"regulator" or "receiver"'),
        ("[supply]\nvolume = inf", "supply.volume", "no unit", 'write e.g. "0 L"'),
        ("[leakage]\nstrength = inf", "leakage.strength", "no finite number", "write e.g. 0"),
        (
            "[valve.solenoid]\nopening_curve = 3",
            "valve.solenoid.opening_curve",
            "no curve",
            "time [ms],opening [-]",
        ),
        ('[valve]\nstrokes = "9 mm"', "valve.strokes", "unknown key", "did you mean valve.stroke?"),
        ('[valve]\n"a\\nb" = "9 mm"', "valve.a\nb", "unknown key", "valid here: stroke, solenoid, lap"),
        (
            '[valve]\ndead_time = "9 ms"',
            "valve.dead_time",
            "unknown key",
            "did you mean valve.solenoid.dead_time?",
        ),
        ("[valves]", "valves", "unknown key", "did you mean valve?"),
        ('pressure = "9 MPa abs"', "pressure", "unknown key", "ambient.pressure or supply.pressure"),
        ("[valve.solenoid]\nzzz = 1", "valve.solenoid.zzz", "unknown key", "effective_area, dead_time"),
        ("valve = 9", "valve", "9 is no table", "write [valve], with keys of stroke"),
        ('valve = ["9 mm"]', "valve", "is no table", "write [valve]"),
        ("[[valve]]", "valve", "is no table", "write [valve]"),
        ('[valve]\nsolenoid = ["9 mm^2"]', "valve.solenoid", "is no table", "write [valve.solenoid]"),
        ("ambient = 3", "ambient", "is no table", "write [ambient]"),
        ('[valve]\nlap = "9 mm"', "valve.lap", "is not below the stroke", "less than valve.stroke"),
        ('[valve.solenoid]\ndead_time = "11 ms"', "valve.solenoid.dead_time", "longer", "at most 10 ms"),
        ("[valve]\nstroke = 9 mm", "line 2", "stroke does not stand in quotes", 'write stroke = "9 mm"'),
        ("[valve]\nstroke = mm", "line 2", "stroke does not stand in quotes", 'write stroke = "mm"'),
        ('[valve]\nstroke = 9 mm"', "line 2", "stroke does not stand in quotes", 'write stroke = "9 mm"'),
        ('[valve]\nstroke = "9 mm\nlap = 1', "line 2", "stroke has no closing quote", 'write stroke = "9 mm"'),
        ('[valve]\nstroke = "9 mm', "line 2", "stroke has no closing quote", 'write stroke = "9 mm"'),
        ('[valve]\nstroke "9 mm"', "line 2", "stroke has no = behind it", 'write stroke = "9 mm"'),
        ('[valve]\nlap = "2 mm"\nlap = "3 mm"', "line 3", "lap stands twice, first in line 2", "keep one of them"),
        ("[valve", "line 1", "[valve has no closing bracket", "write [valve]"),
        ("[valve]\n[supply]\n[valve]", "line 3", "[valve] stands twice, first in line 1", "below the first"),
        ("[valve]\nstroke = [1,\n2", "end of document", "no TOML", 'in quotes: bore = "85 mm"'),
        ("x = " + "[" * 100_000, "", "no TOML", "in quotes"),
        ("x = " + "9" * 5000, "", "no TOML", "in quotes"),
        (b"# fine\nx = '\xff'", "", "no text in line 2", "save it as UTF-8"),
        (b"#" * 10_000_001, "", "larger than 10 MB", "give a machine file"),
    ],
)
def test_refuses_with_the_remedy(tmp_path, data, key, wrong, right):
    (fault,) = faults_of(data, (), tmp_path)
    assert (fault.file, fault.key) == ("m.toml", key)
    assert wrong in fault.wrong
    assert right in fault.right


@pytest.mark.parametrize(
    ("assignment", "key", "wrong", "right"),
    [
        ("valve.stroke=90", "valve.stroke", "'90' has no unit", 'write e.g. "9 mm"'),
        ('valve.stroke="90"', "valve.stroke", "'90' has no unit", 'write e.g. "9 mm"'),
        ("valve.stroke=", "valve.stroke", "'' is no finite number", 'write e.g. "9 mm"'),
        ('valve.stroke="', "valve.stroke", "is no finite number", 'write e.g. "9 mm"'),
        ("valve.stroke", "", "'valve.stroke' assigns nothing", "KEY=VALUE"),
        ("valve=3", "valve", "is a section", "valve.stroke, valve.solenoid"),
        ("valve.strok=9 mm", "valve.strok", "unknown key", "did you mean valve.stroke?"),
        ("vlave.stroke=9 mm", "vlave", "unknown key", "did you mean valve?"),
        ("valve.stroke.x=9 mm", "valve.stroke.x", "unknown key", "did you mean valve.stroke?"),
        ("stroke=9 mm", "stroke", "unknown key", "did you mean valve.stroke?"),
        ("=9 mm", "", "unknown key", "valid here: ambient"),
        ("valve..stroke=9 mm", "valve", "unknown key", "valid here: stroke"),
        ('valve.stroke="9 mmm', "valve.stroke", "is no finite number", 'write e.g. "9 mm"'),
        ("valve.stroke=1.5 mm", "valve.lap", "is not below the stroke", "less than"),
        ("valve.lap=10 mm", "valve.lap", "is not below the stroke", "less than"),
        ("ambient.pressure=1 bar", "ambient.pressure", "neither", '"1 bar abs"'),
        ("valve.solenoid.opening_curve=absent.csv", "valve.solenoid.opening_curve", "absent.csv", "CSV"),
    ],
)
def test_refuses_assignments_with_the_remedy(assignment, key, wrong, right):
    (fault,) = faults_of(assignments=[assignment])
    assert (fault.file, fault.key) == ("--set", key)
    assert wrong in fault.wrong
    assert right in fault.right


def test_every_fault_is_told_with_its_place(tmp_path):
    data = '[valve]\nstroke = 1\nfoo = 2\nlap = "90 mm"\n[valve.solenoid]\ndead_time = "1 s"\n'
    data += '[supply]\nvolume = "x"\n'
    all_faults = faults_of(data, ["valve.lap=1", "nokey=2", "supply.control_air=me"], tmp_path)
    assert sorted((c.file, c.key) for c in all_faults) == [
        ("--set", "nokey"),
        ("--set", "supply.control_air"),
        ("--set", "valve.lap"),
        ("m.toml", "supply.volume"),
        ("m.toml", "valve.foo"),
        ("m.toml", "valve.solenoid.dead_time"),
        ("m.toml", "valve.stroke"),
    ]


def test_an_assignment_below_a_fault_of_the_file(tmp_path):
    (fault,) = faults_of("valve = 3", ["valve.solenoid.dead_time=3 ms"], tmp_path)
    assert (fault.file, fault.key) == ("m.toml", "valve")


def test_all_cross_field_faults_are_told():
    all_faults = faults_of(assignments=["valve.lap=10 mm", "valve.solenoid.dead_time=11 ms"])
    assert [c.key for c in all_faults] == ["valve.solenoid.dead_time", "valve.lap"]


@pytest.mark.parametrize(
    ("name", "reason"),
    [("absent.toml", "No such file"), (".", "Is a directory"), ("nul\0.toml", "embedded null byte")],
)
def test_unreadable_files(tmp_path, name, reason):
    with pytest.raises(InputError) as caught:
        load(Machine, f"{tmp_path}/{name}")
    (fault,) = caught.value.faults
    assert fault.file == f"{tmp_path}/{name}"
    assert f"cannot be read: {reason}" in fault.wrong
    assert "machine file" in fault.right


def test_paths_of_curves(tmp_path, monkeypatch):
    for folder, last in (("machines", 1), ("work", 2)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "c.csv").write_text(f"time [ms],opening [-]\n0,0\n{last},1\n")
    monkeypatch.chdir(tmp_path / "work")
    path = tmp_path / "machines" / "m.toml"
    path.write_text('[valve.solenoid]\nopening_curve = "c.csv"\n')
    assert load(Machine, path).valve.solenoid.opening_curve.tolist() == [[0, 0], [1e-3, 1]]
    machine = load(Machine, path, ["valve.solenoid.opening_curve=c.csv"])
    assert machine.valve.solenoid.opening_curve.tolist() == [[0, 0], [2e-3, 1]]
    assert load(Machine, path, ["valve.solenoid.opening_curve="]).valve.solenoid.opening_curve.shape == (0, 2)


@pytest.mark.parametrize("name", ["../c.csv", "link.csv", "{folder}/c.csv"])
def test_a_curve_that_a_file_names_lies_below_its_folder_and_that_of_a_user_anywhere(tmp_path, name):
    name = name.format(folder=tmp_path)
    (tmp_path / "c.csv").write_text("time [ms],opening [-]\n0,0\n1,1\n")
    path = tmp_path / "machines" / "m.toml"
    path.parent.mkdir()
    (path.parent / "link.csv").symlink_to(tmp_path / "c.csv")
    path.write_text(f'[valve.solenoid]\nopening_curve = "{name}"\n')
    with pytest.raises(InputError) as caught:
        load(Machine, path)
    (fault,) = caught.value.faults
    assert fault.key == "valve.solenoid.opening_curve" and "leads out of the folder" in fault.wrong
    path.write_text("")
    machine = load(Machine, path, [f"valve.solenoid.opening_curve={path.parent / name}"])
    assert machine.valve.solenoid.opening_curve.tolist() == [[0, 0], [1e-3, 1]]


def test_a_pipe_in_place_of_a_machine_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "m.toml")
    with pytest.raises(InputError, match="it is a pipe or a device, no file"):
        load(Machine, tmp_path / "m.toml")


# ---- printing


def reloaded(machine, tmp_path):
    path = tmp_path / "printed.toml"
    path.write_text(dumps(machine))
    return load(type(machine), path)


def test_the_printed_default():
    lines = dumps(Machine()).splitlines()
    at = lines.index("[valve.solenoid]")
    assert lines[at - 1] == "# Two three-way solenoid valves, driven together."
    assert lines[at - 2] == ""
    assert lines[at + 1] == 'effective_area = "9 mm^2" # 0.1 to 500 mm^2; chosen'
    assert lines[lines.index("[supply]") - 1] == "# The receiver before the valve."
    assert 'stroke = "9 mm" # 1 to 50 mm; Table 1' in lines
    assert 'pressure = "1 MPa gauge" # 0.02 to 30 MPa abs; chosen' in lines
    assert 'control_air = "regulator" # "regulator" or "receiver"; Fig. 3' in lines
    assert '# control_pressure = ""  # default: the supply\'s; 0.02 to 30 MPa abs; chosen' in lines
    assert 'volume = "inf" # at least 0 L; chosen' in lines
    assert "strength = 0.0 # 0 to 10; chosen" in lines
    assert any(line.startswith('# opening_curve = ""  # not given; a CSV with') for line in lines)


def test_the_printed_default_names_every_key():
    data = tomllib.loads(
        dumps(Machine()).replace("# control_pressure", "control_pressure").replace("# opening", "opening")
    )

    def keys(table, section=""):
        for key, value in table.items():
            yield from keys(value, f"{section}{key}.") if isinstance(value, dict) else [section + key]

    assert sorted(keys(data)) == sorted(leaf.key for leaf in schema(Machine))


def test_the_printed_default_reads_back_bit_for_bit(tmp_path):
    assert same(reloaded(Machine(), tmp_path), Machine())


@given(data=st.data())
def test_every_tree_reads_back_bit_for_bit(tmp_path_factory, data):
    curve = np.array([[0.0, 0.0], [data.draw(st.floats(1e-9, 1)), data.draw(st.floats(0, 1))]])
    machine = Machine(
        Ambient(data.draw(st.floats(20e3, 500e3)), data.draw(st.floats(200, 350))),
        Supply(
            data.draw(st.floats(0.02e6, 30e6)),
            data.draw(st.integers(0, 1)),
            data.draw(st.one_of(st.just(math.nan), st.floats(0.02e6, 30e6))),
            data.draw(st.floats(0, math.inf)),
        ),
        Valve(
            data.draw(st.floats(10e-3, 50e-3)),
            Solenoid(data.draw(st.floats(1e-7, 5e-4)), data.draw(st.floats(0, 10e-3)), curve),
            data.draw(st.floats(0, 9e-3)),
        ),
        Leakage(data.draw(st.floats(0, 10)), data.draw(st.floats(0, 1e-5))),
    )
    assert same(reloaded(machine, tmp_path_factory.mktemp("m")), machine)


class Given(NamedTuple):
    """Optional keys whose defaults are given."""

    length: Annotated[float, Quantity("mm", 1, 50, "chosen", text="none", optional=True)] = 9e-3
    ratio: Annotated[float, Quantity("", 0, math.inf, "chosen", optional=True)] = math.inf
    curve: Annotated[np.ndarray, Curve(("time [ms]", "area [mm^2]"), "chosen")] = np.array([[0.0, 0.0], [1e-3, 1e-6]])


def test_not_given_where_the_default_is_given(tmp_path):
    assert same(reloaded(Given(), tmp_path), Given())
    assert same(reloaded(Given(math.nan, math.nan, NO_CURVE), tmp_path), Given(math.nan, math.nan, NO_CURVE))


# ---- schema


def test_schema():
    leaves = {leaf.key: leaf for leaf in schema(Machine)}
    assert list(leaves)[:3] == ["ambient.pressure", "ambient.temperature", "supply.pressure"]
    assert "valve.solenoid.opening_curve" in leaves
    assert leaves["valve.stroke"].declaration.unit == "mm"
    assert leaves["valve.stroke"].default == 9e-3
    assert leaves["leakage.strength"].default == 0.0


Effects = NamedTuple("Effects", [(cls.__name__.lower(), cls) for cls in (Leakage, Valve)])
Effects.__doc__ = "Made by a call."
Effects.__new__.__defaults__ = (Leakage(), Valve(stroke=8e-3))


def test_a_class_made_by_a_call(tmp_path):
    assert same(load(Effects, None, ["leakage.strength=3"]), Effects(Leakage(strength=3.0)))
    assert same(reloaded(Effects(Leakage(2.0)), tmp_path), Effects(Leakage(2.0)))


class Undeclared(NamedTuple):
    stroke: float = 3.0


class Unfilled(NamedTuple):
    stroke: Annotated[float, Quantity("mm", 1, 50, "")]


@pytest.mark.parametrize("cls", [Undeclared, Unfilled])
def test_a_field_needs_a_declaration_and_a_default(cls):
    with pytest.raises(TypeError, match=r"stroke"):
        list(schema(cls, cls(3.0)))


# ---- optional sections


class Bounce(NamedTuple):
    """Stops that give back a share of the speed."""

    restitution: Annotated[float, Quantity("", 0, 0.6, "steel on steel")] = 0.0


class Seat(NamedTuple):
    """What the ring rubs on."""

    roughness: Annotated[float, Quantity("um", 0, 10, "chosen")] = 1e-6


class Friction(NamedTuple):
    """Constant friction against the motion."""

    force: Annotated[float, Quantity("N", 0, 12, "chosen")] = 0.0
    breakaway: Annotated[float, Quantity("N", 0, 50, "chosen")] = 0.0
    seat: Seat = Seat()

    def faults(self):
        if self.breakaway < self.force:
            yield "breakaway", "is below the force", "at least the force"


class Heat(NamedTuple):
    """Heat from the walls."""

    h: Annotated[float, Quantity("W/(m^2 K)", 0, 500, "constant part")] = 0.0
    factor: Annotated[float, Quantity("", 0, 5, "on the correlation")] = 0.0
    correlation: Annotated[int, Choice(("woschni", "annand"), "cold gas")] = 0


class Shift(NamedTuple):
    """A measured shift."""

    time: Annotated[float, Quantity("ms", -1, 1, "chosen", text="the curve's", optional=True)] = math.nan
    curve: Annotated[np.ndarray, Curve(("time [ms]", "shift [ms]"), "measured")] = NO_CURVE
    scale: Annotated[float, Quantity("", 0, math.inf, "chosen")] = 1.0


class Library(NamedTuple):
    """Effects: a table that is present switches its effect on."""

    bounce: Bounce = Bounce()
    friction: Friction = Friction()
    heat: Heat = Heat()
    shift: Shift = Shift()
    seat: Seat = Seat()


Library.due = {
    "bounce": ("restitution",),
    "friction": ("force",),
    "heat": ("h", "factor"),
    "shift": ("time", "curve"),
}


class Rig(NamedTuple):
    """A machine with effects."""

    ambient: Ambient = Ambient()
    effects: Library = Library()
    leakage: Leakage = Leakage()


@pytest.mark.parametrize(
    ("data", "key", "wrong", "right"),
    [
        ("[effects.bounce]", "effects.bounce", "is present without restitution", "give restitution = 0.6"),
        (
            "[effects]\nbounce = {}",
            "effects.bounce",
            "is present without restitution",
            "give restitution = 0.6",
        ),
        ("effects.friction.seat = {}", "effects.friction", "is present without force", 'give force = "12 N"'),
        (
            '[effects.friction]\nbreakaway = "3 N"',
            "effects.friction",
            "is present without force",
            'give force = "12 N"',
        ),
        (
            '[effects.heat]\ncorrelation = "annand"',
            "effects.heat",
            "is present without h or factor",
            'give h = "500 W/(m^2 K)" or factor = 5',
        ),
        (
            "[effects.shift]",
            "effects.shift",
            "is present without time or curve",
            'give time = "1 ms" or curve = "curve.csv"',
        ),
    ],
)
def test_a_present_section_gives_a_due_key(tmp_path, data, key, wrong, right):
    path = tmp_path / "m.toml"
    path.write_text(data)
    with pytest.raises(InputError) as caught:
        load(Rig, path)
    assert caught.value.faults == [(str(path), key, wrong, right)]


def test_a_due_key_on_the_command_line(tmp_path):
    assert same(load(Rig, None, ["effects.bounce.restitution=0.3"]), Rig(effects=Library(Bounce(0.3))))
    path = tmp_path / "m.toml"
    path.write_text('[effects.bounce]\n[effects.friction]\nbreakaway = "3 N"\n')
    loaded = load(Rig, path, ["effects.bounce.restitution=0.3", "effects.friction.force=2 N"])
    assert same(loaded, Rig(effects=Library(Bounce(0.3), Friction(2.0, 3.0))))


@pytest.mark.parametrize("assignment", ["effects.friction.breakaway=3 N", "effects.friction.seat.roughness=2 um"])
@pytest.mark.parametrize("data", ["", "[effects.friction]\n", '[effects.friction.seat]\nroughness = "1 um"\n'])
def test_the_place_of_a_section_without_a_due_key(tmp_path, data, assignment):
    path = tmp_path / "m.toml"
    path.write_text(data)
    with pytest.raises(InputError) as caught:
        load(Rig, path, [assignment])
    ((place, key, _, _),) = caught.value.faults
    assert key == "effects.friction"
    assert place == (str(path) if data.endswith('"\n') and "breakaway" in assignment else "--set")


def test_a_missing_due_key_is_told_with_the_other_faults(tmp_path):
    path = tmp_path / "m.toml"
    path.write_text(
        "[effects.bounce]\nrestitutoin = 0.3\n[effects.friction]\nfoo = 1\n[effects.heat]\nh = 5\n"
        "[effects.shift]\nscale = -1\n"
    )
    with pytest.raises(InputError) as caught:
        load(Rig, path)
    assert sorted((c.key, c.wrong) for c in caught.value.faults) == [
        ("effects.bounce.restitutoin", "unknown key"),
        ("effects.friction", "is present without force"),
        ("effects.friction.foo", "unknown key"),
        ("effects.heat.h", "5 has no unit"),
        ("effects.shift", "is present without time or curve"),
        ("effects.shift.scale", "-1 is out of range"),
    ]


def test_every_right_form_of_a_due_key_switches_on(tmp_path):
    for section, keys in Library.due.items():
        with pytest.raises(InputError) as caught:
            read(Rig, {"effects": {section: {}}}, "m.toml")
        forms = caught.value.faults[0].right.removeprefix("give ").split(" or ")
        assert [form.split(" = ")[0] for form in forms] == list(keys)
        for form in forms:
            if "curve" not in form and section != "friction":  # whose force needs a breakaway
                data = tomllib.loads(f"[effects.{section}]\n{form}")
                assert not same(read(Rig, data, "m.toml"), Rig())


@pytest.mark.parametrize(
    ("declaration", "text"),
    [
        (Quantity("mm", 1, 50, ""), '"50 mm"'),
        (Quantity("rpm", 0, 3000, ""), '"3000 rpm"'),
        (Quantity("L", 0, math.inf, ""), '"1 L"'),
        (Quantity("L", 5, math.inf, ""), '"5 L"'),
        (Quantity("L", -math.inf, math.inf, ""), '"1 L"'),
        (Quantity("", -3, 0, ""), "-3"),
        (Quantity("", -math.inf, 0, ""), "-1"),
        (Pressure(0.02, 30, "", show="gauge"), '"30 MPa abs"'),
        (Choice(("off", "on"), ""), '"on"'),
    ],
)
def test_a_right_form_is_not_zero(declaration, text):
    assert declaration.strong == text
    declaration.read(tomllib.loads(f"x = {text}")["x"])


@pytest.mark.parametrize(
    "due", [{"bounces": ("restitution",)}, {"bounce": "restitution"}, {"bounce": ()}, {"friction": ("seat",)}]
)
def test_due_names_keys_of_sections(due, monkeypatch):
    monkeypatch.setattr(Library, "due", due)
    with pytest.raises(TypeError, match=r"Library\.due"):
        dumps(Library())


def test_optional_sections_are_printed_as_comments(tmp_path):
    text = dumps(Rig(effects=Library(heat=Heat(factor=2.0))))
    assert (
        "# Constant friction against the motion.\n"
        "# [effects.friction]\n"
        '# force = "0 N" # 0 to 12 N; chosen\n'
        '# breakaway = "0 N" # 0 to 50 N; chosen\n'
        "#\n"
        "# # What the ring rubs on.\n"
        "# [effects.friction.seat]\n"
        '# roughness = "1 um" # 0 to 10 um; chosen\n'
        "\n"
        "# Heat from the walls.\n"
        "[effects.heat]\n"
        'h = "0 W/(m^2 K)" # 0 to 500 W/(m^2 K); constant part\n'
        "factor = 2.0 # 0 to 5; on the correlation\n"
    ) in text
    assert list(tomllib.loads(text)["effects"]) == ["heat", "seat"]
    uncommented = text.replace("# [effects.bounce]\n# rest", "[effects.bounce]\nrest").replace(" = 0.0 #", " = 0.3 #")
    path = tmp_path / "m.toml"
    path.write_text(uncommented)
    assert same(load(Rig, path).effects, Library(Bounce(0.3), heat=Heat(factor=2.0)))


OFF = st.just(0.0)


@given(data=st.data())
def test_every_tree_with_optional_sections_reads_back(tmp_path_factory, data):
    force = data.draw(OFF | st.floats(0, 12))
    effects = Library(
        Bounce(data.draw(OFF | st.floats(0, 0.6))),
        Friction(
            force,
            data.draw(st.just(force) | st.floats(force, 50)),
            Seat(data.draw(st.sampled_from([1e-6, 2e-6]))),
        ),
        Heat(data.draw(OFF | st.floats(0, 500)), data.draw(OFF | st.floats(0, 5)), data.draw(st.integers(0, 1))),
        Shift(
            data.draw(st.just(math.nan) | st.floats(-1e-3, 1e-3).map(lambda x: x + 0.0)),
            data.draw(st.sampled_from([NO_CURVE, np.array([[0.0, 0.0], [1e-3, 1e-6]])])),
            data.draw(st.sampled_from([1.0, math.inf])),
        ),
    )
    rig = Rig(effects=effects)
    assert same(reloaded(rig, tmp_path_factory.mktemp("m")), rig)


# ---- layout


class Curves(NamedTuple):
    """Two curves, and a key behind them."""

    first: Annotated[np.ndarray, Curve(("time [ms]", "area [mm^2]"), "measured")] = NO_CURVE
    second: Annotated[np.ndarray, Curve(("lift [mm]", 'a long "name" [-]'), "measured; " + "long " * 20)] = NO_CURVE
    last: Annotated[float, Quantity("mm", 1, 50, "chosen " * 20, text="none")] = 9e-3
    long: Annotated[float, Quantity("mm", 1, 50, "chosen " * 13, text="none", optional=True)] = math.nan
    ambient: Ambient = Ambient()


def test_lines_are_not_too_long(tmp_path):
    curve = np.column_stack([np.arange(100) / 7, np.arange(100) / 3])
    curves = Curves(curve, curve[:2], 8e-3)
    lines = dumps(curves).splitlines()
    assert max(map(len, lines)) <= 110
    assert lines[0] == "# Two curves, and a key behind them."
    assert lines[lines.index('last = "8 mm"') - 3].startswith("# 1 to 50 mm")
    assert lines[lines.index('# long = ""  # default: none') - 1].startswith("# 1 to 50 mm; chosen chosen")
    assert same(reloaded(curves, tmp_path), curves)
    assert same(reloaded(Curves(), tmp_path), Curves())


# ---- what is ignored


class Ignoring(NamedTuple):
    """Lengths of which one makes the other void."""

    long: Annotated[float, Quantity("mm", 0, 50, "chosen")] = 0.0
    short: Annotated[float, Quantity("mm", 0, 50, "chosen")] = 1e-3

    def overruled(self):
        if self.long:
            yield "short", ".long is given"
            yield "short", "all else is given"


class Twice(NamedTuple):
    """A section in two places."""

    first: Ignoring = Ignoring()
    second: Ignoring = Ignoring()


def test_a_reason_that_begins_with_a_dot_is_a_key_of_the_same_section():
    tree = Twice(second=Ignoring(long=1e-3))
    assert list(overruled(tree)) == [("second.short", "second.long is given"), ("second.short", "all else is given")]
