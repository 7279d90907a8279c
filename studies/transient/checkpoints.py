"""Checkpoints of a long march, as a shard beside its archive: what is done survives a kill."""

import time
from pathlib import Path

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import run_axis
from apesim.archive.shards import read_shards, shards_folder, write_shard
from apesim.engine.drivetrain.checkpoint import CHECKPOINT, checkpoint_of, resume_march
from apesim.engine.drivetrain.preparing import Prepared
from apesim.engine.drivetrain.run import March, begin_march
from apesim.studies.execution.resuming import keep

SECONDS_BETWEEN = 5.0
"""Computing time between two checkpoints, at least [s]: who kills a run loses no more; shorter runs need none."""
SHARE_OF_WRITING = 0.05
"""Share of the time that writing checkpoints may take: those of long traces are large."""


class Checkpoints:
    """Checkpoints of one march: the newest replaces the one before.

    `out` is the archive of the run, `machine` its text, and `provenance` has the hash of its plan.
    """

    def __init__(self, out: Path, machine: str, provenance: dict[str, str]) -> None:
        self.folder, self.machine, self.provenance = shards_folder(out), machine, provenance
        self.notes: list[str] = []
        self._last, self._patience = time.perf_counter(), SECONDS_BETWEEN

    def resume(self, prepared: Prepared, times: np.ndarray) -> March:
        """Go on from the checkpoint that is there; from the start where there is none, or it is damaged.

        Raises ArchiveError where it is one of another run.
        """
        shards = read_shards(self.folder, self.provenance["plan_hash"])
        self.notes = [
            f"a checkpoint was damaged, and what was done is computed again: {line}" for line in shards.damaged
        ]
        if not shards.parts:
            return begin_march(prepared, times)
        variables = shards.parts[-1].variables
        return resume_march(prepared, times, {name: variables[name].values[0] for name in CHECKPOINT})

    def offer(self, marched: March) -> None:
        """Write a checkpoint where enough time has passed since the last one; the march may go on after the return."""
        begin = time.perf_counter()
        if begin - self._last < self._patience:
            return
        keep(self._archive_of(marched), lambda part: write_shard(self.folder, part))
        self._last = time.perf_counter()
        self._patience = max(SECONDS_BETWEEN, (self._last - begin) / SHARE_OF_WRITING)

    def _archive_of(self, marched: March) -> Archive:
        """Lay out a checkpoint as an archive of one run."""
        variables = {"run": run_axis(1)}
        for name, values in checkpoint_of(marched).items():
            dims = CHECKPOINT[name]
            for axis, size in zip(dims, values.shape, strict=True):
                variables.setdefault(axis, Variable((axis,), np.arange(size), "1", "place in the checkpoint"))
            variables[name] = Variable(("run", *dims), values[np.newaxis], "1", "what the march needs to go on, in SI")
        return Archive(self.machine, self.provenance, variables)
