"""What a user is told of an operating point beside its numbers."""

import pytest
from machines import machine, settled

from apesim.air import CANTERA, CP_UP_TO
from engine.breathing import DEGREE
from engine.indicators import indicators
from studies.commands.engine import warnings_of

HOT_WALLS = {
    "intake": "ideal",
    "targets": (0.0, 30.0),
    "effects__cylinder_wall_heat__h": 500.0,
    "effects__cylinder_wall_heat__wall_temperature": 500.0,
}
HOT_AIR = {"intake": "ideal", "temperature": 600.0, "engine__exhaust__closes": 230.0 * DEGREE}


def told(rpm=1000.0, **options):
    a_machine = machine(**options)
    run = settled(a_machine, rpm)
    return warnings_of(run, indicators(a_machine, run)), run


def test_of_a_usual_operating_point_nothing_is_told():
    assert told(800.0)[0] == []


def test_more_than_isentropic_work_is_told_to_come_from_the_walls():
    [line], _ = told(60.0, **HOT_WALLS)
    assert "isentropic" in line
    assert told(60.0, intake="ideal", targets=(0.0, 30.0))[0] == []


@pytest.mark.parametrize(("air", "lines"), [(CANTERA, 1), (0, 0)])
def test_cp_beyond_its_range_is_told(air, lines):
    found, run = told(air__model=air, engine__compression_ratio=60.0, **HOT_AIR)
    assert run.trace[:, 1].max() > CP_UP_TO
    assert sum(f"{CP_UP_TO:g} K" in line for line in found) == lines
