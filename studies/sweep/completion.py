"""The points of a sweep, computed until none is missing in its shards.

What was lost on the disk, or died with its worker, is computed again as long as that brings anything; what is still
missing then is named, with the reason.
"""

import contextlib
import functools
import math
from typing import NamedTuple

from apesim.archive import Archive, ArchiveError
from apesim.archive.shards import gaps_in_words, read_shards, write_shard
from apesim.studies.sweep.plan import CORRECTED, FIXED

SECONDS_A_POINT = {FIXED: 0.03, CORRECTED: 0.12}
SHARD_SECONDS = 1.0
"""Work of a shard."""
MAX_DEATHS = 8
"""Deaths of chunks before one is computed: then not single points are at fault, and others would go the same way."""
MAX_VAIN = 1
"""Passes in a row that bring nothing: what was lost once is computed again, what is lost twice would be again."""
DIED = "their worker processes died", "free memory or try --jobs 1, and go on with --resume"
LOST = "their shards were damaged or removed each time", "check the disk, and go on with --resume"


class Completion(NamedTuple):
    """What a sweep has come to."""

    parts: list[Archive]
    """All shards that can be read."""
    faults: list[tuple[str, str]]
    """Which points are missing and why, and what to do."""


def complete(folder, points, plan_hash, *, run, to_archive, report):
    """Compute the points that no shard holds.

    Parameters
    ----------
    folder : path
        Of the shards.
    points : sequence of apesim.studies.sweep.plan.Point
    plan_hash : str
    run : function
        Computes lists of points; yields each with its results, None where it killed its worker.
    to_archive : function
        Of a list of points and its results.
    report : function
        Called with the numbers of points done and in all.

    Returns
    -------
    Completion
    """
    tally, best, vain = _Tally(), (-math.inf, 0), 0
    while True:
        shards = read_shards(folder, plan_hash)
        done = set(shards.done)
        missing = [point for point in points if point.run not in done]
        waiting = [point for point in missing if point.run not in tally.given_up]
        progress = -len(waiting), len(tally.died)
        finished = len(points) - len(missing)
        report(finished, len(points))
        vain = 0 if progress > best else vain + 1
        if not waiting or vain > MAX_VAIN:
            return Completion(shards.parts, _faults({point.run for point in missing}, tally.computed))
        best = max(best, progress)
        with contextlib.closing(run(_chunks(waiting, tally.died))) as results_of_chunks:
            for chunk, results in results_of_chunks:
                if results is None:
                    tally.count_death(chunk, waiting)
                    if tally.given_up.issuperset(point.run for point in waiting):
                        break
                    continue
                keep(to_archive(chunk, results), functools.partial(write_shard, folder))
                tally.computed.update(point.run for point in chunk)
                finished += len(chunk)
                report(finished, len(points))


def keep(archive, save):
    """Save an archive, and say where that fails that the others are kept."""
    try:
        return save(archive)
    except ArchiveError as error:
        remedy = f"{error.remedy}; what is done is kept, go on with --resume"
        raise type(error)(error.path, error.what, remedy) from error


def seconds_of(points):
    """Estimated computing time of some points [s]."""
    return sum(SECONDS_A_POINT[point.timing] for point in points)


class _Tally:
    """What became of points, by their run numbers."""

    def __init__(self):
        self.computed, self.died, self.given_up = set(), set(), set()
        self.deaths = 0

    def count_death(self, chunk, waiting):
        """Count the death of a chunk's worker. What dies alone is given up; and all that waits, where nothing lives."""
        runs = {point.run for point in chunk}
        self.given_up |= runs & self.died
        self.died |= runs
        self.deaths += 1
        if self.deaths == MAX_DEATHS and not self.computed:
            self.given_up.update(point.run for point in waiting)


def _chunks(points, died):
    """Points in shares of about `SHARD_SECONDS`; those that died with their worker alone, to take none with them."""
    chunks = []
    for point in points:
        if point.run in died:
            continue
        if not chunks or seconds_of(chunks[-1]) >= SHARD_SECONDS:
            chunks.append([])
        chunks[-1].append(point)
    return chunks + [[point] for point in points if point.run in died]


def _faults(missing, computed):
    """What is missing and why, and what to do."""
    reasons = (missing - computed, DIED), (missing & computed, LOST)
    return [(f"runs {_in_words(runs)} are missing, {why}", remedy) for runs, (why, remedy) in reasons if runs]


def _in_words(runs):
    """Run numbers: "3, 5-7"."""
    ordered = sorted(runs)
    firsts = [run for run in ordered if run - 1 not in runs]
    lasts = [run for run in ordered if run + 1 not in runs]
    return gaps_in_words(list(zip(firsts, lasts, strict=True)))
