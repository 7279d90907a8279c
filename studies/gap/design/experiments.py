"""Experiments that could be made next on the same bench: other runs, and sensors that are not there yet."""

from itertools import product
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import TURN
from apesim.studies.estimation.noise.process import white
from apesim.studies.estimation.priors import nuisances_of
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.decide.operating_points import label_of
from apesim.studies.measured import ENGINE, VALVE, Measured
from apesim.studies.measured.prediction import MEANS

GAUGE = np.array([0.1, 0.2, 0.4, 0.6, 0.8, 1.0]) * 1e6
"""Supply pressures above ambient [Pa]."""
PULSES = 0.012, 0.05
"""Too short for a stroke to rest, and long enough [s]."""
AFTER = 0.05
"""Recorded after the release [s]."""
SPEEDS = np.array([500.0, 1000.0, 1500.0]) * TURN / 60.0
"""[rad/s]"""
ANGLES = np.arange(0.0, TURN, TURN / 180.0)
NEW = {
    VALVE: (("lift",), ("pressure_a",), ("pressure_b",), ("pressure_a", "pressure_b")),
    ENGINE: (("cylinder_pressure",), ("lift",), ("pressure_a", "pressure_b"), ("torque",), ("air_flow",)),
}
"""Sensors that may be added together, by bench."""
USUAL = {
    "lift": 0.03e-3,
    "pressure_a": 2e3,
    "pressure_b": 2e3,
    "cylinder_pressure": 5e3,
    "torque": 0.3,
    "air_flow": 0.3e-3,
}
"""Noise that such a sensor usually has [SI]."""
INTERVAL = 0.2e-3
"""Between two samples on a bench that has recorded none [s]."""


class Experiment(NamedTuple):
    """A run to be made."""

    text: str
    run: object
    """`apesim.studies.measured.MeasuredRun`, its values zero."""
    added: tuple
    """Sensors that are not there yet."""


def experiments_of(measured, ambient_pressure):
    """The experiments: each operating point of a list with the sensors that are there, and runs again with new ones.

    Parameters
    ----------
    measured : apesim.studies.measured.Measured
    ambient_pressure : float
        [Pa]

    Returns
    -------
    list of Experiment
    """
    runs = measured.runs
    there = list(dict.fromkeys(sensor for run in runs for sensor in (*run.channels, *run.means)))
    found = []
    for run in _points(measured, ambient_pressure):
        if not any(_alike(run, other) for other in runs):
            found.append(Experiment(f"a run at {label_of(run, ambient_pressure)}", _with(run, there), ()))
    again = max(runs, key=lambda run: run.supply)
    for added in NEW[measured.bench]:
        if not set(added) & set(there):
            names = " and ".join(sensor.replace("_", " ") for sensor in added)
            text = f"the run at {label_of(again, ambient_pressure)} again, with {names} measured"
            found.append(Experiment(text, _with(again, [*there, *added]), added))
    return found


def _points(measured, ambient_pressure):
    """A run of the data at each operating point of the list."""
    own = measured.runs[0]
    if measured.bench == ENGINE:
        supplies = sorted({run.supply for run in measured.runs})
        for speed, supply in product(SPEEDS, {supplies[0], supplies[-1]}):
            yield own._replace(speed=float(speed), supply=supply)
        return
    interval = min((float(np.median(np.diff(run.times))) for run in measured.runs), default=INTERVAL)
    for gauge, pulse in product(GAUGE, PULSES):
        times = np.arange(0.0, pulse + AFTER, interval)
        yield own._replace(supply=ambient_pressure + gauge, pulse=pulse, times=times)


def _alike(run, other):
    """Whether two runs are of one operating point, as far as it can be set."""
    near = abs(run.supply - other.supply) < 0.05e6
    if run.bench == ENGINE:
        return near and abs(run.speed / other.speed - 1.0) < 0.1
    return near and 0.5 < run.pulse / other.pulse < 2.0


def _with(run, sensors):
    """A run with these sensors, its values zero."""
    traces = [sensor for sensor in sensors if sensor not in MEANS]
    if run.bench == ENGINE and traces and not len(run.angles):
        run = run._replace(angles=ANGLES)
    if run.bench == ENGINE:
        run = run._replace(times=(run.angles - run.energise) / run.speed)
    return run._replace(
        channels={sensor: np.zeros(len(run.times)) for sensor in traces},
        means={sensor: 0.0 for sensor in sensors if sensor not in traces},
    )


def residuals_of(experiment, machine, parameters, noise, starts=None):
    """An experiment as a residuals: the parameters, and behind them what is uncertain about its new sensors.

    Parameters
    ----------
    experiment : Experiment
    machine : apesim.engine.machine.Machine
    parameters : list of apesim.studies.estimation.parameters.Parameter
    noise : dict
        As it was found; a new sensor has its usual one.
    starts : apesim.studies.estimation.starts.Starts, optional
        Starts of the experiment; without them those of the machine as it is.

    Returns
    -------
    apesim.studies.estimation.residuals.WhitenedResiduals
    """
    alone = Measured("", {}, (experiment.run,), experiment.run.bench)
    known = {parameter.key for parameter in parameters}
    new = [parameter for parameter in nuisances_of(machine, alone) if parameter.key not in known]
    usual = {sensor: {0.0: white(USUAL[sensor], "usual")} for sensor in experiment.added}
    return WhitenedResiduals(machine, [experiment.run], [*parameters, *new], noise | usual, starts=starts)
