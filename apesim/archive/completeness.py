"""Which runs of a sweep an archive lacks.

The provenance of an archive says how many runs were planned ("runs_planned"), and which share of them it was to hold
("shard": "1/4" is every fourth from the first; a merge lists several), so that what it lacks can be told from it alone.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence

from apesim.archive.file import Archive

__all__ = ["gaps_in_words", "missing_runs", "runs_planned"]

MAX_GAPS_NAMED = 10
"""Most gaps that a message names: people still read a line of ten."""


def runs_planned(archive: Archive) -> int | None:
    """Return the number of runs of the whole sweep that an archive holds or is a share of; None where not known."""
    planned = archive.provenance.get("runs_planned", "")
    return int(planned) if planned.isdecimal() and len(planned) < 19 else None


def missing_runs(archive: Archive, total: int | None = None) -> list[tuple[int, int]]:
    """Find the runs that an archive lacks: first and last number of each gap, in increasing order.

    It should hold the runs 0...`total` - 1; if that is left out, the planned runs in its share of the sweep ("shard" of
    its provenance), without a plan all up to its highest run number in its share. A gap may span runs that are in
    another share.
    """
    shares = [(1, 1)] if total is not None else _shares(archive)
    total = runs_planned(archive) if total is None else total
    runs = archive.runs.tolist()
    end = (runs[-1] + 1 if runs else 0) if total is None else total
    edges = [-1, *(run for run in runs if run < end), end]
    gaps = [(a + 1, b - 1) for a, b in itertools.pairwise(edges) if b - a > 1]
    return [trimmed for gap in gaps if (trimmed := _trimmed(*gap, shares))]


def gaps_in_words(gaps: Sequence[Sequence[int]]) -> str:
    """Return gaps (first and last number) between runs in words; of many only the first `MAX_GAPS_NAMED`.

    >>> gaps_in_words([(3, 3), (5, 7)])
    '3, 5-7'
    """
    words = [f"{first}-{last}" if last > first else f"{first}" for first, last in gaps[:MAX_GAPS_NAMED]]
    if len(gaps) > MAX_GAPS_NAMED:
        words.append(f"{len(gaps) - MAX_GAPS_NAMED} more gaps")
    return ", ".join(words)


def _shares(archive: Archive) -> list[tuple[int, int]]:
    """Shares of a sweep that an archive was to hold, (i, N) for every N-th run from the i-th."""
    told = re.findall(r"(\d{1,18})/(\d{1,18})", archive.provenance.get("shard", ""))
    if not told:  # the provenance of format version 1 has the command only
        told = re.findall(r"--shard[ =](\d{1,18})/(\d{1,18})", archive.provenance.get("command", ""))
    return [(int(i), int(n)) for i, n in told if int(n)] or [(1, 1)]


def _trimmed(first: int, last: int, shares: Sequence[tuple[int, int]]) -> tuple[int, int] | None:
    """Narrow a gap until its first and its last run are in some share, (i, N); None if no run of the gap is in any."""
    ends = [(first + (i - 1 - first) % n, last - (last - i + 1) % n) for i, n in shares]
    ends = [(a, b) for a, b in ends if a <= b]
    return (min(a for a, _ in ends), max(b for _, b in ends)) if ends else None
