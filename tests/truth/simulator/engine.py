"""One cylinder, two-stroke, breathing through an electro-pneumatic valve, a cam or an ideal valve, over crank angle.

The valve is that of `truth.simulator.valve`; cylinder and receiver, too, are pressures and temperatures. A cycle begins
where the solenoids are energised. SI, absolute pressures, angles in rad from crank pin up. Imports nothing from the
packages it judges.
"""

from collections.abc import Callable
from itertools import pairwise
from math import isinf, radians
from typing import NamedTuple

import numpy as np

from .crank import TURN, corners_of, cylinder_volume, groove_area, opened
from .gas import enthalpy, gas_rates, inflow, ratio
from .valve import (
    ABSOLUTE,
    HEAT_CYLINDER,
    HEAT_RECEIVER,
    MASS_CYLINDER,
    MASS_RECEIVER,
    Bench,
    Now,
    closed_at_rest,
    corners_after,
    energised,
    further,
    further_rates,
    further_states,
    push_of,
    release_of,
    sums_of,
    supply_at,
    valve_rates,
)

CYLINDER_PRESSURE, CYLINDER_TEMPERATURE, RECEIVER_PRESSURE, RECEIVER_TEMPERATURE = range(6, 10)
WORK, ENGINE_AIR, CONTROL_AIR, STATES = range(10, 14)
"""From STATES on those of `truth.simulator.valve.further_states`, then pressure and temperature of the pipe, if any."""
TOLERANCES = np.array([*ABSOLUTE, 1e-3, 1e-7, 1e-3, 1e-7, 1e-7, 1e-13, 1e-13])
APART = 1e-9
"""Corners nearer to one another than this are one [rad]."""


class Engine(NamedTuple):
    """The machine, its air and its command."""

    valve: Bench = Bench()
    """Its supply is the control air's; its terms are those of the whole machine."""
    intake: str = "epv"
    """epv, cam or ideal."""
    intake_pressure: float | None = None
    """Pressure of the engine air; None: that of the control air."""
    control_from_receiver: bool = False
    energise: float = radians(-5.0)
    release: float = radians(70.0)
    open_target: float = radians(-5.0)
    """Opening angle of the ideal valve."""
    close_target: float = radians(70.0)
    bore: float = 85e-3
    stroke: float = 88e-3
    rod_length: float = 150e-3
    pin_offset: float = 0.0
    compression_ratio: float = 18.0
    lap: float = 1e-3
    groove_area: float = 150e-6
    cam: tuple = (radians(-5.0), radians(70.0), radians(25.0))
    """Opens, closes, flank."""
    cam_lift: float = 9e-3
    exhaust: tuple = (radians(165.0), radians(340.0), radians(25.0))
    exhaust_area: float = 500e-6
    receiver_volume: float = 1e-3
    """inf: none, the pressure before the groove is constant [m3]."""
    feed_area: float = 200e-6
    friction: tuple = (0.4e5, 0.005, 0.08e5, 0.0008e5)
    """Chen and Flynn's mean effective pressure: constant [Pa], on the peak pressure, on the mean piston speed [Pa s/m],
    on its square."""
    taper: float = 0.0
    """Share by which the groove's area is larger at half of the open travel."""
    seat_leak: float = 0.0
    """Beside the groove at any lift [m2]."""
    clearance_error: float = 0.0
    """Share by which the clearance is larger."""
    pipe_volume: float = 0.0
    """Between receiver and groove; 0: none [m3]."""
    pipe_area: float = 0.0
    """That feeds it [m2]."""
    exhaust_excess: float = 0.0
    """Pressure behind the exhaust above the ambient's [Pa]."""
    exhaust_swing: Callable | None = None
    """Share by which the pressure behind the exhaust is higher, over crank angle."""
    crevice: float = 0.0
    """Beside the cylinder, its gas as warm as the ambient [m3]."""
    check_valve: bool = False
    """In the feed of the receiver."""


def intake_lift(engine, angle, position):
    """Lift of the valve or the cam [m]."""
    if engine.intake == "epv":
        return engine.valve.stroke - position
    return engine.cam_lift * opened(angle, engine.cam)


def intake_area(engine, angle, position):
    """Effective area into the cylinder, leak and all [m2]."""
    if engine.intake != "ideal":
        return groove_area(engine, intake_lift(engine, angle, position)) + engine.seat_leak
    inside = (angle - engine.open_target) % TURN < engine.close_target - engine.open_target
    return engine.seat_leak + (groove_area(engine, engine.valve.stroke) if inside else 0.0)


def engine_supply(engine):
    """Pressure [Pa abs] and temperature [K] of the air that the regulator feeds to the engine."""
    pressure = engine.valve.supply_pressure if engine.intake_pressure is None else engine.intake_pressure
    return pressure, engine.valve.supply_temperature


def edges_of(engine, speed):
    """Times since the energising of this cycle at which the command switched, and signs; those of the past too."""
    valve = engine.valve
    slowest = valve.dead_time + valve.ramp_time + max(valve.delay_a, valve.delay_b)
    for delay in {valve.delay_a, valve.delay_b}:
        late, ramp = release_of(valve, delay)
        slowest = max(slowest, valve.dead_time + ramp + delay + late)
    past = int(slowest * speed / TURN) + 1
    return [
        ((at + turn * TURN - engine.energise) / speed, sign)
        for turn in range(-past, 1)
        for at, sign in ((engine.energise, 1.0), (engine.release, -1.0))
    ]


def resting(engine):
    """States of an engine at rest, with full receiver, line and pipe, and their absolute tolerances."""
    valve, supply = engine.valve, engine_supply(engine)
    control = supply if engine.control_from_receiver else (valve.supply_pressure, valve.supply_temperature)
    ambient = valve.ambient_pressure, valve.ambient_temperature
    added, tolerances = further_states(valve, control)
    pipe = [*supply] if engine.pipe_volume else []
    y = [*closed_at_rest(valve, control), *ambient, *supply, 0.0, 0.0, 0.0, *added, *pipe]
    return np.array(y), np.array([*TOLERANCES, *tolerances, *[1e-3, 1e-7][: len(pipe)]])


def now_of(engine, angle, y, regulated):
    """What terms see of a state, and the air that feeds the solenoids, that behind the receiver and its supply.

    Parameters
    ----------
    engine : Engine
    angle : float
    y : list of float
    regulated : pair of float
        Control air behind the regulator.

    Returns
    -------
    Now
    control, receiver, supply : pair of float
    """
    supply = engine_supply(engine)
    receiver = supply if isinf(engine.receiver_volume) else (y[RECEIVER_PRESSURE], y[RECEIVER_TEMPERATURE])
    control = receiver if engine.control_from_receiver else regulated
    now = Now(
        y[0],
        y[1],
        (y[2], y[3]),
        (y[4], y[5]),
        *further(engine.valve, y[STATES:], control),
        (y[-2], y[-1]) if engine.pipe_volume else receiver,
        (y[CYLINDER_PRESSURE], y[CYLINDER_TEMPERATURE]),
        *cylinder_volume(engine, angle),
        angle,
    )
    return now, control, receiver, supply


def cylinder_rates(engine, now, swell, mass, heat):
    """Rates of pressure and temperature in the cylinder; a crevice takes in air at its own temperature."""
    valve = engine.valve
    rates = gas_rates(valve, now.cylinder, now.volume, swell, mass, heat)
    if not engine.crevice:
        return rates
    wall = valve.ambient_temperature
    carried = enthalpy(valve, now.cylinder[1] if rates[0] > 0.0 else wall)
    taken = engine.crevice / (valve.gas_constant * wall)  # per pressure
    slowed = 1.0 + (ratio(valve, now.cylinder[1]) - 1.0) * taken * carried / now.volume
    into = taken * rates[0] / slowed
    return gas_rates(valve, now.cylinder, now.volume, swell, mass - into, heat - into * carried)


class Breath(NamedTuple):
    """What a cylinder and its valve do at an instant."""

    motion: list
    """Rates of the valve's six states."""
    cylinder: list
    """Rates of pressure [Pa/s] and temperature [K/s] in the cylinder."""
    added: list
    """Rates of the further states of line and creep, then of the pipe's."""
    power: float
    """Power of the gas on the piston, above the ambient's [W]."""
    groove: float
    """Mass into the cylinder [kg/s]."""
    drawn: float
    """Control air [kg/s]."""
    taken: tuple
    """Mass [kg/s] and enthalpy [W] that leave the receiver."""


def breathe(engine, now, control, before, phase, fractions, speed, position):
    """Rates of one cylinder, its valve and its pipe.

    Parameters
    ----------
    engine : Engine
    now : Now
    control, before : pair of float
        Control air; air in the receiver.
    phase : str
        Of the valve's piston.
    fractions : pair of float
        Energised fractions of solenoids A and B.
    speed : float
        [rad/s]
    position : float
        Of the valve's piston, by which the groove's area goes [m].

    Returns
    -------
    Breath
    """
    valve, sums = engine.valve, sums_of(engine.valve.terms, now)
    motion, added, drawn = [0.0] * CYLINDER_PRESSURE, [0.0] * len(further_states(valve, control)[0]), (0.0, 0.0)
    if engine.intake == "epv":
        motion, drawn = valve_rates(valve, now, sums, phase, *fractions)
        added, drawn = further_rates(valve, now, drawn, control)
    groove, carried = inflow(valve, intake_area(engine, now.angle, position), now.cylinder, now.receiver)
    behind = valve.ambient_pressure * (1.0 + (engine.exhaust_swing(now.angle) if engine.exhaust_swing else 0.0))
    behind += engine.exhaust_excess
    back, back_carried = inflow(
        valve,
        engine.exhaust_area * opened(now.angle, engine.exhaust),
        now.cylinder,
        (behind, valve.ambient_temperature),
    )
    mass, heat = groove + back + sums[MASS_CYLINDER], carried + back_carried + sums[HEAT_CYLINDER]
    cylinder = cylinder_rates(engine, now, now.slope * speed, mass, heat)
    out, out_carried = groove, carried
    if engine.pipe_volume:
        out, out_carried = inflow(valve, engine.pipe_area, now.receiver, before)
        mass, heat = out - groove, out_carried - carried
        added = added + gas_rates(valve, now.receiver, engine.pipe_volume, 0.0, mass, heat)
    share = float(engine.control_from_receiver)
    taken = out + share * drawn[0] - sums[MASS_RECEIVER], out_carried + share * drawn[1] - sums[HEAT_RECEIVER]
    power = (now.cylinder[0] - valve.ambient_pressure) * now.slope * speed
    return Breath(motion, cylinder, added, power, groove, drawn[0], taken)


def receiver_rates(engine, receiver, supply, taken):
    """Rates of pressure [Pa/s] and temperature [K/s] in the receiver, of which mass and enthalpy are taken."""
    if isinf(engine.receiver_volume):
        return [0.0, 0.0]
    mass, heat = inflow(engine.valve, engine.feed_area, receiver, supply)
    if engine.check_valve and mass < 0.0:
        mass = heat = 0.0
    return gas_rates(engine.valve, receiver, engine.receiver_volume, 0.0, mass - taken[0], heat - taken[1])


def rates_of(engine, speed):
    """Functions of crank angle and state: the rates of the states over crank angle, which want the phase too, and the
    push on the piston, see `truth.simulator.piston.exits`."""
    valve, edges = engine.valve, edges_of(engine, speed)
    fixed = valve.supply_pressure, valve.supply_temperature

    def here(angle, y):
        return now_of(engine, angle, y.tolist(), supply_at(valve, fixed, edges, (angle - engine.energise) / speed))

    def push(angle, y):
        return push_of(valve, here(angle, y)[0])

    def rates(angle, y, phase):
        now, control, before, supply = here(angle, y)
        since = (angle - engine.energise) / speed
        fractions = [energised(valve, edges, delay, since) for delay in (valve.delay_a, valve.delay_b)]
        breath = breathe(engine, now, control, before, phase, fractions, speed, now.position)
        receiver = receiver_rates(engine, before, supply, breath.taken)
        groove, drawn = breath.groove, breath.drawn
        own = *breath.motion, *breath.cylinder, *receiver, breath.power, groove, drawn, *breath.added
        return [rate / speed for rate in own]

    return rates, push


def corners_of_cycle(engine, speed):
    """Angles after the energising at which the rates are not smooth, and the end of the cycle."""
    angles = corners_of(engine.exhaust)
    if engine.intake == "epv":
        for edge in (engine.energise, engine.release):
            angles += [edge + speed * lag for lag in (0.0, *corners_after(engine.valve, 0.0))]
    elif engine.intake == "cam":
        angles += corners_of(engine.cam, [lift / engine.cam_lift for lift in (engine.lap, engine.valve.stroke)])
    else:
        angles += [engine.open_target, engine.close_target]
    after = sorted((angle - engine.energise) % TURN for angle in angles)
    apart = [angle for angle, following in pairwise([*after, TURN]) if following - angle > APART < angle]
    return [engine.energise + angle for angle in (*apart, TURN)]
