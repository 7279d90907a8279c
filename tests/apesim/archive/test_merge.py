from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apesim.archive import ArchiveError, read, write
from apesim.archive.merge import merge
from tests.archive_samples import same, sample


@settings(max_examples=50)
@given(st.lists(st.lists(st.integers(0, 40), unique=True).map(sorted), min_size=1, max_size=5))
def test_merge_is_the_whole_whatever_the_parts(parts):
    whole = merge([sample(part) for part in parts])
    assert same(whole, sample(sorted({run for part in parts for run in part})))


def test_contradicting_runs_are_an_error():
    other = sample([1, 2])
    other.variables["cylinder_pressure"].values[0, 3] += 1e-9
    with pytest.raises(ArchiveError, match=r"b.h5: run 1 contradicts a.h5 in cylinder_pressure"):
        merge([sample([0, 1]), other], names=["a.h5", "b.h5"])
    signed = sample([0])
    signed.variables["torque"].values[0] = -0.0
    with pytest.raises(ArchiveError, match="part 2: run 0 contradicts part 1 in torque"):
        merge([sample([0]), signed])


def test_parts_must_belong_together():
    def other(name, **fields):
        archive = sample([5])
        archive.variables[name] = replace(archive.variables[name], **fields)
        return archive

    less = sample([5])
    del less.variables["speed"]
    machine = sample().machine
    for part, message in (
        (
            replace(sample([5]), machine=machine.replace("2 ms", "3 ms")),
            "another machine .valve.solenoid.dead_time",
        ),
        (replace(sample([5]), machine=machine + "# x"), "another machine .in its comments"),
        (sample([5], plan_hash="q"), "plan_hash"),
        (less, "only one of them has speed"),
        (other("speed", unit="1/min"), "speed has unit '1/min', not 'rpm'"),
        (other("cycles", values=np.array([1.0])), "cycles has kind 'float64', not 'int64'"),
        (sample([5], angles=6), "axis crank_angle differs"),
        (other("crank_angle", values=np.linspace(0, 720.1, 5)), "axis crank_angle differs"),
    ):
        with pytest.raises(ArchiveError, match=f"b.h5: does not fit a.h5: .*{message}"):
            merge([sample([0]), part], names=["a.h5", "b.h5"])
    with pytest.raises(ArchiveError, match="no parts"):
        merge([])


def test_merged_provenance_keeps_what_differs(tmp_path):
    merged = merge([sample([0], command="--shard 1/2"), sample([1], command="--shard 2/2", created="later")])
    assert merged.provenance == {"plan_hash": "p", "command": "--shard 1/2; --shard 2/2"}
    files = [write(sample([i]), tmp_path / f"{i}.h5") for i in (1, 0)]
    assert same(merge([read(file) for file in files], files), sample([0, 1]))
