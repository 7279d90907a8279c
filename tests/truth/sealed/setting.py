"""A case's setting: operating points, sensors, noise and sampling, as its seed draws them."""

from math import pi
from typing import NamedTuple

import numpy as np

from tests.truth.simulator.sensors import MEANS

from .library import ENGINE, VALVE

AMBIENT = 101325.0
RPM = pi / 30.0
WHITE, AR1, HUM = COLOURS = ("white", "ar1", "hum")
BASE_NOISE = {
    "lift": 0.03e-3,
    "pressure_a": 2e3,
    "pressure_b": 2e3,
    "cylinder_pressure": 5e3,
    "torque": 0.3,
    "air_flow": 0.3e-3,
}
"""Standard deviations, SI; of air flow, half a percent of a usual one."""
SUITES = {
    "lift": ("lift",),
    "chambers": ("lift", "pressure_a", "pressure_b"),
    "cylinder": ("cylinder_pressure", *MEANS),
    "all": ("lift", "pressure_a", "pressure_b", "cylinder_pressure", *MEANS),
}
HUM_FREQUENCY = 50.0
AFTER_PULSE = 50e-3
"""Time recorded after the release [s]."""
BEFORE = 5e-3
"""Time recorded before the energising, where any is [s]."""


class Point(NamedTuple):
    """An operating point, as the measurer notes it down."""

    role: str
    supply: float
    """[Pa abs]"""
    temperature: float
    """[K]"""
    pulse: float = 0.0
    """Pulse of a valve [s]."""
    speed: float = 0.0
    """Speed of an engine [rad/s]."""
    repeats: int = 1


class Noise(NamedTuple):
    """Noise of all channels."""

    scale: float
    """Times the base."""
    colour: str
    correlation: float
    """Correlation of a sample with the one before."""
    hum: float
    """Amplitude of the hum over the standard deviation of the white noise."""
    stated: bool
    """In the case's file."""


class Setting(NamedTuple):
    """What a case is measured with."""

    bench: str
    suite: str
    points: tuple
    noise: Noise
    samples: int
    """Per run."""
    before: float
    """Recorded before the energising [s]."""

    @property
    def channels(self):
        """Names of what is measured."""
        return SUITES[self.suite]

    def grid(self, point):
        """Recorded times [s] or crank angles [rad] of a run."""
        if self.bench == ENGINE:
            return np.arange(self.samples) * (2.0 * pi / self.samples)
        step = (point.pulse + AFTER_PULSE) / (self.samples - 1)
        return np.arange(-int(self.before / step), self.samples) * step

    def deviation(self, channel):
        """Standard deviation of a channel's noise, SI."""
        return self.noise.scale * BASE_NOISE[channel]


def draw_setting(rng, bench, suites, min_fits=2):
    """A setting.

    Parameters
    ----------
    rng : numpy.random.Generator
    bench : str
    suites : sequence of str
        Of which one is drawn.
    min_fits : int
        Operating points to fit, at least.

    Returns
    -------
    Setting
    """
    suite = str(rng.choice(suites))
    colour = str(rng.choice(COLOURS))
    noise = Noise(
        float(rng.choice([0.5, 1.0, 3.0])),
        colour,
        float(rng.choice([0.5, 0.7, 0.9])) if colour == AR1 else 0.0,
        float(rng.choice([0.3, 0.6])) if colour == HUM else 0.0,
        bool(rng.integers(2)),
    )
    points = draw_points(rng, bench, min_fits)
    if bench == ENGINE:
        return Setting(bench, suite, points, noise, int(rng.choice([360, 720])), 0.0)
    samples = int(rng.choice([201, 501, 1001, 2001]))
    return Setting(bench, suite, points, noise, samples, float(rng.choice([0.0, 0.0, BEFORE])))


def draw_points(rng, bench, min_fits=2):
    """Two to four points to fit, three on an engine; perhaps a gate; one or two to check, inside and 30 % beyond."""
    fits = int(rng.integers(min_fits, 5 if bench == VALVE else 4))
    if bench == VALVE:
        low, high = rng.uniform(0.14, 0.28), rng.uniform(0.4, 0.9)
    else:
        low, high = rng.choice([0.6, 0.7, 0.8]), rng.choice([1.0, 1.1, 1.2])
    gauge = np.linspace(low, high, fits)
    roles = ["fit"] * fits
    inside = gauge[:-1] + rng.uniform(0.3, 0.7, fits - 1) * np.diff(gauge)
    others = [("gate", float(inside[0])), ("check", float(inside[-1])), ("check", 1.3 * float(high))]
    kept = [bool(rng.integers(2)) and fits > 2, bool(rng.integers(2)), True]
    roles += [role for (role, _), keep in zip(others, kept, strict=True) if keep]
    gauge = [*gauge, *(at for (_, at), keep in zip(others, kept, strict=True) if keep)]
    repeats = int(rng.choice([1, 1, 1, 2, 3]))
    points = []
    for role, at in zip(roles, gauge, strict=True):
        own = repeats if role == "fit" else 1
        if bench == VALVE:
            temperature, pulse = 287.0 + float(rng.integers(-6, 7)), 1e-3 * float(rng.integers(40, 61))
            points.append(Point(role, 1e6 * round(at, 2) + AMBIENT, temperature, pulse, repeats=own))
        else:
            speed = RPM * 100.0 * float(rng.integers(5, 13))
            points.append(Point(role, 1e6 * round(at, 1) + AMBIENT, 287.0, speed=speed, repeats=own))
    return tuple(points)
