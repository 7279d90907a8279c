"""Work in a thread of its own: an interrupt while compiled code hands on its results would crash the process."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def call_in_thread(function: Callable[P, R], *arguments: P.args, **options: P.kwargs) -> "Future[R]":
    """Call a function in a thread of its own, so that Ctrl-C is heard at once, and where nothing compiled is at work.

    Parameters
    ----------
    function : function
    *arguments, **options
        What it is called with.

    Returns
    -------
    concurrent.futures.Future
        Its result is what the function returns or raises.

    Examples
    --------
    >>> call_in_thread(max, 1, 2).result()
    2
    """
    future: Future[R] = Future()

    def call() -> None:
        try:
            future.set_result(function(*arguments, **options))
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=call, daemon=True).start()
    return future
