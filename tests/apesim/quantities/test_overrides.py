"""Arrays of tables that give keys of a tree other values: read strictly, printed without loss, compared."""

import math
import tomllib
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from apesim.quantities import NO_CURVE, Choice, Curve, InputError, Pressure, Quantity
from apesim.quantities.overrides import Overridden, Overrides
from apesim.quantities.settings import differences, dumps, load, replaced
from apesim.quantities.trees import Spelling, contents_of


class Ambient(NamedTuple):
    """Air around."""

    pressure: Annotated[float, Pressure(0.02, 0.5, "chosen")] = 101325.0


class Solenoid(NamedTuple):
    """Solenoid valve."""

    dead_time: Annotated[float, Quantity("ms", 0, 10, "chosen")] = 1e-3
    release: Annotated[float, Quantity("ms", 0, 10, "chosen", optional=True)] = math.nan
    curve: Annotated[np.ndarray, Curve(("time [ms]", "opening [-]"), "measured")] = NO_CURVE


class Valve(NamedTuple):
    """Valve."""

    area: Annotated[float, Quantity("mm^2", 1, 1000, "chosen")] = 1e-4
    control: Annotated[float, Pressure(0.02, 30, "chosen", show="gauge")] = 501325.0
    ports: Annotated[float, Quantity("", 1, 9, "chosen", whole=True)] = 4.0
    kind: Annotated[int, Choice(("line", "ports"), "chosen")] = 0
    solenoid: Solenoid = Solenoid()

    @staticmethod
    def spellings():
        side = Quantity("mm", 1, 30, "another spelling")
        return {"side": Spelling("area", side, lambda length: length * length)}


class Own(NamedTuple):
    """What a cylinder may have of its own."""

    valve: Valve = Valve()


class Machine(NamedTuple):
    """Machine with tables."""

    ambient: Ambient = Ambient()
    valve: Valve = Valve()
    cylinder: Annotated[tuple[Overridden, ...], Overrides(Own, "cylinder", "valve.ports = 3", 3, "For each one.")] = ()


ALL = """
[[cylinder]]
[[cylinder]]
valve.solenoid.dead_time = "1.7 ms"
valve.side = "20 mm"
valve.control = "0.5 MPa gauge"
valve.ports = 3
valve.kind = "ports"
valve.solenoid.release = ""
valve.solenoid.curve = { "time [ms]" = [1, 3], "opening [-]" = [0, 1] }
[ambient]
pressure = "0.09 MPa abs"
"""


@pytest.fixture
def path(tmp_path):
    return tmp_path / "machine.toml"


def read(path, text, settings=()):
    path.write_text(text)
    return load(Machine, path, settings)


def faults(path, text, settings=()):
    with pytest.raises(InputError) as caught:
        read(path, text, settings)
    return str(caught.value).replace(f"{path}: ", "").splitlines()


def test_tables_are_read_in_order_each_value_like_the_same_key_of_the_tree(path):
    first, second = read(path, ALL).cylinder
    values = dict(second)
    assert first == ()
    assert list(values) == [f"valve.{key}" for key in ("area", "control", "ports", "kind")] + [
        f"valve.solenoid.{key}" for key in ("dead_time", "release", "curve")
    ]
    assert (values["valve.solenoid.dead_time"], values["valve.area"], values["valve.kind"]) == (1.7e-3, 4e-4, 1)
    assert values["valve.control"] == 590e3 and math.isnan(values["valve.solenoid.release"])
    assert values["valve.solenoid.curve"].tolist() == [[1e-3, 0.0], [3e-3, 1.0]]


def test_what_is_printed_reads_back_bit_for_bit(path):
    machine = read(path, ALL)
    assert contents_of(read(path, dumps(machine))) == contents_of(machine)
    assert tomllib.loads(dumps(machine))["cylinder"][0] == {}
    keys = [key for key, _ in differences(machine)]
    assert contents_of(read(path, dumps(machine, keys=keys))) == contents_of(machine)


def test_the_default_says_how_to_write_a_table():
    assert dumps(Machine()).endswith("# For each one.\n# [[cylinder]]\n# valve.ports = 3\n")


def test_the_order_of_keys_in_a_table_does_not_count(path):
    text = '[[cylinder]]\nvalve.kind = "ports"\nvalve.ports = 3\n'
    turned = '[[cylinder]]\n"valve.ports" = 3\n"valve.kind" = "ports"\n'
    assert contents_of(read(path, text)) == contents_of(read(path, turned))


def test_differences_name_each_key_with_its_table(path):
    told = dict(differences(read(path, ALL)))
    assert told["cylinder[1]"] == "no key of its own"
    assert told["cylinder[2].valve.solenoid.dead_time"] == "1.7 ms"
    assert told["cylinder[2].valve.ports"] == "3"
    assert told["cylinder[2].valve.solenoid.curve"] == "a curve of 2 points"
    assert told["cylinder[2].valve.solenoid.release"] == "not given"
    assert not list(differences(Machine()))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            '[[cylinder]]\n[[cylinder]]\nvalve.area = "3"',
            "cylinder[2].valve.area: '3' has no unit; write e.g. \"3 mm^2\"",
        ),
        ('[[cylinder]]\nvalve.area = "0 mm^2"', "cylinder[1].valve.area: '0 mm^2' is out of range"),
        ("[[cylinder]]\nvalve.ports = 2.5", "cylinder[1].valve.ports: 2.5 is no whole number; write 2 or 3"),
        ('[[cylinder]]\nvalve.kind = "lines"', "cylinder[1].valve.kind: 'lines' is no option"),
        ('[[cylinder]]\nvalve.solenoid.curve = "../no.csv"', "cylinder[1].valve.solenoid.curve: "),
        ("[[cylinder]]\nvalve.port = 2", "cylinder[1].valve.port: unknown key; did you mean valve.ports?"),
        ("[[cylinder]]\nports = 2", "cylinder[1].ports: unknown key; did you mean valve.ports?"),
        ("[[cylinder]]\nengine.bore = 2", "cylinder[1].engine: unknown key; valid here: valve"),
        ("[[cylinder]]\nvalve = 2", "cylinder[1].valve: is a section, no key; set one of valve.area, "),
        (
            '[[cylinder]]\nvalve.ports = 2\n"valve.ports" = 3',
            "cylinder[1].valve.ports: is given twice; give it once",
        ),
        (
            '[[cylinder]]\nvalve.area = "9 mm^2"\nvalve.side = "3 mm"',
            "cylinder[1].valve.side: is given twice; give it once",
        ),
        ("[[cylinder]]\n" * 4, "cylinder: 4 tables are too many; write at most 3"),
        ("[cylinder]\nvalve.ports = 2", "is no list of tables; write [[cylinder]] and valve.ports = 3"),
        ("cylinder = [2]", "cylinder: [2] is no list of tables"),
    ],
)
def test_what_is_wrong_is_told_with_the_number_of_the_table(text, told, path):
    (line,) = faults(path, text)
    assert told in line


def test_all_faults_are_told_and_of_many_unknown_keys_the_first_alone(path):
    lines = faults(path, '[[cylinder]]\nvalve.area = "3"\n[[cylinder]]\nvalve.kind = "x"')
    assert len(lines) == 2
    lines = faults(path, "[[cylinder]]\n" + "".join(f"a{number} = 1\n" for number in range(60)))
    assert len(lines) == 51 and lines[-1] == "cylinder[1]: 10 more unknown keys; mend the first 50 of them"


def test_a_key_of_a_table_is_set_on_the_command_line(path, tmp_path, monkeypatch):
    text = '[[cylinder]]\n[[cylinder]]\nvalve.solenoid.dead_time = "1.7 ms"\nvalve.ports = 2'
    settings = ['cylinder[2].valve.solenoid.dead_time="2 ms"', "cylinder[3].valve.kind=ports"]
    first, second, third = read(path, text, settings).cylinder
    assert (first, second[1], third) == ((), ("valve.solenoid.dead_time", 2e-3), (("valve.kind", 1),))
    assert second[0] == ("valve.ports", 2.0)
    assert faults(path, text, ["cylinder[2].valve.ports=x"])[0].startswith("--set: cylinder[2].valve.ports: 'x'")
    assert faults(path, text, ["cylinder[4].valve.ports=2"])[0].endswith("no number 4; count from 1 to 3")
    assert faults(path, text, ["cylinder[0].valve.ports=2"])[0].endswith("no number 0; count from 1 to 3")
    assert "is no list of tables" in faults(path, "cylinder = 3", ["cylinder[1].valve.ports=2"])[0]
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "curve.csv").write_text("time [ms],opening [-]\n0,0\n1,1\n")
    monkeypatch.chdir(tmp_path)
    settings = ["cylinder[1].valve.solenoid.curve=curve.csv"]
    ((pair,),) = read(tmp_path / "elsewhere" / "machine.toml", "", settings).cylinder
    assert pair[1].tolist() == [[0.0, 0.0], [1e-3, 1.0]]


def test_they_are_set_from_python(path):
    given = [{}, {"valve.ports": 3, "valve.area": "2 cm^2", "valve.solenoid.dead_time": (2, "ms"), "valve.kind": 1}]
    machine = replaced(Machine(), {"cylinder": given}, "with_()")
    assert dict(machine.cylinder[1]) == {
        "valve.area": 2e-4,
        "valve.ports": 3.0,
        "valve.kind": 1,
        "valve.solenoid.dead_time": 2e-3,
    }
    assert replaced(Machine(), {"cylinder": machine.cylinder}, "with_()") == machine
    assert replaced(machine, {"cylinder": []}, "with_()") == Machine()
    curve = np.array([[0.0, 0.0], [1.0, 1.0]])
    held = replaced(Machine(), {"cylinder": [{"valve.solenoid.curve": curve}]}, "with_()").cylinder[0][0][1]
    curve[1, 0] = 5.0
    assert held[1, 0] == 1.0  # the caller's array is his own


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ([{"valve.area": 5.0}], r"with_\(\): cylinder\[1\]\.valve\.area: 5000000 mm\^2 is out of range"),
        ([{"valve.port": 5.0}], r"cylinder\[1\]\.valve\.port: unknown key; did you mean valve.ports\?"),
        ([(("valve.port", 5.0),)], "unknown key"),
        ([(("valve.area", 5.0),)], "out of range"),
        ([3], "are no pairs of key and value"),
        (3, "are no pairs of key and value"),
        ([{}, 3], "is no list of tables"),
        ([{}] * 4, "4 tables are too many"),
        ([()] * 4, "4 tables are too many"),
        ("x", "is no list of tables"),
    ],
)
def test_what_is_wrong_in_python_is_refused(given, told):
    with pytest.raises(InputError, match=told):
        replaced(Machine(), {"cylinder": given}, "with_()")
