"""Work in one process or several gives the same, and a task that kills its worker is set aside."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import typer

from apesim.studies.execution import pool
from apesim.studies.execution.pool import Died, Team, run_tasks, workers_for
from apesim.studies.terminal.console import INCOMPLETE, main_of
from tests.processes import ENVIRONMENT


def square(number):
    return number * number


def die_of_three(number):
    if number == 3:
        os._exit(9)
    return square(number)


def die_once(path):
    if not os.path.exists(path):
        open(path, "w").close()
        os._exit(9)
    return "alive"


def fail(number):
    raise ValueError(f"no {number}")


def note(path):
    with open(path, "a") as file:
        file.write("started\n")
    return path


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_item_comes_back_with_its_result(jobs):
    assert dict(run_tasks(square, range(5), jobs)) == {n: n * n for n in range(5)}


def test_a_worker_goes_on_while_its_results_are_dealt_with(tmp_path):
    path, deadline = tmp_path / "started", time.monotonic() + 20.0
    with Team(2) as team:
        results = team.run(note, [path] * 6)
        next(results)
        while len(path.read_text().split()) < 3 and time.monotonic() < deadline:
            time.sleep(0.02)
        assert len(path.read_text().split()) == 3
        assert [result for _, result in results] == [path] * 5


def test_a_task_that_kills_its_worker_is_set_aside_and_the_others_are_done():
    assert dict(run_tasks(die_of_three, range(6), 2)) == {n: None if n == 3 else n * n for n in range(6)}


def test_a_worker_that_dies_once_costs_nothing(tmp_path):
    path = str(tmp_path / "died")
    assert dict(run_tasks(die_once, [path], 2)) == {path: "alive"}


def worker_of(number):
    return os.getpid()


def until_broken(team):
    """Wait until the pool of a team knows that a worker of it has died."""
    deadline = time.monotonic() + 20.0
    while not team._pool.executor._broken:
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
@pytest.mark.parametrize("seed", range(2))
def test_a_worker_that_is_killed_while_the_parent_is_busy_with_a_result_costs_nothing(seed):
    random = np.random.default_rng(seed)
    strikes, found = set(random.choice(12, 2, replace=False).tolist()), []
    with Team(2) as team:
        for number, worker in team.run(worker_of, range(12)):
            found.append((number, worker))
            if len(found) - 1 in strikes:
                random.choice(list(team._pool.executor._processes.values())).kill()
                until_broken(team)
    assert sorted(number for number, _ in found) == list(range(12))
    assert None not in dict(found).values()


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
def test_a_worker_that_is_killed_between_two_stages_costs_nothing():
    with Team(2) as team:
        assert team.map(square, [(2,), (3,)]) == [4, 9]
        os.kill(next(iter(team._pool.executor._processes)), signal.SIGKILL)
        until_broken(team)
        assert team.map(square, [(4,), (5,)], lambda *_: None) == [16, 25]


def sleep(seconds):
    time.sleep(seconds)
    return os.getpid()


def test_work_of_unknown_length_starts_further_processes_once_it_has_taken_long(monkeypatch):
    monkeypatch.setattr(pool, "SECONDS_ALONE", 0.5)
    with Team(None) as team:
        assert team.map(sleep, [(0.0,)] * 5) == [os.getpid()] * 5
        assert team._pool is None
        workers = team.map(sleep, [(0.3,)] * 6)
        assert workers[:2] == [os.getpid()] * 2
        assert os.getpid() not in workers[2:]
        assert team.map(sleep, [(0.0,)]) != [os.getpid()]


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_of_a_task_is_raised(jobs):
    with pytest.raises(ValueError, match="no 7"):
        list(run_tasks(fail, [7], jobs))


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_team_keeps_the_order_of_what_it_is_given(jobs):
    told = []
    with Team(jobs) as team:
        assert team.map(divmod, [(n, 3) for n in range(5)], lambda *at: told.append(at)) == [
            divmod(n, 3) for n in range(5)
        ]
        assert team.map(pow, [(2, 5), (5, 2)]) == [32, 25]
        assert team.map(pow, []) == []
    assert told == [(n, 5) for n in range(1, 6)]


def test_a_team_says_that_a_task_kills_its_workers_and_goes_on_with_others():
    with Team(2) as team:
        with pytest.raises(Died, match="memory"):
            team.map(die_of_three, [(n,) for n in range(6)])
        assert team.map(square, [(3,), (4,)]) == [9, 16]


def test_a_command_whose_task_kills_its_workers_says_so_in_a_line(monkeypatch, capsys):
    app = typer.Typer()

    @app.command()
    def command():
        with Team(2) as team:
            team.map(die_of_three, [(3,)])

    monkeypatch.setattr(sys, "argv", ["apesim"])
    assert main_of(app) == INCOMPLETE
    assert capsys.readouterr().err == "a worker process died 2 times at the same task; free memory, or try --jobs 1\n"


def test_a_short_job_is_not_worth_a_second_process():
    assert workers_for(2.0) == 1
    assert workers_for(1e6) == (os.cpu_count() or 1)
    assert workers_for(2.0, jobs=3) == 3


LONG = """
import time
from pathlib import Path
from apesim.studies.execution.pool import run_tasks

def long(path):
    Path(path).touch()
    time.sleep(60)

if __name__ == "__main__":
    list(run_tasks(long, ["first", "second"], 2))
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
@pytest.mark.parametrize(("end", "whole_group"), [(signal.SIGKILL, False), (signal.SIGINT, True)])
def test_workers_end_with_their_parent_and_say_nothing(tmp_path, end, whole_group):
    (tmp_path / "long.py").write_text(LONG)
    parent = subprocess.Popen(
        [sys.executable, "long.py"],
        cwd=tmp_path,
        env={**ENVIRONMENT, "PYTHONWARNINGS": "ignore"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # Of a shell that runs in the background SIGINT is ignored, and so it would be here.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    while not all((tmp_path / name).exists() for name in ("first", "second")):
        assert parent.poll() is None
    (os.killpg if whole_group else os.kill)(parent.pid, end)
    # The pipe ends when the last process that holds it has ended.
    _, err = parent.communicate(timeout=20)
    assert err.count("Traceback") == (1 if whole_group else 0)
    assert "SpawnProcess" not in err
