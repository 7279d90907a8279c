"""The points of a sweep, computed until none is missing.

Shards are for a sweep that goes on later; this one holds its results in memory, too, whatever becomes of its shards. A
point that died with its worker is computed again, and named if it dies once more.
"""

import contextlib
import functools
from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from apesim.archive import Archive, ArchiveError
from apesim.archive.completeness import gaps_in_words
from apesim.archive.shards import read_shards, write_shard
from apesim.studies.execution.resuming import keep
from apesim.studies.sweep.plan import CORRECTED, FIXED, Point

SECONDS_A_POINT = {FIXED: 0.03, CORRECTED: 0.12}
"""Estimated computing time of a point by its timing [s]."""
SHARD_SECONDS = 1.0
"""Estimated computing time of the points in a task, and in the first shard [s]."""
SHARE_IN_WORK = 0.5
"""Computing time of a shard over that of all before it: a killed sweep loses no larger share of what was done."""
LARGEST_SHARD = 20.0
"""Computing time of a shard over that of the first, at most.

A shard takes 0.05 to 0.1 s to write, however few points are in it.
"""
MAX_DEATHS = 8
"""Deaths of worker processes at which a sweep gives up, if it could not compute a single point yet.

So many deaths are not the fault of single points. The machine may lack memory, and every other point would die, too.
"""
REMEDY = "free memory or try --jobs 1, and go on with --resume"
"""What helps where worker processes died."""


class Completion(NamedTuple):
    """State of a sweep when it ends: its results, and what is missing."""

    parts: list[Archive]
    """All results, those of earlier shards among them."""
    fault: tuple[str, str] | None
    """Which points are missing and why, and what to do; None if none is missing."""
    damaged: list[str]
    """One line for each earlier shard that was found damaged; its points were computed again."""


def complete(
    folder: str | PathLike[str],
    points: Sequence[Point],
    plan_hash: str,
    *,
    run: Callable[[list[list[Point]]], Any],
    to_archive: Callable[[list[Point], Any], Archive],
    report: Callable[[int, int], Any],
) -> Completion:
    """Compute the points of a sweep that no shard holds, and write them as shards into `folder`.

    `run` takes lists of points and yields each list with its results, or with None where it killed its worker; such
    points are computed once more, each by itself (see `MAX_DEATHS`). `report` gets the numbers of points done and of
    all. Raises ArchiveError where a shard cannot be written, or the folder holds one of another sweep.
    """
    shards, runs = read_shards(folder, plan_hash), {point.run for point in points}
    done, tally = runs.intersection(shards.done), _Tally()
    in_work = _ShardInWork(
        to_archive, functools.partial(write_shard, folder), seconds_of(point for point in points if point.run in done)
    )
    report(len(done), len(points))
    while waiting := _without(points, done | tally.given_up):
        with contextlib.closing(run(_chunks(waiting, tally.died))) as results_of_chunks, in_work:
            for chunk, results in results_of_chunks:
                if results is None:
                    tally.count_death(chunk, waiting)
                    if tally.given_up.issuperset(point.run for point in waiting):
                        break
                    continue
                done.update(point.run for point in chunk)
                tally.has_results = True
                if in_work.add(chunk, results):
                    report(len(done), len(points))
        report(len(done), len(points))
    missing = _in_words(runs - done)
    fault = (f"runs {missing} are missing, their worker processes died", REMEDY) if missing else None
    return Completion(shards.parts + in_work.parts, fault, shards.damaged)


def seconds_of(points: Iterable[Point]) -> float:
    """Estimate the computing time [s] of some operating points in one process, as the sum of `SECONDS_A_POINT`."""
    return sum(SECONDS_A_POINT[point.timing] for point in points)


class _ShardInWork:
    """Results that wait until they are worth a shard; leaving the context writes those that still wait.

    `to_archive` and `save` make an archive and write it (see `complete`), `seconds` is the estimated computing time of
    the points written already [s], and `parts` has the archives that were written.
    """

    def __init__(
        self, to_archive: Callable[[list[Point], Any], Archive], save: Callable[[Archive], Path], seconds: float
    ) -> None:
        self.to_archive, self.save, self.seconds = to_archive, save, seconds
        self.parts: list[Archive] = []
        self.waiting: list[tuple[Point, Any]] = []

    def __enter__(self) -> "_ShardInWork":
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None or not issubclass(kind, ArchiveError):
            self.write()

    def add(self, points: Sequence[Point], results: Sequence[Any]) -> int:
        """Take the results of some points; returns how many were written because of them."""
        self.waiting += zip(points, results, strict=True)
        enough = SHARD_SECONDS * min(max(1.0, SHARE_IN_WORK * self.seconds), LARGEST_SHARD)
        return self.write() if seconds_of(point for point, _ in self.waiting) >= enough else 0

    def write(self) -> int:
        """Write what waits as a shard; returns the number of its points."""
        waiting, self.waiting = sorted(self.waiting, key=lambda one: one[0].run), []
        if waiting:
            points, results = (list(each) for each in zip(*waiting, strict=True))
            part = self.to_archive(points, results)
            keep(part, self.save)
            self.parts.append(part)
            self.seconds += seconds_of(points)
        return len(waiting)


class _Tally:
    """Run numbers of the points that died with their worker, and of those that were given up."""

    def __init__(self) -> None:
        self.died: set[int] = set()
        self.given_up: set[int] = set()
        self.deaths = 0
        self.has_results = False

    def count_death(self, chunk: Iterable[Point], waiting: Iterable[Point]) -> None:
        """Count the death of a chunk's worker.

        A point that dies for the second time is given up. After `MAX_DEATHS` deaths with nothing computed, all waiting
        points are.
        """
        runs = {point.run for point in chunk}
        self.given_up |= runs & self.died
        self.died |= runs
        self.deaths += 1
        if self.deaths == MAX_DEATHS and not self.has_results:
            self.given_up.update(point.run for point in waiting)


def _without(points: Sequence[Point], runs: set[int]) -> list[Point]:
    """Leave out the points of some run numbers."""
    return [point for point in points if point.run not in runs]


def _chunks(points: Sequence[Point], died: set[int]) -> list[list[Point]]:
    """Split points into chunks of about `SHARD_SECONDS`; each point that died before is alone, to take none with it."""
    chunks: list[list[Point]] = []
    for point in points:
        if point.run in died:
            continue
        if not chunks or seconds_of(chunks[-1]) >= SHARD_SECONDS:
            chunks.append([])
        chunks[-1].append(point)
    return chunks + [[point] for point in points if point.run in died]


def _in_words(runs: set[int]) -> str:
    """Write run numbers as ranges: "3, 5-7"."""
    ordered = sorted(runs)
    firsts = [run for run in ordered if run - 1 not in runs]
    lasts = [run for run in ordered if run + 1 not in runs]
    return gaps_in_words(list(zip(firsts, lasts, strict=True)))
