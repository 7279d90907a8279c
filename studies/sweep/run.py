"""A sweep into one archive: what is finished survives a kill, and is the same however the work is shared out."""

import functools
import hashlib
import itertools
import json
import operator
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from apesim.archive import Archive, ArchiveError, DamagedError, IncompleteError, read, write
from apesim.archive.shards import (
    lock,
    merge,
    missing_runs,
    plan_hash,
    read_shards,
    remove_shards,
    runs_planned,
    shards_folder,
)
from apesim.engine.cycle.operating_point import cycle_of
from apesim.kernel import sources_hash
from apesim.quantities.settings import dumps
from apesim.studies.execution.cluster import run_on_cluster
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.output import refuse_folder, refuse_to_replace
from apesim.studies.sweep.completion import complete, keep, seconds_of
from apesim.studies.sweep.compute import compute
from apesim.studies.sweep.plan import FIXED, plan
from apesim.studies.sweep.results import archive_of, faults_of
from apesim.studies.sweep.variation import Variation


class SweepResult(NamedTuple):
    """What a sweep leaves."""

    path: Path
    archive: Archive
    faults: list
    """One line for each point that is out of reach, failed or did not converge, and for those that are missing."""
    seconds: float
    """Computing time, warm; that of checking, where it was finished already."""
    was_finished: bool
    """The archive was there and whole already, and nothing was computed."""


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
        Machines to run instead, see `apesim.studies.sweep.variation.vary`.
    jobs : int, optional
        Processes; as many as the work is worth if left out.
    cluster : distributed.Client, optional
        Where to compute instead, see `apesim.studies.execution.cluster.connected`.
    shard : tuple of int, optional
        (i, N): only every N-th point from the i-th, i = 1...N; `apesim archive merge` joins the archives.
    resume : bool
        Go on with the shards of a sweep that was interrupted; one that is finished stays as it is.
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
        The target exists, or another process writes it, or it cannot be written.
    IncompleteError
        Not one of the runs could be computed.
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
        "shard": "{}/{}".format(*shard or (1, 1)),
        "axes": json.dumps(planned.axes),
    }
    refuse_folder(out)
    if shard:
        total = len(points)
        points = points[shard[0] - 1 :: shard[1]]
        if not points:
            raise ArchiveError(out, "its share of the work is empty", f"give --shard i/N with N at most {total}")
    with lock(out):
        start = time.perf_counter()
        there = _own_archive(out, provenance, overwrite) if resume else None
        if there and not missing_runs(there):
            return _finished(out, there, start)
        _clear(out, resume, overwrite or there)
        warm_up(compute, _first_of_each_kind(points))  # one process compiles; the others' time is that of computing
        start = time.perf_counter()
        found = complete(
            shards_folder(out),
            points,
            provenance["plan_hash"],
            run=functools.partial(run_on_cluster, cluster, compute) if cluster else functools.partial(_run_here, jobs),
            to_archive=lambda *done: archive_of(*done, planned.variation, text, provenance),
            report=report or (lambda done, total: None),
        )
        if not found.parts:
            raise IncompleteError(out, *found.faults[0])
        archive = merge(found.parts)
        archive = replace(archive, provenance=archive.provenance | {"shard": provenance["shard"]})
        keep(archive, functools.partial(write, path=out))
        if not found.faults:
            remove_shards(shards_folder(out))
    faults = [f"{what}; {remedy}" for what, remedy in found.faults] + faults_of(archive)
    return SweepResult(out, archive, faults, time.perf_counter() - start, was_finished=False)


def find_finished(out):
    """A finished sweep, whatever was swept: for whom resumes it without saying what.

    Parameters
    ----------
    out : path
        The archive.

    Returns
    -------
    SweepResult or None
        None where there is no sound archive of a sweep, or one that lacks runs.

    Raises
    ------
    ArchiveError
        Another process writes it.
    """
    out = Path(out)
    if not out.is_file():
        return None
    with lock(out):
        start = time.perf_counter()
        try:
            there = read(out)
        except ArchiveError:
            return None
        is_whole = "plan_hash" in there.provenance and runs_planned(there) is not None and not missing_runs(there)
        return _finished(out, there, start) if is_whole else None


def _finished(out, archive, start):
    """Result of a sweep whose archive is there and whole; shards that it left are removed."""
    read_shards(shards_folder(out), archive.provenance["plan_hash"])  # those of another sweep are not ours to remove
    remove_shards(shards_folder(out))
    return SweepResult(out, archive, faults_of(archive), time.perf_counter() - start, was_finished=True)


def _run_here(jobs, chunks):
    """Run tasks, see `apesim.studies.execution.pool.run_tasks`, in as many processes as the work is worth."""
    return run_tasks(compute, chunks, workers_for(seconds_of(itertools.chain(*chunks)), jobs))


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


def _own_archive(out, provenance, overwrite):
    """The archive that is there, if it is of this sweep and of this share of it."""
    if not out.exists():
        return None
    try:
        archive = read(out)
    except DamagedError as error:
        if overwrite:
            return None
        raise DamagedError(out, f"is there, but damaged ({error.what})", "give --overwrite to replace it") from None
    except ArchiveError:
        return None
    own = all(archive.provenance.get(key) == provenance[key] for key in ("plan_hash", "shard"))
    return archive if own else None


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
