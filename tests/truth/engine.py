"""One cylinder, two-stroke, breathing through an electro-pneumatic valve, a cam or an ideal valve, over crank angle.

The valve is that of `truth.valve`; cylinder and receiver, too, are pressures and temperatures. A cycle begins where
the solenoids are energised. SI, absolute pressures, angles in rad from crank pin up. Imports nothing from the packages
it judges.
"""

from itertools import pairwise
from math import isinf, radians
from typing import NamedTuple

import numpy as np

from truth.crank import TURN, corners_of, cylinder_volume, groove_area, opened
from truth.gas import gas_rates, inflow
from truth.valve import (
    ABSOLUTE,
    HEAT_CYLINDER,
    HEAT_RECEIVER,
    MASS_CYLINDER,
    MASS_RECEIVER,
    Bench,
    Now,
    corners_after,
    energised,
    sums_of,
    valve_rates,
)

CYLINDER_PRESSURE, CYLINDER_TEMPERATURE, RECEIVER_PRESSURE, RECEIVER_TEMPERATURE = range(6, 10)
WORK, ENGINE_AIR, CONTROL_AIR, STATES = range(10, 14)
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
    """Of the engine air; None: that of the control air."""
    control_from_receiver: bool = False
    energise: float = radians(-5.0)
    release: float = radians(70.0)
    open_target: float = radians(-5.0)
    """Of the ideal valve."""
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


def intake_lift(engine, angle, position):
    """Lift of the valve or the cam [m]."""
    if engine.intake == "epv":
        return engine.valve.stroke - position
    return engine.cam_lift * opened(angle, engine.cam)


def intake_area(engine, angle, position):
    """Effective area between receiver and cylinder [m2]."""
    if engine.intake != "ideal":
        return groove_area(engine, intake_lift(engine, angle, position))
    inside = (angle - engine.open_target) % TURN < engine.close_target - engine.open_target
    return groove_area(engine, engine.valve.stroke) if inside else 0.0


def engine_supply(engine):
    """Pressure [Pa abs] and temperature [K] of the air that the regulator feeds to the engine."""
    pressure = engine.valve.supply_pressure if engine.intake_pressure is None else engine.intake_pressure
    return pressure, engine.valve.supply_temperature


def now_of(engine, angle, y):
    """What terms see of a state; shape (STATES,)."""
    y = y.tolist()
    receiver = engine_supply(engine)
    if not isinf(engine.receiver_volume):
        receiver = y[RECEIVER_PRESSURE], y[RECEIVER_TEMPERATURE]
    control = engine.valve.supply_pressure, engine.valve.supply_temperature
    return Now(
        y[0],
        y[1],
        (y[2], y[3]),
        (y[4], y[5]),
        receiver if engine.control_from_receiver else control,
        receiver,
        (y[CYLINDER_PRESSURE], y[CYLINDER_TEMPERATURE]),
        *cylinder_volume(engine, angle),
        angle,
    )


def rates_of(engine, speed):
    """The function of crank angle, state and phase that gives the rates of the states over crank angle."""
    valve = engine.valve
    ambient, supply = (valve.ambient_pressure, valve.ambient_temperature), engine_supply(engine)
    slowest = valve.dead_time + valve.ramp_time + max(valve.delay_a, valve.delay_b)
    past = int(slowest * speed / TURN) + 1
    edges = [
        ((at + turn * TURN - engine.energise) / speed, sign)
        for turn in range(-past, 1)
        for at, sign in ((engine.energise, 1.0), (engine.release, -1.0))
    ]

    def rates(angle, y, phase):
        now = now_of(engine, angle, y)
        sums = sums_of(valve.terms, now)
        motion, drawn = [0.0] * CYLINDER_PRESSURE, (0.0, 0.0)
        if engine.intake == "epv":
            since = (angle - engine.energise) / speed
            x_a, x_b = (energised(valve, edges, delay, since) for delay in (valve.delay_a, valve.delay_b))
            motion, drawn = valve_rates(valve, now, sums, phase, x_a, x_b)
        groove, carried = inflow(valve, intake_area(engine, angle, now.position), now.cylinder, now.receiver)
        back, back_carried = inflow(valve, engine.exhaust_area * opened(angle, engine.exhaust), now.cylinder, ambient)
        cylinder = gas_rates(
            valve,
            now.cylinder,
            now.volume,
            now.slope * speed,
            groove + back + sums[MASS_CYLINDER],
            carried + back_carried + sums[HEAT_CYLINDER],
        )
        receiver = [0.0, 0.0]
        if not isinf(engine.receiver_volume):
            mass, heat = inflow(valve, engine.feed_area, now.receiver, supply)
            share = float(engine.control_from_receiver)
            mass += sums[MASS_RECEIVER] - groove - share * drawn[0]
            heat += sums[HEAT_RECEIVER] - carried - share * drawn[1]
            receiver = gas_rates(valve, now.receiver, engine.receiver_volume, 0.0, mass, heat)
        power = (now.cylinder[0] - valve.ambient_pressure) * now.slope * speed
        return [rate / speed for rate in (*motion, *cylinder, *receiver, power, groove, drawn[0])]

    return rates


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
