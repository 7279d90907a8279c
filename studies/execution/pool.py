"""Pool of processes that work is done in: this one, or several."""

import contextlib
import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from apesim.studies.execution.own_thread import call_in_thread

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
    """Apply a function to items and yield what comes out, as it comes; see `Team.run`."""
    with Team(jobs) as team:
        yield from team.run(task, items)


class Died(RuntimeError):
    """A task killed its worker `TRIES` times; the text says what to do."""


class Team:
    """Processes that stand ready for the tasks of several stages; they start with the first.

    Parameters
    ----------
    jobs : int
        1: all is done in this process.
    """

    def __init__(self, jobs=1):
        self.jobs = jobs
        self._pool, self._gone = None, False

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        self._gone = True
        self._dismiss(at_once=kind is not None)

    def run(self, task, items):
        """Apply a function to items and yield what comes out, as it comes.

        Parameters
        ----------
        task : function
            Of one item; of a module, so that other processes find it.
        items : sequence

        Yields
        ------
        item, result
            The result is None where the item was set aside because it killed its worker `TRIES` times.
        """
        if self.jobs == 1:
            for item in items:
                yield item, call_in_thread(task, item).result()
            return
        waiting = [(item, 0) for item in items]
        while waiting:
            waiting, suspects = yield from self._until_broken(task, waiting)
            for item, deaths in suspects:
                if deaths >= TRIES:
                    yield item, None
                else:
                    # Alone, so that the next death has one suspect only.
                    again, dead = yield from self._until_broken(task, [(item, deaths)])
                    waiting += again
                    for item_dead, _ in dead:
                        yield item_dead, None

    def map(self, function, items, report=None):
        """Apply a function to tuples of arguments, and bring what comes out into their order.

        Parameters
        ----------
        function : function
            Of a module; what it changes of its arguments is lost.
        items : sequence of tuple
        report : callable, optional
            Told how many are done, and of how many.

        Returns
        -------
        list

        Raises
        ------
        Died
        """
        items, found = list(items), {}
        for (number, *_), result in self.run(_called, [(n, function, item) for n, item in enumerate(items)]):
            if result is None:
                raise Died(f"a worker process died {TRIES} times at the same task; free memory, or try --jobs 1")
            (found[number],) = result
            if report:
                report(len(found), len(items))
        return [found[number] for number in range(len(items))]

    def _until_broken(self, task, waiting):
        """Run items, each with its number of deaths, until all is done or a worker dies.

        Returns
        -------
        list, list
            What was not started, and what was running as the worker died.
        """
        if self._gone:
            raise RuntimeError("the team has gone")
        waiting, running, suspects, is_broken = list(waiting), {}, [], False
        self._pool = self._pool or _Pool(self.jobs)
        while running or (waiting and not is_broken):
            while waiting and len(running) < self.jobs and not is_broken:
                try:
                    with _deaf_to_interrupts():
                        running[self._pool.executor.submit(task, waiting[0][0])] = waiting[0]
                except BrokenProcessPool:  # a worker died since the last result was fetched
                    is_broken = True
                else:
                    del waiting[0]
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                try:
                    result = future.result()
                except BrokenProcessPool:
                    is_broken = True
                    item, deaths = running.pop(future)
                    suspects.append((item, deaths + 1))
                else:
                    yield running.pop(future)[0], result
        if is_broken:
            self._dismiss()
        return waiting, suspects

    def _dismiss(self, at_once=False):
        pool, self._pool = self._pool, None
        if pool:
            pool.close(at_once)


class _Pool:
    """Worker processes, and a pipe by which they know that this one lives."""

    def __init__(self, jobs):
        context = multiprocessing.get_context("spawn")
        self.lifeline, self.held = context.Pipe(duplex=False)
        self.executor = ProcessPoolExecutor(jobs, mp_context=context, initializer=_live_on, initargs=(self.lifeline,))

    def close(self, at_once):
        if at_once:
            self.held.close()  # or the pool would wait for what its workers are at
        self.executor.shutdown()
        self.held.close()
        self.lifeline.close()


def _called(numbered):
    """What a function makes of its arguments, in a tuple, as None stands for a death."""
    _, function, arguments = numbered
    return (function(*arguments),)


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
