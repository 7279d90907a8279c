"""Work in a thread of its own: an interrupt while compiled code hands on its results would crash the process."""

import threading
from concurrent.futures import Future


def call_in_thread(function, *arguments, **options):
    """Call a function in a thread of its own, so that Ctrl-C is heard at once, and where nothing compiled is at work.

    Parameters
    ----------
    function : function

    Returns
    -------
    concurrent.futures.Future
    """
    future = Future()

    def call():
        try:
            future.set_result(function(*arguments, **options))
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=call, daemon=True).start()
    return future
