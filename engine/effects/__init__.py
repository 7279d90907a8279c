"""Effects of the engine, and the list of all effects of a machine.

This list names them by hand; machine file, sweeps, archives, tests and the missing-effect search read it and
nothing else.
"""

from typing import NamedTuple

from engine.effects import blow_by, cylinder_wall_heat
from valve.effects import VALVE_EFFECTS

ENGINE_EFFECTS = (
    cylinder_wall_heat.EFFECT,
    blow_by.EFFECT,
)
ALL_EFFECTS = VALVE_EFFECTS + ENGINE_EFFECTS

EngineEffects = NamedTuple("EngineEffects", [(effect.name, effect.parameters) for effect in ENGINE_EFFECTS])
Effects = NamedTuple("Effects", [(effect.name, effect.parameters) for effect in ALL_EFFECTS])
Effects.__doc__ = "Effects: physics that the base model leaves out. A table that is present switches its effect on."
Effects.__new__.__defaults__ = tuple(effect.parameters() for effect in ALL_EFFECTS)
Effects.due = {effect.name: effect.strengths or effect.parameters._fields[:1] for effect in ALL_EFFECTS}
