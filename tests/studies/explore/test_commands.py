"""The command that the page hands on gives the machine of the page."""

import shlex
from itertools import pairwise

import pytest

from apesim.engine.machine import Machine
from apesim.studies.explore.commands import FILE, MAX_SETTINGS, command_of

MACHINES = {
    "default": {},
    "thin air": {
        "ambient_pressure": "80 kPa abs",
        "supply_pressure": "0.8 MPa gauge",
        "supply_control_pressure": "0.6 MPa abs",
    },
    "effect": {"effects_supply_droop_feed_area": "5 mm^2", "command_energise": "-30 deg"},
    "cam": {"engine_intake": "cam", "engine_receiver_volume": "inf", "engine_cylinders": 2},
}


@pytest.mark.parametrize("name", MACHINES)
def test_its_settings_make_the_machine(name):
    machine = Machine().with_(**MACHINES[name])
    words = shlex.split(command_of(machine, "1000 rpm"))
    assert words[:5] == ["apesim", "engine", "run", "--speed", "1000 rpm"]
    settings = [word for before, word in pairwise(words) if before == "--set"]
    assert len(settings) == len(MACHINES[name])
    assert Machine.load(settings=settings) == machine


def test_a_machine_that_no_settings_can_say_is_named_by_its_file():
    own = Machine().with_(engine_cylinders=2, cylinder=[{}, {"valve.solenoid.dead_time": "1.7 ms"}])
    many = Machine().with_(
        **{f"effects_tabulated_force_force_at_{10 * number}": "1 N" for number in range(MAX_SETTINGS + 1)}
    )
    for machine in (own, many):
        assert command_of(machine, "1000 rpm").endswith(f"--machine {FILE}")
