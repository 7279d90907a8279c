"""Means of an engine over its speed, measured and simulated: the curve of a dynamometer."""

from collections.abc import Iterator, Sequence
from math import isclose, radians
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE
from apesim.studies.estimation.noise.discrepancy import state_discrepancy
from apesim.studies.estimation.noise.process import noise_for
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals, unless_ended
from apesim.studies.gap.report.comparison import ComparedSignal
from apesim.studies.measured import ENGINE, Measured, MeasuredRun
from apesim.studies.measured.runs import NO_ANGLES

if TYPE_CHECKING:
    from apesim.studies.estimation.model import Model
    from apesim.studies.gap.explanation import Explanation

MIN_SPEEDS = 3
"""Speeds from which on means are shown as a curve: two tell no form."""
POINTS = 25
"""Speeds at which the models are simulated between the slowest and the fastest run, besides those that were measured:
enough that their polygon looks smooth."""
MAX_SHARE_APART = 0.05
"""Share of the gauge pressure within which runs are of one curve: the supply of a bench sags as the engine draws
more."""
STATED = "supply", "temperature", "energise", "release", "control_supply"
"""What a run states besides its speed, as its attributes are named."""
SAME_SPEED = 0.01
"""Share within which two speeds are one: a dynamometer holds its speed as well."""
SAME_COMMAND = radians(1.0)
"""Angle within which commands are the same [rad]."""


class EngineCurve(NamedTuple):
    """A mean of an engine over its speed at one supply pressure."""

    label: str
    """Supply pressure in words, with the commands where several curves have the same pressure."""
    sensor: str
    """Name of the mean: "torque" or "air_flow"."""
    points: list[ComparedSignal]
    """What was measured, the slowest run first."""
    speeds: np.ndarray
    """Speeds at which the models were simulated, (n,) [rad/s], ascending."""
    stated: np.ndarray
    """Values by the machine file as it is, (n,) [SI]; NaN where a simulation did not come to its end, as below."""
    spread: np.ndarray
    """Standard deviation of these by what is known of the machine and the sensors, (n,) [SI]."""
    before: np.ndarray
    """Values that the calibrated machine gives, (n,) [SI]."""
    after: np.ndarray | None
    """Values that the machine with what was added gives, (n,) [SI]; None: nothing was added."""


def is_speed_curve(measured: Measured) -> bool:
    """Whether data are the curve of a dynamometer: means of an engine at several speeds, and no traces."""
    if measured.bench != ENGINE or any(run.channels for run in measured.runs):
        return False
    return any(len(list_speeds(group)) >= MIN_SPEEDS for group in group_by_supply(measured))


def group_by_supply(measured: Measured) -> list[list[MeasuredRun]]:
    """The runs with means, those of one supply pressure together: the lowest pressure first, the slowest run first.

    Runs at one speed with different commands are of different groups, as no line over the speed joins them.
    """
    runs = sorted((run for run in measured.runs if run.means), key=lambda run: run.supply)
    groups: list[list[MeasuredRun]] = []
    ambient = measured.ambient_pressure if measured.ambient_pressure > 0.0 else 0.0
    for run in runs:
        if groups and run.supply - groups[-1][0].supply <= MAX_SHARE_APART * (run.supply - ambient):
            groups[-1].append(run)
        else:
            groups.append([run])
    split = [part for group in groups for part in ([group] if _is_function_of_speed(group) else _split(group))]
    return [sorted(group, key=lambda run: run.speed) for group in split]


def _is_function_of_speed(runs: Sequence[MeasuredRun]) -> bool:
    """Whether all runs of one speed have the same commands."""
    return all(
        _has_same_commands(run, other)
        for place, run in enumerate(runs)
        for other in runs[:place]
        if isclose(run.speed, other.speed, rel_tol=SAME_SPEED)
    )


def _has_same_commands(run: MeasuredRun, other: MeasuredRun) -> bool:
    """Whether the solenoids of two runs are energised and released at the same angles."""
    return max(abs(run.energise - other.energise), abs(run.release - other.release)) <= SAME_COMMAND


def _split(runs: Sequence[MeasuredRun]) -> list[list[MeasuredRun]]:
    """Runs with the same commands together."""
    parts: list[list[MeasuredRun]] = []
    for run in runs:
        for part in parts:
            if _has_same_commands(run, part[0]):
                part.append(run)
                break
        else:
            parts.append([run])
    return parts


def list_speeds(runs: Sequence[MeasuredRun]) -> list[float]:
    """The different speeds of runs, ascending [rad/s]; repeats are one."""
    speeds: list[float] = []
    for speed in sorted(run.speed for run in runs):
        if not speeds or not isclose(speed, speeds[-1], rel_tol=SAME_SPEED):
            speeds.append(speed)
    return speeds


def find_curves(explanation: "Explanation", compared: Sequence[ComparedSignal]) -> list[EngineCurve]:
    """The means of an engine over its speed, beside the models: a curve for each sensor and each supply pressure.

    `compared` are signals by `compare_signals`; those with traces are passed over.
    """
    ambient = explanation.calibrated.residuals.machine.ambient.pressure
    groups = group_by_supply(explanation.measured)
    means = [signal for signal in compared if signal.is_mean]
    return [
        curve
        for group, label in zip(groups, _label_groups(groups, ambient), strict=True)
        for curve in _simulate_group(explanation, means, group, label)
        if curve.points
    ]


def _label_groups(groups: Sequence[Sequence[MeasuredRun]], ambient_pressure: float) -> list[str]:
    """Supply pressures [MPa gauge] as text, with the commands where several groups have the same pressure."""
    supplies = [f"{np.mean([run.supply - ambient_pressure for run in group]) / 1e6:.2f} MPa gauge" for group in groups]
    return [
        f"{supply}, {group[0].energise / DEGREE:.0f} to {group[0].release / DEGREE:.0f} deg"
        if supplies.count(supply) > 1
        else supply
        for supply, group in zip(supplies, groups, strict=True)
    ]


def _simulate_group(
    explanation: "Explanation", means: Sequence[ComparedSignal], group: Sequence[MeasuredRun], label: str
) -> Iterator[EngineCurve]:
    """The curves of one supply pressure, one for each sensor."""
    calibrated, best = explanation.calibrated, explanation.best
    sensors = list(dict.fromkeys(sensor for run in group for sensor in run.means))
    measured_at = list_speeds(group)
    between = np.linspace(measured_at[0], measured_at[-1], POINTS if len(measured_at) > 1 else 1)
    speeds = np.unique(np.concatenate([measured_at, between]))
    runs = [_interpolate(group, speed, sensors) for speed in speeds]

    # The machine file as it is, what calibration makes of it, and what was added: each at all speeds.
    stated = _predict(calibrated, runs, np.zeros(len(calibrated.fitted.x)))
    before = _predict(calibrated, runs, calibrated.fitted.x)
    after = _predict(best, runs, best.fitted.x) if best is not calibrated else None

    # How far the file may be off is needed roughly: at the measured speeds, and straight lines between.
    known = _find_spread(calibrated, [_interpolate(group, speed, sensors) for speed in measured_at], sensors)
    ours = {id(run) for run in group}
    for column, sensor in enumerate(sensors):
        points = [one for one in means if one.block.sensor == sensor and id(one.block.run) in ours]
        yield EngineCurve(
            label,
            sensor,
            sorted(points, key=lambda one: one.block.run.speed),
            speeds,
            stated=stated[:, column],
            spread=np.interp(speeds, measured_at, known[:, column]),
            before=before[:, column],
            after=None if after is None else after[:, column],
        )


def _interpolate(group: Sequence[MeasuredRun], speed: float, sensors: Sequence[str]) -> MeasuredRun:
    """A run at a speed between those of a group, in order of speed, with what they state taken linear between them."""

    def between(name: str) -> float:
        stated = [run for run in group if not np.isnan(getattr(run, name))]
        speeds = [run.speed for run in stated]
        return float(np.interp(speed, speeds, [getattr(run, name) for run in stated])) if stated else np.nan

    states: dict[str, Any] = {name: between(name) for name in STATED}
    return group[0]._replace(
        name=f"{speed * 30.0 / np.pi:.0f} r/min",
        data="",  # of no file, so that no fault of a file is in it
        speed=float(speed),
        times=np.empty(0),
        angles=NO_ANGLES,
        channels={},
        means=dict.fromkeys(sensors, 0.0),
        **states,
    )


def _predict(model: "Model", runs: Sequence[MeasuredRun], x: np.ndarray) -> np.ndarray:
    """Means of runs with all sensors, (runs, sensors) [SI]; NaN where a simulation does not come to its end."""
    own, sensors = model.residuals, len(runs[0].means)

    def predict(of: Sequence[MeasuredRun]) -> np.ndarray:
        return np.array(WhitenedResiduals(own.machine, of, own.parameters).predicted(x)).reshape(len(of), sensors)

    found = unless_ended(predict, runs)
    if found is not None:
        return found
    single = [unless_ended(predict, [run]) for run in runs]
    return np.concatenate([np.full((1, sensors), np.nan) if each is None else each for each in single])


def _find_spread(model: "Model", runs: Sequence[MeasuredRun], sensors: Sequence[str]) -> np.ndarray:
    """Standard deviations of means by what is known of machine and sensors, to first order, (runs, sensors) [SI].

    They are taken at the machine file as it is; NaN where a simulation does not come to its end.
    """
    own = model.residuals
    parameters: list[Parameter] = [parameter for parameter in own.parameters if parameter.prior]
    residuals = WhitenedResiduals(own.machine, runs, parameters, state_discrepancy(own.noise, {}))
    x = np.zeros(len(parameters))
    try:
        errors = residuals.at(x)
        jacobian, _ = residuals.jacobian(x, errors)
    except EndedEarly:
        return np.full((len(runs), len(sensors)), np.nan)
    noise = np.array([noise_for(own.noise, block).deviation for block in residuals.blocks])
    return (np.linalg.norm(jacobian[: len(noise)], axis=1) * noise).reshape(len(runs), len(sensors))
