"""Optional physics: each function makes a term that adds to the balances of `truth.simulator.valve`, or a dry friction.

A term is called with `truth.simulator.valve.Now` and the list of sums, and is handed to a bench in its ``terms``; a dry
friction is called with `Now`, gives the friction under way and at rest [N], and stands in ``rubbing``. What only
changes a number - a delay, an area, a mass - is no term but another value of `truth.simulator.valve.Bench` or
`truth.simulator.engine.Engine`.
"""

from math import exp, pi, sqrt

from .gas import inflow
from .valve import FORCE, HEAT_A, HEAT_B, HEAT_CYLINDER, MASS_A, MASS_B, MASS_CYLINDER


def ring_leakage(air, area):
    """An orifice [m2] between the chambers; air as in `truth.simulator.gas.inflow`."""

    def term(now, sums):
        mass, heat = inflow(air, area, now.b, now.a)
        sums[MASS_A] -= mass
        sums[HEAT_A] -= heat
        sums[MASS_B] += mass
        sums[HEAT_B] += heat

    return term


def leakage(air, area, chamber):
    """An orifice [m2] between a chamber, a or b, and ambient."""
    ambient = air.ambient_pressure, air.ambient_temperature
    mass_in, heat_in = (MASS_A, HEAT_A) if chamber == "a" else (MASS_B, HEAT_B)

    def term(now, sums):
        mass, heat = inflow(air, area, now.a if chamber == "a" else now.b, ambient)
        sums[mass_in] += mass
        sums[heat_in] += heat

    return term


def blow_by(air, area):
    """An orifice [m2] between cylinder and ambient."""
    ambient = air.ambient_pressure, air.ambient_temperature

    def term(now, sums):
        mass, heat = inflow(air, area, now.cylinder, ambient)
        sums[MASS_CYLINDER] += mass
        sums[HEAT_CYLINDER] += heat

    return term


def wall_heat(bore, h, wall):
    """Heat from walls of a temperature [K] over two piston areas and the liner, by a constant h [W/(m2 K)]."""

    def term(now, sums):
        area = 0.5 * pi * bore**2 + 4.0 * now.volume / bore
        sums[HEAT_CYLINDER] += h * area * (wall - now.cylinder[1])

    return term


def chamber_heat(valve, h, wall):
    """Heat from the walls of both chambers, round ones of the piston's area, by a constant h [W/(m2 K)]."""
    girth, ends = sqrt(4.0 * pi * valve.piston_area), 2.0 * valve.piston_area
    spare = valve.clearance_volume / valve.piston_area

    def term(now, sums):
        sums[HEAT_A] += h * (ends + girth * (spare + now.position)) * (wall - now.a[1])
        sums[HEAT_B] += h * (ends + girth * (spare + valve.stroke - now.position)) * (wall - now.b[1])

    return term


def force(of):
    """A force to closed [N], a function of `Now`."""

    def term(now, sums):
        sums[FORCE] += of(now)

    return term


def cushion(stroke, damping, length):
    """A force towards the open middle that grows with speed and over the last length [m] before the stop ahead."""

    def of(now):
        left = stroke - now.position if now.speed > 0.0 else now.position
        return -damping * now.speed * max(0.0, 1.0 - left / length)

    return force(of)


def stribeck(extra, fading):
    """Dry friction [N] that fades with speed [m/s]."""
    return lambda now: (extra * exp(-((now.speed / fading) ** 2)), extra)


def pressed(coefficient, ambient):
    """Dry friction of seals that the chambers' gauge pressures press on [N/Pa, Pa abs]."""

    def rub(now):
        pressing = coefficient * (abs(now.a[0] - ambient) + abs(now.b[0] - ambient))
        return pressing, pressing

    return rub
