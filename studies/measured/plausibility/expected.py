"""What the machine shows of a measured run, over the whole run and beyond its ends."""

from typing import NamedTuple

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility.thresholds import MAX_TRIED_SHIFT
from apesim.studies.measured.prediction import predict, run_of
from apesim.studies.measured.runs import ENGINE, MeasuredRun

POINTS = 1500
"""Instants of a run that the machine is asked for: a step of 0.1 ms for most."""


class Expected(NamedTuple):
    """What the machine shows of a run."""

    places: np.ndarray
    """Times since the command [s], on an engine angles of one turn [rad], (n,), ascending."""
    channels: dict[str, np.ndarray]
    """Values [SI], each (n,), by sensor."""
    means: dict[str, float]
    """Means [SI], by sensor."""
    is_engine: bool

    def at(self, channel: str, run: MeasuredRun, shift: float = 0.0) -> np.ndarray:
        """Values of a channel (n,) [SI] at those samples of a run at which it is known.

        `shift` is the time [s], or angle [rad], by which the machine is moved to later ones. NaN where the run has the
        channel, and a sample of it is missing.
        """
        if self.is_engine:
            values = np.interp((run.angles - shift) % TURN, self.places, self.channels[channel], period=TURN)
        else:
            values = np.interp(run.times - shift, self.places, self.channels[channel])
        return np.where(np.isnan(run.channels[channel]), np.nan, values) if channel in run.channels else values


NOTHING_SHOWN = Expected(np.empty(0), {}, {}, False)
"""What is known of the machine before it is simulated."""


def expect(machine: Machine, run: MeasuredRun) -> Expected | None:
    """Simulate a measured run, from its first sample to beyond its last; None: the machine could not be simulated."""
    if run.bench == ENGINE:
        places = np.arange(POINTS) * (TURN / POINTS)
        asked = run._replace(times=(places - run.energise) / run.speed, angles=places)
    else:
        places = np.linspace(min(run.times[0], 0.0), max(run.times[-1], run.pulse) + 2 * MAX_TRIED_SHIFT, POINTS)
        asked = run._replace(times=places)
    shown = predict(run_of(machine, run), asked)
    if shown.failed or not all(np.isfinite(values).all() for values in shown.channels.values()):
        return None
    return Expected(places, shown.channels, shown.means, run.bench == ENGINE)
