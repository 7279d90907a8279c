"""Where work is done: in this process, or in several."""

import contextlib
import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from studies.aside import aside

TRIES = 2
"""A task that kills its worker so often is set aside."""


def workers_for(seconds, jobs=None):
    """How many processes some work is worth.

    Parameters
    ----------
    seconds : float
        Estimated time of the whole in one process; another process takes a second or two to start.
    jobs : int, optional
        As the user wants it.

    Returns
    -------
    int
    """
    if jobs:
        return jobs
    return max(1, min(os.cpu_count() or 1, int(seconds / 6.0)))


def run_tasks(task, items, jobs=1):
    """Apply a function to items and yield what comes out, as it comes.

    Parameters
    ----------
    task : function
        Of one item; of a module, so that other processes find it.
    items : sequence
    jobs : int
        1: in this process.

    Yields
    ------
    item, result
        The result is None where the item was set aside because it killed its worker `TRIES` times.
    """
    if jobs == 1:
        for item in items:
            yield item, aside(task, item).result()
        return
    waiting = [(item, 1) for item in items]
    while waiting:
        waiting, suspects = yield from _until_broken(task, waiting, jobs)
        for item, tried in suspects:
            if tried >= TRIES:
                yield item, None
            else:
                # Alone in a pool of its own, so that the next death has one suspect only.
                again, dead = yield from _until_broken(task, [(item, tried + 1)], 1)
                waiting += again
                for item_dead, _ in dead:
                    yield item_dead, None


def _until_broken(task, waiting, jobs):
    """Run until all is done or a worker dies; return what was not started and what was running then."""
    waiting = list(waiting)
    running = {}
    context = multiprocessing.get_context("spawn")
    lifeline, held = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_live_on, initargs=(lifeline,))
    with lifeline, held, pool:
        try:
            while waiting or running:
                while waiting and len(running) < jobs:
                    item, tried = waiting.pop(0)
                    with _deaf_to_interrupts():
                        running[pool.submit(task, item)] = (item, tried)
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    item, tried = running[future]
                    try:
                        result = future.result()
                    except BrokenProcessPool:
                        return waiting, list(running.values())
                    del running[future]
                    yield item, result
        except BaseException:
            held.close()  # or the pool would wait for what its workers are at
            raise
    return [], []


def _live_on(lifeline):
    """End this worker as soon as the other end of a pipe is closed, be it because the process that holds it died."""

    def watch():
        multiprocessing.connection.wait([lifeline])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextlib.contextmanager
def _deaf_to_interrupts():
    """Processes that are started within never hear of Ctrl-C; who started them does, and ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
