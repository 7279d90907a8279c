"""Physics that is in no library, and clutter: what a good model leaves out as small.

Each entry is drawn into a function of a rig and a share of its largest size, which gives the rig with it.
"""

from math import exp, pi, sin, tanh
from typing import NamedTuple

from tests.truth.simulator.gas import REAL_AIR, capacity
from tests.truth.simulator.terms import force

from .library import ENGINE, VALVE


class Foreign(NamedTuple):
    """Physics without a name in the library."""

    draw: object
    """Function of a random generator: it gives the function of rig and share."""
    benches: tuple = (VALVE, ENGINE)


def viscoelastic_spring(rng):
    """Springs that creep: a part of their rate relaxes within milliseconds."""
    relaxation = rng.uniform(2e-3, 8e-3)
    return lambda rig, share: rig.valve(creep=(share * rig.engine.valve.spring_rate, relaxation))


def line_pulsation(rng):
    """The supply line rings after each switch."""
    frequency, fading = rng.uniform(90.0, 220.0), rng.uniform(8e-3, 20e-3)

    def swing(share):
        return lambda t: 0.3 * share * exp(-t / fading) * sin(2.0 * pi * frequency * t)

    return lambda rig, share: rig.valve(swing=swing(share))


def warm_viscosity(rng):
    """Oil that thins as the chambers' air warms it."""
    thinning = rng.uniform(0.015, 0.03)

    def add(rig, share):
        valve = rig.engine.valve

        def of(now):
            warmth = 0.5 * (now.a[1] + now.b[1]) - valve.supply_temperature
            return -valve.viscous_friction * (exp(-share * thinning * warmth) - 1.0) * now.speed

        return rig.term(force(of))

    return add


def second_order_solenoid(rng):
    """Plungers with inertia: a critically damped rise of the same mean delay in place of the ramp."""

    def add(rig, share):
        ramp = rig.engine.valve.ramp_time

        def rise(t):
            z = 4.0 * t / ramp
            return (1.0 - share) * min(1.0, t / ramp) + share * (1.0 - (1.0 + z) * exp(-z))

        return rig.valve(rise=rise)

    return add


def snag(rng):
    """A ring that catches at an edge somewhere along the travel."""
    at, width = rng.uniform(0.25, 0.75), rng.uniform(0.15e-3, 0.4e-3)

    def add(rig, share):
        middle = at * rig.engine.valve.stroke

        def rub(now):
            held = 60.0 * share * exp(-(((now.position - middle) / width) ** 2))
            return held, held

        return rig.rubbing(rub)

    return add


def progressive_spring(rng):
    """Springs that stiffen towards the ends of the travel."""
    steep = int(rng.choice([3, 5]))

    def add(rig, share):
        half = 0.5 * rig.engine.valve.stroke
        return rig.term(force(lambda now: 15.0 * share * (1.0 - now.position / half) ** steep))

    return add


def exhaust_pulsation(rng):
    """A resonant exhaust pipe."""
    order, phase = int(rng.choice([3, 4, 5])), rng.uniform(0.0, 2.0 * pi)
    return lambda rig, share: rig.of_engine(exhaust_swing=lambda angle: 0.3 * share * sin(order * angle + phase))


def crevice(rng):
    """A volume beside the cylinder that air enters and leaves, cooled or warmed on its way."""
    volume = rng.uniform(4e-6, 8e-6)
    return lambda rig, share: rig.of_engine(crevice=share * volume)


FOREIGN = {
    "viscoelastic_spring": Foreign(viscoelastic_spring),
    "line_pulsation": Foreign(line_pulsation),
    "warm_viscosity": Foreign(warm_viscosity),
    "second_order_solenoid": Foreign(second_order_solenoid),
    "snag": Foreign(snag),
    "progressive_spring": Foreign(progressive_spring),
    "exhaust_pulsation": Foreign(exhaust_pulsation, (ENGINE,)),
    "crevice": Foreign(crevice, (ENGINE,)),
}


def real_air(rng):
    """Heat capacities that vary with temperature."""

    def add(rig, share):
        valve = rig.engine.valve
        constant = capacity(valve, valve.supply_temperature)
        a, b, c = REAL_AIR
        return rig.valve(heat_capacity=((1.0 - share) * constant + share * a, share * b, share * c))

    return add


def elastic_stops(rng):
    """Rubber on both stops: another law of contact."""
    depth = rng.uniform(0.05e-3, 0.15e-3)

    def add(rig, share):
        stroke = rig.engine.valve.stroke

        def of(now):
            open_side, closed_side = (max(0.0, 1.0 - d / depth) for d in (now.position, stroke - now.position))
            return 60.0 * share * (open_side**1.5 - closed_side**1.5)

        return rig.term(force(of))

    return add


def bent_friction(rng):
    """Viscous friction of another power of the speed, or a little dry friction without any phase of rest."""
    if rng.integers(2):
        return lambda rig, share: rig.term(force(lambda now: -3.0 * share * tanh(now.speed / 0.02)))
    power = rng.choice([-0.2, 0.2])

    def add(rig, share):
        friction = rig.engine.valve.viscous_friction

        def of(now):
            return -friction * now.speed * ((abs(now.speed) + 1e-6) ** (share * power) - 1.0)

        return rig.term(force(of))

    return add


CLUTTER = {"real_air": real_air, "elastic_stops": elastic_stops, "bent_friction": bent_friction}
"""Clutter by name, drawn like `Foreign.draw`."""
