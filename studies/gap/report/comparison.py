"""Every measured signal beside the calibrated machine, and the machine with what explains it best."""

from typing import NamedTuple

import numpy as np

from apesim.quantities import unit
from apesim.studies.estimation.noise.process import noise_for
from apesim.studies.estimation.residuals import Block, WhitenedResiduals
from apesim.studies.measured import CHECK, FIT, GATE
from apesim.studies.measured.sensors import SENSORS


class Compared(NamedTuple):
    """One signal of one run, measured and simulated."""

    block: Block
    """The signal as it was measured."""
    noise: float
    """Standard deviation [SI]."""
    before: np.ndarray
    """What the calibrated machine gives [SI], shape (n,)."""
    after: np.ndarray | None
    """What the machine with what was added gives; None: nothing was."""
    left_before: np.ndarray
    """What the calibrated machine leaves, made white [standard deviations], shape (n,)."""
    left_after: np.ndarray | None
    marks: dict
    """Instants that divide the run, see `apesim.studies.measured.prediction.Prediction`."""

    @property
    def role(self):
        """Role of the run."""
        return self.block.run.role

    @property
    def is_mean(self):
        """Whether it is a mean over the cycle, no trace."""
        return len(self.block.values) == 1


def compare(explanation):
    """All signals of all runs; those that were never fitted too, which are simulated as they are.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    list of Compared
        Runs to check first, then the gates, then the fitted ones.
    """
    measured = explanation.measured
    runs = [run for role in (CHECK, GATE, FIT) for run in measured.of(role)]
    residuals, before, left_before = _simulated(explanation.calibrated, runs, explanation.noise)
    after = left_after = [None] * len(before)
    if explanation.best is not explanation.calibrated:
        _, after, left_after = _simulated(explanation.best, runs, explanation.noise)
    marks = residuals.marks(explanation.calibrated.fitted.x)
    return [
        Compared(block, noise_for(explanation.noise, block).deviation, *values, marks[block.number])
        for block, *values in zip(residuals.blocks, before, after, left_before, left_after, strict=True)
    ]


def _simulated(model, runs, noise):
    residuals = WhitenedResiduals(model.residuals.machine, runs, model.residuals.parameters, noise)
    values = residuals.predicted(model.fitted.x)
    left = [simulated - block.values for simulated, block in zip(values, residuals.blocks, strict=True)]
    return residuals, values, residuals.by_block(residuals.whiten(left)[:, 0])


def size_of(arrays):
    """Root mean square of all numbers of several arrays.

    Parameters
    ----------
    arrays : iterable of (n,) float array

    Returns
    -------
    float

    Examples
    --------
    >>> size_of([np.array([3.0]), np.array([4.0, 0.0, 0.0])])
    2.5
    """
    joined = np.concatenate(list(arrays))
    return float(np.sqrt(np.mean(joined**2)))


class Shown(NamedTuple):
    """How values of a sensor are shown."""

    name: str
    unit: str
    factor: float
    """SI values over shown ones."""

    def of(self, values):
        """Shown values of SI ones."""
        return values / self.factor


def shown_of(block):
    """How a block's sensor is shown: in the unit in which its noise is stated.

    Parameters
    ----------
    block : apesim.studies.estimation.residuals.Block
    """
    sensors = SENSORS[block.run.bench]
    quantity = (sensors.traces | sensors.means)[block.sensor]
    return Shown(block.sensor.replace("_", " "), quantity.unit, unit(quantity.unit).si("1"))


def by_run(compared):
    """The signals of each run together, in their order.

    Returns
    -------
    list of list of Compared
    """
    found: dict = {}
    for one in compared:
        found.setdefault(one.block.number, []).append(one)
    return list(found.values())


def worst(compared, count):
    """The traces that the calibrated machine misses by most, of runs that were never fitted where there are such.

    A signal comes once, as long as there are others.
    """
    traces = sorted((one for one in compared if not one.is_mean), key=lambda one: -size_of([one.left_before]))
    unseen = [one for role in (CHECK, GATE, FIT) for one in traces if one.role == role]
    first: dict = {}
    for one in unseen:
        first.setdefault(one.block.sensor, one)
    chosen = sorted(first.values(), key=lambda one: -size_of([one.left_before]))
    return (chosen + [one for one in unseen if not any(one is other for other in chosen)])[:count]
