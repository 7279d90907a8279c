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
        """Values of a channel at those samples of a run at which it is known.

        Parameters
        ----------
        channel : str
        run : apesim.studies.measured.MeasuredRun
        shift : float
            Time [s], or angle [rad], by which the machine is moved to later ones.

        Returns
        -------
        (n,) float array
            [SI], NaN where the run has the channel, and a sample of it is missing.

        Examples
        --------
        >>> run = MeasuredRun("a", "", 0.5e6, 287.0, 5e-3, "fit", np.array([0.0, 1.0]), {})
        >>> expected = Expected(np.arange(3.0), {"lift": np.arange(3.0)}, {}, False)
        >>> expected.at("lift", run, shift=-1.0).tolist()
        [1.0, 2.0]
        """
        if self.is_engine:
            values = np.interp((run.angles - shift) % TURN, self.places, self.channels[channel], period=TURN)
        else:
            values = np.interp(run.times - shift, self.places, self.channels[channel])
        return np.where(np.isnan(run.channels[channel]), np.nan, values) if channel in run.channels else values


def expect(machine: Machine, run: MeasuredRun) -> Expected | None:
    """Simulate a measured run, from its first sample to beyond its last.

    Parameters
    ----------
    machine : Machine
    run : apesim.studies.measured.MeasuredRun

    Returns
    -------
    Expected or None
        None: the machine could not be simulated.

    Examples
    --------
    >>> times = np.arange(0.0, 60e-3, 1e-3)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 30e-3, "fit", times, {"lift": 0.0 * times})
    >>> expected = expect(Machine(), run)
    >>> float(round(1e3 * expected.at("lift", run).max(), 2))
    9.0
    """
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
