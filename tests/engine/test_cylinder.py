"""Number and phases of the cylinders in a machine file."""

import numpy as np
import pytest

from apesim.engine.cycle.operating_point import cycle_of
from apesim.engine.machine import Machine
from apesim.quantities import InputError


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
