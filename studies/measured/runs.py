"""What a folder of measured data holds, once read."""

from collections.abc import Mapping
from enum import StrEnum
from math import nan
from typing import NamedTuple

import numpy as np

from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.measured.dialect import ReadTable


class Bench(StrEnum):
    """Bench that data come from."""

    VALVE = "valve"
    """The valve alone, opened by a pulse from rest."""
    ENGINE = "engine"
    """The engine in its periodic state."""
    CYLINDER = "cylinder"
    """A piston moved to and fro by a drive, one chamber pressurised."""


class Role(StrEnum):
    """What a run is there for."""

    FIT = "fit"
    """It is fitted."""
    GATE = "gate"
    """It is never fitted, and refuses a model that it contradicts."""
    CHECK = "check"
    """It is never fitted, and only reported."""


VALVE, ENGINE, CYLINDER = BENCHES = tuple(Bench)
FIT, GATE, CHECK = ROLES = tuple(Role)
NO_ANGLES = np.empty(0)
"""Crank angles of a run of the valve."""
NO_MEANS: dict[str, float] = {}
"""Means of a run of the valve."""
NO_GIVEN: dict[str, np.ndarray] = {}
"""What is given of a run of the valve or the engine besides its supply and commands."""
ALL_DEFAULT: dict[str, Uncertainty] = {}
"""What is known of the rig where nothing is stated."""
NONE_STATED: dict[str, Uncertainty] = {}
"""What scatters between runs where nothing is stated."""


class MeasuredRun(NamedTuple):
    """One run on a bench: a pulse of the valve from rest, a periodic state of the engine, or a cylinder to and fro."""

    name: str
    """Name of the run; repeats share it."""
    data: str
    """Name of the file; "": an engine's run of means alone."""
    supply: float
    """Pressure of the supply [Pa abs]."""
    temperature: float
    """Temperature of the supply [K]; NaN: the machine's."""
    pulse: float
    """Time for which the solenoids are energised [s]; NaN on an engine."""
    role: Role
    """What the run is there for."""
    times: np.ndarray
    """Times since the solenoids were energised [s], shape (n,), ascending; on an engine its angles, less energise, over
    its speed, as a turn repeats for ever."""
    channels: dict[str, np.ndarray]
    """Measured values, SI, each of shape (n,), by the name of the sensor, NaN where a cell of the file has no number;
    the velocity is that of the lift, positive as the valve opens."""
    bench: Bench = Bench.VALVE
    """Bench that it comes from."""
    speed: float = nan
    """Speed of the engine [rad/s]."""
    energise: float = nan
    """Crank angle at which the solenoids are energised [rad]."""
    release: float = nan
    """Crank angle at which they are released [rad]."""
    angles: np.ndarray = NO_ANGLES
    """Crank angles of an engine's traces [rad], shape (n,), ascending: a turn, a part of one or several."""
    means: dict[str, float] = NO_MEANS
    """Means of an engine, SI: ``torque``, brake [N m]; ``air_flow``, all air [kg/s]; those that are measured."""
    given: dict[str, np.ndarray] = NO_GIVEN
    """What the model of a cylinder is given, SI, each of shape (n,): ``stroke`` [m], ``pressure`` [Pa abs] and
    ``velocity`` of the stroke [m/s], see `apesim.studies.measured.strokes`."""
    control_supply: float = nan
    """Pressure of an engine's control air [Pa abs]; NaN: as the machine has it. On a valve's bench the supply is it."""

    def __repr__(self) -> str:
        sensors = ", ".join([*self.channels, *self.means]) or "nothing"
        return f"MeasuredRun {self.name}: {self.role}, {len(self.times)} samples of {sensors}"

    @property
    def file(self) -> str:
        """Name of the run that no other has: that of its file, or its own where it is of means alone."""
        return self.data or self.name


class Disturbance(StrEnum):
    """What a sensor or a recorder does wrong for a few samples."""

    SPIKES = "spikes"
    """Single samples far from those beside them."""
    STUCK = "stuck"
    """One value is repeated where noise would change it."""
    CLIPPED = "clipped"
    """The largest or smallest value is repeated where noise would change it."""
    IMPOSSIBLE = "impossible"
    """Values that no rig can have: codes of a recorder, what a loose contact shows."""
    REPEATED = "repeated"
    """Rows that repeat the last value of a slower sampler."""


class Masked(NamedTuple):
    """Samples of a channel that were measured, and are taken for missing."""

    run: int
    """Number of the run in the folder, from 0."""
    channel: str
    disturbance: Disturbance
    places: np.ndarray
    """Times [s], or crank angles [rad], (n,), ascending, as the file has them."""
    values: np.ndarray
    """Values that were measured [SI], (n,); NaN where the file says that they are over range."""
    share: float
    """Their share of the samples of the channel."""
    is_short: bool = True
    """Whether they are so few that nothing is lost with them; only what is over range may be more."""


class Measured(NamedTuple):
    """A folder of measured data."""

    folder: str
    """Path of the folder."""
    noise: dict[str, float]
    """Standard deviations that the user states, SI, by the name of the sensor."""
    runs: tuple[MeasuredRun, ...]
    bench: Bench = Bench.VALVE
    """Bench that it comes from."""
    ambient_pressure: float = nan
    """Pressure that gauge pressures in it stood above when it was read [Pa abs]; NaN: it was not read."""
    hints: tuple[str, ...] = ()
    """What was guessed of its files, or left out of them, in words."""
    known_to: dict[str, Uncertainty] = ALL_DEFAULT
    """Standard deviations within which numbers of machine and sensors are known, by the key of the machine file, where
    the user states them."""
    masked: tuple[Masked, ...] = ()
    """Samples that a disturbance of the recorder made: NaN in the channels, and used by nothing."""
    scatter: dict[str, Uncertainty] = NONE_STATED
    """Standard deviations between runs, by the key of the machine file, where the user states them."""
    read: Mapping[str, ReadTable] = {}
    """Table ``[read]`` by file that says all of how the file was read, what was guessed included; it prints as TOML,
    and reads the same numbers where it is put into ``measured.toml``."""
    discrepancy: Mapping[str, float] = {}
    """Standard deviations by which a model may be off, SI, by the name of the sensor, where the user states them."""

    def __repr__(self) -> str:
        roles = ", ".join(f"{len(runs)} {role}" for role in ROLES if (runs := self.of(role)))
        sensors = ", ".join(dict.fromkeys(sensor for run in self.runs for sensor in (*run.channels, *run.means)))
        return f"Measured: {self.bench}, {len(self.runs)} runs ({roles or 'none'}) of {sensors or 'nothing'}"

    def of(self, role: str) -> list[MeasuredRun]:
        """Take the runs of a role.

        Parameters
        ----------
        role : {"fit", "gate", "check"}
            Role of a run, as ``measured.toml`` says it.

        Returns
        -------
        list of MeasuredRun
            In the order of the file.

        Examples
        --------
        >>> first = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, FIT, np.empty(0), {})
        >>> measured = Measured("measured", {}, (first, first._replace(name="p049", role=CHECK)))
        >>> [run.name for run in measured.of(CHECK)]
        ['p049']
        """
        return [run for run in self.runs if run.role == role]
