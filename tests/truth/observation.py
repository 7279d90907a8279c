"""What a case's setting sees of a rig, the noise on it, and how many deviations of that noise a change amounts to."""

from math import sqrt

import numpy as np

from .crank import TURN
from .library import ENGINE
from .nuisances import nuisances_for
from .periodic import periodic
from .sensors import MEANS, bench_channels, engine_channels
from .setting import AFTER_PULSE, HUM, HUM_FREQUENCY
from .valve import noise, simulate

TOLERANCE = 1e-8
"""Of the solver; errs by less than 0.01 deviations per sample."""
NEAR = 1e-6
"""To the engine's periodic state, relative."""


def at_point(rig, point):
    """A rig at an operating point, whose noted values stand in place of the nominal ones."""
    rig = rig.valve(supply_pressure=point.supply, supply_temperature=point.temperature)
    return rig.of_engine(intake_pressure=point.supply)


class Laboratory:
    """Runs rigs at a setting's points; what only changes the sensors runs nothing anew."""

    def __init__(self, setting):
        self.setting = setting
        self.runs = {}
        """Of the nominal rig, by point."""
        self.columns = None

    def run(self, rig, point):
        """A run of a rig that stands at its point."""
        if self.setting.bench == ENGINE:
            return periodic(rig.engine, point.speed, start=self.runs.get(point), near=NEAR, relative=TOLERANCE)
        return simulate(rig.engine.valve, point.pulse, point.pulse + AFTER_PULSE, relative=TOLERANCE)

    def nominal(self, rig, point):
        """That of the nominal rig, kept."""
        if point not in self.runs:
            self.runs[point] = self.run(rig, point)
        return self.runs[point]

    def read(self, rig, point, run):
        """Channels of a run, SI, by name."""
        grid, channels = self.setting.grid(point), self.setting.channels
        if self.setting.bench == ENGINE:
            return engine_channels(run, grid, rig.sensors, channels)
        return bench_channels(rig.engine.valve, run, grid, rig.sensors, channels)

    def seen(self, nominal, changes, point):
        """Channels of a nominal rig after a change, a function from rig to rig."""
        before = at_point(nominal, point)
        after = changes(before)
        same = after.engine is before.engine
        return self.read(after, point, self.nominal(before, point) if same else self.run(after, point))

    def deviations(self, nominal, changes, points):
        """A change of a nominal rig, over the noise and freed of what nuisances can take on.

        Parameters
        ----------
        nominal : truth.effects.Rig
        changes : callable
            From rig to rig.
        points : sequence of Point

        Returns
        -------
        left : float array
            Of each sample.
        deviations : float
        """
        change = np.concatenate([self.whitened(point, self.difference(nominal, changes, point)) for point in points])
        return freed(change, self.sensitivities(nominal, points))

    def difference(self, nominal, changes, point):
        """Channels after a change less those before."""
        after, before = self.seen(nominal, changes, point), self.seen(nominal, lambda rig: rig, point)
        return {name: after[name] - before[name] for name in after}

    def sensitivities(self, nominal, points):
        """Columns of the whitened change per prior deviation of each nuisance; kept."""
        if self.columns is None:
            self.columns = np.column_stack(
                [
                    np.concatenate(
                        [
                            self.whitened(
                                point, self.difference(nominal, lambda rig, one=one: one.add(rig, one.deviation), point)
                            )
                            for point in points
                        ]
                    )
                    for one in nuisances_for(self.setting.bench, self.setting.channels)
                ]
            )
        return self.columns

    def whitened(self, point, channels):
        """Channels over their noise, its correlation and hum taken out, as one vector; repeats count."""
        setting, parts = self.setting, []
        rho = setting.noise.correlation
        for name in setting.channels:
            part = np.atleast_1d(channels[name]) / setting.deviation(name)
            if name not in MEANS:
                part = without_hum(setting, point, part)
                part = np.append(part[:1], (part[1:] - rho * part[:-1]) / sqrt(1.0 - rho**2))
            parts.append(part)
        return sqrt(point.repeats) * np.concatenate(parts)


def freed(change, columns):
    """What is left of a change where the columns take on what they can, and what it costs in all [deviations].

    Each column is worth one prior deviation and costs its share squared.
    """
    n = columns.shape[1]
    augmented, target = np.vstack((columns, np.eye(n))), np.append(change, np.zeros(n))
    left = target - augmented @ np.linalg.lstsq(augmented, target, rcond=None)[0]
    return left[:-n], float(np.linalg.norm(left))


def without_hum(setting, point, part):
    """A trace over its noise, free of what the mains hum could have made."""
    if setting.noise.colour != HUM:
        return part
    grid = setting.grid(point)
    turns = HUM_FREQUENCY * (grid / point.speed if setting.bench == ENGINE else grid)
    waves = np.column_stack((np.cos(TURN * turns), np.sin(TURN * turns)))
    return part - waves @ np.linalg.lstsq(waves, part, rcond=None)[0]


def noisy(setting, point, channels, rng):
    """A reading of the channels, SI; means have white noise."""
    found, grid = {}, setting.grid(point)
    for name in setting.channels:
        value, deviation = np.asarray(channels[name]), setting.deviation(name)
        if name in MEANS:
            found[name] = float(value + deviation * rng.normal())
            continue
        added = noise(len(grid), deviation, rng, setting.noise.correlation)
        if setting.noise.colour == HUM:
            times = grid / point.speed if setting.bench == ENGINE else grid
            amplitude = setting.noise.hum * deviation
            added = added + amplitude * np.sin(TURN * (HUM_FREQUENCY * times + rng.uniform()))
        found[name] = value + added
    return found
