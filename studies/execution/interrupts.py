"""Interrupts (Ctrl-C) that wait until compiled code has handed on its results: one in between would crash the process.

What takes long is called in another thread, see `apesim.studies.execution.own_thread`; a call of microseconds is not.
"""

import _signal  # what `signal` wraps: its search for the names of handlers, which have none, takes microseconds
import threading
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def call_uninterrupted(function: Callable[P, R], *arguments: P.args, **options: P.kwargs) -> R:
    """Call a function; an interrupt that comes meanwhile is heard when it has returned.

    >>> call_uninterrupted(max, 1, 2)
    2
    """
    usual = _signal.getsignal(_signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual):
        return function(*arguments, **options)  # only the main thread hears them
    heard: list[tuple[Any, ...]] = []
    _signal.signal(_signal.SIGINT, lambda *told: heard.append(told))
    try:
        return function(*arguments, **options)
    finally:
        _signal.signal(_signal.SIGINT, usual)
        if heard:
            usual(*heard[0])
