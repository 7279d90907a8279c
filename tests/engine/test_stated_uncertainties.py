"""How far numbers are known, in a machine file: read strictly, kept with the machine, of no matter to simulations."""

import pickle

import pytest

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.quantities.uncertainties import Uncertainty
from apesim.valve.bench import run_bench

STATED = {
    "valve.stroke": "0.05 mm",
    "sensor.lift.gain": "0.2 %",
    "supply.pressure": "0.5 %",
    "valve.moving_mass": "exact",
}
PAIRS = (
    ("valve.stroke", Uncertainty(5e-5)),
    ("effects.sensor_gain.lift", Uncertainty(0.002)),
    ("supply.pressure", Uncertainty(0.005, is_share=True)),
    ("valve.moving_mass", Uncertainty(0.0)),
)
TABLE = "[known_to]\n" + "".join(f'"{key}" = "{text}"\n' for key, text in STATED.items())


@pytest.fixture
def path(tmp_path):
    return tmp_path / "machine.toml"


def lines(path, settings=()):
    with pytest.raises(InputError) as caught:
        Machine.load(path, settings)
    return str(caught.value).replace(f"{path}: ", "").splitlines()


def test_a_table_is_read_kept_and_printed(path):
    path.write_text(TABLE)
    machine = Machine.load(path)
    assert machine.known_to == PAIRS
    assert machine.with_(engine_bore="90 mm").known_to == PAIRS
    assert pickle.loads(pickle.dumps(machine)).known_to == PAIRS
    assert machine.to_toml().endswith(TABLE)
    path.write_text(machine.to_toml())
    assert Machine.load(path).known_to == PAIRS
    assert "known_to.sensor.lift.gain = 0.2 %" in repr(machine)


def test_the_default_says_how_to_write_one(path):
    text = Machine().to_toml()
    assert text.endswith('# [known_to]\n# "valve.stroke" = "0.05 mm"\n')
    path.write_text(text.replace("# [known_to]\n# ", "[known_to]\n"))
    assert Machine.load(path).known_to == PAIRS[:1]


def test_it_is_set_from_python_and_from_the_command_line(path):
    assert Machine().with_(known_to=STATED).known_to == PAIRS
    assert Machine().with_(known_to=PAIRS).known_to == PAIRS
    assert Machine().with_(known_to=STATED).with_(known_to={}).known_to == ()
    path.write_text("[known_to]\nvalve.stroke = '1 %'\nvalve.moving_mass = '2 %'\n")
    known_to = dict(Machine.load(path, ["known_to.valve.stroke=0.05 mm", "known_to.sensor.lift.gain=0.2 %"]).known_to)
    assert known_to == dict(PAIRS[:2]) | {"valve.moving_mass": Uncertainty(0.02, is_share=True)}


def test_it_is_kept_by_a_machine_with_an_effect_from_outside():
    machine = Machine().with_(known_to=STATED).with_effects("docs/examples/data/tapered_bore.py")
    assert machine.known_to == PAIRS
    assert machine.to_toml().endswith(TABLE)


def test_every_fault_is_told_with_the_right_form(path):
    path.write_text('[known_to]\n"valve.strok" = "1 %"\n"valve.stroke" = "1"\nengine.intake = "1 %"\n')
    assert lines(path) == [
        'known_to.valve.stroke: \'1\' has no unit; write e.g. "1 %" or "0.09 mm"',
        "known_to.valve.strok: unknown key; did you mean valve.stroke?",
        "known_to.engine.intake: is no number that can be known within a standard deviation; leave it out",
    ]
    path.write_text('known_to = "1 %"\n')
    assert lines(path) == ['known_to: \'1 %\' is no table; write [known_to] and "valve.stroke" = "0.05 mm"']
    path.write_text('[known_to]\n"engine.pin_offset" = "1 %"\n"valve.solenoid.release_dead_time" = "1 ms"\n')
    assert lines(path) == [
        "known_to.engine.pin_offset: is a share of 0; write a number of mm",
        "known_to.valve.solenoid.release_dead_time: the machine gives it no value; give it one, or leave it out here",
    ]
    assert lines(None, ["known_to.valve.strok=1 %"]) == [
        "--set: known_to.valve.strok: unknown key; did you mean valve.stroke?"
    ]


def test_pairs_that_no_table_gives_are_refused():
    for wrong in ((("valve.stroke", Uncertainty(-1e-3)),), (("valve.strok", Uncertainty(1e-3)),), ("valve.stroke",), 3):
        with pytest.raises(InputError, match="known_to"):
            Machine().with_(known_to=wrong)


def test_nothing_that_is_simulated_reads_it():
    plain, stated = (run_bench(machine, 30e-3, 40e-3) for machine in (Machine(), Machine().with_(known_to=STATED)))
    assert plain.trace.tobytes() == stated.trace.tobytes()
