"""A sweep into one archive: what is finished survives a kill, and is the same however the work is shared out."""

import functools
import hashlib
import itertools
import json
import operator
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Archive, ArchiveError, IncompleteError, find_target, read, write
from apesim.archive.completeness import missing_runs, runs_planned
from apesim.archive.file import complete_provenance
from apesim.archive.lock import lock
from apesim.archive.memory import available_memory
from apesim.archive.merge import merge
from apesim.archive.shards import plan_hash, read_shards, shards_folder
from apesim.archive.untrusted import SIZE_LIMIT
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cycle.operating_point import cycle_of
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.quantities.settings import dumps
from apesim.studies.execution.cluster import run_on_cluster
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.execution.resuming import keep, make_room, read_own_archive, remove_what_is_done
from apesim.studies.sweep.completion import complete, seconds_of
from apesim.studies.sweep.compute import ROWS, compute
from apesim.studies.sweep.plan import FIXED, Point, plan
from apesim.studies.sweep.results import archive_of, faults_of
from apesim.studies.sweep.variation import Variation


class SweepResult(NamedTuple):
    """A sweep that has ended: its archive, and what is wrong with some of its points."""

    path: Path
    """Path of the archive."""
    archive: Archive
    """Results of all points that could be computed."""
    faults: list[str]
    """One line for each point that is out of reach, failed or did not converge, and for those that are missing."""
    seconds: float
    """Wall time without that of compiling [s]; where the sweep was finished already, the time of checking it."""
    notes: list[str]
    """One line for each shard that was damaged and computed again, and for shards that could not be removed."""
    was_finished: bool
    """The archive was there and whole already, and nothing was computed."""


def run_sweep(
    machine: Machine,
    speeds: Sequence[float],
    intakes: Sequence[int],
    out: str | os.PathLike[str],
    *,
    timings: Sequence[int] = (FIXED,),
    variation: Variation | None = None,
    traces: bool = True,
    jobs: int | None = None,
    cluster: Any = None,
    shard: tuple[int, int] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    command: str = "",
    report: Callable[[int, int], Any] | None = None,
    warm_up: Callable[..., Any] = operator.call,
) -> SweepResult:
    """Run a sweep and write its archive `out`; what is finished survives a kill.

    `speeds` are in [rad/s], `intakes` and `timings` are codes, and `variation` (see
    `apesim.studies.sweep.variation.vary`) runs instead of `machine`. Without `traces` an archive takes some hundredth
    of the room. `jobs` None: as many processes as the work is worth; a `cluster` (see
    `apesim.studies.execution.cluster.connected`) computes instead of this machine; `shard` (i, N) takes every N-th
    point from the i-th, i = 1...N, and ``apesim archive merge`` joins the archives. `resume` goes on with the shards of
    an interrupted sweep and leaves a finished one as it is; `overwrite` replaces what is there. `report` gets the
    numbers of points done and of all; `warm_up` calls the function that it gets with its arguments, for a few points
    during which the model may be compiled. Raises ArchiveError where the target exists, is being written by another
    process, cannot be written, gets no points or would be too large to be read, and IncompleteError where not one run
    could be computed.
    """
    out = Path(out)
    text = dumps(machine)
    planned = plan(variation or Variation((), (machine,)), speeds, intakes, timings)
    points = planned.points

    # What makes a sweep this one and no other: shards and archives with another hash are not joined to it.
    settings: dict[str, Any] = {
        "kind": "engine sweep",
        "speeds": [float(speed) for speed in speeds],
        "axes": planned.axes,
        "machines": _hash_of(planned.variation.machines),
    }
    if not traces:
        settings["traces"] = False
    provenance = {
        "kind": "engine sweep",
        "command": command,
        "plan_hash": plan_hash(text, settings | {"kernels": sources_hash()}),
        "kernels": sources_hash(),
        "runs_planned": str(len(points)),
        "shard": "{}/{}".format(*shard or (1, 1)),
        "axes": json.dumps(planned.axes),
    }

    # A wrong target, an empty share and too many traces are refused before anything is computed.
    find_target(out)
    if shard:
        total = len(points)
        points = points[shard[0] - 1 :: shard[1]]
        if not points:
            raise ArchiveError(out, "its share of the work is empty", f"give --shard i/N with N at most {total}")
    if traces:
        _refuse_too_many(out, len(points))
    with lock(out):
        start = time.perf_counter()
        own = {key: provenance[key] for key in ("plan_hash", "shard")}
        there = read_own_archive(out, own, overwrite=overwrite) if resume else None
        if there and not missing_runs(there):
            return _finished(out, there, start)

        # Where a sweep goes on, its own archive that lacks runs may be replaced without `overwrite`.
        is_ours = there is not None
        make_room(out, resume=resume, overwrite=overwrite or is_ours, unfinished="the points of an unfinished sweep")
        warm_up(compute, _first_of_each_kind(points))  # one process compiles; the others' time is that of computing

        # What no shard holds yet is computed, and written as shards that survive a kill; compiling is not timed.
        start = time.perf_counter()
        task = compute if traces else functools.partial(compute, traces=False)
        completion = complete(
            shards_folder(out),
            points,
            provenance["plan_hash"],
            run=functools.partial(run_on_cluster, cluster, task)
            if cluster
            else functools.partial(_run_here, task, jobs),
            to_archive=lambda chunk, results: complete_provenance(
                archive_of(chunk, results, planned.variation, text, provenance)
            ),
            report=report or (lambda done, total: None),
        )
        if completion.fault and not completion.parts:
            raise IncompleteError(out, *completion.fault)

        # All results become one archive. The shards are removed when it is written, and only where no run is missing.
        archive = merge(completion.parts)
        completion.parts.clear()  # else all would be in memory twice while the archive is written
        archive = replace(archive, provenance=archive.provenance | {"shard": provenance["shard"]})
        keep(archive, functools.partial(write, path=out))
        notes = [f"a shard was damaged and computed again: {line}" for line in completion.damaged]
        if not completion.fault:
            notes += remove_what_is_done(out)
    faults = ["; ".join(completion.fault)] if completion.fault else []
    seconds = time.perf_counter() - start
    return SweepResult(out, archive, faults + faults_of(archive), seconds, notes, was_finished=False)


def find_finished(out: str | os.PathLike[str]) -> SweepResult | None:
    """Read a sweep that is finished already, whatever was swept; its remaining shards are removed.

    None where the archive does not exist, cannot be read, is not of a sweep, or lacks runs. Raises ArchiveError where
    another process writes it, or shards of another sweep lie beside it.

    >>> import tempfile
    >>> from apesim.engine.cylinder import IDEAL_VALVE
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = run_sweep(Machine(), [94.0], [IDEAL_VALVE], f"{folder}/sweep.h5", jobs=1)
    ...     find_finished(done.path).was_finished, find_finished(f"{folder}/other.h5")
    (True, None)
    """
    out = Path(out)
    if not os.path.isfile(out):
        return None
    with lock(out):
        start = time.perf_counter()
        try:
            there = read(out)
        except ArchiveError:
            return None
        is_whole = "plan_hash" in there.provenance and runs_planned(there) is not None and not missing_runs(there)
        return _finished(out, there, start) if is_whole else None


def _finished(out: Path, archive: Archive, start: float) -> SweepResult:
    """Make the result of a sweep whose archive is there and whole, and remove the shards that it left."""
    read_shards(shards_folder(out), archive.provenance["plan_hash"])  # those of another sweep are not ours to remove
    notes = remove_what_is_done(out)
    return SweepResult(out, archive, faults_of(archive), time.perf_counter() - start, notes, was_finished=True)


def _run_here(
    task: Callable[[Sequence[Point]], Any], jobs: int | None, chunks: Sequence[Sequence[Point]]
) -> Iterator[tuple[Any, Any]]:
    """Run tasks, see `apesim.studies.execution.pool.run_tasks`, in as many processes as the work is worth."""
    return run_tasks(task, chunks, workers_for(seconds_of(itertools.chain(*chunks)), jobs))


def _refuse_too_many(out: Path, runs: int) -> None:
    """Refuse runs before they start whose traces are more than apesim reads of an archive, or than memory can hold."""
    size = runs * (ROWS + 1) * len(TRACE) * np.dtype(float).itemsize
    too_much = {
        "apesim reads of an archive": SIZE_LIMIT,
        "the memory can hold while it is written": available_memory() / 2,
    }
    what, limit = min(too_much.items(), key=operator.itemgetter(1))
    if size > limit:
        text = (
            f"would hold {runs} runs with traces, {size / 1e9:.1f} GB; that is more than {what}, {limit / 1e9:.1f} GB"
        )
        raise ArchiveError(out, text, "leave the traces out (--no-traces), or share the runs out (--shard i/N)")


def _first_of_each_kind(points: Iterable[Point]) -> list[Point]:
    """Choose points that compile all code that any needs: corrected or not, of each kind of effects and of exhausts."""
    machines: dict[tuple[int, int], Point] = {}
    kinds: dict[tuple[int, int, type, type], Point] = {}
    for point in points:
        machines.setdefault((point.timing, point.combination), point)
    for point in machines.values():
        cycle, *_ = cycle_of(point.machine, point.speed)
        types = type(cycle.effects), type(cycle.actuator.effects)
        kinds.setdefault((point.timing, len(cycle.exhausts), *types), point)
    return list(kinds.values())


def _hash_of(machines: Iterable[Machine]) -> str:
    """Hash all numbers of some machines; 64 hexadecimal digits."""
    digest = hashlib.sha256()
    for machine in machines:
        digest.update(json.dumps(machine, default=lambda curve: curve.tolist()).encode())
    return digest.hexdigest()
