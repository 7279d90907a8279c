"""The truth's engine with the numbers of a machine file; numbers alone are taken over, no law."""

from math import isnan

from .effects import EFFECTS, Rig
from .engine import Engine
from .valve import Bench

KNOWN = set(EFFECTS)


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
    return rig_of(machine).engine


def rig_of(machine):
    """The truth's engine and sensors for a machine, see `engine_of`."""
    refuse_unknown(machine)
    rig = Rig(plain_engine(machine))
    for name, effect in machine.effects._asdict().items():
        if effect != type(effect)():
            rig = EFFECTS[name](rig, **effect._asdict())
    return rig


def plain_engine(machine):
    """The engine without its effects."""
    engine, command, supply = machine.engine, machine.command, machine.supply
    return Engine(
        bench_of(machine),
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
        machine.valve.stroke if isnan(engine.cam.lift) else engine.cam.lift,
        (engine.exhaust.opens, engine.exhaust.closes, engine.exhaust.flank),
        engine.exhaust.effective_area,
        engine.receiver.volume,
        engine.receiver.feed_area,
        tuple(engine.friction),
        check_valve=bool(engine.receiver.check_valve),
    )


def bench_of(machine):
    """The valve and its air, without effects."""
    supply, valve, ambient = machine.supply, machine.valve, machine.ambient
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
        **read_solenoid(valve.solenoid),
    )


def read_solenoid(solenoid):
    """Numbers of the solenoids by their names in `Bench`; what a machine does not say of a release is not given."""
    dead, ramp = solenoid.release_dead_time, solenoid.release_ramp_time
    return {
        "effective_area": solenoid.effective_area,
        "dead_time": solenoid.dead_time,
        "ramp_time": solenoid.ramp_time,
        "release_delay": 0.0 if isnan(dead) else dead - solenoid.dead_time,
        "release_ramp_time": None if isnan(ramp) else ramp,
    }


def refuse_unknown(machine):
    """Raises a ValueError where a machine has something that the truth does not know."""
    unknown = [
        name for name, effect in machine.effects._asdict().items() if name not in KNOWN and effect != type(effect)()
    ]
    if machine.effects.cylinder_wall_heat.factor:
        unknown.append("cylinder_wall_heat.factor")
    if machine.air.model:
        unknown.append("air.model")
    if machine.engine.exhaust_2.effective_area:
        unknown.append("engine.exhaust_2")
    unknown += [
        name
        for name, curve in (
            ("groove.area_curve", machine.groove.area_curve),
            ("valve.solenoid.opening_curve", machine.valve.solenoid.opening_curve),
            ("valve.solenoid.release_curve", machine.valve.solenoid.release_curve),
        )
        if len(curve)
    ]
    if unknown:
        raise ValueError(f"the truth does not know {', '.join(unknown)}")
