"""Delays of the valve on its bench, from rest: the shortcut that takes them for those in the engine."""

from typing import NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.valve.bench import run_bench
from apesim.valve.groove import area_table, lap_of

PULSE = 0.2
"""Time for which the solenoids are energised: long enough for the chambers to come to rest before the release [s]."""


class Delays(NamedTuple):
    """Delays of the valve: from a command to the lift's passage through the lap."""

    opening: float
    """Time from the energising until the lift rises through the lap [s]; NaN where it never does."""
    closing: float
    """Time from the release until the lift falls through the lap [s]; NaN where it never does."""


def lap_of_machine(machine: Machine) -> float:
    """Find the lap of a machine's valve [m]: the lift at which its groove begins to open.

    >>> round(1e3 * lap_of_machine(Machine()), 3)  # [mm]
    1.0
    """
    return lap_of(area_table(machine.groove, machine.valve.stroke))


def open_loop_delays(machine: Machine) -> Delays:
    """Find the delays [s] of a single stroke of the valve from rest, on its bench.

    The solenoids are energised for `PULSE`.

    >>> delays = open_loop_delays(Machine())
    >>> f"{1e3 * delays.opening:.2f} ms, {1e3 * delays.closing:.2f} ms"
    '6.73 ms, 10.84 ms'
    """
    from scipy.interpolate import CubicHermiteSpline  # here, as it would add a third to the time of each start

    run = run_bench(machine, PULSE)
    above = run.trace[:, 0] - lap_of_machine(machine)
    speed = run.trace[:, 1]
    rises = np.flatnonzero((above[:-1] < 0.0) & (above[1:] >= 0.0) & (run.times[1:] <= PULSE))
    falls = np.flatnonzero((above[:-1] >= 0.0) & (above[1:] < 0.0) & (run.times[:-1] >= PULSE))

    def passage(samples: np.ndarray) -> float:
        if not len(samples):
            return float("nan")
        here = slice(samples[0], samples[0] + 2)
        return float(CubicHermiteSpline(run.times[here], above[here], speed[here]).roots(extrapolate=False)[0])

    return Delays(passage(rises), passage(falls) - PULSE)
