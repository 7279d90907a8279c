"""Cluster that work is done on, a cluster of dask.distributed.

Whoever reaches a scheduler can run any code on its workers and here: keep it on the loopback address, or behind TLS.
"""

import contextlib
import logging
import re
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from apesim.kernel import sources_hash
from apesim.quantities import Fault, InputError

if TYPE_CHECKING:
    from distributed import Client

DASK = "--dask"
"""Option that names the cluster."""
ADDRESS = r"(tcp|tls)://\S+:\d+|inproc://\S+"
"""Pattern of a scheduler's address."""
PATIENCE = 10.0
"""Time for which a scheduler may stay silent [s]."""


@contextlib.contextmanager
def connected(address: str) -> "Iterator[Client]":
    """Connect to a scheduler as its client, by an address like "tcp://127.0.0.1:8786".

    Raises InputError where distributed is not installed, or nobody answers.
    """
    try:
        from distributed import Client
    except ImportError:
        raise _refusal("needs distributed, which is not installed", 'python -m pip install "apesim[dask]"') from None
    right = "start one with `dask scheduler`, and give e.g. tcp://127.0.0.1:8786"
    if not re.fullmatch(ADDRESS, address):
        raise _refusal(f"{address!r} is no address of a scheduler", right)
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what it would log is reported as a fault
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except OSError:
        raise _refusal(f"no scheduler answers at {address!r}", right) from None
    with client:
        yield client


def run_on_cluster(client: "Client", task: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[tuple[Any, Any]]:
    """Apply a function to items on a cluster and yield each item with its result, as it comes.

    `task` stands in a module, so that workers find it. A result is None where the item killed more workers than the
    scheduler allows. Raises InputError where the scheduler is lost, or workers have no apesim, another one, or another
    processor: the bits would differ.
    """
    from distributed import KilledWorker, as_completed

    pending = {client.submit(_checked, task, item, sources_hash(), pure=False): item for item in items}
    try:
        for future in as_completed(list(pending), loop=client.loop):
            if future.cancelled():
                raise _refusal("the scheduler is gone; what is done is kept", "start it, and go on with --resume")
            item, error = pending.pop(future), future.exception()
            if error is None:
                yield item, future.result()
            elif isinstance(error, KilledWorker):
                yield item, None
            elif isinstance(error, ImportError):
                raise _refusal(f"its workers have no apesim ({error})", "install it where they run") from error
            else:
                raise error
    finally:
        client.cancel(list(pending))


def _checked(task: Callable[[Any], Any], item: Any, expected: str) -> Any:
    """Do a task on a worker, if its kernels are the same there as where the task comes from."""
    if sources_hash() != expected:
        wrong = "its workers run another version of apesim or of its libraries, or have another processor"
        raise _refusal(wrong, "make them the same")
    return task(item)


def _refusal(wrong: str, right: str) -> InputError:
    """The error that names the option, what is wrong and what would be right."""
    return InputError([Fault(DASK, "", wrong, right)])
