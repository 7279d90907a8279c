"""What no machine file knows exactly: every case draws these about the nominal rig, and says nothing of them.

Normal with the stated deviation, cut at two of them. They are priors to state to whoever solves the cases.
"""

from typing import NamedTuple

import numpy as np

from tests.truth.simulator.effects import sensor_gain, sensor_offset

CUT = 2.0
"""Deviations."""
SHARES = (
    "valve.viscous_friction",
    "valve.solenoid.effective_area",
    "groove.effective_area",
    "engine.exhaust.effective_area",
    "engine.receiver.feed_area",
)


class Nuisance(NamedTuple):
    """A number that is not known exactly."""

    name: str
    deviation: float
    """SI, or a share."""
    add: object
    """Function of a rig and a value: the rig with it."""
    channel: str = ""
    """Only where this is measured."""
    engine_only: bool = False
    ends: tuple = ()
    """Between which it lies, no value likelier than another; none: it is normal."""

    @property
    def is_share(self):
        """Whether it is a share of a number that stays above zero."""
        return self.name in SHARES


def of_valve(name):
    """A share of a number of the valve."""
    return lambda rig, x: rig.valve(**{name: (1.0 + x) * getattr(rig.engine.valve, name)})


def of_engine(name):
    """A share of a number of the engine."""
    return lambda rig, x: rig.of_engine(**{name: (1.0 + x) * getattr(rig.engine, name)})


def supply(rig, x):
    """A share of the supply's gauge pressure, engine air and control air alike."""
    engine, zero = rig.engine, rig.engine.valve.ambient_pressure
    intake = None if engine.intake_pressure is None else engine.intake_pressure + x * (engine.intake_pressure - zero)
    control = engine.valve.supply_pressure + x * (engine.valve.supply_pressure - zero)
    return rig.of_engine(intake_pressure=intake).valve(supply_pressure=control)


def friction(rig, x):
    """A mean effective pressure more [Pa]."""
    constant, *others = rig.engine.friction
    return rig.of_engine(friction=(constant + x, *others))


def gain(channel):
    return lambda rig, x: sensor_gain(rig, **{channel: x})


def offset(channel):
    return lambda rig, x: sensor_offset(rig, **{channel: x})


NUISANCES = (
    Nuisance("valve.viscous_friction", 0.10, of_valve("viscous_friction")),
    Nuisance("valve.solenoid.effective_area", 0.05, of_valve("effective_area")),
    Nuisance(
        "valve.solenoid.dead_time", 0.1e-3, lambda rig, x: rig.valve(dead_time=max(0.0, rig.engine.valve.dead_time + x))
    ),
    Nuisance("supply.pressure", 0.01, supply),
    Nuisance(
        "supply.temperature", 2.0, lambda rig, x: rig.valve(supply_temperature=rig.engine.valve.supply_temperature + x)
    ),
    Nuisance(
        "air.heat_capacity_ratio",
        0.003,
        lambda rig, x: rig.valve(heat_capacity_ratio=rig.engine.valve.heat_capacity_ratio + x),
    ),
    Nuisance("groove.effective_area", 0.03, of_engine("groove_area"), engine_only=True),
    Nuisance("engine.exhaust.effective_area", 0.05, of_engine("exhaust_area"), engine_only=True),
    Nuisance("engine.receiver.feed_area", 0.05, of_engine("feed_area"), engine_only=True),
    Nuisance("engine.friction.constant", 2e3, friction, "torque", engine_only=True),
    Nuisance(
        "tdc_error",
        np.radians(0.1),
        lambda rig, x: rig.reading(tdc_error=rig.sensors.tdc_error + x),
        engine_only=True,
    ),
    Nuisance("lift offset", 0.02e-3, offset("lift"), "lift"),
    Nuisance("lift gain", 0.005, gain("lift"), "lift"),
    Nuisance("pressure_a offset", 2e3, offset("pressure_a"), "pressure_a"),
    Nuisance("pressure_a gain", 0.005, gain("pressure_a"), "pressure_a"),
    Nuisance("pressure_b offset", 2e3, offset("pressure_b"), "pressure_b"),
    Nuisance("pressure_b gain", 0.005, gain("pressure_b"), "pressure_b"),
    Nuisance("cylinder_pressure offset", 5e3, offset("cylinder_pressure"), "cylinder_pressure"),
    Nuisance("cylinder_pressure gain", 0.005, gain("cylinder_pressure"), "cylinder_pressure"),
    Nuisance("torque gain", 0.005, gain("torque"), "torque"),
    Nuisance("air_flow gain", 0.01, gain("air_flow"), "air_flow"),
)


def nuisances_for(bench, channels):
    """Those that act on a bench where these channels are measured."""
    return [
        one
        for one in NUISANCES
        if (not one.channel or one.channel in channels) and (bench == "engine" or not one.engine_only)
    ]


def drawn(nuisances, rng):
    """A value for each, by name; SI or shares."""
    values = {}
    for one in nuisances:
        x = rng.normal()
        while abs(x) > CUT:
            x = rng.normal()
        values[one.name] = one.deviation * float(x)
    return values


def with_nuisances(rig, nuisances, values):
    """A rig with the drawn values."""
    for one in nuisances:
        rig = one.add(rig, values[one.name])
    return rig
