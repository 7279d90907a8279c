"""Localisation of a gap: its energy by signal and phase."""

from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.search.phases import PHASES, Phase, find_phases

WINDOW_SAMPLES = 8
"""Samples over which noise is averaged, where the gap is seen only through it."""


class Cell(NamedTuple):
    """A signal in a phase."""

    signal: str
    """Name of the sensor."""
    phase: Phase | None
    """Phase of the stroke or cycle, see `apesim.studies.gap.search.phases.Phase`; None: a mean over the cycle."""
    share: float
    """Share of the gap's energy."""
    size: float
    """Root mean square of the gap there, over the noise."""


def localise(
    residuals: WhitenedResiduals, marks: list[dict[str, Any]], gap: np.ndarray, *, holds_noise: bool
) -> list[Cell]:
    """Localise a gap: its energy in each cell, which is a signal in a phase of the stroke or cycle.

    The energy of a cell is the sum of squares over its samples, and its size the root of that over their number. Where
    `holds_noise` says that the gap holds the noise, too, the energy is ``sum(sum(part)^2 / len(part) - 1)`` over parts
    of `WINDOW_SAMPLES` samples, which noise alone makes 0 on average. `gap` (n,) are whitened residuals in the order of
    `WhitenedResiduals.at` [standard deviations]; `marks` are the instants that divide each run. The cell of the largest
    share comes first.
    """
    energy: dict[tuple[str, Phase | None], float] = {}
    count: dict[tuple[str, Phase | None], int] = {}
    for block, values in zip(residuals.blocks, residuals.by_block(gap), strict=True):
        phase_of_sample = find_phases(block, marks[block.number])
        for phase in np.unique(phase_of_sample):
            inside = values[phase_of_sample == phase]
            cell = block.sensor, PHASES[phase] if phase >= 0 else None
            energy[cell] = energy.get(cell, 0.0) + _energy(inside, holds_noise)
            count[cell] = count.get(cell, 0) + len(inside)
    whole = sum(max(e, 0.0) for e in energy.values()) or 1.0
    cells = [Cell(*cell, max(e, 0.0) / whole, float(np.sqrt(max(e, 0.0) / count[cell]))) for cell, e in energy.items()]
    return sorted(cells, key=lambda cell: -cell.share)


def _energy(errors: np.ndarray, holds_noise: bool) -> float:
    """Energy of the gap in the samples of one block and phase."""
    if not holds_noise:
        return float(errors @ errors)
    parts = np.array_split(errors, max(1, len(errors) // WINDOW_SAMPLES))
    return float(sum(part.sum() ** 2 / len(part) for part in parts) - len(parts))
