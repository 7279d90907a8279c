"""Effects of the valve, in the order in which air flows: solenoids, chambers, piston, stops.

This list names them by hand; machine file, sweeps, archives, tests and the missing-effect search read it and
nothing else.
"""

from typing import NamedTuple

from valve.effects import bounce, coulomb_friction, ring_leakage, solenoid_b_delay

VALVE_EFFECTS = (
    solenoid_b_delay.EFFECT,
    ring_leakage.EFFECT,
    coulomb_friction.EFFECT,
    bounce.EFFECT,
)

ValveEffects = NamedTuple("ValveEffects", [(effect.name, effect.parameters) for effect in VALVE_EFFECTS])
ValveEffects.__new__.__defaults__ = tuple(effect.parameters() for effect in VALVE_EFFECTS)
