"""What commands share that compute an archive and draw its figures."""

import sys
import time
from pathlib import Path

from apesim.archive import command_line
from studies.aside import aside
from studies.commands.tables import warm_up
from studies.output import publish, refuse_to_replace


def computed(console, what, first, compute, out, overwrite, draw):
    """Compute an archive, and leave it with its figures.

    Parameters
    ----------
    console : studies.console.Console
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
    if not overwrite:
        refuse_to_replace(out)
    warm_up(console, *first)
    start = time.perf_counter()
    with console.progress(what) as report:
        archive = aside(compute, command=command_line(["apesim", *sys.argv[1:]]), report=report).result()
    wall = time.perf_counter() - start
    publish(archive, out, overwrite)
    drawn = draw(archive, out.with_suffix(".figures"))
    return archive, {"archive": str(out), "figures": [str(path) for path in drawn], "wall_time_s": wall}


def summary(told, count):
    """A line of what was computed, in which time, and where it lies."""
    line = f"{told['archive']}: {count} in {told['wall_time_s']:.2f} s"
    return f"{line}; figures in {Path(told['figures'][0]).parent}/" if told["figures"] else line
