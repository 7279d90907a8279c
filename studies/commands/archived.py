"""What commands share that compute an archive and draw its figures."""

import sys
import time
from pathlib import Path

from apesim.archive import command_line, read_digest
from apesim.studies.commands.tables import warm_up
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.output import publish, refuse_folder, refuse_to_replace


def computed(console, what, first, compute, out, overwrite, draw):
    """Compute an archive, and leave it with its figures.

    Parameters
    ----------
    console : apesim.studies.console.Console
    what : str
        In a word, for the progress.
    first : tuple
        Function and arguments of one march, which compiles what all the others need.
    compute : function
        Of ``command=`` and ``report=``; returns the archive.
    out : path
    overwrite : bool
    draw : function
        Of the archive and a folder; returns the paths of the figures.

    Returns
    -------
    Archive, dict
        And what every such command tells as JSON.
    """
    (refuse_folder if overwrite else refuse_to_replace)(out)
    warm_up(console, *first)
    start = time.perf_counter()
    with console.progress(what) as report:
        archive = call_in_thread(compute, command=command_line(["apesim", *sys.argv[1:]]), report=report).result()
    wall = time.perf_counter() - start
    publish(archive, out, overwrite)
    drawn = draw(archive, out.with_suffix(".figures"))
    told = {"archive": str(out), "content_sha256": read_digest(out), "figures": [str(path) for path in drawn]}
    return archive, told | {"wall_time_s": wall}


def summary(told, count):
    """Lines of what was computed, in which time, where it lies, and by which digest it is known."""
    line = f"{told['archive']}: {count} in {told['wall_time_s']:.2f} s"
    if told["figures"]:
        line += f"; figures in {Path(told['figures'][0]).parent}/"
    return f"{line}\n{digest_line(told['content_sha256'])}"


def digest_line(digest):
    """A line of the root digest of an archive."""
    return f"SHA-256 of its content: {digest or 'none, format version 1 has no digests'}"
