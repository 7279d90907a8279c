"""All figures of the missing-effect workflow as files."""

from collections.abc import Callable, Sequence
from functools import partial
from os import PathLike
from typing import TYPE_CHECKING

import matplotlib
from matplotlib.figure import Figure

from apesim.studies.drawing.files import save, svg
from apesim.studies.drawing.style import STYLE
from apesim.studies.gap.figures.candidates import plot_candidates
from apesim.studies.gap.figures.curve import plot_curves
from apesim.studies.gap.figures.latent import plot_branches
from apesim.studies.gap.figures.overlays import plot_overlays
from apesim.studies.gap.figures.residual_map import plot_residual_map
from apesim.studies.gap.figures.sizes import plot_sizes
from apesim.studies.gap.report.comparison import select_worst
from apesim.studies.gap.report.residual_map import map_residuals

if TYPE_CHECKING:
    from apesim.studies.gap.report.comparison import ComparedSignal
    from apesim.studies.gap.report.engine_curve import EngineCurve
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
    curves: "Sequence[EngineCurve]" = (),
) -> dict[str, str]:
    """Draw all figures of the workflow, write them as PNG and PDF, and give the SVG of each by its name.

    `compared` are signals beside the models, `rows` candidates with what was expected of them and what came, `added`
    says in words what was added to the model, `latent` is what a table says, where one was added, and `curves` are
    means over the speed, where there is nothing else; `ambient_pressure` is in [Pa abs], and `folder` exists.
    """
    figures: dict[str, Callable[[], Figure]] = {"gap": partial(plot_sizes, compared, added, ambient_pressure)}
    if curves:  # means have no phases to be mapped over
        figures["curve"] = partial(plot_curves, curves, added)
    else:
        figures["maps"] = lambda: plot_residual_map(map_residuals(compared), added, ambient_pressure)
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
