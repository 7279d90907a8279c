"""The campaigns themselves, and a short form of each."""

import json
import os
import random
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import apesim
from apesim.archive.file import write
from apesim.engine.cylinder import CAM
from apesim.engine.machine import Machine
from apesim.quantities import Curve, Quantity
from apesim.quantities.trees import faults, schema
from tests.acceptance import independent_simulator
from tests.acceptance.independent_simulator import random_machine
from tests.archive_samples import sample
from tests.campaigns import agreement, archives, cluster, failures, inputs, kills, machines, probes
from tests.campaigns.campaign import (
    DIES,
    HANGS,
    RAISES,
    Outcome,
    find_most_memory,
    forget_most_memory,
    run_campaign,
    summarise,
)
from tests.campaigns.draws import CURVES, draw_machine
from tests.campaigns.mutations import VALUES, draw, spoil_bytes, spoil_toml
from tests.campaigns.probes import ENDING, KILLED, RAISING

TRIALS = 24
"""Trials of a short form."""


def test_what_a_trial_does_to_its_process_is_told(tmp_path):
    found = run_campaign(probes.__name__, range(7), tmp_path, longest=2.0)
    assert [found[seed].word for seed in range(7)] == ["well", HANGS, DIES, DIES, RAISES, "well", "well"]
    assert [found[seed].detail for seed in (KILLED, ENDING, RAISING)] == [
        "signal SIGKILL",
        "exit code 7",
        "ValueError: no trial",
    ]
    assert summarise(found)[0] == (DIES, 2, [KILLED, ENDING], True)


def test_a_campaign_goes_on_where_it_was_interrupted(tmp_path):
    run_campaign(probes.__name__, (0, 5), tmp_path)
    path = tmp_path / "probes.jsonl"
    path.write_text(path.read_text().replace("well", "as it was") + "[6, ")  # cut off as it was written
    found = run_campaign(probes.__name__, (0, 5, 6), tmp_path)
    assert [found[seed].word for seed in (0, 5, 6)] == ["as it was", "as it was", "well"]


@pytest.mark.skipif(not find_most_memory(), reason="memory is counted on Linux alone")
def test_memory_is_counted_anew_for_each_trial():
    forget_most_memory()
    before = find_most_memory()
    held = np.ones(30_000_000)
    assert find_most_memory() > before + 0.9 * held.nbytes
    del held
    forget_most_memory()
    assert find_most_memory() < before + 0.5 * 240e6


@pytest.mark.parametrize(
    ("code", "out", "err", "broken"),
    [
        (0, '{"a": 1}', "", False),
        (0, '{"a": NaN}', "", True),
        (0, '{"a": 1} {}', "", True),
        (1, "", "Traceback", True),
        ("KeyError", "", "'bore'", True),
        (2, "", "f.toml: bore: no number", False),
        (2, '{"faults": [{"file": "f.toml"}]}', "", False),
        (2, "", "no number", True),
        (2, "", "f.toml: \x1b[2J", True),
        (3, "", "f.toml", False),
        (3, "", "the march ended early", False),
    ],
)
def test_a_promise_that_is_broken_is_seen(code, out, err, broken):
    assert inputs.judge(inputs.MACHINE_FILE, ["machine", "--json"], ["f.toml"], code, out, err).is_broken is broken


@pytest.mark.parametrize(("err", "broken"), [("f.h5: damaged", False), ("damaged", True)])
def test_an_archive_that_is_not_complete_has_to_be_named(err, broken):
    assert inputs.judge("archive", ["archive", "info"], ["f.h5"], 3, "", err).is_broken is broken


@pytest.mark.slow
def test_what_is_spoilt_follows_from_its_seed():
    for spoil, whole in ((spoil_bytes, bytes(range(256))), (spoil_toml, inputs.whole_machine())):
        spoilt = [spoil(whole, random.Random(seed)) for seed in range(20)]
        assert spoilt == [spoil(whole, random.Random(seed)) for seed in range(20)]
        assert sum(one != whole for one in spoilt) > 17
    assert draw(VALUES, 5) == draw(VALUES, 5)
    assert len({draw(VALUES, seed) for seed in range(20)}) > 10


@pytest.mark.parametrize("make", inputs.MAKERS)
def test_inputs_that_are_not_spoilt_are_read(make, tmp_path, monkeypatch):
    monkeypatch.setattr(inputs, "spoil", lambda text, rng: text.encode())
    monkeypatch.setattr(inputs, "spoil_bytes", lambda data, rng: data)
    monkeypatch.chdir(tmp_path)
    kind, arguments, names = make(tmp_path, random.Random(7))
    assert inputs.judge(kind, arguments, names, *inputs.run(arguments)) == Outcome(f"{kind}: done")


@pytest.mark.slow
def test_whatever_a_file_holds_it_is_read_or_refused(tmp_path):
    found = run_campaign(inputs.__name__, range(TRIALS), tmp_path)
    assert [(seed, one) for seed, one in found.items() if one.is_broken] == []
    assert len(json.loads((tmp_path / "inputs.jsonl").read_text().splitlines()[0])) == 1 + len(Outcome._fields)


# --- archives ---


@pytest.mark.parametrize("damage", archives.DAMAGES)
def test_a_damage_changes_a_file_and_follows_from_its_seed(damage, tmp_path):
    whole = archives.archives()[2]
    for seed in range(8):
        found = []
        for _ in range(2):
            (tmp_path / "f.h5").write_bytes(whole)
            damage(tmp_path / "f.h5", random.Random(seed))
            found.append((tmp_path / "f.h5").read_bytes())
        assert damage is archives.rewrite or found[0] == found[1]  # which says when it was written
        if found[0] != whole:
            return
    raise AssertionError(damage.__name__)


def test_a_value_that_is_changed_unseen_is_told(tmp_path, monkeypatch):
    whole, damaged = tmp_path / "whole.h5", tmp_path / "damaged.h5"
    for path in (whole, damaged):
        path.write_bytes(archives.archives()[2])
    flipped, rewritten = "One bit of the file", archives.rewrite.__doc__.removesuffix(".")
    assert archives.judge(archives.flip_bit, whole, damaged) == Outcome(f"{flipped}: reads as before", is_void=True)
    archives.rewrite(damaged, random.Random(1))
    told = Outcome(f"{rewritten}: the root digest is another one", is_void=True)
    assert archives.judge(archives.rewrite, whole, damaged) == told
    assert archives.judge(archives.flip_bit, whole, damaged) == Outcome(f"{flipped}: changed unseen", True)
    damaged.write_bytes(b"no archive")
    monkeypatch.setattr(archives, "verify", lambda path: [])
    assert archives.judge(archives.cut_off, whole, damaged).is_broken


@pytest.mark.slow
def test_no_damage_of_an_archive_changes_what_is_read_unseen(tmp_path):
    found = run_campaign(archives.__name__, range(4 * len(archives.DAMAGES)), tmp_path)
    assert [(seed, one) for seed, one in found.items() if one.is_broken] == []
    assert len({one.word.partition(":")[0] for one in found.values()}) == len(archives.DAMAGES)


# --- kills ---

IS_LINUX = pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc")


def test_a_killed_sweep_that_lost_something_is_told(tmp_path):
    whole = sample()
    (tmp_path / "err.txt").touch()
    write(whole, tmp_path / "whole.h5")
    write(whole, tmp_path / "sweep.h5")
    struck = ["with shards written"]
    assert kills.judge("group", struck, 0, tmp_path) == Outcome("group: the same bits, struck with shards written")
    assert kills.judge("group", struck, 3, tmp_path).is_broken
    torque = whole.variables["torque"]
    other = replace(torque, values=np.nextafter(torque.values, np.inf))
    write(replace(whole, variables=whole.variables | {"torque": other}), tmp_path / "sweep.h5")
    assert kills.judge("group", struck, 0, tmp_path).word == "group: other bits"
    (tmp_path / "sweep.h5").write_bytes(b"half")
    assert kills.judge("group", struck, 0, tmp_path).word == "group: damaged"
    (tmp_path / "sweep.h5.lock").touch()
    assert kills.judge("group", struck, 0, tmp_path).word == "group: not whole"


@IS_LINUX
def test_a_process_that_outlives_its_group_is_found(monkeypatch):
    monkeypatch.setattr(kills, "PATIENCE", 0.1)
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, process_group=0)
    assert kills.find_survivors(process.pid) == [str(process.pid)]
    process.communicate(b"\n")
    assert kills.find_survivors(process.pid) == []


@IS_LINUX
def test_a_worker_is_killed_only_where_there_is_one():
    command = [sys.executable, "-c", "input()"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, process_group=0) as process:
        assert not kills.strike(process, kills.WORKER, random.Random(0))
        assert process.poll() is None
        assert kills.strike(process, kills.LEADER, random.Random(0))
        assert process.wait() == -signal.SIGKILL


@IS_LINUX
@pytest.mark.slow
def test_a_sweep_that_is_killed_goes_on_to_the_same_bits(tmp_path):
    seeds = [kills.STRIKES.index((victim, 2)) for victim in (kills.GROUP, kills.LEADER, kills.WORKER)]
    found = run_campaign(kills.__name__, seeds, tmp_path)
    assert [(seed, one) for seed, one in found.items() if one.is_broken] == []
    assert not any(one.word.endswith(kills.NOT_STRUCK) for one in found.values())


# --- cluster ---


@pytest.mark.parametrize(
    ("code", "err", "is_told"),
    [
        (2, "--dask: the scheduler is gone; what is done is kept; start it, and go on with --resume", True),
        (2, "--dask: no scheduler answers at 'tcp://127.0.0.1:1'; start one with `dask scheduler`", True),
        (2, "--dask: the scheduler is gone", False),
        (1, "--dask: the scheduler is gone; start it, and go on with --resume", False),
        (2, "", False),
    ],
)
def test_a_lost_scheduler_that_is_not_told_is_seen(code, err, is_told, tmp_path):
    (tmp_path / "err.txt").write_text(err)
    assert cluster.told_how_to_go_on(code, tmp_path) is is_told


@pytest.mark.parametrize("trouble", [cluster.KILL, cluster.LOSE])
@pytest.mark.slow
def test_a_sweep_on_a_cluster_in_trouble_ends_with_the_same_bits(trouble, monkeypatch):
    monkeypatch.setattr(cluster, "MOST", 1)
    monkeypatch.setattr(cluster, "EVERY", (4.0, 6.0))
    outcome = cluster.trial(cluster.TROUBLES.index(trouble))
    assert outcome.word.startswith(f"{trouble}: the same bits"), outcome


# --- failures ---

FIRST_CALLS = sum(map(len, failures.ROWS.values()))


@pytest.fixture
def shard(tmp_path):
    path = tmp_path / "sweep.h5.shards" / "1.h5"
    path.parent.mkdir()
    (tmp_path / "new").write_bytes(b"whole")
    return path


def test_a_shard_loses_its_second_half_once_it_is_written_and_the_archive_cannot_be(shard, tmp_path):
    with failures.fail(failures.damaging, 2) as reached:
        os.replace(tmp_path / "new", shard)
        (tmp_path / "new").write_bytes(b"whole")
        os.replace(tmp_path / "new", tmp_path / "first.h5")
        assert not reached and shard.read_bytes() == b"whole"
        (tmp_path / "new").write_bytes(b"whole")
        os.replace(tmp_path / "new", shard)
        with pytest.raises(OSError, match="Input/output error"):
            os.replace(tmp_path / "sweep.h5", tmp_path / "last.h5")
    assert reached and shard.read_bytes() == b"wh"


def test_the_call_that_is_to_fail_does_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with failures.fail(failures.writing, 2) as reached, Path("note.txt").open("w") as file:
        file.write("first ")
        assert reached == []
        with pytest.raises(OSError, match="No space left"):
            file.write("second")
        file.write(" third")
        assert reached == [2]
    assert Path("note.txt").read_text() == "first sec third"
    with failures.fail(failures.removing, 3) as reached:
        Path("note.txt").unlink()
    assert reached == []


@pytest.mark.parametrize(
    ("code", "err", "is_whole", "is_broken"),
    [
        (0, "", True, False),
        (0, "", False, True),
        (1, "Traceback", True, True),
        (2, "sweep.h5: could not be written", False, False),
        (2, "something is wrong", False, True),
        ("OSError", "sweep.h5", True, True),
    ],
)
def test_a_failure_that_is_not_told_is_seen(code, err, is_whole, is_broken):
    assert bool(failures.judge(code, err, lambda: is_whole)) is is_broken


def test_a_place_that_takes_memory_fails_once(monkeypatch):
    monkeypatch.setattr(failures, "find_place", lambda: "the same lines")
    with failures.fail(failures.allocating, 2) as reached:
        np.empty(3), np.zeros(3)
    assert reached == []
    monkeypatch.setattr(failures, "find_place", iter(("some lines", "others")).__next__)
    with failures.fail(failures.allocating, 2) as reached:
        np.empty(3)
        with pytest.raises(MemoryError):
            np.empty(3)


@pytest.mark.parametrize(
    ("place", "done"),
    [(failures.BEFORE, []), (failures.INSIDE, ["begun"]), (failures.AFTER, ["begun", "ended"])],
)
def test_a_worker_dies_where_it_is_told(place, done, monkeypatch):
    class Killed(Exception):
        pass

    def kill():
        raise Killed

    def task(calls):
        told.append("begun")
        for number in range(calls):
            str(number).strip()
        told.append("ended")

    told, before = [], (sys.getprofile(), threading.getprofile())
    monkeypatch.setattr(failures, "kill", kill)
    try:
        with pytest.raises(Killed):
            failures.die((place, task, 2 * failures.CALLS_INSIDE))
    finally:
        sys.setprofile(before[0])
        threading.setprofile(before[1])
    assert told == done


def test_every_call_of_a_row_is_let_fail_once():
    assert len(set(failures.TRIALS)) == len(failures.TRIALS)
    assert [number for number, *_ in failures.TRIALS[:FIRST_CALLS]] == [1] * FIRST_CALLS
    assert failures.trial(len(failures.TRIALS)).word.startswith("none")


@pytest.mark.slow
def test_whatever_call_fails_first_a_command_is_complete_or_names_what_is_missing(tmp_path):
    found = run_campaign(failures.__name__, range(FIRST_CALLS), tmp_path)
    assert [(seed, one) for seed, one in found.items() if one.is_broken] == []


# --- machines ---


def value_of(machine, key):
    for name in key.split("."):
        machine = getattr(machine, name)
    return machine


@pytest.mark.parametrize("is_wide", [False, True])
def test_a_machine_that_is_drawn_is_valid_and_follows_from_its_seed(is_wide):
    drawn = [draw_machine(np.random.default_rng(seed), is_wide) for seed in range(40)]
    assert [list(faults(machine)) for machine in drawn] == [[]] * len(drawn)
    assert str(drawn[3]) == str(draw_machine(np.random.default_rng(3), is_wide))
    assert {machine.air.model for machine in drawn} == {0, 1}
    assert {machine.engine.intake for machine in drawn} == {0, 1, 2}
    frictions = [machine.valve.viscous_friction for machine in drawn]
    assert (max(frictions) > 1000.0) is is_wide


@pytest.mark.slow
def test_every_effect_and_every_curve_is_drawn_and_a_wide_machine_reaches_the_ends():
    default, drawn = Machine(), [draw_machine(np.random.default_rng(seed), True) for seed in range(300)]
    for leaf in schema(Machine):
        if leaf.key.startswith(("known_to", "rig")):
            continue
        values = [value_of(machine, leaf.key) for machine in drawn]
        if isinstance(leaf.declaration, Curve):
            assert leaf.key in CURVES and any(map(len, values))
        elif isinstance(leaf.declaration, Quantity):
            assert len({value for value in values if value != value_of(default, leaf.key)}) > 5, leaf.key


@pytest.fixture(scope="module")
def whole_run():
    return Machine(), apesim.run_engine(Machine(), speed="1000 rpm")


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(1862, id="a table of leaks below zero made work from nothing"),
        pytest.param(387, id="a table of heat cooled a chamber to 0 K"),
        pytest.param(102, id="real air above 1887 K had no ratio of heat capacities"),
        pytest.param(418, id="a difference of 0.1 % told of a state that is repelled"),
        pytest.param(454, id="a store took a million cycles to fill with cold air"),
        pytest.param(38, id="a table of leaks emptied a cylinder, and a cycle took half a million evaluations"),
        pytest.param(50454, id="the solver's error moved a closed chamber"),
        pytest.param(50798, id="slopes were taken across an edge"),
        pytest.param(71205, id="a valve repeats after five pulses alone"),
        pytest.param(60762, id="a flow that had turned carried air of the wrong side"),
        pytest.param(72606, id="long steps left a pressure out of balance, which hid what a temperature gains"),
        pytest.param(70946, id="the search took 2506 cycles"),
        pytest.param(87243, id="a step of the search put a piston at rest beyond its stop, and it stayed there"),
    ],
)
def test_a_machine_that_once_had_no_result_or_a_wrong_one_has_one(seed):
    outcome = machines.trial(seed)
    assert (outcome.word.partition(": ")[2], outcome.is_broken) == ("closes", False)


def test_a_whole_run_breaks_no_promise(whole_run):
    assert list(machines.find_faults(*whole_run)) == []


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("cylinder_pressure", np.nan, "cylinder_pressure is no number"),
        ("cylinder_temperature", -1.0, "cylinder_temperature is not above 0"),
        ("lift", -1e-6, "the lift leaves its stroke"),
        ("lift", 9.0001e-3, "the lift leaves its stroke"),
    ],
)
def test_a_trace_beyond_its_bounds_is_told(whole_run, name, value, told):
    machine, run = whole_run
    values = run.traces[name].values.copy()
    values[7] = value
    other = replace(run, traces={**run.traces, name: replace(run.traces[name], values=values)})
    assert [what for what, _ in machines.find_faults(machine, other)] == [told]


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("mass_closure", 2e-6, "mass_closure above 1e-06"),
        ("energy_closure", np.nan, "energy_closure above 1e-06"),
        ("exergy_closure", 2e-6, "exergy does not close, and nothing says so"),
        ("exergy_indicated_work", 1e6, "more work than exergy"),
    ],
)
def test_a_balance_that_does_not_close_is_told(whole_run, name, value, told):
    machine, run = whole_run
    other = replace(run, scalars={**run.scalars, name: replace(run.scalars[name], value=value)})
    assert [what for what, _ in machines.find_faults(machine, other)] == [told]


@pytest.mark.slow
def test_whatever_machine_is_drawn_it_closes_or_is_named(tmp_path):
    """However long it takes: other tests share the processor."""
    found = run_campaign(machines.__name__, range(TRIALS), tmp_path, longest=300.0)
    assert [(seed, one) for seed, one in found.items() if one.is_broken] == []
    assert {one.word.partition(":")[0] for one in found.values()} == set(machines.KINDS)


# --- agreement ---


def test_a_machine_on_which_the_simulators_disagree_is_told(monkeypatch):
    seed = next(seed for seed in range(50) if random_machine(seed)[0].engine.intake == CAM)  # takes half a second
    assert agreement.trial(seed).word.endswith("effects: agrees")
    run = independent_simulator.settled
    monkeypatch.setattr(independent_simulator, "settled", lambda machine, rpm: run(machine, 1.0001 * rpm))
    outcome = agreement.trial(seed)
    assert outcome.is_broken and outcome.word.startswith("cam, ") and "engine_air" in outcome.detail


def test_a_second_cycle_that_looks_periodic_by_chance_is_not_taken_for_the_last():
    """The change of the second cycle is a thousandth of that of the first, and 150 cycles are due."""
    assert agreement.trial(282).word == "cam, with effects: agrees"
