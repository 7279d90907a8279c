"""What sensors see: channels of a run over its recorded times or crank angles, with the errors of the sensors."""

from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from .crank import TURN
from .engine import CYLINDER_PRESSURE, STATES
from .periodic import results
from .valve import POSITION, PRESSURE_A, PRESSURE_B

ROWS = {"pressure_a": PRESSURE_A, "pressure_b": PRESSURE_B, "cylinder_pressure": CYLINDER_PRESSURE}
TRACES = ("lift", *ROWS)
MEANS = ("torque", "air_flow")
FINE = 5e-6
"""Time step at which a lagging sensor is followed [s]."""
SETTLED = 5.0
"""Time constants after which a lag over crank angle has forgotten where it began, in turns at least one."""


class Sensors(NamedTuple):
    """Errors of the sensors."""

    lift_lag: float = 0.0
    """First order [s]."""
    pressure_lag: float = 0.0
    """Lag of all pressures [s]."""
    gains: dict = {}  # noqa: RUF012 - never changed
    """Shares by which a channel reads more, by channel."""
    offsets: dict = {}  # noqa: RUF012 - never changed
    """What a channel reads more, SI, by channel."""
    time_zero: float = 0.0
    """Time by which recorded times lie late [s]."""
    tdc_error: float = 0.0
    """Angle by which recorded crank angles lie late [rad]."""
    speed_ripple: float = 0.0
    """Share of the swing of the crank's speed over a turn; angles are recorded as equal steps of time."""


def bench_channels(bench, run, times, sensors, wanted):
    """What is recorded of a run of a bench.

    Parameters
    ----------
    bench : truth.simulator.valve.Bench
    run : truth.simulator.valve.Run
    times : (n,) float array
        As recorded, since the energising; what lies before is at rest [s].
    sensors : Sensors
    wanted : sequence of str

    Returns
    -------
    dict of (n,) float array
        SI, by channel.
    """
    end = run.march.x
    lags = [lag for lag in (sensors.lift_lag, sensors.pressure_lag) if lag]
    true = np.clip(times - sensors.time_zero, 0.0, end)
    grid = np.arange(0.0, end + FINE, FINE).clip(max=end) if lags else None
    states = run.states(grid if lags else true)
    found = {}
    for name in wanted:
        trace = bench.stroke - states[POSITION] if name == "lift" else states[ROWS[name]]
        if lags:
            trace = np.interp(true, grid, lagging(trace, lag_of(sensors, name), FINE))
        found[name] = read(sensors, name, trace)
    return found


def engine_channels(run, angles, sensors, wanted):
    """What is recorded of an engine's periodic cycle.

    Parameters
    ----------
    run : truth.simulator.periodic.Periodic
    angles : (n,) float array
        As recorded, any turn [rad].
    sensors : Sensors
    wanted : sequence of str
        Traces and means.

    Returns
    -------
    dict of (n,) float array or float
        SI, by channel; torque is the brake's, air flow all air that the machine takes [kg/s].
    """
    engine, speed = run.engine, run.speed
    true = true_angles(angles - sensors.tdc_error, sensors.speed_ripple)
    lags = [lag for lag in (sensors.lift_lag, sensors.pressure_lag) if lag]
    n = int(TURN / (FINE * speed))
    grid = np.arange(n) * TURN / n
    states = cycle_states(run, grid if lags else true)
    found = {}
    for name in wanted:
        if name in MEANS:
            continue
        trace = engine.valve.stroke - states[POSITION] if name == "lift" else states[ROWS[name]]
        if lags:
            step = TURN / (n * speed)
            turns = 1 + int(np.ceil(SETTLED * max(lags) / (n * step)))
            trace = lagging(np.tile(trace, turns), lag_of(sensors, name), step)[-n:]
            trace = np.interp(true, grid, trace, period=TURN)
        found[name] = read(sensors, name, trace)
    means = {} if set(MEANS).isdisjoint(wanted) else results(run)
    for name in set(MEANS) & set(wanted):
        air = means["engine_air"] + means["control_air"]
        found[name] = read(sensors, name, means["brake_torque"] if name == "torque" else air * speed / TURN)
    return found


def cycle_states(run, angles):
    """States of a periodic cycle at angles of any turn; shape (states, n)."""
    start = run.engine.energise
    return run.march.states(start + (np.asarray(angles) - start) % TURN)[:STATES]


def true_angles(angles, ripple):
    """Crank angles at equal steps of time, the crank's speed being its mean times 1 + ripple sin(angle).

    The mean is that over time, and recorded and true angle agree at 0.
    """
    if not ripple:
        return angles
    # Separation of variables: tan(angle/2) + ripple = root tan(root c/2 t + const); root = sqrt(1 - ripple^2).
    root = np.sqrt(1.0 - ripple**2)
    turns = np.floor((angles + np.pi) / TURN)
    within = angles - turns * TURN
    start = np.arctan(ripple / root)
    half = 0.5 * within + start
    true = 2.0 * np.arctan2(root * np.sin(half) - ripple * np.cos(half), np.cos(half))
    return true + TURN * turns + TURN * np.round((within - true) / TURN)


def lag_of(sensors, name):
    """Time constant of a channel [s]."""
    return sensors.lift_lag if name == "lift" else sensors.pressure_lag


def lagging(trace, lag, step):
    """A trace in steps of time, behind a lag of first order that began settled; linear between the samples."""
    if not lag:
        return trace
    kept = np.exp(-step / lag)
    mean = (1.0 - kept) * lag / step
    return lfilter([1.0 - mean, mean - kept], [1.0, -kept], trace, zi=[trace[0] * mean])[0]


def read(sensors, name, value):
    """A channel's reading of a true value."""
    return (1.0 + sensors.gains.get(name, 0.0)) * value + sensors.offsets.get(name, 0.0)
