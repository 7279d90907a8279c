"""Surroundings of a computation: versions of all that computes, the commit of a checkout, the processor."""

from __future__ import annotations

import functools
import importlib.metadata
import os
import platform
import re
import subprocess
import sys
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

import h5py

import apesim

__all__ = ["PACKAGES", "surroundings"]

PACKAGES = ("apesim", "numpy", "numba", "llvmlite", "scipy", "h5py")
"""What computes and stores, by the names of their distributions."""
GIT_SECONDS = 5.0
"""Patience with git, which answers in 10 ms; on a network drive it may hang."""


def surroundings() -> dict[str, str]:
    """Return where and when a result is computed; nothing that names a user, a folder or a computer.

    The keys are ``created``, ``python``, ``platform``, ``processor``, ``hdf5``, each of `PACKAGES` that is at work, and
    ``commit`` where apesim runs from a checkout.
    """
    known = {
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "processor": processor(),
        "hdf5": h5py.version.hdf5_version,
        **{package: version_of(package) for package in PACKAGES if package in sys.modules},
        "commit": commit(),
    }
    return {name: text for name, text in known.items() if text}


@functools.cache
def version_of(package: str) -> str:
    """Return the version of an installed package, by the name of its distribution; "" for others."""
    with suppress(importlib.metadata.PackageNotFoundError):
        return importlib.metadata.version(package)
    return ""


@functools.cache
def processor() -> str:
    """Return the name of the processor as its maker gives it, else that of its kind, such as "arm64"."""
    with suppress(OSError):
        if found := re.search(r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(errors="replace"), re.M):
            return " ".join(found[1].split())
    return platform.processor() or platform.machine()


@functools.cache
def commit() -> str:
    """Return the hash of the commit of the checkout that apesim runs from; "" without a checkout or without git.

    It ends in "-dirty" where files differ from the commit.
    """
    folder = Path(apesim.__file__).parents[1]
    if not (folder / ".git").exists():
        return ""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    with suppress(OSError, subprocess.SubprocessError):
        done = subprocess.run(command, capture_output=True, text=True, timeout=GIT_SECONDS, env=environment, check=True)
        return done.stdout.strip()
    return ""
