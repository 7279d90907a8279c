"""Faults of measurement: what is wrong with the record of one run, and with no other.

Some have a name that a program may know (a zero, a gain, a label); spikes, a drift and a sensor that sticks have none.
"""

from typing import NamedTuple

import numpy as np

from tests.truth.simulator.effects import sensor_gain, sensor_offset
from tests.truth.simulator.sensors import MEANS

from .nuisances import supply
from .observation import at_point
from .setting import BASE_NOISE

NAMED_FAULTS = {
    "offset": "run_offset",
    "gain": "run_gain",
    "clock": "run_clock",
    "time_zero": "run_time_zero",
    "supply": "run_supply",
    "temperature": "run_temperature",
    "swap": "run_swap",
    "angle": "run_angle",
}
"""Names that `apesim gap explain` has for them; the others have none."""
LARGEST = {
    "gain": 0.3,
    "clock": 0.05,
    "time_zero": 5e-3,
    "supply": 0.3,
    "temperature": 40.0,
    "swap": 1.0,
    "angle": np.radians(5.0),
    "stuck": 0.3,
}
"""Sizes that none exceeds, SI or shares; of a stretch that sticks, its share of the record."""
NOISES = {"offset": 40.0, "drift": 60.0, "spikes": 150.0}
"""Largest sizes of what is added to a channel, over its usual noise."""
SIGNED = "offset", "gain", "clock", "time_zero", "supply", "temperature", "angle", "drift"
FIRST = 0.1
"""Share of the largest size that is tried first."""
SPIKES = 3, 13
"""Number of spikes: at least, below."""
TRIES = 6
NEAR = 1.05
"""Factor to the deviations asked for that is let pass."""


class Fault(NamedTuple):
    """What is wrong with one record."""

    kind: str
    channel: str
    """Channel, where the fault is in one."""
    size: float
    """SI, or a share; of spikes their height, of a stretch that sticks its length over the record's."""
    places: tuple = ()
    """Shares of the record: of each spike, or of the beginning of the stretch."""

    def rig(self, rig):
        """The rig and its sensors as they were in this run, where the record says something else."""
        if self.kind == "offset":
            return sensor_offset(rig, **{self.channel: self.size})
        if self.kind == "gain":
            return sensor_gain(rig, **{self.channel: self.size})
        if self.kind == "time_zero":
            return rig.reading(time_zero=rig.sensors.time_zero + self.size)
        if self.kind == "angle":
            return rig.reading(tdc_error=rig.sensors.tdc_error + self.size)
        if self.kind == "supply":
            return supply(rig, self.size)
        if self.kind == "temperature":
            return rig.valve(supply_temperature=rig.engine.valve.supply_temperature + self.size)
        return rig

    def grid(self, grid):
        """Times [s] at which the samples were truly taken."""
        return grid / (1.0 + self.size) if self.kind == "clock" else grid

    def spoil(self, channels):
        """The channels of a record with what is wrong in them."""
        if self.kind == "swap":
            return channels | {"pressure_a": channels["pressure_b"], "pressure_b": channels["pressure_a"]}
        if self.kind not in ("spikes", "drift", "stuck"):
            return channels
        trace = np.array(channels[self.channel])
        places = [int(share * (len(trace) - 1)) for share in self.places]
        if self.kind == "spikes":
            for number, at in enumerate(places):
                trace[at] += self.size * (-1.0) ** number
        elif self.kind == "drift":
            trace += self.size * np.linspace(0.0, 1.0, len(trace))
        else:
            trace[places[0] : places[0] + int(self.size * len(trace))] = trace[places[0]]
        return channels | {self.channel: trace}


def largest_size(kind, channel):
    """Size that no fault of a kind exceeds, SI or a share."""
    return LARGEST[kind] if kind in LARGEST else NOISES[kind] * BASE_NOISE[channel]


def draw_fault(rng, lab, nominal, points, kind, wanted):
    """A fault in the record of one of the runs to fit, as large as is wanted.

    Parameters
    ----------
    rng : numpy.random.Generator
    lab : truth.sealed.observation.Laboratory
    nominal : truth.simulator.effects.Rig
    points : sequence of truth.sealed.setting.Point
        To fit.
    kind : str
    wanted : float
        Deviations that it is to make, freed of what is uncertain.

    Returns
    -------
    Fault
    int
        Number of the run, from 0, among all repeats of the points.
    float
        Deviations that it makes; fewer than wanted where its largest size makes no more.
    """
    number = int(rng.integers(sum(point.repeats for point in points)))
    traces = [name for name in lab.setting.channels if name not in MEANS]
    channels = lab.setting.channels if kind == "offset" else traces
    channel = str(rng.choice(channels)) if kind in ("offset", "gain", "spikes", "drift", "stuck") else ""
    sign = float(rng.choice([-1.0, 1.0])) if kind in SIGNED else 1.0
    places = {"spikes": rng.uniform(size=int(rng.integers(*SPIKES))), "stuck": rng.uniform(0.0, 0.6, 1)}.get(kind, ())
    largest = sign * largest_size(kind, channel)
    share, low, high = (1.0 if kind == "swap" else FIRST), 0.0, 1.0
    for _ in range(TRIES):
        fault = Fault(kind, channel, share * largest, tuple(map(float, places)))
        deviations = deviations_of(lab, nominal, points, fault, number)
        if kind == "swap" or 1.0 / NEAR < deviations / wanted < NEAR or (share == 1.0 and deviations < wanted):
            break
        low, high = (share, high) if deviations < wanted else (low, share)
        straight = share * wanted / max(deviations, 1e-9)
        share = min(1.0, straight) if low < straight < high or (high == straight == 1.0) else 0.5 * (low + high)
        share = 1.0 if straight >= 1.0 and high == 1.0 else share
    return fault, number, deviations


def deviations_of(lab, nominal, points, fault, number):
    """Deviations that a fault of one record makes, freed of what is uncertain; see `draw_fault`."""
    shared, own, first = [], 0.0, 0
    for point in points:
        before = lab.seen(nominal, lambda rig: rig, point)
        change = {name: np.zeros_like(before[name]) for name in before}
        if first <= number < first + point.repeats:
            at = at_point(nominal, point)
            rig = fault.rig(at)
            run = lab.nominal(at, point) if rig.engine == at.engine else lab.run(rig, point)
            after = fault.spoil(lab.read(rig, point, run, fault.grid(lab.setting.grid(point))))
            change = {name: (after[name] - before[name]) / point.repeats for name in after}
            # What the mean of the repeats shows of it is one part; how it differs from the other repeats is the rest.
            part = lab.whitened(point, change)
            own = np.linalg.norm(lab.freed_of_scatter(nominal, point, part)) * np.sqrt(point.repeats - 1.0)
        first += point.repeats
        shared.append(lab.freed_of_scatter(nominal, point, lab.whitened(point, change)))
    left = lab.freed(nominal, points, np.append(np.concatenate(shared), np.zeros(len(lab.nuisances))))
    return float(np.hypot(np.linalg.norm(left), own))
