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
from tests.folders import ROOT
from tests.machines import changed

W = 1000.0 * math.pi / 30.0
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
    for culprit in caught.value.culprits:
        assert culprit.file == f"{function.__name__}()" and culprit.wrong and culprit.right
    return [culprit.key for culprit in caught.value.culprits]


@pytest.mark.parametrize(("key", "value"), [(key, value) for key, values in BAD.items() for value in values])
def test_a_machine_that_no_file_could_say_is_refused_by_every_call(tmp_path, key, value):
    bad = changed(Machine(), {key: value})
    run = (apesim.run_steady, bad, W), (apesim.run_bench, bad, 50e-3), (apesim.indicators, bad, None)
    for call in (*run, (apesim.run_sweep, bad, [W], [0], tmp_path / "x.h5")):
        assert refused(*call) == [key]
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
    assert apesim.run_bench(Machine(), 5e-3).steps > 0


@pytest.mark.parametrize("speed", [0, -W, math.nan, math.inf, 0.01, "1000 rpm", None, [W]])
def test_a_speed_that_the_command_line_would_refuse_is_refused(speed):
    assert refused(apesim.run_steady, Machine(), speed) == ["speed"]


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"pulse": 0.0}, "pulse"),
        ({"pulse": math.nan}, "pulse"),
        ({"pulse": 1e-2, "until": -1.0}, "until"),
        ({"pulse": 1e-2, "period": 5e-3}, "pulse"),
        ({"pulse": 1e-2, "sample": 0.0}, "sample"),
        ({"pulse": 1e-2, "sample": np.array([2e-3, 1e-3])}, "sample"),
        ({"pulse": 1e-2, "tolerance": 0.0}, "tolerance"),
        ({"pulse": 1e-2, "brakes": (math.nan, 1e-3)}, "brakes"),
        ({"pulse": 1e-2, "brakes": (1e-3,)}, "brakes"),
        ({"pulse": 1e-2, "intake_pressure": -1.0}, "intake_pressure"),
    ],
)
def test_a_bench_run_that_makes_no_sense_is_refused(options, key):
    assert refused(apesim.run_bench, Machine(), **options) == [key]


def test_a_sweep_is_refused_for_all_that_is_wrong_with_it(tmp_path):
    out = tmp_path / "x.h5"
    assert refused(apesim.run_sweep, Machine(), [W, 0.0], [7], out, timings=[2]) == ["speeds", "intakes", "timings"]
    assert refused(apesim.run_sweep, Machine(), W, [0], out) == ["speeds"]
    varied = apesim.vary(["engine.bore=80 mm, 90 mm"])
    bad = varied._replace(machines=(varied.machines[0], changed(varied.machines[1], {"engine.bore": -1.0})))
    assert refused(apesim.run_sweep, Machine(), [W], [0], out, variation=bad) == ["variation: engine.bore"]


def test_a_whole_number_is_a_speed_as_well_and_compiles_nothing_anew():
    run = apesim.run_steady(Machine(), 100, max_cycles=1)
    assert type(run.cycle.speed) is float


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
    assert refused(apesim.run_steady, machine, W) == ["effects.mine"]
    swapped = Machine()._replace(effects=Machine().effects._replace(seat_leak=Mine(1.0)))
    assert refused(apesim.run_steady, swapped, W) == ["effects.seat_leak"]


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
    print(apesim.run_bench(apesim.load_machine(None, settings), 20e-3).opening.delay)
except apesim.InputError as error:
    print(error)
"""


@pytest.mark.parametrize("when", [EARLY, LATE], ids=["early", "late"])
def test_an_effect_that_was_added_to_the_list_from_outside_is_refused(when):
    program = [sys.executable, "-c", APPENDED + when + RUN]
    done = subprocess.run(program, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stderr == "" and "effects.mine: nothing that is computed knows it; " in done.stdout
