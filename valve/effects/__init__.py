"""Effects of the valve, in the order in which air flows.

Supply line, solenoids, chambers, piston, stops; then what a record passes: sensors, the recorder.
This list names ours by hand; machine file, sweeps, archives, tests and the missing-effect search read it, and what a
machine was given from outside, see `apesim.engine.effects.outside`.
"""

from typing import NamedTuple

from apesim.effect import Library, NoEffects, acting
from apesim.valve.effects import (
    bounce,
    chamber_wall_heat,
    channel_swap,
    clock_error,
    coulomb_friction,
    critical_ratio,
    dead_volume,
    discharge_coefficient_slope,
    end_cushion,
    intake_flow_force,
    leakage_a,
    leakage_b,
    lift_sensor_lag,
    moving_mass_error,
    pressure_dependent_delay,
    pressure_sensor_lag,
    quadratic_drag,
    release_delay,
    ring_leakage,
    seal_friction,
    sensor_gain,
    sensor_offset,
    side_force,
    slow_ramp,
    solenoid_a_delay,
    solenoid_b_delay,
    spring_rate_error,
    stribeck_friction,
    supply_droop,
    tabulated_area,
    tabulated_damping,
    tabulated_delay,
    tabulated_force,
    tabulated_heat,
    tabulated_leak,
    time_zero,
    vent_back_pressure,
)

VALVE_EFFECTS = (
    supply_droop.EFFECT,
    solenoid_a_delay.EFFECT,
    solenoid_b_delay.EFFECT,
    release_delay.EFFECT,
    slow_ramp.EFFECT,
    pressure_dependent_delay.EFFECT,
    critical_ratio.EFFECT,
    discharge_coefficient_slope.EFFECT,
    vent_back_pressure.EFFECT,
    dead_volume.EFFECT,
    ring_leakage.EFFECT,
    leakage_a.EFFECT,
    leakage_b.EFFECT,
    chamber_wall_heat.EFFECT,
    moving_mass_error.EFFECT,
    spring_rate_error.EFFECT,
    coulomb_friction.EFFECT,
    stribeck_friction.EFFECT,
    seal_friction.EFFECT,
    quadratic_drag.EFFECT,
    side_force.EFFECT,
    intake_flow_force.EFFECT,
    end_cushion.EFFECT,
    bounce.EFFECT,
    tabulated_force.EFFECT,
    tabulated_damping.EFFECT,
    tabulated_heat.EFFECT,
    tabulated_leak.EFFECT,
    tabulated_area.EFFECT,
    tabulated_delay.EFFECT,
    lift_sensor_lag.EFFECT,
    pressure_sensor_lag.EFFECT,
    sensor_gain.EFFECT,
    sensor_offset.EFFECT,
    time_zero.EFFECT,
    clock_error.EFFECT,
    channel_swap.EFFECT,
)

ValveEffects = NamedTuple("ValveEffects", [(effect.name, effect.parameters) for effect in VALVE_EFFECTS])
ValveEffects.__new__.__defaults__ = tuple(effect.parameters() for effect in VALVE_EFFECTS)
ValveLaws = acting("ValveLaws", __name__, VALVE_EFFECTS)
ValveTables = acting("ValveTables", __name__, VALVE_EFFECTS, tables=True)
VALVE_LIBRARY = Library(VALVE_EFFECTS, (NoEffects, ValveLaws, ValveTables))
