"""Nuisances: what is known of a rig only within a prior, and is projected out of everything that is judged.

The priors are standard deviations: what a catalogue, a drawing or a calibration sheet leaves open.
"""

from typing import NamedTuple

from apesim.engine.machine import Machine
from apesim.studies.estimation.parameters import DECLARED, Parameter, value_of
from apesim.studies.measured import Measured


class Prior(NamedTuple):
    """The standard deviation within which a number of the machine is known."""

    key: str
    """Key of the machine file."""
    deviation: float
    """Standard deviation: a share of the value where it is relative, else SI."""
    relative: bool = False
    """Whether the standard deviation is a share of the value."""
    sensor: str = ""
    """Sensor without which the number does not matter; "": it always does."""


FARTHEST = 100.0
"""Prior standard deviations beyond which no nuisance is fitted."""
VALVE = (
    Prior("valve.viscous_friction", 0.10, True),
    Prior("valve.solenoid.effective_area", 0.05, True),
    Prior("valve.solenoid.dead_time", 0.1e-3),
    Prior("supply.pressure", 0.01, True),
    Prior("supply.temperature", 2.0),
    Prior("air.heat_capacity_ratio", 0.003),
    Prior("effects.sensor_offset.lift", 0.02e-3, sensor="lift"),
    Prior("effects.sensor_gain.lift", 0.005, sensor="lift"),
    Prior("effects.sensor_offset.pressure_a", 2e3, sensor="pressure_a"),
    Prior("effects.sensor_gain.pressure_a", 0.005, sensor="pressure_a"),
    Prior("effects.sensor_offset.pressure_b", 2e3, sensor="pressure_b"),
    Prior("effects.sensor_gain.pressure_b", 0.005, sensor="pressure_b"),
)
ENGINE = (
    Prior("groove.effective_area", 0.03, True),
    Prior("engine.exhaust.effective_area", 0.05, True),
    Prior("engine.receiver.feed_area", 0.05, True),
    Prior("engine.friction.constant", 2e3),
    Prior("effects.sensor_offset.cylinder_pressure", 5e3, sensor="cylinder_pressure"),
    Prior("effects.sensor_gain.cylinder_pressure", 0.005, sensor="cylinder_pressure"),
    Prior("effects.tdc_error.angle", 0.1 * 3.141592653589793 / 180.0),
    Prior("effects.sensor_gain.torque", 0.005, sensor="torque"),
    Prior("effects.sensor_gain.air_flow", 0.01, sensor="air_flow"),
)


def nuisances_of(machine: Machine, measured: Measured) -> list[Parameter]:
    """The nuisances of a set of measured data: those of its bench, without those of sensors that it does not have.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured

    Returns
    -------
    list of apesim.studies.estimation.parameters.Parameter

    Examples
    --------
    >>> nuisances = nuisances_of(Machine(), Measured("", {}, (), "valve"))  # no sensor at all
    >>> [parameter.key for parameter in nuisances][:2], len(nuisances)
    (['valve.viscous_friction', 'valve.solenoid.effective_area'], 6)
    """
    sensors = {sensor for run in measured.runs for sensor in (*run.channels, *run.means)}
    priors = VALVE if measured.bench == "valve" else VALVE + ENGINE
    return [nuisance(machine, prior) for prior in priors if not prior.sensor or prior.sensor in sensors]


def nuisance(machine: Machine, prior: Prior) -> Parameter:
    """A nuisance as a parameter: x is the shift in prior standard deviations, beforehand a standard normal number.

    Its bounds are what the machine file allows, and `FARTHEST` prior standard deviations at most.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    prior : Prior

    Returns
    -------
    apesim.studies.estimation.parameters.Parameter

    Examples
    --------
    >>> dead_time = nuisance(Machine(), Prior("valve.solenoid.dead_time", 0.1e-3))
    >>> dead_time.scale, dead_time.prior
    (0.0001, True)
    """
    own = value_of(machine, prior.key)
    low, high = DECLARED[prior.key].ends
    unit = prior.deviation * (own if prior.relative else 1.0)
    ends = max((low - own) / unit, -FARTHEST), min((high - own) / unit, FARTHEST)
    return Parameter(prior.key, prior.deviation, *ends, own, True, prior.relative, True)
