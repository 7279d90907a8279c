"""The electro-pneumatic valve on its bench, after Eqs. 1-8 of doi 10.1631/jzus.A0820373.

The chambers are pressures and temperatures, the solver is LSODA with root finding; the march restarts at each corner
of the solenoids' ramp and wherever the piston meets or leaves a stop. Imports nothing from the packages it judges.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

CLOSED, FLYING, OPEN = "closed", "flying", "open"
POSITION, SPEED, PRESSURE_A, TEMPERATURE_A, PRESSURE_B, TEMPERATURE_B = range(6)
ABSOLUTE = np.array([1e-13, 1e-10, 1e-4, 1e-7, 1e-4, 1e-7])
RELATIVE = 1e-9
PAST = 1e-13
"""Contact counts this far inside a stop, so that a piston that has just left it is not found on it [m]."""
LINEAR_ABOVE = 0.999


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
    pieces: tuple
    """Start [s] and dense solution of each smooth stretch."""

    def states(self, times):
        """Position [m], speed [m/s], p [Pa] and T [K] of A, p and T of B at the given times; shape (6, n)."""
        starts = [start for start, _ in self.pieces]
        which = np.searchsorted(starts, times, side="right") - 1
        found = np.empty((6, len(times)))
        for i in np.unique(which):
            found[:, which == i] = self.pieces[i][1](np.asarray(times)[which == i])
        return found


def energised(bench, pulse, t):
    """Energised fraction of the solenoids."""

    def ramp(lag):
        return min(1.0, max(0.0, (lag - bench.dead_time) / bench.ramp_time))

    return min(1.0, max(0.0, ramp(t) - ramp(t - pulse)))


def flow_function(r, k):
    """psi of Eq. 8, linear above 0.999."""
    if r > LINEAR_ABOVE:
        return flow_function(LINEAR_ABOVE, k) * (1.0 - r) / (1.0 - LINEAR_ABOVE)
    r = max(r, (2.0 / (k + 1.0)) ** (k / (k - 1.0)))
    return sqrt(2.0 * k / (k - 1.0) * (r ** (2.0 / k) - r ** ((k + 1.0) / k)))


def inflow(bench, area, inside, outside):
    """Mass [kg/s] and enthalpy [W] into a chamber through a restriction (Eq. 7); each side is (p, T)."""
    into = outside[0] > inside[0]
    up, down = (outside, inside) if into else (inside, outside)
    k, gas = bench.heat_capacity_ratio, bench.gas_constant
    mass = area * flow_function(down[0] / up[0], k) * up[0] / sqrt(gas * up[1])
    mass = mass if into else -mass
    return mass, mass * k / (k - 1.0) * gas * up[1]


def net_force(bench, y):
    """Force on the piston without a stop's, positive to closed (Eq. 1) [N]."""
    return (
        (y[PRESSURE_A] - y[PRESSURE_B]) * bench.piston_area
        + bench.spring_rate * (bench.stroke - 2.0 * y[POSITION])
        - bench.viscous_friction * y[SPEED]
    )


def rates(bench, pulse, mode, t, y):
    """dy/dt."""
    supply = bench.supply_pressure, bench.supply_temperature
    ambient = bench.ambient_pressure, bench.ambient_temperature
    position, speed, p_a, t_a, p_b, t_b = (float(value) for value in y)
    x = energised(bench, pulse, t)
    dy = [speed, net_force(bench, y) / bench.moving_mass] if mode == FLYING else [0.0, 0.0]
    k, gas, swell = bench.heat_capacity_ratio, bench.gas_constant, bench.piston_area * dy[0]
    for p, warm, depth, growth, share in (
        (p_a, t_a, position, swell, 1.0 - x),
        (p_b, t_b, bench.stroke - position, -swell, x),
    ):
        volume = bench.clearance_volume + bench.piston_area * depth
        mass_in, heat_in = inflow(bench, bench.effective_area * share, (p, warm), supply)
        mass_out, heat_out = inflow(bench, bench.effective_area * (1.0 - share), (p, warm), ambient)
        dp = ((k - 1.0) * (heat_in + heat_out) - k * p * growth) / volume
        mass = p * volume / (gas * warm)
        dy += [dp, warm * (dp / p + growth / volume - (mass_in + mass_out) / mass)]
    return dy


def event(function, direction, terminal=True):
    """A function as solve_ivp wants its events."""
    function.direction, function.terminal = direction, terminal
    return function


def events(bench, mode):
    """What ends a smooth stretch, with the mode that follows; and the crossings of 1 and 99 % of lift."""
    if mode == CLOSED:
        return [event(lambda t, y: net_force(bench, y), -1)], [FLYING]
    if mode == OPEN:
        return [event(lambda t, y: net_force(bench, y), 1)], [FLYING]
    found = [
        event(lambda t, y: y[POSITION] + PAST, -1),
        event(lambda t, y: y[POSITION] - bench.stroke - PAST, 1),
        event(lambda t, y: y[POSITION] - 0.99 * bench.stroke, -1, terminal=False),
        event(lambda t, y: y[POSITION] - 0.01 * bench.stroke, 1, terminal=False),
    ]
    return found, [OPEN, CLOSED]


def simulate(bench, pulse, until):
    """One run from rest, closed, A full and B empty.

    Parameters
    ----------
    bench : Bench
    pulse : float
        Time for which the solenoids are energised, from t = 0 [s].
    until : float
        [s]

    Returns
    -------
    Run
    """
    corners = [edge + lag for edge in (0.0, pulse) for lag in (0.0, bench.dead_time, bench.dead_time + bench.ramp_time)]
    ends = sorted({t for t in corners if 0.0 < t < until} | {until})
    t, mode = 0.0, CLOSED
    warm = bench.supply_temperature
    y = np.array([bench.stroke, 0.0, bench.supply_pressure, warm, bench.ambient_pressure, warm])
    pieces, seen = [], {name: [] for name in ("starts", "ends", OPEN, CLOSED)}
    while t < until:
        end = next(at for at in ends if at > t)
        watched, following = events(bench, mode)
        piece = solve_ivp(
            lambda t, y, mode=mode: rates(bench, pulse, mode, t, y),
            (t, end),
            y,
            method="LSODA",
            rtol=RELATIVE,
            atol=ABSOLUTE,
            max_step=0.5e-3,
            dense_output=True,
            events=watched,
        )
        if piece.status < 0:
            raise ArithmeticError(piece.message)
        pieces.append((t, piece.sol))
        t, y = float(piece.t[-1]), piece.y[:, -1].copy()
        if mode == FLYING:
            seen["starts"] += list(piece.t_events[2])
            seen["ends"] += list(piece.t_events[3])
        if piece.status == 1:
            mode = next(mode for mode, times in zip(following, piece.t_events, strict=False) if len(times))
            if mode != FLYING:
                seen[mode].append((t, abs(float(y[SPEED]))))
                y[POSITION], y[SPEED] = (0.0 if mode == OPEN else bench.stroke), 0.0
    return Run(stroke(0.0, seen["starts"], seen[OPEN]), stroke(pulse, seen["ends"], seen[CLOSED]), tuple(pieces))


def stroke(command, starts, contacts):
    """The first stroke after a command."""
    start = next((t for t in starts if t >= command), np.nan)
    contact, speed = next((pair for pair in contacts if pair[0] >= command), (np.nan, np.nan))
    return Stroke(start - command, contact - start, speed)


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
