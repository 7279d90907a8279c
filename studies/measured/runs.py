"""What a folder of measured data holds, once read."""

from math import nan
from typing import NamedTuple

import numpy as np

VALVE, ENGINE = BENCHES = ("valve", "engine")
FIT, GATE, CHECK = ROLES = ("fit", "gate", "check")
NO_ANGLES = np.empty(0)
NO_MEANS: dict = {}


class MeasuredRun(NamedTuple):
    """One run on a bench: of the valve, a pulse from rest; of the engine, its periodic state."""

    name: str
    """Repeats share it."""
    data: str
    """Name of the file; "": an engine's run of means alone."""
    supply: float
    """[Pa abs]"""
    temperature: float
    """Temperature of the supply [K]; NaN: the machine's."""
    pulse: float
    """Time for which the solenoids are energised [s]; NaN on an engine."""
    role: str
    times: np.ndarray
    """Since the solenoids were energised [s], shape (n,), ascending; on an engine its angles, less energise, over its
    speed, as a turn repeats for ever."""
    channels: dict
    """SI values, each of shape (n,), by the name of the sensor; the velocity is that of the lift, positive as the
    valve opens."""
    bench: str = VALVE
    """valve or engine"""
    speed: float = nan
    """Speed of the engine [rad/s]."""
    energise: float = nan
    """Crank angle [rad]."""
    release: float = nan
    angles: np.ndarray = NO_ANGLES
    """Crank angles of an engine's traces [rad], shape (n,), ascending: a turn, a part of one or several."""
    means: dict = NO_MEANS
    """Means of an engine, SI: ``torque``, brake [N m]; ``air_flow``, all air [kg/s]; those that are measured."""


class Measured(NamedTuple):
    """A folder of measured data."""

    folder: str
    noise: dict
    """Standard deviations that the user states, SI, by the name of the sensor."""
    runs: tuple
    bench: str = VALVE
    ambient_pressure: float = nan
    """What gauge pressures in it stood above when it was read [Pa]; NaN: it was not read."""

    def of(self, role):
        """The runs of a role."""
        return [run for run in self.runs if run.role == role]
