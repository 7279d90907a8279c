"""Shaft and load in a machine file: read, printed, refused; of no matter to a steady run."""

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.engine.shaft import BRAKE, HOIST, Load
from apesim.quantities import InputError

TABLE = '[load]\ntable = { "speed [rpm]" = [0, 60], "torque [N m]" = [1, 2] }\n'


def test_the_defaults_are_those_that_are_said():
    shaft, load = Machine().shaft, Machine().load
    assert (shaft.inertia, shaft.breakaway_factor, shaft.breakaway_speed) == (0.1, 2.0, 2.0 * np.pi)
    assert (load.kind, load.constant, load.proportional, load.quadratic, load.table.size) == (BRAKE, 0.0, 0.0, 0.0, 0)
    assert 'breakaway_speed = "60 rpm"' in Machine().to_toml()


def test_the_section_and_the_reader_have_one_name():
    machine = Machine.load(settings=["load.kind=hoist", "load.constant=-3 N m"])
    assert machine.load == machine[Machine._fields.index("load")] != Load()
    assert machine.load.kind == HOIST and machine.load.constant == -3.0
    assert type(machine).load().load.kind == BRAKE
    outside = machine.with_effects("docs/examples/data/tapered_bore.py")
    assert outside.load == machine.load
    with pytest.raises(InputError):
        type(outside).load(settings=["load.kind=crane"])


def test_they_are_read_and_printed(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(TABLE + 'quadratic = "2.8e-3 N m s^2"\nproportional = "1 N s m"\n[shaft]\ninertia = "50 kg cm^2"\n')
    machine = Machine.load(path)
    assert machine.load.table[:, 0] == pytest.approx([0.0, 2.0 * np.pi], rel=1e-15)
    assert machine.load.table[:, 1].tolist() == [1.0, 2.0]
    assert (machine.load.quadratic, machine.load.proportional, machine.shaft.inertia) == (2.8e-3, 1.0, 5e-3)
    path.write_text(machine.to_toml())
    assert Machine.load(path) == machine


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (["load.constant=-3 N m"], 'load.constant: -3 N m would drive the shaft; at least 0 N m, or kind = "hoist"'),
        (["load.kind=hoist", "load.proportional=1 N m s"], "load.proportional: is given for a hoist"),
        (["load.kind=hoist", "load.quadratic=1 N m s^2"], "load.quadratic: is given for a hoist"),
        (["shaft.breakaway_factor=0.9"], "out of range"),
        (["shaft.inertia=0 kg m^2"], "out of range"),
        (["shaft.inertia=3 kgm^2"], 'write "3 kg m^2"'),
        (["load.quadratic=3 Nms^2"], 'write "3 N m s^2"'),
    ],
)
def test_what_cannot_be_is_refused(settings, told):
    with pytest.raises(InputError) as caught:
        Machine.load(settings=settings)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ([[0.0, 1.0], [5.0, -1.0]], "load.table: has a speed or a torque below 0"),
        ([[-1.0, 1.0], [5.0, 1.0]], "load.table: has a speed or a torque below 0"),
        ([[5.0, 1.0], [1.0, 1.0]], "does not rise"),
    ],
)
def test_a_table_of_torque_over_speed_acts_against_the_motion(table, told):
    with pytest.raises(InputError, match=told):
        Machine().with_(load_table=np.array(table))
    with pytest.raises(InputError, match=r"load.table: is given for a hoist"):
        Machine().with_(load_kind="hoist", load_table=np.array([[0.0, 1.0], [5.0, 2.0]]))
