"""Optional physics: each function makes a term that adds to the balances of `truth.valve`.

A term is called with `truth.valve.Now` and the list of sums, and is handed to a bench in its ``terms``. What only
changes a number - a delay, an area, a mass - is no term but another value of `truth.valve.Bench` or
`truth.engine.Engine`; dry friction and restitution change the piston's phases and stand there.
"""

from math import pi

from truth.gas import inflow
from truth.valve import HEAT_A, HEAT_B, HEAT_CYLINDER, MASS_A, MASS_B, MASS_CYLINDER


def ring_leakage(air, area):
    """An orifice [m2] between the chambers; air as in `truth.gas.inflow`."""

    def term(now, sums):
        mass, heat = inflow(air, area, now.b, now.a)
        sums[MASS_A] -= mass
        sums[HEAT_A] -= heat
        sums[MASS_B] += mass
        sums[HEAT_B] += heat

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
