"""Sweep of operating points: speeds and intakes of one machine, into one archive."""

import operator
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from apesim.archive import Archive, ArchiveError, Variable, write
from apesim.archive.shards import lock, merge, plan_hash, read_shards, remove_shards, shards_folder, write_shard
from apesim.kernel import sources_hash
from apesim.march import Status
from apesim.quantities import split_header
from apesim.quantities.settings import dumps
from engine.breathing import DEGREE, TURN
from engine.cycle import TRACE
from engine.cylinder import INTAKES
from engine.indicators import COUNTS, FLAGS, INDICATORS, indicators
from engine.machine import Machine
from engine.steady import run_steady
from studies.output import refuse_folder, refuse_to_replace
from studies.pool import run_tasks, workers_for

ANGLE_STEP = 0.5 * DEGREE
SECONDS_A_POINT = 0.03
CHUNK = 25
"""Points of a shard: about a second's work."""
STATUS_MEANINGS = ", ".join(f"{int(status)} {status.name.lower().replace('_', ' ')}" for status in Status)
TRACE_DESCRIPTIONS = {
    "cylinder_pressure": "cylinder pressure",
    "cylinder_temperature": "cylinder temperature",
    "lift": "lift of the intake",
    "velocity": "velocity of the lift, positive as it opens",
    "pressure_a": "pressure of chamber A, which pushes to closed",
    "pressure_b": "pressure of chamber B, which pushes to open",
    "groove_flow": "flow through the groove into the cylinder",
    "torque": "indicated torque",
    "receiver_pressure": "pressure before the groove",
    "exhaust_flow": "flow through the exhaust valve out of the cylinder",
    "cylinder_volume": "cylinder volume",
}


class Point(NamedTuple):
    """One operating point of a plan."""

    run: int
    machine: Machine
    speed: float
    """[rad/s]"""


class SweepResult(NamedTuple):
    """What a sweep leaves."""

    path: Path
    archive: Archive
    faults: list
    """One line for each point that failed or did not converge."""
    seconds: float
    """Computing time, warm."""


def plan(machine, speeds, intakes):
    """Operating points: every intake at every speed.

    Parameters
    ----------
    machine : Machine
    speeds : sequence of float
        [rad/s]
    intakes : sequence of int
        Codes of `engine.cylinder.INTAKES`.

    Returns
    -------
    list of Point
    """
    cases = [(intake, speed) for intake in intakes for speed in speeds]
    return [
        Point(run, machine._replace(engine=machine.engine._replace(intake=intake)), speed)
        for run, (intake, speed) in enumerate(cases)
    ]


def compute(points):
    """Run operating points.

    Parameters
    ----------
    points : sequence of Point

    Returns
    -------
    list of tuple
        For each point its scalars by name and its trace, (n, 11).
    """
    results = []
    for point in points:
        run = run_steady(point.machine, point.speed, angle_step=ANGLE_STEP)
        scalars = dict.fromkeys(INDICATORS, np.nan) | {"speed_rpm": float(f"{point.speed / TURN * 60.0:.12g}")}
        trace = np.full_like(run.trace, np.nan)
        if run.status == Status.DONE:
            scalars, trace = indicators(point.machine, run), run.trace
        results.append((scalars | {"status": run.status}, trace))
    return results


def archive_of(points, results, machine, provenance):
    """Results of some operating points as an archive.

    Parameters
    ----------
    points : sequence of Point
    results : list of tuple
        See `compute`.
    machine : str
        TOML text.
    provenance : dict of str

    Returns
    -------
    Archive
    """
    scalars = [scalars for scalars, _ in results]
    traces = np.stack([trace for _, trace in results])
    start = points[0].machine.command.energise / DEGREE
    angles = start + ANGLE_STEP / DEGREE * np.arange(traces.shape[1])
    variables = {
        "run": Variable(("run",), np.array([point.run for point in points], dtype=np.int64), "1", "number of the run"),
        "crank_angle": Variable(("crank_angle",), angles, "deg", "crank angle after TDC"),
        "intake": Variable(
            ("run",),
            np.array([point.machine.engine.intake for point in points], dtype=np.int8),
            "1",
            "what opens the intake",
            ", ".join(f"{code} {name}" for code, name in enumerate(INTAKES)),
        ),
        "status": Variable(
            ("run",),
            np.array([values["status"] for values in scalars], dtype=np.int8),
            "1",
            "how the march ended",
            STATUS_MEANINGS,
        ),
    }
    for name, (unit, description) in INDICATORS.items():
        column = np.array([values[name] for values in scalars], dtype=float)
        meanings = ""
        if name in FLAGS:
            column, meanings = np.nan_to_num(column).astype(np.int8), "0 no, 1 yes"
        elif name in COUNTS:
            column = np.nan_to_num(column).astype(np.int64)
        variables[name] = Variable(("run",), column, unit, description, meanings)
    for number, header in enumerate(TRACE):
        name, unit = split_header(header)
        values = np.ascontiguousarray(traces[:, :, number])
        variables[name] = Variable(("run", "crank_angle"), values, unit, TRACE_DESCRIPTIONS[name])
    return Archive(machine, provenance, variables)


def run_sweep(
    machine,
    speeds,
    intakes,
    out,
    *,
    jobs=None,
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
    speeds : sequence of float
        [rad/s]
    intakes : sequence of int
    out : path
        The archive.
    jobs : int, optional
        Processes; as many as the work is worth if left out.
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
        Calls a function with its arguments; it is given the first point, for which the model may have to be compiled.

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
    points = plan(machine, speeds, intakes)
    settings = {"kind": "engine sweep", "speeds": [float(s) for s in speeds], "intakes": [int(i) for i in intakes]}
    provenance = {
        "command": command,
        "plan_hash": plan_hash(text, settings | {"kernels": sources_hash()}),
        "kernels": sources_hash(),
        "runs_planned": str(len(points)),
    }
    refuse_folder(out)
    if shard:
        points = points[shard[0] - 1 :: shard[1]]
        if not points:
            raise ArchiveError(out, "its share of the work is empty", f"give --shard i/N with N at most {len(speeds)}")
    with lock(out):
        _clear(out, resume, overwrite)
        warm_up(compute, points[:1])  # one process compiles; and the time of the others is that of computing
        start = time.perf_counter()
        faults = _complete(out, points, text, provenance, jobs, report or (lambda done, total: None))
        parts = read_shards(shards_folder(out), provenance["plan_hash"]).parts
        if not parts:
            raise ArchiveError(out, "no point could be computed, every worker process died", "try --jobs 1")
        archive = merge(parts)
        write(archive, out)
        remove_shards(shards_folder(out))
    return SweepResult(out, archive, faults + faults_of(archive), time.perf_counter() - start)


def _complete(out, points, machine, provenance, jobs, report):
    """Compute the points that no shard holds, and write them as shards; one line for each that could not be."""
    shards = read_shards(shards_folder(out), provenance["plan_hash"])
    to_do = [point for point in points if point.run not in set(shards.done)]
    faults = []
    finished = len(points) - len(to_do)
    chunks = [to_do[i : i + CHUNK] for i in range(0, len(to_do), CHUNK)]
    report(finished, len(points))
    for chunk, results in run_tasks(compute, chunks, workers_for(SECONDS_A_POINT * len(to_do), jobs)):
        if results is None:
            faults += [f"run {point.run}: its worker died" for point in chunk]
            continue
        write_shard(shards_folder(out), archive_of(chunk, results, machine, provenance))
        finished += len(chunk)
        report(finished, len(points))
    return faults


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


def faults_of(archive):
    """One line for each point that failed or did not reach a periodic state.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    list of str
    """
    v = {
        name: archive.variables[name].values for name in ("run", "intake", "speed_rpm", "status", "converged", "cycles")
    }
    lines = []
    for run, intake, speed, status, converged, cycles in zip(*v.values(), strict=True):
        name = f"run {run} ({INTAKES[intake]} at {speed:g} r/min)"
        if status != Status.DONE:
            lines.append(f"{name}: failed: {Status(status).remedy}")
        elif not converged:
            lines.append(f"{name}: not periodic after {cycles} cycles; its state still changes")
    return lines
