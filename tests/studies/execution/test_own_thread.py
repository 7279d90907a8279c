"""Calls in another thread: one is kept for the next call, nothing of a call is kept, and a fork starts its own."""

import gc
import os
import threading
import weakref

import pytest

from apesim.studies.execution.own_thread import call_in_thread


class Held:
    """Something that can be watched."""


def test_a_thread_is_kept_for_the_next_call_and_is_not_this_one():
    first, second = (call_in_thread(threading.get_ident).result() for _ in range(2))
    assert first == second != threading.get_ident()


def test_a_call_within_a_call_has_a_thread_of_its_own():
    def both():
        return threading.get_ident(), call_in_thread(threading.get_ident).result()

    outer, inner = call_in_thread(both).result()
    assert outer != inner


def test_an_error_comes_out_and_the_thread_goes_on():
    with pytest.raises(ZeroDivisionError):
        call_in_thread(divmod, 1, 0).result()
    assert call_in_thread(divmod, 7, 2).result() == (3, 1)


def test_a_result_is_let_go():
    watched = weakref.ref(call_in_thread(Held).result())
    call_in_thread(max, 1, 2).result()
    gc.collect()
    assert watched() is None


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_forked_process_starts_threads_of_its_own():
    call_in_thread(max, 1, 2).result()
    child = os.fork()
    if not child:
        os._exit(call_in_thread(max, 1, 2).result(timeout=20.0) != 2)
    assert os.waitpid(child, 0)[1] == 0
