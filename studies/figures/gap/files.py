"""All figures of the missing-effect workflow as files."""

from collections.abc import Callable, Sequence
from functools import partial
from os import PathLike
from typing import TYPE_CHECKING

import matplotlib
from matplotlib.figure import Figure

from apesim.studies.figures.drawing.files import save, svg
from apesim.studies.figures.drawing.style import STYLE
from apesim.studies.figures.gap.candidates import plot_candidates
from apesim.studies.figures.gap.latent import plot_branches
from apesim.studies.figures.gap.overlays import plot_overlays
from apesim.studies.figures.gap.residual_map import plot_residual_map
from apesim.studies.figures.gap.sizes import plot_sizes
from apesim.studies.gap.report.comparison import select_worst
from apesim.studies.gap.report.residual_map import map_residuals

if TYPE_CHECKING:
    from apesim.studies.gap.report.comparison import ComparedSignal
    from apesim.studies.gap.report.html import TriedCandidate
    from apesim.studies.gap.tables.latent import Branch

MAX_OVERLAYS = 3
"""Traces that are drawn over the model at most: more would not be read."""


def draw_gap(
    compared: "Sequence[ComparedSignal]",
    rows: "Sequence[TriedCandidate]",
    added: str,
    ambient_pressure: float,
    folder: str | PathLike[str],
    latent: "Sequence[Branch]" = (),
) -> dict[str, str]:
    """Draw all figures of the workflow, and write them as PNG and PDF.

    Parameters
    ----------
    compared : sequence of apesim.studies.gap.report.comparison.ComparedSignal
        Signals beside the models.
    rows : sequence of apesim.studies.gap.report.html.TriedCandidate
        Candidates with what was expected of them and what came.
    added : str
        What was added to the model, in words.
    ambient_pressure : float
        [Pa abs]
    folder : path
        A folder that exists.
    latent : sequence of apesim.studies.gap.tables.latent.Branch
        What a table says, where one was added.

    Returns
    -------
    dict of str to str
        SVG of each figure by its name.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from apesim.studies.estimation.residuals import Block
    >>> from apesim.studies.gap.report.comparison import ComparedSignal
    >>> from apesim.studies.measured import MeasuredRun
    >>> times = np.zeros(1)
    >>> run = MeasuredRun("n1000", "", 1.1e6, 287.0, float("nan"), "check", times, {}, "engine", 100.0)
    >>> block = Block(0, run, "torque", times, np.array([30.0]), 0.0)
    >>> mean = ComparedSignal(block, 0.3, np.array([31.0]), None, np.array([3.0]), None, {})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     texts = draw_gap([mean], [], "nothing", 0.1e6, folder)
    >>> sorted(texts)
    ['gap', 'maps']
    """
    figures: dict[str, Callable[[], Figure]] = {
        "gap": partial(plot_sizes, compared, added, ambient_pressure),
        "maps": lambda: plot_residual_map(map_residuals(compared), added, ambient_pressure),
    }
    if latent:
        figures["latent"] = partial(plot_branches, latent)
    if rows:  # all of the library may be left out
        figures["candidates"] = partial(plot_candidates, rows)
    chosen = select_worst(compared, MAX_OVERLAYS)
    if chosen:  # an engine may have means alone
        figures["overlays"] = partial(plot_overlays, chosen, added, ambient_pressure)
    texts = {}
    with matplotlib.rc_context(STYLE):
        for name, make in figures.items():
            figure = make()
            texts[name] = svg(figure)
            save(figure, folder, name)
    return texts
