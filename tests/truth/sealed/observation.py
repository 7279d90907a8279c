"""What a case's setting sees of a rig, the noise on it, and how many deviations of that noise a change amounts to."""

from math import sqrt

import numpy as np

from tests.truth.simulator.crank import TURN
from tests.truth.simulator.periodic import periodic
from tests.truth.simulator.sensors import MEANS, bench_channels, engine_channels
from tests.truth.simulator.valve import noise, simulate

from .library import ENGINE
from .nuisances import NUISANCES, nuisances_for, with_nuisances
from .setting import AFTER_PULSE, HUM, HUM_FREQUENCY

TOLERANCE = 1e-7
"""Tolerance of the solver; errs by less than 0.001 deviations per sample, the least noise taken."""
ROUNDS = 15
"""How often nuisances are fitted anew about where the last fit took them, at most."""
DONE = 0.05
"""Share of the square of what is left, that another fit may promise to take, and is not made."""
FORESEEN = 0.5, 1.5
"""Fall over that promised, between which sensitivities are believed."""
MIN_DAMPING = 0.03
"""Damping of a step that follows one that was not foreseen."""
FIRST_STEP, STEP = 0.25, 0.1
"""Steps of the differences that they are taken from, at first and anew [prior deviations]."""
FARTHEST = 20.0
"""How far nuisances may go [prior deviations]."""
LOWEST = -0.8
"""Share of a number by which it may fall."""
NEAR = 1e-5
"""To the engine's periodic state, relative."""


def at_point(rig, point):
    """A rig at an operating point, whose noted values stand in place of the nominal ones."""
    rig = rig.valve(supply_pressure=point.supply, supply_temperature=point.temperature)
    return rig.of_engine(intake_pressure=point.supply)


class Laboratory:
    """Runs rigs at a setting's points; what only changes the sensors runs nothing anew."""

    def __init__(self, setting, bank=None, nuisances=None, scatter=()):
        self.setting, self.bank, self.scatter = setting, bank, scatter
        self.nuisances = nuisances_for(setting.bench, setting.channels) if nuisances is None else nuisances
        """What is uncertain, and alike in all runs; the scatter is what is another one in each."""
        self.runs = {}
        """Runs of the nominal rig, by point."""
        self.columns = None
        self.spreads = {}
        """Directions in which runs scatter, and by how much, by point."""

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

    def read(self, rig, point, run, grid=None):
        """Channels of a run, SI, by name, over the setting's times or angles, or others."""
        grid, channels = self.setting.grid(point) if grid is None else grid, self.setting.channels
        if self.setting.bench == ENGINE:
            return engine_channels(run, grid, rig.sensors, channels)
        return bench_channels(rig.engine.valve, run, grid, rig.sensors, channels)

    def seen(self, nominal, changes, point, label=""):
        """Channels of a nominal rig after a change, a function from rig to rig; labelled ones go by the bank."""
        before = at_point(nominal, point)
        after, run = changes(before), self.nominal(before, point)
        if after.engine == before.engine:
            return self.read(after, point, run)
        if self.bank and label:
            found = self.bank.channels(label, point, self.setting.samples, lambda: self.run(after, point))
            return {name: found[name] for name in self.setting.channels}
        return self.read(after, point, self.run(after, point))

    def left(self, nominal, changes, points, linear=False, label="", anew=0, stand_in=None, start=0.0):
        """A change of a nominal rig, over the noise and freed of what nuisances can take on.

        Parameters
        ----------
        nominal : truth.simulator.effects.Rig
        changes : callable
            From rig to rig.
        points : sequence of Point
        linear : bool
            Take the nuisances' effects to be in proportion, instead of simulating them at the sizes fitted.
        label : str
            Of the change, where the bank shall keep it.
        anew : int
            How often the nuisances' sensitivities are taken anew where they have been moved to, at most.
        stand_in : truth.sealed.nuisances.Nuisance, optional
            What else may take on what it can, at a size between its ends.
        start : float
            The size of the stand-in that is tried first, in its deviations.

        Returns
        -------
        float array
            Of each sample over the noise, then of each nuisance and the stand-in in prior deviations (0 without a
            prior); its length is what is left in all [deviations].
        """
        change, columns = self.changed(nominal, changes, points, label), self.sensitivities(nominal, points)
        free, taken = (*self.nuisances, *([stand_in] if stand_in else [])), np.zeros(columns.shape[1])
        if stand_in:
            taken = np.append(taken, start)
            at_start = self.changed(nominal, shifted(taken, free), points)
            columns, residual = np.column_stack((columns, at_start / start)), change - at_start
        else:
            residual = change
        n = len(free)
        prior = np.diag([0.0 if one.ends else 1.0 for one in free])
        slopes, target, damping = np.vstack((columns, prior)), np.append(residual, np.zeros(n)), 0.0
        fresh = False
        lowest, highest = np.array([reach(one) for one in free]).T

        def renewed():
            return self.slopes(nominal, points, taken, change - target[: len(change)], free, prior)

        for _ in range(0 if linear else ROUNDS):
            damped = np.vstack((slopes, sqrt(damping) * np.diag(np.linalg.norm(slopes, axis=0))))
            step = np.linalg.lstsq(damped, np.append(target, np.zeros(n)), rcond=None)[0]
            step = np.clip(taken + step, lowest, highest) - taken
            promised = target @ target - np.sum((target - slopes @ step) ** 2)
            if not step.any() or (taken.any() and promised < DONE * (target @ target)):
                if not anew or fresh:
                    break
                slopes, anew, fresh = renewed(), anew - 1, True
                continue
            tried = np.append(
                change - self.changed(nominal, shifted(taken + step, free), points), -prior @ (taken + step)
            )
            fall = target @ target - tried @ tried
            slopes = slopes + np.outer(target - tried - slopes @ step, step) / (step @ step)  # Broyden's rule
            if fall > 0.0:
                taken, target, fresh = taken + step, tried, False
            foreseen = FORESEEN[0] < fall / promised < FORESEEN[1]
            damping = 0.1 * damping if foreseen else max(10.0 * damping, MIN_DAMPING)
            if not foreseen and anew and not fresh:
                slopes, anew, fresh = renewed(), anew - 1, True
        movable = slopes[:, (np.diag(prior) > 0.0) | ((taken > lowest) & (taken < highest))]
        return target - movable @ np.linalg.lstsq(movable, target, rcond=None)[0]

    def freed(self, nominal, points, target):
        """What nuisances cannot take on of a whitened change and the nuisances below it, if all is straight."""
        columns = self.sensitivities(nominal, points)
        slopes = np.vstack((columns, np.eye(columns.shape[1])))
        return target - slopes @ np.linalg.lstsq(slopes, target, rcond=None)[0]

    def slopes(self, nominal, points, taken, there, free, prior):
        """Columns of the whitened change, and of the priors, where what is free is at some sizes.

        Parameters
        ----------
        nominal : truth.simulator.effects.Rig
        points : sequence of Point
        taken : (p,) float array
            [prior deviations]
        there : (n,) float array
            The change by them.
        free : sequence of Nuisance
        prior : (p, p) float array

        Returns
        -------
        (n + p, p) float array
        """
        steps = STEP * np.eye(len(taken))
        columns = [(self.changed(nominal, shifted(taken + step, free), points) - there) / STEP for step in steps]
        return np.vstack((np.column_stack(columns), prior))

    def changed(self, nominal, changes, points, label=""):
        """What a change does to all samples, whitened."""
        parts = []
        for point in points:
            after = self.seen(nominal, changes, point, label)
            before = self.seen(nominal, lambda rig: rig, point)
            part = self.whitened(point, {name: after[name] - before[name] for name in after})
            parts.append(self.freed_of_scatter(nominal, point, part))
        return np.concatenate(parts)

    def freed_of_scatter(self, nominal, point, part):
        """What a change of a point's samples over their noise is over noise and scatter together.

        Parameters
        ----------
        nominal : truth.simulator.effects.Rig
        point : Point
        part : (n,) float array
            See `whitened`. The mean of repeats scatters, over its noise, as much as a single run does.

        Returns
        -------
        (n,) float array
        """
        if not self.scatter:
            return part
        if point not in self.spreads:
            one = point._replace(repeats=1)
            self.runs.setdefault(one, self.nominal(at_point(nominal, point), point))
            before = self.seen(nominal, lambda rig: rig, one)
            columns = []
            for nuisance, step in zip(self.scatter, np.eye(len(self.scatter)), strict=True):
                after = self.seen(nominal, shifted(step, self.scatter), one, label_of(nuisance))
                columns.append(self.whitened(one, {name: after[name] - before[name] for name in after}))
            directions, sizes, _ = np.linalg.svd(np.column_stack(columns), full_matrices=False)
            self.spreads[point] = directions, 1.0 - 1.0 / np.sqrt(1.0 + sizes**2)
        directions, shares = self.spreads[point]
        return part - directions @ (shares * (directions.T @ part))

    def sensitivities(self, nominal, points):
        """Columns of the whitened change per prior deviation of each nuisance; kept."""
        if self.columns is None:
            steps = zip(self.nuisances, FIRST_STEP * np.eye(len(self.nuisances)), strict=True)
            self.columns = np.column_stack(
                [
                    self.changed(nominal, shifted(step, self.nuisances), points, label_of(one)) / FIRST_STEP
                    for one, step in steps
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


def label_of(nuisance):
    """Label under which the bank keeps a nuisance; only of another width than usual it has one of its own."""
    return nuisance.name if nuisance in NUISANCES else f"{nuisance.name} {nuisance.deviation:g}"


def reach(nuisance):
    """How far a nuisance may fall and rise [prior deviations]; a number stays above zero."""
    if nuisance.ends:
        return tuple(end / nuisance.deviation for end in nuisance.ends)
    return max(-FARTHEST, LOWEST / nuisance.deviation) if nuisance.is_share else -FARTHEST, FARTHEST


def shifted(taken, nuisances):
    """The change by nuisances, in their prior deviations."""
    values = {one.name: x * one.deviation for one, x in zip(nuisances, taken, strict=True)}
    return lambda rig: with_nuisances(rig, nuisances, values)


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
