"""Cluster that work is done on, a cluster of dask.distributed.

Whoever reaches a scheduler can run any code on its workers and here: keep it on the loopback address, or behind TLS.
"""

import contextlib
import logging
import re

from apesim.kernel import sources_hash
from apesim.quantities import Culprit, InputError

DASK = "--dask"
ADDRESS = r"(tcp|tls)://\S+:\d+|inproc://\S+"
PATIENCE = 10.0
"""Time for which a scheduler may stay silent [s]."""


@contextlib.contextmanager
def connected(address):
    """A client of a scheduler.

    Parameters
    ----------
    address : str
        E.g. "tcp://127.0.0.1:8786".

    Yields
    ------
    distributed.Client

    Raises
    ------
    InputError
        distributed is not installed, or nobody answers.
    """
    try:
        from distributed import Client
    except ImportError:
        raise _refusal("needs distributed, which is not installed", 'python -m pip install "apesim[dask]"') from None
    right = "start one with `dask scheduler`, and give e.g. tcp://127.0.0.1:8786"
    if not re.fullmatch(ADDRESS, address):
        raise _refusal(f"{address!r} is no address of a scheduler", right)
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what it would log is told as a culprit
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except OSError:
        raise _refusal(f"no scheduler answers at {address!r}", right) from None
    with client:
        yield client


def run_on_cluster(client, task, items):
    """Apply a function to items on a cluster and yield what comes out, as it comes.

    Parameters
    ----------
    client : distributed.Client
    task : function
        Of one item; of a module, so that workers find it.
    items : sequence

    Yields
    ------
    item, result
        The result is None where the item killed more workers than the scheduler allows.

    Raises
    ------
    InputError
        The scheduler is lost. Or workers have no apesim, another one, or another processor: the bits would differ.
    """
    from distributed import KilledWorker, as_completed

    given = {client.submit(_checked, task, item, sources_hash(), pure=False): item for item in items}
    try:
        for future in as_completed(list(given), loop=client.loop):
            if future.cancelled():
                raise _refusal("the scheduler is gone; what is done is kept", "start it, and go on with --resume")
            item, error = given.pop(future), future.exception()
            if error is None:
                yield item, future.result()
            elif isinstance(error, KilledWorker):
                yield item, None
            elif isinstance(error, ImportError):
                raise _refusal(f"its workers have no apesim ({error})", "install it where they run") from error
            else:
                raise error
    finally:
        client.cancel(list(given))


def _checked(task, item, expected):
    """On a worker: a task, if its kernels are the same there as where it comes from."""
    if sources_hash() != expected:
        wrong = "its workers run another version of apesim or of its libraries, or have another processor"
        raise _refusal(wrong, "make them the same")
    return task(item)


def _refusal(wrong, right):
    return InputError([Culprit(DASK, "", wrong, right)])
