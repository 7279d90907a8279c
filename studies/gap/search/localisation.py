"""Localisation of a gap: its energy by signal and phase."""

from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.residuals import Problem
from apesim.studies.gap.search.phases import PHASES, phases

WINDOW = 8
"""Samples over which noise is averaged, where the gap is seen only through it."""


class Cell(NamedTuple):
    """A signal in a phase."""

    signal: str
    phase: str | None
    """None: of a mean over the cycle."""
    share: float
    """Share of the gap's energy."""
    size: float
    """Root mean square of the gap there, over the noise."""


def localise(problem: Problem, marks: list[dict[str, Any]], gap: np.ndarray, *, holds_noise: bool) -> list[Cell]:
    """The cells of a gap, the largest first.

    Parameters
    ----------
    problem : apesim.studies.estimation.residuals.Problem
    marks : list of dict
        Of each run.
    gap : (n,) float array
        What is to be placed [standard deviations], as `Problem.errors` has it.
    holds_noise : bool
        Whether the gap holds the noise, too, whose energy is then taken off.

    Returns
    -------
    list of Cell
    """
    energy: dict[tuple[str, str | None], float] = {}
    count: dict[tuple[str, str | None], int] = {}
    for block, own in zip(problem.blocks, problem.parted(gap), strict=True):
        of = phases(block, marks[block.number])
        for phase in np.unique(of):
            inside = own[of == phase]
            cell = block.sensor, PHASES[phase] if phase >= 0 else None
            energy[cell] = energy.get(cell, 0.0) + _energy(inside, holds_noise)
            count[cell] = count.get(cell, 0) + len(inside)
    whole = sum(max(e, 0.0) for e in energy.values()) or 1.0
    cells = [Cell(*cell, max(e, 0.0) / whole, float(np.sqrt(max(e, 0.0) / count[cell]))) for cell, e in energy.items()]
    return sorted(cells, key=lambda cell: -cell.share)


def _energy(errors: np.ndarray, holds_noise: bool) -> float:
    if not holds_noise:
        return float(errors @ errors)
    parts = np.array_split(errors, max(1, len(errors) // WINDOW))
    return float(sum(part.sum() ** 2 / len(part) for part in parts) - len(parts))
