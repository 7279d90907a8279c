"""A sweep into one archive: what is finished survives a kill, and is the same however the work is shared out."""

import hashlib
import json
import operator
import time
from pathlib import Path
from typing import NamedTuple

from apesim.archive import Archive, ArchiveError, write
from apesim.archive.shards import lock, merge, plan_hash, read_shards, remove_shards, shards_folder, write_shard
from apesim.kernel import sources_hash
from apesim.quantities.settings import dumps
from engine.operating_point import cycle_of
from studies.cluster import run_on_cluster
from studies.output import refuse_folder, refuse_to_replace
from studies.pool import run_tasks, workers_for
from studies.sweep.compute import compute
from studies.sweep.plan import CORRECTED, FIXED, plan
from studies.sweep.results import archive_of, faults_of
from studies.sweep.variation import Variation

SECONDS_A_POINT = {FIXED: 0.03, CORRECTED: 0.12}
SHARD_SECONDS = 1.0
"""Work of a shard."""


class SweepResult(NamedTuple):
    """What a sweep leaves."""

    path: Path
    archive: Archive
    faults: list
    """One line for each point that is out of reach, failed or did not converge."""
    seconds: float
    """Computing time, warm."""


def run_sweep(
    machine,
    speeds,
    intakes,
    out,
    *,
    timings=(FIXED,),
    variation=None,
    jobs=None,
    cluster=None,
    shard=None,
    resume=False,
    overwrite=False,
    command="",
    report=None,
    warm_up=operator.call,
):
    """Run a sweep and write its archive; what is finished survives a kill.

    Parameters
    ----------
    machine : Machine
        Its text goes into the archive.
    speeds : sequence of float
        [rad/s]
    intakes : sequence of int
    out : path
        The archive.
    timings : sequence of int
        `FIXED` and `CORRECTED` commands of the electro-pneumatic valve.
    variation : Variation, optional
        Machines to run instead, see `studies.sweep.variation.vary`.
    jobs : int, optional
        Processes; as many as the work is worth if left out.
    cluster : distributed.Client, optional
        Where to compute instead, see `studies.cluster.connected`.
    shard : tuple of int, optional
        (i, N): only every N-th point from the i-th, i = 1...N; `apesim archive merge` joins the archives.
    resume : bool
        Go on with the shards of a sweep that was interrupted.
    overwrite : bool
        Replace an archive or shards that are there.
    command : str
        The command line, for the archive.
    report : function, optional
        Called with the numbers of points done and in all, whenever some are done.
    warm_up : function
        Calls a function with its arguments; it is given a few points, for which the model may have to be compiled.

    Returns
    -------
    SweepResult

    Raises
    ------
    ArchiveError
        The target exists, or another process writes it.
    """
    out = Path(out)
    text = dumps(machine)
    planned = plan(variation or Variation((), (machine,)), speeds, intakes, timings)
    points = planned.points
    settings = {
        "kind": "engine sweep",
        "speeds": [float(speed) for speed in speeds],
        "axes": planned.axes,
        "machines": _hash_of(planned.variation.machines),
    }
    provenance = {
        "command": command,
        "plan_hash": plan_hash(text, settings | {"kernels": sources_hash()}),
        "kernels": sources_hash(),
        "runs_planned": str(len(points)),
        "axes": json.dumps(planned.axes),
    }
    refuse_folder(out)
    if shard:
        total = len(points)
        points = points[shard[0] - 1 :: shard[1]]
        if not points:
            raise ArchiveError(out, "its share of the work is empty", f"give --shard i/N with N at most {total}")
    with lock(out):
        _clear(out, resume, overwrite)
        warm_up(compute, _first_of_each_kind(points))  # one process compiles; the others' time is that of computing
        start = time.perf_counter()
        faults = _complete(out, points, planned.variation, text, provenance, jobs, cluster, report)
        parts = read_shards(shards_folder(out), provenance["plan_hash"]).parts
        if not parts:
            raise ArchiveError(out, "no point could be computed, every worker process died", "try --jobs 1")
        archive = merge(parts)
        write(archive, out)
        remove_shards(shards_folder(out))
    return SweepResult(out, archive, faults + faults_of(archive), time.perf_counter() - start)


def _complete(out, points, variation, machine, provenance, jobs, cluster, report):
    """Compute the points that no shard holds, and write them as shards; one line for each that could not be."""
    done = set(read_shards(shards_folder(out), provenance["plan_hash"]).done)
    chunks = _chunks([point for point in points if point.run not in done])
    report = report or (lambda done, total: None)
    finished, faults = len(done), []
    report(finished, len(points))
    for chunk, results in run_on_cluster(cluster, compute, chunks) if cluster else _run_here(compute, chunks, jobs):
        if results is None:
            faults += [f"run {point.run}: its worker died" for point in chunk]
            continue
        write_shard(shards_folder(out), archive_of(chunk, results, variation, machine, provenance))
        finished += len(chunk)
        report(finished, len(points))
    return faults


def _run_here(task, chunks, jobs):
    """As `studies.pool.run_tasks`, in as many processes as the work is worth."""
    return run_tasks(task, chunks, workers_for(sum(map(_seconds, chunks)), jobs))


def _seconds(points):
    """Estimated computing time of some points."""
    return sum(SECONDS_A_POINT[point.timing] for point in points)


def _chunks(points):
    """Points in shares of about `SHARD_SECONDS`."""
    chunks = []
    for point in points:
        if not chunks or _seconds(chunks[-1]) >= SHARD_SECONDS:
            chunks.append([])
        chunks[-1].append(point)
    return chunks


def _first_of_each_kind(points):
    """Points for which all is compiled that any needs: corrected or not, with effects of each library or without."""
    machines, kinds = {}, {}
    for point in points:
        machines.setdefault((point.timing, point.combination), point)
    for point in machines.values():
        cycle, *_ = cycle_of(point.machine, point.speed)
        kinds.setdefault((point.timing, type(cycle.effects), type(cycle.actuator.effects)), point)
    return list(kinds.values())


def _hash_of(machines):
    """Hash of all numbers of some machines."""
    digest = hashlib.sha256()
    for machine in machines:
        digest.update(json.dumps(machine, default=lambda curve: curve.tolist()).encode())
    return digest.hexdigest()


def _clear(out, resume, overwrite):
    """Refuse to lose what is there, or make room for the new."""
    folder = shards_folder(out)
    if not overwrite:
        refuse_to_replace(out)
    if folder.exists() and not resume:
        if not overwrite:
            raise ArchiveError(
                folder, "holds the points of an unfinished sweep", "go on with --resume, or give --overwrite"
            )
        remove_shards(folder)
