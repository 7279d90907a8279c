"""Step of a model as object files: compiled in a process of its own, and kept for machines of the same kind."""

import hashlib
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from apesim.archive import write_file
from apesim.compiling import note_compile_time, tell_of_compiling
from apesim.engine.machine import Machine
from apesim.kernel import cache_folder
from apesim.studies.fmu.model import Model
from apesim.studies.fmu.platforms import PLATFORMS

STEP = "apesim_step"
"""Name of the function of a step, as the C sources call it."""
SOURCES = "flat", "native", "model", "step_object"
"""Files here that a compiled step follows, beside its model's. It is kept in the folder that kernels' files name."""
COMPILED_FOR = {"NUMBA_CPU_NAME": "x86-64-v2", "NUMBA_CPU_FEATURES": "", "NUMBA_DISABLE_JIT": "0"}
"""What Numba is told by its environment before it is imported: any processor of the last fifteen years."""


def step_objects(machine: Machine, model: Model) -> dict[str, bytes]:
    """Return the object files of a model's step, by the names of the platforms; they are compiled where none is kept.

    Machines of other numbers have the same: their numbers are data. Another process compiles, as Numba is told of the
    processor once.
    """
    key = _key(model, model.numbers_of(machine))
    kept = {platform.name: cache_folder() / f"step-{key}-{platform.name}.o" for platform in PLATFORMS}
    if not all(path.exists() for path in kept.values()):
        kind = f"{model.kind} of an FMU"
        tell_of_compiling(kind, "any x86-64")
        begin = time.perf_counter()
        with TemporaryDirectory(prefix="apesim-fmu-") as folder:
            _compile_elsewhere(machine, model, folder)
            for name, path in kept.items():
                write_file(path, Path(folder, name).read_bytes())
        note_compile_time(kind, time.perf_counter() - begin)
    return {name: path.read_bytes() for name, path in kept.items()}


def _key(model: Model, example: Any) -> str:
    """Name of what is compiled for a model: a hash of the types and shapes of its numbers, and of these sources."""
    digest = hashlib.sha256(repr([model.kind, *_shape_of(example)]).encode())
    for name in (*SOURCES, f"{model.kind}_model"):
        digest.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return digest.hexdigest()[:16]


def _shape_of(value: Any) -> Iterator[Any]:
    """Types and shapes of a tuple, in order; of effects from outside, the hash of their files, too."""
    kind = type(value)
    yield kind.__module__, kind.__qualname__, getattr(kind, "outside_hash", "")
    if isinstance(value, tuple):
        for member in value:
            yield from _shape_of(member)
    elif isinstance(value, np.ndarray):
        yield value.dtype.str, value.shape


def _compile_elsewhere(machine: Machine, model: Model, folder: str) -> None:
    """Compile the step of a model into a folder, in a process of its own."""
    environment = os.environ | COMPILED_FOR | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-P", "-m", "apesim.studies.fmu.step_object", folder]
    given = pickle.dumps((machine, model.numbers_of, model.make_step))
    done = subprocess.run(command, input=given, capture_output=True, env=environment, check=False)
    if done.returncode:
        raise RuntimeError(f"the step could not be compiled:\n{done.stderr.decode(errors='replace')[-4000:]}")


def _compile_here(machine: Machine, numbers_of: Callable[[Machine], Any], make_step: Any, folder: str) -> None:
    """Compile the step of a model into a folder: a file for each platform."""
    from numba import types

    from apesim.studies.fmu.native import compile_module, emit_object

    numbers = types.CPointer(types.float64)
    signature = types.int64(numbers, numbers, numbers, types.int64, types.float64, numbers)
    module = compile_module(make_step(numbers_of(machine)), signature, STEP)
    for platform in PLATFORMS:
        Path(folder, platform.name).write_bytes(emit_object(module.clone(), platform.name))


if __name__ == "__main__":
    given = pickle.load(sys.stdin.buffer)  # from the process that has started this one
    _compile_here(given[0], given[1], given[2], sys.argv[1])
