"""A cylinder that a drive moves to and fro, one chamber pressurised, as a laboratory would record it.

The motion is that of a drive with a trapezoidal velocity, faster where the pressure helps; the recorder's clock is
uneven. The force follows from the balance of the piston, written down here anew.
"""

from collections.abc import Sequence
from math import pi
from pathlib import Path
from typing import NamedTuple

import numpy as np

HEADER = "time [ms],stroke [mm],pressure [bar gauge],force [N]"
FORMATS = "%.2f", "%.4f", "%.5f", "%.3f"


class Cylinder(NamedTuple):
    """A cylinder on its rig, as it is in truth."""

    bore: float = 25.72e-3
    """[m]"""
    coulomb: float = 0.0
    """Friction that nothing changes [N]."""
    seal: float = 0.0
    """Friction of the seal over the gauge pressure [N/Pa]."""
    viscous: float = 20.0
    """[N s/m]"""
    tare: float = 0.6
    """What the load cell shows without a load [N]."""
    gain: float = 1.002
    """What the load cell shows over the load [-]."""
    travel: float = 60e-3
    """Way between the turning points [m]."""
    pushing: float = 12e-3
    """Speed against the pressure at no pressure [m/s]."""
    returning: float = 15e-3
    """Speed with the pressure [m/s]."""
    yielding: float = 7e-9
    """How much slower the drive pushes with pressure [m/s/Pa]."""
    turning: float = 0.15
    """Time in which the drive stops or starts [s]."""


class Noise(NamedTuple):
    """Standard deviations of the sensors, white."""

    stroke: float = 20e-6
    """[m]"""
    pressure: float = 200.0
    """[Pa]"""
    force: float = 0.4
    """[N]"""


class Record(NamedTuple):
    """A record that is made."""

    bar: float
    """Supply [bar gauge]."""
    role: str
    """What it is there for, as ``measured.toml`` says it."""
    faster: float = 1.0
    """Factor on the speeds of the drive."""


NOISE = Noise()


def find_speeds(cylinder, gauge):
    """Speeds of the drive against the pressure and with it [m/s]."""
    return cylinder.pushing - cylinder.yielding * gauge, cylinder.returning


def time_ways(cylinder, gauge):
    """Times that both ways take [s]."""
    return [cylinder.travel / speed + cylinder.turning for speed in find_speeds(cylinder, gauge)]


def move(cylinder, gauge, times):
    """Stroke [m] and velocity [m/s] of the drive at times [s]: from the middle to one end, and to and fro."""
    speeds, lasts = find_speeds(cylinder, gauge), time_ways(cylinder, gauge)
    phase = (times + 0.5 * lasts[0]) % sum(lasts)
    stroke, velocity = np.empty_like(times), np.empty_like(times)
    for speed, start, last, sign in ((speeds[0], 0.0, lasts[0], 1.0), (speeds[1], lasts[0], lasts[1], -1.0)):
        here = (phase >= start) & (phase < start + last)
        t, ramp = phase[here] - start, cylinder.turning
        away, left = np.minimum(t, ramp), np.minimum(last - t, ramp)
        way = speed * (0.5 * away**2 / ramp + np.clip(t - ramp, 0.0, last - 2.0 * ramp) + 0.5 * (ramp - left**2 / ramp))
        stroke[here] = way if sign > 0.0 else cylinder.travel - way
        velocity[here] = sign * speed * np.minimum(away, left) / ramp
    return stroke, velocity


def balance(cylinder, gauge, velocity):
    """Force that holds the piston at its velocity, as the load cell shows it [N]."""
    load = 0.25 * pi * cylinder.bore**2 * gauge + cylinder.viscous * velocity
    load = load + (cylinder.coulomb + cylinder.seal * gauge) * np.sign(velocity)
    return cylinder.gain * load + cylinder.tare


def record(cylinder, gauge, seconds, noise, rng):
    """Record of some time at a supply [Pa gauge], one row a sample: time, stroke, pressure, force, in SI."""
    times = np.cumsum(rng.uniform(8e-3, 13e-3, int(seconds / 10.5e-3)))
    stroke, velocity = move(cylinder, gauge, times)
    pressure = gauge * (1.0 + 0.008 * np.tanh(velocity / 5e-3)) + 3e3 * np.sin(2.0 * pi * stroke / 0.05)
    columns = stroke, pressure, balance(cylinder, pressure, velocity)
    return np.column_stack([times, *(c + rng.normal(0.0, s, len(c)) for c, s in zip(columns, noise, strict=True))])


def write_folder(
    folder: Path,
    cylinder: Cylinder,
    records: Sequence[Record],
    *,
    seed: int,
    ways: int = 9,
    noise: Noise = NOISE,
) -> None:
    """Write a folder of measured data: records of a cylinder, each of about so many ways to and fro."""
    rng = np.random.default_rng(seed)
    lines = ['bench = "cylinder"']
    for number, (bar, role, faster) in enumerate(records, 1):
        moved = cylinder._replace(pushing=faster * cylinder.pushing, returning=faster * cylinder.returning)
        rows = record(moved, bar * 1e5, (ways + 1) * sum(time_ways(moved, bar * 1e5)), noise, rng) * [
            1e3,
            1e3,
            1e-5,
            1.0,
        ]
        np.savetxt(folder / f"record{number}.csv", rows, FORMATS, ",", header=HEADER, comments="")
        lines += ["[[run]]", f'data = "record{number}.csv"', f'supply = "{bar:g} bar gauge"', f'role = "{role}"']
    (folder / "measured.toml").write_text("\n".join(lines) + "\n")
