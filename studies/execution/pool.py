"""Pool of processes that work is done in: this one, or several."""

import contextlib
import logging
import multiprocessing
import multiprocessing.connection
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import Connection
from typing import Any

from apesim.studies.execution.own_thread import THREAD_NAME, call_in_thread

MAX_DEATHS = 2
"""Deaths of workers after which a task is set aside: the first may have been chance, as where memory was short."""
SECONDS_PER_WORKER, SECONDS_PER_FORK = 6.0, 1.5
"""Work that a further process is worth [s]: starting it takes a second or two, and forking it some hundredths."""
SECONDS_ALONE, SECONDS_ALONE_IF_FORKED = 3.0, 0.5
"""Work of unknown length that is done before further processes start [s]: about what starting them costs, so that at
most twice the time is spent that was due."""
OWN_THREADS = ("MainThread", THREAD_NAME)
"""Names of threads that only wait while this one forks."""

Task = Callable[[Any], Any]
"""What is done with one item; it stands in a module, so that other processes find it."""
Counted = tuple[Any, int]
"""An item with the number of workers that died at it."""


def workers_for(seconds: float, jobs: int | None = None) -> int:
    """Number of processes that some work is worth, if one would take so many seconds for the whole.

    It is at least 1, and at most the number of processors; `jobs`, the number that the user wants, is taken as it is.
    """
    if jobs:
        return jobs
    worth = SECONDS_PER_FORK if can_fork() else SECONDS_PER_WORKER
    return max(1, min(os.cpu_count() or 1, int(seconds / worth)))


def can_fork() -> bool:
    """Judge whether a process may be a copy of this one, which has all imported and compiled already.

    False: it has to start from scratch. Elsewhere than on Linux libraries of the system do not bear a copy, and a
    thread of somebody else, as a notebook has them, may hold a lock that the copy would wait for.
    """
    return sys.platform == "linux" and all(
        thread.name in OWN_THREADS or type(thread).__module__.startswith("rich.") for thread in threading.enumerate()
    )


@contextlib.contextmanager
def done_beside(function: Callable[[], object]) -> Iterator[None]:
    """Call a function in a copy of this process while something else is done; where that fails, here after it.

    The function writes files; what it changes in memory may be lost. At the end of the context it has come to its end,
    too.

    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "there"
    ...     with done_beside(path.touch):
    ...         print("meanwhile")
    ...     path.exists()
    meanwhile
    True
    """
    if not can_fork() or (os.cpu_count() or 1) < 2:
        yield
        function()
        return
    process = multiprocessing.get_context("fork").Process(target=_called_quietly, args=(function,), daemon=True)
    with _no_warning_of_threads():
        process.start()
    try:
        yield
        process.join()
    except BaseException:
        process.kill()
        raise
    if process.exitcode:  # whatever it was happens here once more, where it is heard
        function()


def _called_quietly(function: Callable[[], object]) -> None:
    """Call a function in a copy of a process; an interrupt ends that, and a fault shows in its exit code alone."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        function()
    except Exception:
        os._exit(1)


def run_tasks(task: Task, items: Iterable[Any], jobs: int = 1) -> Iterator[tuple[Any, Any]]:
    """Apply a function to items and yield each item with its result, as it comes.

    `task` stands in a module, so that other processes find it; with 1 of `jobs`, the processes, all is done in this
    one. A result is None where the item was set aside because it killed its worker `MAX_DEATHS` times.
    """
    with Team(jobs) as team:
        yield from team.run(task, items)


class Died(RuntimeError):
    """A task killed its worker `MAX_DEATHS` times, or none can be started; the text says what to do."""


class Team:
    """Processes that stand ready for the tasks of several stages; they start with the first.

    `jobs` is their number; with 1 all is done in this one. None: as many as there are processors, once this one has
    worked for `SECONDS_ALONE`.
    """

    def __init__(self, jobs: int | None = 1) -> None:
        self.jobs = jobs or os.cpu_count() or 1
        self._alone = 0.0 if jobs else min(SECONDS_ALONE, SECONDS_ALONE_IF_FORKED if can_fork() else SECONDS_ALONE)
        self._pool: _Pool | None = None
        self._gone = False

    def __enter__(self) -> "Team":
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._gone = True
        self._dismiss(at_once=kind is not None)

    def run(self, task: Task, items: Iterable[Any]) -> Iterator[tuple[Any, Any]]:
        """Apply a function to items and yield each item with its result, as it comes.

        `task` stands in a module, so that other processes find it. A result is None where the item was set aside
        because it killed its worker `MAX_DEATHS` times.
        """
        items = iter(items)
        while self.jobs == 1 or self._alone > 0.0:
            start = time.monotonic()
            try:
                item = next(items)
            except StopIteration:
                return
            result = call_in_thread(task, item).result()
            self._alone -= time.monotonic() - start
            yield item, result
        waiting = [(item, 0) for item in items]
        while waiting:
            waiting, suspects = yield from self._until_broken(task, waiting)
            for item, deaths in suspects:
                if deaths >= MAX_DEATHS:
                    yield item, None
                else:
                    # Alone, so that the next death has one suspect only.
                    again, dead = yield from self._until_broken(task, [(item, deaths)])
                    waiting += again
                    for item_dead, _ in dead:
                        yield item_dead, None

    def map(
        self, function: Callable, items: Iterable[tuple], report: Callable[[int, int], object] | None = None
    ) -> list:
        """Apply a function to tuples of arguments, and bring what comes out into their order.

        The function stands in a module; what it changes of its arguments is lost. `report` is called with the numbers
        of calls done and in all. Raises Died where a call killed its worker `MAX_DEATHS` times.
        """
        calls, results = list(items), {}
        for (number, *_), result in self.run(_called, [(n, function, item) for n, item in enumerate(calls)]):
            if result is None:
                raise Died(f"a worker process died {MAX_DEATHS} times at the same task; free memory, or try --jobs 1")
            (results[number],) = result
            if report:
                report(len(results), len(calls))
        return [results[number] for number in range(len(calls))]

    def _until_broken(
        self, task: Task, items: Sequence[Counted]
    ) -> Generator[tuple[Any, Any], None, tuple[list[Counted], list[Counted]]]:
        """Run items, each with its number of deaths, until all is done or a worker dies.

        Returns what was not started, and what was running, or next, as the worker died.
        """
        if self._gone:
            raise RuntimeError("the team has gone")
        waiting, suspects, is_broken = list(items), [], False
        running: dict[Future, Counted] = {}

        # The processes of an earlier stage serve again; they start here where there are none.
        pool = self._pool = self._pool or _Pool(self.jobs)
        while running or (waiting and not is_broken):
            # One waits, so that no worker stands idle while this process is busy with what was yielded.
            while waiting and len(running) <= self.jobs and not is_broken:
                try:
                    with _deaf_to_interrupts(), _no_warning_of_threads():
                        running[pool.executor.submit(task, waiting[0][0])] = waiting[0]
                except BrokenProcessPool:  # a worker died since the last result was fetched
                    is_broken = True
                except OSError as error:
                    why = error.strerror or error
                    raise Died(f"no worker process can be started: {why}; free memory, or try --jobs 1") from error
                else:
                    del waiting[0]

            # One death breaks the whole pool, and nothing tells whose it was: all that was running is under suspicion.
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

        # A broken pool takes no more tasks. It goes, so that the next call starts another.
        if is_broken:
            self._dismiss()
        return waiting, suspects

    def _dismiss(self, *, at_once: bool = False) -> None:
        """End the processes; at once: without waiting for their tasks."""
        pool, self._pool = self._pool, None
        if pool:
            pool.close(at_once=at_once)


class _Pool:
    """Worker processes, and a pipe by which they know that this one lives."""

    def __init__(self, jobs: int) -> None:
        is_forked = can_fork()
        context = multiprocessing.get_context("fork" if is_forked else "spawn")
        self.lifeline, self.held = context.Pipe(duplex=False)
        # A copy of this process has a copy of the end that is held, too, and has to let go of it.
        ends = self.lifeline, self.held if is_forked else None
        self.executor = ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin, initargs=ends)

    def close(self, *, at_once: bool) -> None:
        """End the processes; at once: without waiting for their tasks."""
        if at_once:
            self.held.close()  # or the pool would wait for what its workers are at
        self.executor.shutdown()
        self.held.close()
        self.lifeline.close()


def _called(numbered: tuple[int, Callable, tuple]) -> tuple[Any]:
    """Result of a function for its arguments, in a tuple, as None stands for a death."""
    _, function, arguments = numbered
    return (function(*arguments),)


def _begin(lifeline: Connection, held: Connection | None) -> None:
    """Begin a worker: what libraries warn of stays out of the standard error that it shares with the command."""
    if held:
        held.close()
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
        logging.lastResort = logging.NullHandler()
    _live_on(lifeline)


def _live_on(lifeline: Connection) -> None:
    """End this worker as soon as the other end of a pipe is closed, be it because the process that holds it died."""

    def watch() -> None:
        multiprocessing.connection.wait([lifeline])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextlib.contextmanager
def _no_warning_of_threads() -> Iterator[None]:
    """Fork without Python's warning that there are other threads, see `can_fork`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        yield


@contextlib.contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Start processes that never hear of Ctrl-C; who started them does, and ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
