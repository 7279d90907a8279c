"""A sweep on a cluster of dask.distributed is the same as here."""

import sys
import time

import numpy as np
import pytest
from distributed import LocalCluster

from apesim.engine.cylinder import CAM, EPV
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.execution import cluster as cluster_module
from apesim.studies.execution.cluster import connected, run_on_cluster
from apesim.studies.sweep import TIMINGS, run_sweep

RPM = np.pi / 30.0
SPEEDS = [800.0 * RPM, 1400.0 * RPM]
SMALL = {"n_workers": 1, "threads_per_worker": 2, "processes": False, "dashboard_address": ":0"}


@pytest.fixture(scope="module")
def scheduler():
    with LocalCluster(**SMALL) as local:
        yield local.scheduler_address


def inverse(number):
    return 1.0 / number


def test_a_cluster_gives_the_same_bits(scheduler, tmp_path, monkeypatch):
    monkeypatch.setattr("apesim.studies.sweep.completion.SHARD_SECONDS", 0.05)
    here = run_sweep(Machine(), SPEEDS, [EPV, CAM], tmp_path / "here.h5", timings=TIMINGS)
    with connected(scheduler) as client:
        there = run_sweep(Machine(), SPEEDS, [EPV, CAM], tmp_path / "there.h5", timings=TIMINGS, cluster=client)
    assert here.archive.variables.keys() == there.archive.variables.keys()
    for name, variable in here.archive.variables.items():
        np.testing.assert_array_equal(variable.values, there.archive.variables[name].values, err_msg=name)


def test_a_fault_on_a_worker_is_raised_here(scheduler):
    with connected(scheduler) as client:
        assert sorted(run_on_cluster(client, inverse, [1.0, 2.0])) == [(1.0, 1.0), (2.0, 0.5)]
        with pytest.raises(ZeroDivisionError):
            list(run_on_cluster(client, inverse, [1.0, 0.0]))


def test_a_worker_with_another_program_is_refused(scheduler, monkeypatch):
    with connected(scheduler) as client:
        submit = client.submit
        monkeypatch.setattr(client, "submit", lambda f, task, item, _, **o: submit(f, task, item, "another", **o))
        with pytest.raises(InputError, match=r"--dask: .* another version"):
            list(run_on_cluster(client, inverse, [1.0]))


def patient(seconds):
    time.sleep(seconds)
    return seconds


def test_a_scheduler_that_is_lost_is_told_and_how_to_go_on():
    with LocalCluster(**SMALL) as local, connected(local.scheduler_address) as client:
        results = run_on_cluster(client, patient, [0.0, 3.0])
        assert next(results) == (0.0, 0.0)
        local.close()
        with pytest.raises(InputError, match=r"--dask: the scheduler is gone.*--resume"):
            list(results)


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1", "http://127.0.0.1:80", "tcp://127.0.0.1:1"])
def test_an_address_where_no_scheduler_is_names_the_option_and_a_right_form(address, monkeypatch):
    monkeypatch.setattr(cluster_module, "PATIENCE", 0.5)
    with pytest.raises(InputError, match=r"--dask: .*tcp://127\.0\.0\.1:8786"), connected(address):
        pass


def test_without_distributed_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"--dask: needs distributed.*apesim\[dask\]"), connected("tcp://127.0.0.1:1"):
        pass
