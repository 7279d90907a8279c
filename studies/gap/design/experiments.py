"""Experiments that could be made next on the same bench: other runs, and sensors that are not there yet."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise, product
from math import isnan
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.machine import Machine
from apesim.studies.estimation.engine_starts import Starts
from apesim.studies.estimation.noise.process import white
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.estimation.priors import nuisance, priors_of
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.decide.operating_points import label_point
from apesim.studies.measured import CYLINDER, ENGINE, VALVE, Measured, MeasuredRun
from apesim.studies.measured.prediction import MEANS

GAUGE_PRESSURES = np.array([0.1, 0.2, 0.4, 0.6, 0.8, 1.0]) * 1e6
"""Supply pressures above ambient, beside those between the runs that there are [Pa]."""
PULSES = 0.012, 0.05
"""Pulses of a valve: one too short for a stroke to rest, and one that is long enough [s]."""
RECORD_AFTER = 0.05
"""Time that is recorded after the release: a stroke and its rebounds are over by then [s]."""
SPEEDS = np.array([500.0, 1000.0, 1500.0]) * TURN / 60.0
"""Speeds of an engine, beside those between the runs that there are [rad/s]."""
NEAR_PRESSURE, NEAR_SPEED = 0.05e6, 0.1
"""Difference of two supplies [Pa], and share of a speed, by which two runs are set alike."""
TIMES_FASTER = 0.2, 1.0, 5.0
"""Factors on the speed with which a drive moves a cylinder: fivefold either way shows what depends on it."""
ANGLES = np.arange(0.0, TURN, TURN / 180.0)
"""Crank angles of the samples of an engine that has recorded none [rad]."""
NEW_SENSORS = {
    VALVE: (("lift",), ("pressure_a",), ("pressure_b",), ("pressure_a", "pressure_b")),
    ENGINE: (("cylinder_pressure",), ("lift",), ("pressure_a", "pressure_b"), ("torque",), ("air_flow",)),
    CYLINDER: (),
}
"""Sensors that may be added together, by bench."""
USUAL_NOISE = {
    "lift": 0.03e-3,
    "pressure_a": 2e3,
    "pressure_b": 2e3,
    "cylinder_pressure": 5e3,
    "torque": 0.3,
    "air_flow": 0.3e-3,
}
"""Standard deviation of the noise that a sensor usually has [SI]."""
INTERVAL = 0.2e-3
"""Interval between two samples on a bench that has recorded none [s]."""


class Experiment(NamedTuple):
    """A run to be made."""

    text: str
    """The run in words."""
    run: MeasuredRun
    """The run, its measured values zero."""
    added: tuple[str, ...]
    """Sensors that are not there yet."""
    is_within: bool = True
    """Whether pressure and speed lie between those of the runs that there are: nothing tells that a rig stands more."""


def list_experiments(measured: Measured, ambient_pressure: float) -> list[Experiment]:
    """List the experiments: other operating points with the sensors that are there, and runs again with new sensors.

    Points beyond what was run say so in their text. `ambient_pressure` in [Pa abs].
    """
    runs = measured.runs
    sensors = list(dict.fromkeys(sensor for run in runs for sensor in (*run.channels, *run.means)))
    experiments = []
    for run in _list_runs(measured, ambient_pressure):
        if not any(_is_alike(run, other) for other in runs):
            is_within = _is_within(run, runs)
            text = f"a run at {label_point(run, ambient_pressure)}" + ("" if is_within else ", beyond what was run")
            experiments.append(Experiment(text, _add_sensors(run, sensors), (), is_within))
    again = max(runs, key=lambda run: run.supply)
    for added in NEW_SENSORS[measured.bench]:
        if not set(added) & set(sensors):
            names = " and ".join(sensor.replace("_", " ") for sensor in added)
            text = f"the run at {label_point(again, ambient_pressure)} again, with {names} measured"
            experiments.append(Experiment(text, _add_sensors(again, [*sensors, *added]), added))
    return experiments


def _list_runs(measured: Measured, ambient_pressure: float) -> Iterator[MeasuredRun]:
    """A run of the data at each operating point of the list."""
    pattern, runs = measured.runs[0], measured.runs
    supplies = _fill(ambient_pressure + GAUGE_PRESSURES, (run.supply for run in runs))
    if measured.bench == ENGINE:
        ends = {min(run.supply for run in runs), max(run.supply for run in runs)}
        for speed, supply in product(_fill(SPEEDS, (run.speed for run in runs)), sorted(ends)):
            yield pattern._replace(speed=speed, supply=supply)
        return
    if measured.bench == CYLINDER:
        for supply, faster in product(supplies, TIMES_FASTER):
            yield _move_cylinder(pattern, supply, faster)
        return
    interval = min((float(np.median(np.diff(run.times))) for run in runs), default=INTERVAL)
    for supply, pulse in product(supplies, PULSES):
        times = np.arange(0.0, pulse + RECORD_AFTER, interval)
        yield pattern._replace(supply=supply, pulse=pulse, times=times)


def _fill(usual: np.ndarray, there: Iterable[float]) -> list[float]:
    """Usual values, and the middles between those that are there, in ascending order."""
    middles = [0.5 * (low + high) for low, high in pairwise(sorted(set(there)))]
    return sorted({*map(float, usual), *middles})


def _is_within(run: MeasuredRun, runs: Sequence[MeasuredRun]) -> bool:
    """Whether pressure and speed of a run lie between those of others, as far as they can be set."""
    supplies, speeds = [each.supply for each in runs], [_find_speed(each) for each in runs]
    is_pressure = min(supplies) - NEAR_PRESSURE < run.supply < max(supplies) + NEAR_PRESSURE
    return is_pressure and (1.0 - NEAR_SPEED) * min(speeds) < _find_speed(run) < (1.0 + NEAR_SPEED) * max(speeds)


def _find_speed(run: MeasuredRun) -> float:
    """Speed of an engine [rad/s] or of a driven cylinder [m/s]; of a valve, which has none, 1."""
    if run.bench == CYLINDER:
        return float(np.median(np.abs(run.given["velocity"])))
    return run.speed if run.bench == ENGINE else 1.0


def _move_cylinder(pattern: MeasuredRun, supply: float, faster: float) -> MeasuredRun:
    """The way of a cylinder at another constant pressure [Pa abs], so many times as fast."""
    given = pattern.given | {
        "pressure": np.full(len(pattern.times), supply),
        "velocity": faster * pattern.given["velocity"],
    }
    return pattern._replace(supply=supply, times=pattern.times / faster, given=given)


def _is_alike(run: MeasuredRun, other: MeasuredRun) -> bool:
    """Whether two runs are of one operating point, as far as it can be set."""
    near = abs(run.supply - other.supply) < NEAR_PRESSURE
    if run.bench == ENGINE and not (isnan(run.control_supply) and isnan(other.control_supply)):
        near &= abs(run.control_supply - other.control_supply) < NEAR_PRESSURE
    if run.bench == ENGINE:
        return near and abs(run.speed / other.speed - 1.0) < NEAR_SPEED
    if run.bench == CYLINDER:
        return near and 0.5 < _find_speed(run) / _find_speed(other) < 2.0
    return near and 0.5 < run.pulse / other.pulse < 2.0


def _add_sensors(run: MeasuredRun, sensors: Iterable[str]) -> MeasuredRun:
    """A run with these sensors, its values zero; it has no file, so that no fault of a file is in it."""
    sensors = list(sensors)
    traces = [sensor for sensor in sensors if sensor not in MEANS]
    if run.bench == ENGINE and traces and not len(run.angles):
        run = run._replace(angles=ANGLES)
    if run.bench == ENGINE:
        run = run._replace(times=(run.angles - run.energise) / run.speed)
    return run._replace(
        name="next test",
        data="",
        channels={sensor: np.zeros(len(run.times)) for sensor in traces},
        means={sensor: 0.0 for sensor in sensors if sensor not in traces},
    )


def describe_run(experiment: Experiment) -> dict[str, Any]:
    """Describe how an experiment is to be run, in words (``text``) and in SI units.

    ``supply_Pa_abs``, ``temperature_K``, ``pulse_s`` and ``speed_rad_s`` are NaN where they do not apply,
    ``interval_s`` between two samples and ``recorded_s``, the last sample after the command, where no trace is
    recorded. ``sensors`` are all that are to be read, ``added_sensors`` those of them that are not there yet.
    """
    run, times = experiment.run, experiment.run.times
    return {
        "text": experiment.text,
        "supply_Pa_abs": run.supply,
        "temperature_K": run.temperature,
        "pulse_s": run.pulse,
        "speed_rad_s": run.speed,
        "interval_s": float(np.round(np.median(np.diff(times)), 9)) if len(times) > 1 else np.nan,
        "recorded_s": float(times[-1]) if len(times) else np.nan,
        "sensors": [*run.channels, *run.means],
        "added_sensors": list(experiment.added),
    }


def make_residuals(
    experiment: Experiment,
    machine: Machine,
    parameters: Sequence[Parameter],
    noise: dict[str, Any],
    starts: Starts | None = None,
) -> WhitenedResiduals:
    """Make the residuals of an experiment, with the nuisances of its new sensors behind the parameters.

    `noise` is that of the sensors that there are; a new sensor has its usual one. Without `starts` those of the machine
    as it is are taken.
    """
    alone = Measured("", {}, (experiment.run,), experiment.run.bench)
    known = {parameter.key for parameter in parameters}
    new = [
        nuisance(machine, prior)
        for prior in priors_of(machine, alone)
        if prior.deviation and prior.sensor in experiment.added and prior.key not in known
    ]
    usual = {sensor: {0.0: white(USUAL_NOISE[sensor], "usual")} for sensor in experiment.added}
    return WhitenedResiduals(machine, [experiment.run], [*parameters, *new], noise | usual, starts=starts)
