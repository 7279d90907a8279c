"""Phases of a stroke and of a cycle, and where in signals and phases a gap lies."""

from math import isnan

import numpy as np

from tests.truth.simulator.crank import TURN
from tests.truth.simulator.periodic import results
from tests.truth.simulator.sensors import MEANS

from .library import ENGINE
from .observation import at_point

DEAD_TIME, OPENING, IMPACT, DWELL, CLOSING = "dead time", "opening flight", "impact", "dwell", "closing flight"
CHARGING, EXPANSION, EXHAUST = "charging", "expansion", "exhaust"
CONTACT = 3e-3
"""How long a contact lasts [s]."""


def stroke_phases(times, command, start, contact, flight):
    """Phases from a command on; NaN: it does not come to it.

    Returns
    -------
    (n,) array of str
    """
    start, contact = (np.inf if isnan(at) else at for at in (start, contact))
    return np.select(
        [times < command, times < start, times < contact, times < contact + CONTACT],
        ["", DEAD_TIME, flight, IMPACT],
        DWELL,
    )


def bench_phases(run, point, grid):
    """Phase of each sample of a bench's run."""
    strokes = []
    for command, stroke in ((0.0, run.opening), (point.pulse, run.closing)):
        start = command + stroke.delay
        strokes.append((command, start, start + stroke.stroke_time))
    opening = stroke_phases(grid.clip(min=0.0), *strokes[0], OPENING)
    closing = stroke_phases(grid, *strokes[1], CLOSING)
    return np.where(closing == "", opening, closing)


def engine_phases(run, channel, grid):
    """Phase of each sample of a channel of an engine's cycle."""
    engine, found = run.engine, results(run)
    if channel == "cylinder_pressure":
        after = (grid - found["opens"]) % TURN
        opens = engine.exhaust[0]
        exhaust = (grid - opens) % TURN < (found["opens"] - opens) % TURN  # recompression, too
        return np.select([after < found["closes"] - found["opens"], exhaust], [CHARGING, EXHAUST], EXPANSION)
    after, release = (grid - engine.energise) % TURN, engine.release - engine.energise
    starts = [engine.valve.stroke * share for share in (0.99, 0.01)]
    angles = np.arange(0.0, TURN, 1e-3)
    position = run.march.states(engine.energise + angles)[0]
    opening = next(iter(angles[position < starts[0]]), np.nan)
    closing = next(iter(angles[(angles > release) & (position > starts[1])]), np.nan)
    full, closed = found["full_open"] - engine.energise, found["closed"] - engine.energise
    times = after / run.speed
    first = stroke_phases(times, 0.0, opening / run.speed, full / run.speed, OPENING)
    second = stroke_phases(times, release / run.speed, closing / run.speed, closed / run.speed, CLOSING)
    return np.where(second == "", first, second)


def gap_shares(lab, nominal, points, left):
    """Shares of a gap by signal and phase, largest first.

    Parameters
    ----------
    lab : truth.sealed.observation.Laboratory
    nominal : truth.simulator.effects.Rig
    points : sequence of Point
    left : float array
        The gap of each sample over its noise, as `Laboratory.deviations` orders them.

    Returns
    -------
    list of dict
    """
    shares, at = {}, 0
    for point in points:
        grid = lab.setting.grid(point)
        run = lab.nominal(at_point(nominal, point), point)
        for name in lab.setting.channels:
            if name in MEANS:
                phases = np.array([""])
            elif lab.setting.bench == ENGINE:
                phases = engine_phases(run, name, grid)
            else:
                phases = bench_phases(run, point, grid)
            energy = left[at : at + len(phases)] ** 2
            at += len(phases)
            for phase in np.unique(phases):
                key = name, str(phase)
                shares[key] = shares.get(key, 0.0) + float(energy[phases == phase].sum())
    whole = sum(shares.values()) or 1.0
    ordered = sorted(shares.items(), key=lambda item: -item[1])
    return [{"signal": name, "phase": phase, "share": share / whole} for (name, phase), share in ordered]
