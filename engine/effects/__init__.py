"""Effects of the engine, and the list of all effects of a machine.

This list names ours by hand; machine file, sweeps, archives, tests and the missing-effect search read it, and what a
machine was given from outside, see `apesim.engine.effects.outside`.
"""

from typing import Any, NamedTuple

from apesim.effect import Effect, Library, NoEffects, acting, library_for, unserved
from apesim.engine.effects import (
    blow_by,
    clearance_error,
    cylinder_wall_heat,
    exhaust_back_pressure,
    exhaust_restriction,
    exhaust_timing,
    friction_torque,
    groove_area_error,
    intake_pipe_loss,
    seat_leak,
    speed_ripple,
    tabulated_cylinder_heat,
    tabulated_cylinder_leak,
    tabulated_groove,
    tdc_error,
)
from apesim.valve import effects as valve_library
from apesim.valve.effects import VALVE_EFFECTS, VALVE_LIBRARY

ENGINE_EFFECTS = (
    intake_pipe_loss.EFFECT,
    groove_area_error.EFFECT,
    seat_leak.EFFECT,
    clearance_error.EFFECT,
    cylinder_wall_heat.EFFECT,
    blow_by.EFFECT,
    exhaust_timing.EFFECT,
    exhaust_restriction.EFFECT,
    exhaust_back_pressure.EFFECT,
    friction_torque.EFFECT,
    tabulated_cylinder_heat.EFFECT,
    tabulated_cylinder_leak.EFFECT,
    tabulated_groove.EFFECT,
    speed_ripple.EFFECT,
    tdc_error.EFFECT,
)
ALL_EFFECTS = VALVE_EFFECTS + ENGINE_EFFECTS

EngineLaws = acting("EngineLaws", __name__, ENGINE_EFFECTS)
EngineTables = acting("EngineTables", __name__, ENGINE_EFFECTS, tables=True)
ENGINE_LIBRARY = Library(ENGINE_EFFECTS, (NoEffects, EngineLaws, EngineTables))
Effects = NamedTuple("Effects", [(effect.name, effect.parameters) for effect in ALL_EFFECTS])
Effects.__doc__ = "Effects: physics that the base model leaves out. A table that is present switches its effect on."
Effects.__new__.__defaults__ = tuple(effect.parameters() for effect in ALL_EFFECTS)
Effects.due = {effect.name: effect.strengths or effect.parameters._fields[:1] for effect in ALL_EFFECTS}

VALVE_SLOTS = frozenset({"adjust", "law", "contact", "volume", "sensor"})
ENGINE_SLOTS = VALVE_SLOTS - {"contact"}
"""Slots that are looked at for the effects of each list: the engine has no stops."""


def library_of(effects: Any) -> tuple[Effect, ...]:
    """Return every effect that a machine may have on: ours, and those that it was given from outside.

    `effects` is the machine's section; those of the valve come first, then those of the engine.
    """
    return getattr(effects, "library", ALL_EFFECTS)


def unserved_effects(effects: Any) -> list[str]:
    """Name the effects that would be ignored, as they were added to a list after it was compiled for.

    `effects` is the machine's section; see `apesim.effect.unserved`.
    """
    valve = library_for(effects, VALVE_LIBRARY, "valve")
    engine = library_for(effects, ENGINE_LIBRARY, "engine")
    of_valve = {id(effect): effect for effect in (*valve_library.VALVE_EFFECTS, *valve.effects)}
    others = {id(effect): effect for effect in (*ALL_EFFECTS, *ENGINE_EFFECTS, *engine.effects)}
    others = {key: effect for key, effect in others.items() if key not in of_valve}
    return [
        *unserved(of_valve.values(), effects, valve.marches[-1].__annotations__, VALVE_SLOTS),
        *unserved(others.values(), effects, engine.marches[-1].__annotations__, ENGINE_SLOTS),
    ]
