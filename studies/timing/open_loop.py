"""The shortcut: delays of the valve on its bench, from rest, as if the engine could not change them."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from apesim.valve.bench import run_bench
from apesim.valve.groove import area_table, lap_of

PULSE = 0.2
"""Long enough for the chambers to come to rest before the release [s]."""


class Delays(NamedTuple):
    """From a command to the lift's passage through the lap; NaN where it never comes to it."""

    opening: float
    """[s]"""
    closing: float
    """[s]"""


def lap_of_machine(machine):
    """Lift at which the groove begins to open [m]."""
    return lap_of(area_table(machine.groove, machine.valve.stroke))


def open_loop_delays(machine):
    """Delays of a single stroke from rest, on the bench.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine

    Returns
    -------
    Delays
    """
    run = run_bench(machine, PULSE)
    above = run.trace[:, 0] - lap_of_machine(machine)
    speed = run.trace[:, 1]
    rises = np.flatnonzero((above[:-1] < 0.0) & (above[1:] >= 0.0) & (run.times[1:] <= PULSE))
    falls = np.flatnonzero((above[:-1] >= 0.0) & (above[1:] < 0.0) & (run.times[:-1] >= PULSE))

    def passage(found):
        if not len(found):
            return float("nan")
        here = slice(found[0], found[0] + 2)
        return float(CubicHermiteSpline(run.times[here], above[here], speed[here]).roots(extrapolate=False)[0])

    return Delays(passage(rises), passage(falls) - PULSE)
