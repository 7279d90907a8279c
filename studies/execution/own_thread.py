"""Work in another thread: an interrupt while compiled code hands on its results would crash the process."""

import os
import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from queue import SimpleQueue
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
THREAD_NAME = "apesim"
"""Name of the threads that are made here."""

_Call = tuple[Callable[[], Any], "Future[Any]"]
_idle: list["SimpleQueue[_Call]"] = []
"""Queue of each thread that has nothing to do, in which it waits for its next call."""
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)  # a forked process has none of them


def call_in_thread(function: Callable[P, R], *arguments: P.args, **options: P.kwargs) -> "Future[R]":
    """Call a function in another thread, so that Ctrl-C is heard at once, and where nothing compiled is at work.

    The future's result is what the function returns or raises. A thread is kept for the next call: to start one takes a
    good part of the time that a march of the valve takes.
    """
    future: Future[R] = Future()
    try:
        calls = _idle.pop()
    except IndexError:
        calls = SimpleQueue()
        threading.Thread(target=_work, args=[calls], name=THREAD_NAME, daemon=True).start()
    calls.put((partial(function, *arguments, **options), future))
    return future


def _work(calls: "SimpleQueue[_Call]") -> None:
    """Do one call after the other."""
    while True:
        _do(*calls.get(), calls)  # which lets go of the result when it returns


def _do(call: Callable[[], Any], future: "Future[Any]", calls: "SimpleQueue[_Call]") -> None:
    """Do one call; the thread is idle again before the one that waits for its result goes on."""
    try:
        result = call()
    except BaseException as error:
        _idle.append(calls)
        future.set_exception(error)
    else:
        _idle.append(calls)
        future.set_result(result)
