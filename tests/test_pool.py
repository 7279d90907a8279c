"""Work in one process or several gives the same, and a task that kills its worker is set aside."""

import os

import pytest

from studies.pool import run_tasks, workers_for


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


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_item_comes_back_with_its_result(jobs):
    assert dict(run_tasks(square, range(5), jobs)) == {n: n * n for n in range(5)}


def test_a_task_that_kills_its_worker_is_set_aside_and_the_others_are_done():
    assert dict(run_tasks(die_of_three, range(6), 2)) == {n: None if n == 3 else n * n for n in range(6)}


def test_a_worker_that_dies_once_costs_nothing(tmp_path):
    path = str(tmp_path / "died")
    assert dict(run_tasks(die_once, [path], 2)) == {path: "alive"}


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_of_a_task_is_raised(jobs):
    with pytest.raises(ValueError, match="no 7"):
        list(run_tasks(fail, [7], jobs))


def test_a_short_job_is_not_worth_a_second_process():
    assert workers_for(2.0) == 1
    assert workers_for(1e6) == (os.cpu_count() or 1)
    assert workers_for(2.0, jobs=3) == 3
