"""The memory that this process may still take."""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path

GROUP = Path("/sys/fs/cgroup")


def available_memory() -> float:
    """Return the memory that can be taken before the system, a container or a limit of the process refuses it.

    In [bytes]; infinity where the system does not tell.
    """
    return min(_of_system(), _of_container(), _of_process())


def _of_system() -> float:
    import psutil  # takes long to import, and few need it

    with suppress(OSError, RuntimeError):
        return float(psutil.virtual_memory().available)
    return math.inf


def _of_container() -> float:
    with suppress(OSError, ValueError, KeyError):  # ValueError: the limit is "max"
        limit, used = (int((GROUP / name).read_text()) for name in ("memory.max", "memory.current"))
        details = dict(line.split() for line in (GROUP / "memory.stat").read_text().splitlines())
        return float(limit - used + int(details["file"]))  # the cache of files gives way
    return math.inf


def _of_process() -> float:
    with suppress(ImportError, OSError, ValueError, IndexError):
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        if limit != resource.RLIM_INFINITY:
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            return float(limit - pages * resource.getpagesize())
    return math.inf
