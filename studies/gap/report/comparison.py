"""Every measured signal beside the calibrated machine, and the machine with what explains it best."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from apesim.quantities import unit
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.process import noise_for
from apesim.studies.estimation.residuals import Block, WhitenedResiduals
from apesim.studies.measured import CHECK, FIT, GATE, MeasuredRun, Role
from apesim.studies.measured.sensors import SENSORS

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation


class ComparedSignal(NamedTuple):
    """One signal of one run, measured and simulated."""

    block: Block
    """The signal as it was measured."""
    noise: float
    """Standard deviation [SI]."""
    before: np.ndarray
    """Values that the calibrated machine gives, (n,) [SI]."""
    after: np.ndarray | None
    """Values that the machine with what was added gives, (n,) [SI]; None: nothing was added."""
    residuals_before: np.ndarray
    """Whitened residuals of the calibrated machine, (n,) [standard deviations]."""
    residuals_after: np.ndarray | None
    """Whitened residuals of the machine with what was added, (n,) [standard deviations]; None: nothing was added."""
    marks: dict[str, float]
    """Instants that divide the run, see `apesim.studies.measured.prediction.Prediction`."""

    @property
    def role(self) -> Role:
        """Role of the run."""
        return self.block.run.role

    @property
    def is_mean(self) -> bool:
        """Whether it is a mean over the cycle, no trace."""
        return len(self.block.values) == 1


def compare_signals(explanation: "Explanation") -> list[ComparedSignal]:
    """Compare all signals of all runs with the models, those that were never fitted, too.

    Runs to check come first, then the gates, then the fitted ones.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> [(str(signal.role), signal.block.sensor) for signal in compare_signals(explain_example())]
    [('check', 'lift'), ('gate', 'lift'), ('fit', 'lift'), ('fit', 'lift')]
    """
    measured = explanation.measured
    runs = [run for role in (CHECK, GATE, FIT) for run in measured.of(role)]
    residuals, before, residuals_before = _simulate(explanation.calibrated, runs, explanation.noise)
    after: Sequence[np.ndarray | None] = [None] * len(before)
    residuals_after = after
    if explanation.best is not explanation.calibrated:
        _, after, residuals_after = _simulate(explanation.best, runs, explanation.noise)
    marks = residuals.marks(explanation.calibrated.fitted.x)
    rows = zip(residuals.blocks, before, after, residuals_before, residuals_after, strict=True)
    return [
        ComparedSignal(
            block,
            noise=noise_for(explanation.noise, block).deviation,
            before=values_before,
            after=values_after,
            residuals_before=white_before,
            residuals_after=white_after,
            marks=marks[block.number],
        )
        for block, values_before, values_after, white_before, white_after in rows
    ]


def _simulate(
    model: Model, runs: list[MeasuredRun], noise: dict[str, Any]
) -> tuple[WhitenedResiduals, list[np.ndarray], list[np.ndarray]]:
    """Residuals of runs as a function of parameters, with their values at the fit and those made white."""
    own = model.residuals
    residuals = WhitenedResiduals(own.machine, runs, own.parameters, noise, scatter=own.scatter)
    errors = residuals.at(model.fitted.x)[: -len(own.parameters)]
    return residuals, residuals.predicted(model.fitted.x), residuals.by_block(errors)


def find_rms(arrays: Iterable[np.ndarray]) -> float:
    """Root mean square of all numbers of several arrays (n,)."""
    joined = np.concatenate(list(arrays))
    return float(np.sqrt(np.mean(joined**2)))


class Display(NamedTuple):
    """How values of a sensor are shown."""

    name: str
    """Name of the sensor in words."""
    unit: str
    """Unit in which values are shown."""
    factor: float
    """SI values over shown ones."""

    def convert(self, values: Any) -> Any:
        """Values, one or (n,), in SI units converted to the unit in which they are shown."""
        return values / self.factor


def find_display(block: Block) -> Display:
    """How a block's sensor is shown: in the unit in which its noise is stated."""
    sensors = SENSORS[block.run.bench]
    quantity = (sensors.traces | sensors.means)[block.sensor]
    return Display(block.sensor.replace("_", " "), quantity.unit, unit(quantity.unit).si("1"))


def group_by_run(compared: Iterable[ComparedSignal]) -> list[list[ComparedSignal]]:
    """The signals of each run together, in their order."""
    by_run: dict[int, list[ComparedSignal]] = {}
    for signal in compared:
        by_run.setdefault(signal.block.number, []).append(signal)
    return list(by_run.values())


def select_worst(compared: Iterable[ComparedSignal], count: int) -> list[ComparedSignal]:
    """The traces that the calibrated machine misses by most, of runs that were never fitted where there are such.

    There are at most `count`; a signal comes once, as long as there are others.
    """

    def rms(signal: ComparedSignal) -> float:
        return find_rms([signal.residuals_before])

    traces = sorted((signal for signal in compared if not signal.is_mean), key=rms, reverse=True)
    by_role = [signal for role in (CHECK, GATE, FIT) for signal in traces if signal.role == role]
    of_sensor: dict[str, ComparedSignal] = {}
    for signal in by_role:
        of_sensor.setdefault(signal.block.sensor, signal)
    chosen = sorted(of_sensor.values(), key=rms, reverse=True)
    return (chosen + [signal for signal in by_role if not any(signal is other for other in chosen)])[:count]
