"""The public face refuses from Python what it refuses from a file, in the same words."""

import math
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest

import apesim
from apesim.effect import Effect, contact, unserved
from apesim.engine.effects import Effects
from apesim.engine.machine import Machine
from apesim.kernel import kernel
from apesim.quantities.checking import check
from apesim.quantities.settings import schema
from apesim.studies.commands.cli import app
from apesim.studies.terminal.console import main_of
from tests.folders import ROOT
from tests.machines import changed

W = "1000 rpm"
BAD = {
    "engine.bore": (-85e-3, math.nan, math.inf, "85 mm", True, None, 1j, [0.085]),
    "engine.intake": (3, -1, 0.0, "epv", True),
    "supply.pressure": (0.0, -1e5, math.nan),
    "engine.receiver.volume": (-1e-3, math.nan, -math.inf),
    "groove.lap": (9e-3,),  # the groove never opens
    "groove.area_curve": (np.zeros((3, 2)), np.array([[0.0, 0.0], [1e-3, math.nan]]), np.zeros(4), "curve.csv"),
    "command.release": (-0.5,),  # before the energising
    "effects.blow_by.area": (-1e-6, math.nan),
}


def refused(function, *arguments, **options):
    """Keys of what a call is refused for."""
    with pytest.raises(apesim.InputError) as caught:
        function(*arguments, **options)
    for fault in caught.value.faults:
        assert fault.file == f"{function.__name__}()" and fault.wrong and fault.right
    return [fault.key for fault in caught.value.faults]


@pytest.mark.parametrize(("key", "value"), [(key, value) for key, values in BAD.items() for value in values])
def test_a_machine_that_no_file_could_say_is_refused_by_every_call(tmp_path, key, value):
    bad = changed(Machine(), {key: value})
    out = tmp_path / "x.h5"
    assert refused(apesim.run_engine, bad, W) == refused(apesim.run_valve, bad) == [key]
    for function in (apesim.sweep, apesim.map_valve, apesim.find_valve_limit):
        assert refused(function, bad, out=out) == [key]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("end", ["low", "high"])
def test_a_value_at_an_end_of_its_range_is_taken_and_one_beyond_it_refused(end):
    """Each key alone, as a file's text would be."""
    for leaf in schema(Machine):
        value = getattr(leaf.declaration, end, None)
        if value is None or not math.isfinite(value):
            continue
        si = leaf.declaration.ends[end == "high"]
        leaf.declaration.check(si)
        beyond = si + (1e-9 * max(map(abs, leaf.declaration.ends)) or 1.0) * (1.0 if end == "high" else -1.0)
        with pytest.raises(ValueError):
            leaf.declaration.check(beyond)


def test_every_default_is_taken():
    for leaf in schema(Machine):
        leaf.declaration.check(leaf.default)
    check(Machine(), Machine, "")
    assert apesim.run_valve(Machine(), pulse=5e-3).march.steps > 0


@pytest.mark.parametrize(
    "speed", [0, 104.7, math.nan, "-9 rpm", (0.01, "rad/s"), "1000", "0 rpm", "1000 mm", True, [W]]
)
def test_a_speed_that_the_command_line_would_refuse_is_refused(speed):
    assert refused(apesim.run_engine, Machine(), speed) == ["speed"]


@pytest.mark.parametrize(
    ("options", "keys"),
    [
        ({"pulse": 0.0}, ["pulse"]),
        ({"pulse": math.nan}, ["pulse"]),
        ({"pulse": "50"}, ["pulse"]),
        ({"pulse": 1e-2, "until": -1.0}, ["until"]),
        ({"pulse": "60 ms", "repeat": "20 Hz"}, ["pulse"]),
        ({"until": "60 ms", "repeat": 10.0}, ["until"]),
        ({"supply": "5 bar", "temperature": 10.0}, ["supply", "temperature"]),
    ],
)
def test_a_bench_run_that_makes_no_sense_is_refused(options, keys):
    assert refused(apesim.run_valve, Machine(), **options) == keys


@pytest.mark.parametrize(
    ("command", "function", "options"),
    [
        ("valve run", apesim.run_valve, {"pulse": "50", "supply": "5 bar"}),
        ("valve run", apesim.run_valve, {"pulse": "60 ms", "repeat": "20 Hz"}),
        ("valve run", apesim.run_valve, {"until": "60 ms", "repeat": "20 Hz"}),
        ("engine run", apesim.run_engine, {"speed": "1000"}),
        ("engine sweep", apesim.sweep, {"speed": "600 rpm, 600 rpm", "intake": "kam"}),
        ("engine sweep", apesim.sweep, {"intake": "cam", "timing": "corrected"}),
        ("engine sweep", apesim.sweep, {"shard": "5/2", "out": "x.h5"}),
        ("valve map", apesim.map_valve, {"pressure": "0.4", "temperature": "280"}),
        ("valve limit", apesim.find_valve_limit, {"duty": "2", "pressure": "1:0:1 MPa gauge"}),
    ],
)
def test_an_option_is_refused_in_the_words_of_the_argument(capsys, tmp_path, monkeypatch, command, function, options):
    monkeypatch.chdir(tmp_path)
    words = [word for name, text in options.items() for word in (f"--{name}", text)]
    monkeypatch.setattr(sys, "argv", ["apesim", *command.split(), *words])
    assert main_of(app) == 2
    with pytest.raises(apesim.InputError) as caught:
        function(Machine(), **options)
    of_call = [f"command line: --{fault.key}: {fault.wrong}; {fault.right}" for fault in caught.value.faults]
    named = {f"`{name}`": f"--{name}" for name in ("repeat", "intake")}
    for argument, option in named.items():
        of_call = [line.replace(argument, option) for line in of_call]
    assert capsys.readouterr().err.splitlines() == of_call
    assert not list(tmp_path.iterdir())


def test_a_sweep_is_refused_for_all_that_is_wrong_with_it(tmp_path):
    out = tmp_path / "x.h5"
    keys = ["speed", "intake", "timing", "jobs", "shard"]
    wrong = {"intake": ["kam"], "timing": "late", "jobs": 0, "shard": "3/2"}
    assert refused(apesim.sweep, Machine(), [W, "0 rpm"], **wrong, out=out) == keys
    assert refused(apesim.sweep, Machine(), [], out=out) == ["speed"]
    with pytest.raises(apesim.InputError) as caught:
        apesim.sweep(Machine(), W, vary={"engine_bore": ["80 mm", -1.0], "engine.stroke": "80"}, out=out)
    assert [fault[:2] for fault in caught.value.faults] == [
        ("sweep(): vary", "engine.bore"),
        ("sweep(): vary", "engine.stroke"),
    ]
    assert not list(tmp_path.iterdir())


# --- effects that nothing computes ---


class Mine(NamedTuple):
    strength: float = 0.0


class Stop(NamedTuple):
    share: float = 0.0


@contact.for_type(Stop)
@kernel
def stop(effect, speed):
    return effect.share


def effect_of(name, parameters, **slots):
    return Effect(name, parameters, "", "", "", "", **slots)


def test_a_machine_with_an_effect_of_its_own_is_refused():
    own = NamedTuple("Own", [*Effects.__annotations__.items(), ("mine", Mine)])
    machine = Machine()._replace(effects=own(*Machine().effects, Mine(1.0)))
    assert refused(apesim.run_engine, machine, W) == ["effects.mine"]
    swapped = Machine()._replace(effects=Machine().effects._replace(seat_leak=Mine(1.0)))
    assert refused(apesim.run_engine, swapped, W) == ["effects.seat_leak"]


def test_an_effect_that_is_on_and_in_no_slot_that_is_served_is_found():
    class Own(NamedTuple):
        mine: Mine = Mine()
        stop: Stop = Stop()

    library = effect_of("mine", Mine), effect_of("stop", Stop)
    marched = {"mine": Mine, "stop": Stop}
    assert list(unserved(library, Own(), marched, {"law"})) == []
    assert list(unserved(library, Own(Mine(1.0), Stop(1.0)), marched, {"law"})) == ["mine", "stop"]
    assert list(unserved(library, Own(stop=Stop(1.0)), marched, {"contact"})) == []
    assert list(unserved(library, Own(stop=Stop(1.0)), {}, {"contact"})) == ["stop"]

    class Two(NamedTuple):
        a: Stop = Stop(1.0)
        b: Stop = Stop(1.0)

    pipes = [effect_of(name, Stop, volume=lambda effect: (1.0, 1.0)) for name in ("a", "b")]
    served = {"contact", "volume"}
    assert list(unserved(pipes, Two(), {"a": Stop, "b": Stop}, served)) == ["b"]


APPENDED = """
from typing import Annotated, NamedTuple
import apesim.valve.effects
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity

class Mine(NamedTuple):
    "Mine."
    force: Annotated[float, Quantity("N", -100, 100, "mine")] = 0.0

@law.for_type(Mine)
@kernel
def mine(effect, state, balance):
    balance[0] += effect.force

EFFECT = Effect("mine", Mine, equation="", source="", seen_in="", isolated_by="")
"""
LATE = """
import apesim.engine.machine
import apesim.engine.effects
apesim.engine.effects.ALL_EFFECTS += (EFFECT,)
settings = []
"""
EARLY = """
import apesim.valve.effects
apesim.valve.effects.VALVE_EFFECTS += (EFFECT,)
settings = ["effects.mine.force=50 N"]
"""
RUN = """
try:
    print(apesim.run_valve(apesim.Machine.load(None, settings), pulse=20e-3)["opening_delay"])
except apesim.InputError as error:
    print(error)
"""


@pytest.mark.parametrize("when", [EARLY, LATE], ids=["early", "late"])
def test_an_effect_that_was_added_to_the_list_from_outside_is_refused(when):
    program = [sys.executable, "-c", APPENDED + when + RUN]
    done = subprocess.run(program, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stderr == "" and "effects.mine: nothing that is computed knows it; " in done.stdout
