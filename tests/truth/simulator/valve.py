"""The electro-pneumatic valve, alone on its bench, after Eqs. 1-8 of doi 10.1631/jzus.A0820373.

The chambers are pressures and temperatures, the solver is LSODA with root finding; the march restarts at each corner
of the solenoids' ramp and wherever the piston meets or leaves a stop. Imports nothing from the packages it judges.
"""

from collections.abc import Callable
from math import sqrt
from typing import NamedTuple

import numpy as np

from .gas import gas_rates, inflow
from .march import RELATIVE, March, march
from .piston import CLOSED, CLOSING, DIRECTION, OPEN, OPENING

POSITION, SPEED, PRESSURE_A, TEMPERATURE_A, PRESSURE_B, TEMPERATURE_B = range(6)
ABSOLUTE = np.array([1e-13, 1e-10, 1e-4, 1e-7, 1e-4, 1e-7])
LONGEST = 0.5e-3
"""Step [s]."""
APART = 1e-12
"""Corners nearer to one another than this are one [s]."""
FORCE, MASS_A, HEAT_A, MASS_B, HEAT_B, MASS_CYLINDER, HEAT_CYLINDER, MASS_RECEIVER, HEAT_RECEIVER, SUMS = range(10)
"""What optional terms add to: a force to closed [N]; mass [kg/s], and heat with enthalpy [W], into a volume."""


class Bench(NamedTuple):
    """The valve, its air and its command; SI, absolute pressures."""

    supply_pressure: float = 1.101325e6
    supply_temperature: float = 287.0
    ambient_pressure: float = 101325.0
    ambient_temperature: float = 293.15
    gas_constant: float = 287.05
    heat_capacity_ratio: float = 1.4
    stroke: float = 9e-3
    moving_mass: float = 0.1145
    piston_area: float = 1134.1e-6
    clearance_volume: float = 11382e-9
    spring_rate: float = 1828.0
    viscous_friction: float = 111.08
    effective_area: float = 9e-6
    dead_time: float = 1.5e-3
    ramp_time: float = 1.5e-3
    delay_a: float = 0.0
    """Delay of solenoid A, besides the dead time [s]."""
    delay_b: float = 0.0
    release_delay: float = 0.0
    """Delay of both solenoids as they are released, besides all other delays [s]."""
    release_ramp_time: float | None = None
    """Time after a release; None: as long as that of energising [s]."""
    dry_friction: float = 0.0
    """Under way [N]."""
    breakaway: float = 0.0
    """At rest; at least the dry friction [N]."""
    restitution: float = 0.0
    terms: tuple = ()
    """Optional, see `truth.simulator.terms`."""
    rubbing: tuple = ()
    """Dry friction that varies: functions of `Now` that give it under way and at rest [N]."""
    heat_capacity: tuple = ()
    """Heat capacity of the air, see `truth.simulator.gas.inflow`; in place of the ratio."""
    vent_excess: float = 0.0
    """Pressure behind the vents above the ambient's [Pa]."""
    stretch: float = 1.0
    """Stretch of the solenoids, see `truth.simulator.gas.inflow`."""
    fall: float = 0.0
    """Share by which the solenoids' area is smaller at equal pressures than towards a vacuum."""
    line_volume: float = 0.0
    """Between supply and solenoids; 0: none [m3]."""
    line_area: float = 0.0
    """That feeds it [m2]."""
    rise: Callable | None = None
    """How a solenoid follows an edge, of the time after the dead time [s], in place of the ramp."""
    swing: Callable | None = None
    """Share by which the supply pressure is higher, of the time since an edge [s]; that of all edges adds up."""
    creep: tuple = ()
    """A spring in series with a damper, between piston and case: rate [N/m], relaxation time [s]."""


class Now(NamedTuple):
    """What an optional term sees; a gas is a pair of pressure [Pa abs] and temperature [K]."""

    position: float
    speed: float
    a: tuple
    b: tuple
    supply: tuple
    """Before the solenoids."""
    creep: float = 0.0
    """Force of the spring in series with a damper, to closed [N]."""
    receiver: tuple | None = None
    """Before the groove; None on the bench, like what follows."""
    cylinder: tuple | None = None
    volume: float | None = None
    """Volume of the cylinder [m3]."""
    slope: float | None = None
    """Slope of the cylinder's volume over crank angle [m3/rad]."""
    angle: float | None = None
    """Angle of the crank [rad]."""


class Stroke(NamedTuple):
    """Measures of an opening or a closing; NaN where the motion did not come to it."""

    delay: float
    """Command edge to 1 % of the stroke [s]."""
    stroke_time: float
    """From there to contact with the far stop [s]."""
    seating_speed: float
    """[m/s]"""


class Run(NamedTuple):
    """One run from rest."""

    opening: Stroke
    closing: Stroke
    march: March

    def states(self, times):
        """Position [m], speed [m/s], p [Pa] and T [K] of A, p and T of B at the given times; shape (6, n)."""
        return self.march.states(times)


def release_of(bench, delay):
    """How much later a solenoid lets go than it pulls in, though not before the command, and its ramp then [s]."""
    ramp = bench.ramp_time if bench.release_ramp_time is None else bench.release_ramp_time
    return max(bench.release_delay, -bench.dead_time - delay), ramp


def energised(bench, edges, delay, t):
    """Energised fraction of a solenoid; edges of the command are pairs of time [s] and sign."""
    lag, x = t - bench.dead_time - delay, 0.0
    late, release_ramp = release_of(bench, delay)
    for at, sign in edges:
        since, ramp = (lag, bench.ramp_time) if sign > 0.0 else (lag - late, release_ramp)
        if since > at:
            followed = bench.rise(since - at) if bench.rise else (since - at) / ramp
            x += sign * min(1.0, followed)
    return min(1.0, max(0.0, x))


def supply_at(bench, supply, edges, t):
    """A supply that swings after each edge of the command."""
    if not bench.swing:
        return supply
    return supply[0] * (1.0 + sum(bench.swing(t - at) for at, _ in edges if t > at)), supply[1]


def corners_after(bench, edge):
    """Times at which a solenoid begins and ends to follow an edge of the command, whichever it is [s]."""
    corners = []
    for delay in {bench.delay_a, bench.delay_b}:
        late, release_ramp = release_of(bench, delay)
        for after, ramp in {(0.0, bench.ramp_time), (late, release_ramp)}:
            followed = (bench.dead_time,) if bench.rise else (bench.dead_time, bench.dead_time + ramp)
            corners += [edge + lag + delay + after for lag in followed]
    return corners


def apart(corners):
    """Corners in their order, one for those that are nearer to one another than `APART`."""
    kept = []
    for corner in sorted(corners):
        if not kept or corner - kept[-1] > APART:
            kept.append(corner)
    return kept


def sums_of(terms, now):
    """What all optional terms add; the terms are functions of `Now` and of the list that they add to."""
    sums = [0.0] * SUMS
    for term in terms:
        term(now, sums)
    return sums


def net_force(bench, now, sums):
    """Force on the piston without a stop's and dry friction's, positive to closed (Eq. 1) [N]."""
    return (
        (now.a[0] - now.b[0]) * bench.piston_area
        + bench.spring_rate * (bench.stroke - 2.0 * now.position)
        - bench.viscous_friction * now.speed
        + now.creep
        + sums[FORCE]
    )


def rubbed(bench, now):
    """Dry friction under way and at rest [N]."""
    if not bench.rubbing:
        return bench.dry_friction, max(bench.dry_friction, bench.breakaway)
    both = [rub(now) for rub in bench.rubbing]
    return (
        bench.dry_friction + sum(sliding for sliding, _ in both),
        max(bench.dry_friction, bench.breakaway) + sum(resting for _, resting in both),
    )


def push_of(bench, now):
    """Net force, and what dry friction holds at rest, as `truth.simulator.piston.exits` wants them [N]."""
    return net_force(bench, now, sums_of(bench.terms, now)), rubbed(bench, now)[1]


def through_solenoid(bench, area, gas, outside):
    """Mass [kg/s] and enthalpy [W] into a chamber through a solenoid of an effective area [m2]."""
    mass, heat = inflow(bench, area, gas, outside, bench.stretch)
    if bench.fall:
        share = 1.0 - bench.fall * min(gas[0], outside[0]) / max(gas[0], outside[0])
        return mass * share, heat * share
    return mass, heat


def valve_rates(bench, now, sums, phase, x_a, x_b):
    """Rates of the valve's six states, and the mass [kg/s] and enthalpy [W] that it draws from its supply."""
    vent = bench.ambient_pressure + bench.vent_excess, bench.ambient_temperature
    speed = push = 0.0
    if phase in (OPENING, CLOSING):
        speed = now.speed
        push = net_force(bench, now, sums) - DIRECTION[phase] * rubbed(bench, now)[0]
    swell = bench.piston_area * speed
    rates, drawn = [speed, push / bench.moving_mass], [0.0, 0.0]
    for gas, depth, growth, share, mass, heat in (
        (now.a, now.position, swell, 1.0 - x_a, sums[MASS_A], sums[HEAT_A]),
        (now.b, bench.stroke - now.position, -swell, x_b, sums[MASS_B], sums[HEAT_B]),
    ):
        mass_in, heat_in = through_solenoid(bench, bench.effective_area * share, gas, now.supply)
        mass_out, heat_out = through_solenoid(bench, bench.effective_area * (1.0 - share), gas, vent)
        volume = bench.clearance_volume + bench.piston_area * depth
        rates += gas_rates(bench, gas, volume, growth, mass + mass_in + mass_out, heat + heat_in + heat_out)
        drawn[0] += mass_in
        drawn[1] += heat_in
    return rates, drawn


def further_states(bench, supply):
    """States of line and creep, where there are any, at rest; and their absolute tolerances."""
    line, creep = [*supply] if bench.line_volume else [], [0.0] if bench.creep else []
    return [*line, *creep], [1e-3, 1e-7][: len(line)] + [1e-6] * len(creep)


def further(bench, further, regulated):
    """The air before the solenoids and the force of the creep, from the further states."""
    supply = (further[0], further[1]) if bench.line_volume else regulated
    return supply, further[2 if bench.line_volume else 0] if bench.creep else 0.0


def further_rates(bench, now, drawn, regulated):
    """Rates of the further states, and mass [kg/s] and enthalpy [W] that line and valve draw from what feeds them."""
    rates = []
    if bench.line_volume:
        fed = inflow(bench, bench.line_area, now.supply, regulated)
        rates += gas_rates(bench, now.supply, bench.line_volume, 0.0, fed[0] - drawn[0], fed[1] - drawn[1])
        drawn = fed
    if bench.creep:
        rate, relaxation = bench.creep
        rates.append(-rate * now.speed - now.creep / relaxation)
    return rates, drawn


def closed_at_rest(bench, supply):
    """States of a valve closed and at rest, A at the supply's pressure and B at the vent's."""
    vent = bench.ambient_pressure + bench.vent_excess
    return [bench.stroke, 0.0, supply[0], supply[1], vent, supply[1]]


def simulate(bench, pulse, until, brakes=(), brakes_b=None, relative=RELATIVE):
    """One run from rest, closed, A full and B empty.

    Parameters
    ----------
    bench : Bench
    pulse : float
        Time for which the solenoids are energised, from t = 0 [s].
    until : float
        [s]
    brakes : sequence of float
        Further edges, which interrupt a stroke [s].
    brakes_b : sequence of float, optional
        Those of solenoid B where they are its own [s].
    relative : float
        Tolerance.

    Returns
    -------
    Run
    """
    supply = bench.supply_pressure, bench.supply_temperature
    brakes_b = brakes if brakes_b is None else brakes_b
    edges_a, edges_b = (
        [(edge, (-1.0) ** number) for number, edge in enumerate(sorted((0.0, pulse, *own)))]
        for own in (brakes, brakes_b)
    )
    edges = sorted({edge for edge, _ in edges_a + edges_b})
    corners = [at for edge in edges for at in corners_after(bench, edge)] + edges

    def now(t, y):
        y = y.tolist()
        regulated = supply_at(bench, supply, edges_a, t)
        return Now(y[0], y[1], (y[2], y[3]), (y[4], y[5]), *further(bench, y[6:], regulated)), regulated

    def rates(t, y, phase):
        here, regulated = now(t, y)
        x_a, x_b = energised(bench, edges_a, bench.delay_a, t), energised(bench, edges_b, bench.delay_b, t)
        own, drawn = valve_rates(bench, here, sums_of(bench.terms, here), phase, x_a, x_b)
        return own + further_rates(bench, here, drawn, regulated)[0]

    added, tolerances = further_states(bench, supply)
    found = march(
        bench,
        rates,
        lambda t, y: push_of(bench, now(t, y)[0]),
        [*apart(t for t in corners if 0.0 < t < until - APART), until],
        0.0,
        np.array([*closed_at_rest(bench, supply), *added]),
        CLOSED,
        np.array([*ABSOLUTE, *tolerances]),
        LONGEST,
        (0.99 * bench.stroke, 0.01 * bench.stroke),
        relative,
    )
    opening = stroke(found, 0.0, 0.99 * bench.stroke, -1, OPEN)
    closing = stroke(found, pulse, 0.01 * bench.stroke, 1, CLOSED)
    return Run(opening, closing, found)


def stroke(found, command, start, direction, stop):
    """The first stroke after a command."""
    starts = (one.at for one in found.crossings if (one.position, one.direction) == (start, direction))
    begin = next((t for t in starts if t >= command), np.nan)
    contacts = (one for one in found.contacts if one.stop == stop and one.at >= command)
    at, speed = next(((one.at, one.speed) for one in contacts), (np.nan, np.nan))
    return Stroke(begin - command, at - begin, speed)


def measured_lift(bench, pulse, times, deviation, rng, colour=0.0):
    """What a noisy sensor sees of a run; AR(1) noise of a given standard deviation.

    Parameters
    ----------
    bench : Bench
    pulse : float
        [s]
    times : (n,) float array
        [s]
    deviation : float
        [m]
    rng : numpy.random.Generator
    colour : float
        Correlation of a sample's noise with that of the one before.

    Returns
    -------
    (n,) float array
        [m]
    """
    lift = bench.stroke - simulate(bench, pulse, float(times[-1])).states(times)[POSITION]
    return lift + noise(len(times), deviation, rng, colour)


def noise(n, deviation, rng, colour=0.0):
    """AR(1) noise of a given standard deviation; shape (n,)."""
    from scipy.signal import lfilter

    white = rng.normal(size=n)
    white[1:] *= sqrt(1.0 - colour**2)
    return deviation * lfilter([1.0], [1.0, -colour], white)
