"""Shared library of an FMU: the compiled step and the functions of FMI in C, linked by a compiler that is there."""

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from importlib.resources import as_file, files
from pathlib import Path
from tempfile import TemporaryDirectory

from apesim.studies.fmu.platforms import LINUX, PLATFORMS, Platform

SOURCES = ("instance.c", "runtime.c")
"""Sources that both versions of FMI have."""
OPTIONS = ("-O2", "-std=gnu11", "-fPIC", "-shared", "-fvisibility=hidden")
"""Options of every compiler."""
OLD_FUNCTIONS = ("exp", "log", "pow", "memcpy")
"""Functions of glibc that are taken in their oldest version, see `runtime.c`."""
OWN_OPTIONS = ("-Wl,--gc-sections", "-Wl,-z,defs", "-Wl,-s")
"""Options of the compiler of a Linux system: nothing may be left undefined."""
GLIBC_OPTIONS = ("-DAPESIM_OLD_GLIBC", *(f"-Wl,--wrap={name}" for name in OLD_FUNCTIONS))
"""Further ones where its C library is glibc."""


def find_compilers() -> dict[Platform, list[str]]:
    """Find a C compiler for each platform: that of this system, else Zig's, as the words of its command."""
    found = {}
    if importlib.util.find_spec("ziglang"):
        zig = [sys.executable, "-m", "ziglang", "cc"]
        found = {each: [*zig, "-target", each.zig, "-s"] for each in PLATFORMS}
    own = next(filter(None, map(shutil.which, ("gcc", "cc", "clang"))), None)
    if own and sys.platform == "linux" and platform.machine() == "x86_64":
        found[LINUX] = [own, *OWN_OPTIONS, *(GLIBC_OPTIONS if platform.libc_ver()[0] == "glibc" else ())]
    return found


def link(compiler: Sequence[str], code: bytes, header: str, fmi: int) -> bytes:
    """Link a library from the object file of a step and the sources of a version of FMI.

    Raises RuntimeError with what the compiler says where it fails.
    """
    with TemporaryDirectory(prefix="apesim-fmu-") as name, as_file(files("apesim.studies.fmu") / "c") as sources:
        folder = Path(name)
        (folder / "model.h").write_text(header, encoding="utf-8")
        (folder / "step.o").write_bytes(code)
        paths = [str(sources / source) for source in (*SOURCES, f"fmi{fmi}.c")]
        command = [*compiler, *OPTIONS, f"-I{folder}", f"-I{sources}", *paths, str(folder / "step.o")]
        done = subprocess.run(
            [*command, "-o", str(folder / "library"), "-lm"],
            capture_output=True,
            text=True,
            env=os.environ | {"ZIG_LOCAL_CACHE_DIR": str(folder / "zig")},
            check=False,
        )
        if done.returncode:
            raise RuntimeError(f"the C compiler failed:\n{done.stderr[-4000:]}")
        return (folder / "library").read_bytes()
