"""Vessels with a wall, emptied through a valve by their balances of mass and energy, without the code under test."""

from functools import cache
from itertools import pairwise
from math import inf, sqrt

import numpy as np
from scipy.integrate import solve_ivp

from apesim.studies.discharge import Record
from tests.machines import AMBIENT

R, K, ROOM = 287.05, 1.4, 293.15
FULL = 9e-6
"""Effective area of the open valve [m2]."""
DEAD, RAMP = 1.5e-3, 1.5e-3
"""Time until the valve begins to open, and until it is open then [s]."""


def ramp(time, closes=inf, leak=1e-6):
    """Effective area [m2]; of a valve that closes again, and leaks then."""
    return FULL * min(max((time - DEAD) / RAMP, 0.0), 1.0) if time < closes else leak


def psi(ratio):
    """Eq. 8 of doi 10.1631/jzus.A0820373."""
    ratio = max(ratio, (2.0 / (K + 1.0)) ** (K / (K - 1.0)))
    return sqrt(max(2.0 * K / (K - 1.0) * (ratio ** (2.0 / K) - ratio ** ((K + 1.0) / K)), 0.0))


@cache
def warm(volume, conductance, initial, end, rate, closes=inf, capacity=inf, nozzle=psi):
    """Times [s] and pressures [Pa abs] of a vessel [m3] whose wall [W/K, J/K] gives heat to the gas."""

    def slopes(time, state):
        mass, energy, wall = state
        temperature = energy * (K - 1.0) / (mass * R)
        pressure = mass * R * temperature / volume
        out = ramp(time, closes) * nozzle(min(AMBIENT / pressure, 1.0)) * pressure / sqrt(R * temperature)
        heat = conductance * (wall - temperature)
        return -out, heat - out * K / (K - 1.0) * R * temperature, -heat / capacity

    times = np.arange(-round(0.05 * rate), round(end * rate) + 1) / rate
    state = (initial * volume / (R * ROOM), initial * volume / (K - 1.0), ROOM)
    pressures = [np.full(np.sum(times <= 0.0), initial)]
    corners = [0.0, *(corner for corner in (DEAD, DEAD + RAMP, closes) if corner < end), end]
    for start, stop in pairwise(corners):
        instants = times[(times > start) & (times <= stop)]
        exact = {"rtol": 1e-8, "atol": 1e-12, "method": "LSODA"}
        # The right-hand side just before the corner, or a valve that closes would close within a step.
        solution = solve_ivp(slopes, (start, stop * (1.0 - 1e-12)), state, dense_output=True, **exact)
        state = solution.y[:, -1]
        pressures.append(solution.sol(np.minimum(instants, stop * (1.0 - 1e-12)))[1] * (K - 1.0) / volume)
    return times, np.concatenate(pressures)


def record_of(volume, conductance, initial, end, rate=1e3, noise=500.0, seed=0, **options):
    """Record of a discharge test with noise [Pa]."""
    times, pressures = warm(volume, conductance, initial, end, rate, **options)
    name = f"p{initial / 1e4:03.0f}.csv"
    return Record(name, times, pressures + noise * np.random.default_rng(seed).standard_normal(len(times)))
