"""Number and phases of the cylinders in a machine file, and what is their own."""

import pickle

import numpy as np
import pytest

from apesim.engine.cycle.operating_point import cycle_of
from apesim.engine.machine import Machine, OwnKeys
from apesim.quantities import InputError
from apesim.quantities.trees import leaves_of


def phases_of(**keys):
    return np.degrees(Machine().with_(**keys).engine.resolve_phases()).round(9).tolist()


def test_phases_are_evenly_spread_where_they_are_not_given():
    assert phases_of() == [0.0]
    assert phases_of(engine_cylinders=3) == [0.0, 120.0, 240.0]
    assert phases_of(engine_cylinders=3, engine_phases="10, 10, 350 deg") == [10.0, 10.0, 350.0]


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (["engine.phases=0, 120 deg"], "engine.phases: 2 angles are given for 1 cylinder; give one for each"),
        (["engine.cylinders=2", "engine.phases=0 deg"], "engine.phases: 1 angle is given for 2 cylinders"),
        (["engine.phases=360 deg"], "engine.phases: 360 deg is a whole turn; at least 0 and less than 360 deg"),
        (["engine.phases=-1 deg"], "out of range"),
        (["engine.cylinders=9"], "out of range"),
        (["engine.cylinders=0"], "out of range"),
        (["engine.cylinders=1.5"], "is no whole number"),
    ],
)
def test_what_cannot_be_is_refused(settings, told):
    with pytest.raises(InputError) as caught:
        Machine.load(settings=settings)
    assert told in str(caught.value)


def test_phases_are_compared_hashed_and_printed(tmp_path):
    machine = Machine().with_(engine_cylinders=2, engine_phases="0, 90 deg")
    other = Machine().with_(engine_cylinders=2, engine_phases="0, 91 deg")
    assert machine != other and machine == Machine().with_(engine_cylinders=2, engine_phases="0, 90 deg")
    assert hash(machine) != hash(other) and "engine.phases = 0, 90 deg" in repr(machine)
    path = tmp_path / "machine.toml"
    path.write_text(machine.to_toml())
    assert Machine.load(path) == machine


def test_kernels_get_no_array_of_phases():
    cycle, _, _ = cycle_of(Machine().with_(engine_phases="10 deg"), 100.0)
    assert cycle.engine.phases is None


OWN = {"valve.solenoid.dead_time": "1.7 ms", "command.energise": "-8 deg"}


def test_the_machine_of_a_cylinder_has_what_is_its_own():
    machine = Machine().with_(engine_cylinders=3, cylinder=[{}, OWN])
    plain, own, untold = (machine.machine_of_cylinder(index) for index in range(3))
    assert plain == untold == Machine().with_(engine_cylinders=3)
    assert own == plain.with_(**OWN)
    for index in (-1, 3, 1.5, "1"):
        with pytest.raises(InputError, match="is no cylinder of 3; give a whole number from 0 to 2"):
            machine.machine_of_cylinder(index)


def test_tables_of_cylinders_are_read_printed_compared_and_pickled(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(
        '[engine]\ncylinders = 2\n[[cylinder]]\n[[cylinder]]\nvalve.solenoid.dead_time = "1.7 ms"\n'
        'command.energise = "-8 deg"\ngroove.area_curve = { "lift [mm]" = [1, 9], "effective_area [mm^2]" = [0, 90] }\n'
    )
    machine = Machine.load(path)
    for keys in ("all", "first"):
        path.write_text(machine.to_toml(keys))
        assert Machine.load(path) == machine == pickle.loads(pickle.dumps(machine))
    assert hash(machine) == hash(Machine.load(path)) != hash(machine._replace(cylinder=()))
    assert machine != machine._replace(cylinder=())
    assert "cylinder[2].command.energise = -8 deg" in repr(machine)
    outside = machine.with_effects("docs/examples/data/tapered_bore.py")
    assert outside.machine_of_cylinder(1).command == machine.machine_of_cylinder(1).command


@pytest.mark.parametrize(
    ("own", "told"),
    [
        (
            {"command.energise": "80 deg"},
            "cylinder[2].command.release: release at 70 deg is 10 deg before energise at 80",
        ),
        ({"groove.lap": "9 mm"}, "cylinder[2].groove.lap: the groove never opens; less than the valve's stroke, 9 mm"),
        ({"valve.stroke": "9 m"}, "cylinder[2].valve.stroke: '9 m' is out of range"),
        ({"engine.bore": "9 mm"}, "cylinder[2].engine.bore: unknown key; valid here: valve, groove, command"),
    ],
)
def test_what_is_wrong_with_a_cylinder_of_its_own_is_told_once(own, told):
    with pytest.raises(InputError) as caught:
        Machine().with_(engine_cylinders=2, cylinder=[{}, own])
    assert told in str(caught.value) and len(caught.value.faults) == 1


def test_a_fault_of_the_machine_is_not_told_of_each_cylinder():
    with pytest.raises(InputError) as caught:
        Machine().with_(engine_cylinders=2, groove_lap="9 mm", cylinder=[OWN, OWN])
    assert [fault.key for fault in caught.value.faults] == ["groove.lap"]


def test_there_are_no_more_tables_than_cylinders():
    with pytest.raises(InputError, match="cylinder: has 2 tables for 1 cylinder; write at most 1, or raise engine"):
        Machine().with_(cylinder=[{}, OWN])


def test_a_key_of_a_cylinder_that_another_replaces_is_found():
    curve = np.array([[0.0, 0.0], [9e-3, 1e-4]])
    machine = Machine().with_(engine_cylinders=2, cylinder=[{"groove.lap": "2 mm"}, {"groove.lap": "2 mm"} | OWN])
    assert machine.find_ignored_keys() == {}
    machine = machine.with_(groove_area_curve=curve)
    assert machine.find_ignored_keys() == {
        "cylinder[1].groove.lap": "groove.area_curve is given",
        "cylinder[2].groove.lap": "groove.area_curve is given",
    }


def test_no_key_that_a_cylinder_may_have_follows_the_ambient_pressure():
    """Their values are kept as they were read: a gauge pressure would stand above the ambient of then."""
    assert not [leaf.key for leaf in leaves_of(OwnKeys).values() if leaf.declaration.is_gauge]
