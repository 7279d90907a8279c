"""The largest time shift at equal lift between a measured run and its simulation.

The EPV paper (doi 10.1631/jzus.A0820373) judges its model by it.
"""

from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from apesim.studies.identify.simulation import machine_for
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import predict

if TYPE_CHECKING:
    from apesim.studies.identify.fit import Identified

FLIGHT = 0.1, 0.9
"""Shares of the stroke between which the piston counts as in flight."""


def find_time_shift(identified: "Identified", run: MeasuredRun) -> dict[str, Any]:
    """Find the largest time shift at equal lift between a measured run and its simulation, while the piston flies.

    The dict holds ``run``, ``time_shift_s``, positive where the measured piston is later, and ``noise_limit_s``, what
    noise alone exceeds in one of twenty such runs; both NaN where nothing flies or lift is not measured.
    """
    machine = machine_for(identified, run)
    shifts, noises = [np.empty(0)], [np.empty(0)]
    if "lift" in run.channels:
        known, stroke = identified.noise.get("lift"), machine.valve.stroke
        deviation = known[0.0].deviation if known else 0.0
        times = np.arange(0.0, float(run.times[-1]), 1e-5)
        lift = predict(machine, run._replace(times=times), ("lift",)).channels["lift"]
        measured = run.channels["lift"]
        is_measured = ~np.isnan(measured)
        for start, end, sign in ((0.0, run.pulse, 1.0), (run.pulse, inf, -1.0)):
            flights: list[tuple[np.ndarray, np.ndarray]] = []
            for t, values in ((times, lift), (run.times[is_measured], measured[is_measured])):
                within = (t >= start) & (t < end)
                flights.append((t[within], (values if sign > 0.0 else stroke - values)[within] / stroke))
            shift, noise = _shifts(*flights[0], *flights[1], deviation / stroke)
            shifts.append(shift)
            noises.append(noise)
    shift, noise = np.concatenate(shifts), np.concatenate(noises)
    if not len(shift):
        return {"run": run.data, "time_shift_s": np.nan, "noise_limit_s": np.nan}
    return {"run": run.data, "time_shift_s": float(shift[np.argmax(np.abs(shift))]), "noise_limit_s": _largest(noise)}


def _shifts(
    simulated_times: np.ndarray, simulated: np.ndarray, times: np.ndarray, measured: np.ndarray, deviation: float
) -> tuple[np.ndarray, np.ndarray]:
    """Shifts of the samples in flight, and the standard deviation of each; travel and noise as shares of the stroke."""
    none = np.empty(0), np.empty(0)
    if not len(simulated) or not len(measured) or max(simulated[0], measured[0]) > FLIGHT[0]:
        return none
    highest = np.maximum.accumulate(simulated)
    first = np.append(True, np.diff(highest) > 0.0)
    levels, at = highest[first], simulated_times[first]
    if len(levels) < 3:
        return none
    speed = np.maximum(np.gradient(levels, at), 1e-3)
    flying = (measured >= FLIGHT[0]) & (measured <= min(FLIGHT[1], levels[-1]))
    flying[np.argmax(measured) :] = False
    level = measured[flying]
    return times[flying] - np.interp(level, levels, at), deviation / np.interp(level, levels, speed)


def _largest(deviations: np.ndarray) -> float:
    """What the largest of independent normal deviates of these standard deviations exceeds in one of twenty cases."""
    from scipy.optimize import brentq
    from scipy.special import erf

    widest = deviations.max()
    if widest == 0.0:
        return 0.0
    held = deviations[deviations > 0.0] * np.sqrt(2.0)
    return brentq(lambda x: np.sum(np.log(erf(x / held))) - np.log(0.95), 0.1 * widest, 20.0 * widest)
