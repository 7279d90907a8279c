"""Second stage and inter-receiver in a machine file: read, printed, refused; nothing that is marched knows them yet."""

import numpy as np
import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.engine.second_stage import SecondStage
from apesim.engine.steady import known_state, run_steady
from apesim.quantities import InputError

ON = "stage_2.bore=120 mm"


def faults(*settings):
    with pytest.raises(InputError) as caught:
        Machine.load(settings=settings)
    return [f"{fault.key}: {fault.wrong}; {fault.right}" for fault in caught.value.faults]


def test_there_is_no_second_stage_by_default():
    machine = Machine()
    assert not machine.stage_2.is_on and machine.stage_2 == SecondStage()
    assert "# [stage_2]\n" in machine.to_toml() and "\n[stage_2" not in machine.to_toml()
    stage, engine = machine.stage_2, machine.engine
    same = ("stroke", "rod_length", "pin_offset", "compression_ratio", "exhaust")
    assert [getattr(stage, key) for key in same] == [getattr(engine, key) for key in same]
    assert stage.command == machine.command and stage.phase == np.pi
    assert machine.inter_receiver[:2] == (2e-3, 0.0) and machine.inter_receiver.wall_conductance == 0.0


def test_a_table_that_is_present_switches_it_on(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(
        '[stage_2]\nbore = "120 mm"\ngroove.lap = "2 mm"\ncommand.energise = "-20 deg"\n'
        '[inter_receiver]\nvolume = "3 L"\neffectiveness = 0.8\ntemperature = "350 K"\nwall_conductance = "2 W/K"\n'
    )
    machine = Machine.load(path)
    assert machine.stage_2.is_on and machine.stage_2.groove.lap == 2e-3 and machine.groove.lap == 1e-3
    assert machine.command == Machine().command != machine.stage_2.command
    assert machine.inter_receiver == (3e-3, 0.8, 350.0, 2.0)
    for keys in ("all", "first"):
        path.write_text(machine.to_toml(keys))
        assert Machine.load(path) == machine
    path.write_text('[stage_2]\nstroke = "90 mm"\n')
    with pytest.raises(InputError, match='stage_2: is present without bore; give bore = "1000 mm"'):
        Machine.load(path)


def test_one_that_is_off_with_keys_of_its_own_reads_back(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text('[stage_2]\nbore = "0 mm"\nstroke = "90 mm"\n')
    machine = Machine.load(path)
    for keys in ("all", "first"):
        path.write_text(machine.to_toml(keys))
        assert Machine.load(path) == machine
    assert machine.find_ignored_keys() == {"stage_2.stroke": "stage_2.bore is 0"}


def test_a_key_of_a_section_of_a_stage_that_is_on_is_set_alone():
    machine = Machine().with_(stage_2_bore="120 mm")
    assert machine.with_(stage_2_groove_lap="2 mm").stage_2.groove.lap == 2e-3
    with pytest.raises(InputError, match="stage_2: is present without bore"):
        Machine().with_(stage_2_groove_lap="2 mm")


def test_exchanger_and_wall_are_at_ambient_temperature_unless_given():
    assert Machine().inter_receiver.resolve_temperature(290.0) == 290.0
    assert (
        Machine.load(settings=[ON, "inter_receiver.temperature=350 K"]).inter_receiver.resolve_temperature(290.0)
        == 350.0
    )


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (["stage_2.bore=2 mm"], "stage_2.bore: 2 mm is no cylinder; at least 5 mm, or 0 mm: there is none"),
        ([ON, "stage_2.rod_length=44 mm"], "stage_2.rod_length: the crank cannot turn; more than half the stroke plus"),
        ([ON, "stage_2.groove.lap=9 mm"], "stage_2.groove.lap: the groove never opens; less than the valve's stroke"),
        (
            [ON, "stage_2.groove.geometry=ports", "stage_2.groove.ports.number=40"],
            "stage_2.groove.ports.number: 40 ports of 8 mm overlap",
        ),
        ([ON, "stage_2.command.release=-6 deg"], "stage_2.command.release: release at -6 deg is 1 deg before energise"),
        ([ON, "stage_2.exhaust.closes=165 deg"], "stage_2.exhaust.closes: "),
        ([ON, "engine.cylinders=2"], "engine.cylinders: is 2 beside a second stage; write 1: two stages have one"),
        ([ON, "inter_receiver.effectiveness=1.1"], "out of range"),
        ([ON, "inter_receiver.volume=inf"], "inter_receiver.volume: "),
        (["inter_receiver.volume=3 L"], "inter_receiver.volume: is ignored: stage_2.bore is 0"),
        ([ON, "stage_2.groove.ports.number=3"], 'is ignored: stage_2.groove.geometry is "line"'),
    ],
)
def test_what_cannot_be_is_refused(settings, told):
    (line,) = faults(*settings)
    assert told in line


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"engine_cylinders": 3}, "engine.cylinders: is 3, and one alone is marched; write 1"),
        ({"stage_2_bore": "120 mm"}, "stage_2.bore: switches a second stage on"),
        ({"cylinder": [{"valve.stroke": "8 mm"}]}, r"cylinder\[1\]: has keys of its own for the only cylinder"),
    ],
)
def test_a_steady_run_refuses_what_it_does_not_march(keys, told):
    machine = Machine().with_(**keys)
    for call in (
        lambda: run_steady(machine, 100.0),
        lambda: known_state(machine, 100.0),
        lambda: apesim.assess_valve(machine, speed="1000 rpm"),
    ):
        with pytest.raises(InputError, match=told):
            call()
