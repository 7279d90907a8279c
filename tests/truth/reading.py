"""The truth's engine with the numbers of a machine file; numbers alone are taken over, no law."""

from math import isnan

from truth.engine import Engine
from truth.terms import blow_by, ring_leakage, wall_heat
from truth.valve import Bench

KNOWN = {"solenoid_b_delay", "ring_leakage", "coulomb_friction", "bounce", "cylinder_wall_heat", "blow_by"}


def engine_of(machine):
    """The truth's engine for a machine.

    Parameters
    ----------
    machine : NamedTuple
        As a machine file declares it; SI, angles in rad.

    Returns
    -------
    Engine

    Raises
    ------
    ValueError
        The machine has something that the truth does not know.
    """
    refuse_unknown(machine)
    engine, command, supply = machine.engine, machine.command, machine.supply
    valve = bench_of(machine)
    return Engine(
        valve._replace(terms=terms_of(machine.effects, valve, engine.bore)),
        ("epv", "cam", "ideal")[engine.intake],
        supply.pressure,
        bool(supply.control_air),
        command.energise,
        command.release,
        command.open_target,
        command.close_target,
        engine.bore,
        engine.stroke,
        engine.rod_length,
        engine.pin_offset,
        engine.compression_ratio,
        machine.groove.lap,
        machine.groove.effective_area,
        (engine.cam.opens, engine.cam.closes, engine.cam.flank),
        engine.cam.lift,
        (engine.exhaust.opens, engine.exhaust.closes, engine.exhaust.flank),
        engine.exhaust.effective_area,
        engine.receiver.volume,
        engine.receiver.feed_area,
        tuple(engine.friction),
    )


def bench_of(machine):
    """The valve and its air, without optional terms."""
    supply, valve, ambient, effects = machine.supply, machine.valve, machine.ambient, machine.effects
    return Bench(
        supply.pressure if isnan(supply.control_pressure) else supply.control_pressure,
        supply.temperature,
        ambient.pressure,
        ambient.temperature,
        machine.air.gas_constant,
        machine.air.heat_capacity_ratio,
        valve.stroke,
        valve.moving_mass,
        valve.piston_area,
        valve.clearance_volume,
        valve.spring_rate,
        valve.viscous_friction,
        valve.solenoid.effective_area,
        valve.solenoid.dead_time,
        valve.solenoid.ramp_time,
        0.0,
        effects.solenoid_b_delay.time,
        effects.coulomb_friction.force,
        effects.coulomb_friction.breakaway,
        effects.bounce.restitution,
    )


def terms_of(effects, air, bore):
    """Those of the optional terms that a machine's effects switch on."""
    heat = effects.cylinder_wall_heat
    terms = (
        (effects.ring_leakage.area, ring_leakage(air, effects.ring_leakage.area)),
        (effects.blow_by.area, blow_by(air, effects.blow_by.area)),
        (heat.h, wall_heat(bore, heat.h, heat.wall_temperature)),
    )
    return tuple(term for strength, term in terms if strength)


def refuse_unknown(machine):
    """Raises a ValueError where a machine has something that the truth does not know."""
    unknown = [
        name for name, effect in machine.effects._asdict().items() if name not in KNOWN and effect != type(effect)()
    ]
    if machine.effects.cylinder_wall_heat.factor:
        unknown.append("cylinder_wall_heat.factor")
    if machine.air.model:
        unknown.append("air.model")
    unknown += [
        name
        for name, curve in (
            ("groove.area_curve", machine.groove.area_curve),
            ("valve.solenoid.opening_curve", machine.valve.solenoid.opening_curve),
        )
        if len(curve)
    ]
    if unknown:
        raise ValueError(f"the truth does not know {', '.join(unknown)}")
