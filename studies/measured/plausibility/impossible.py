"""Impossible samples: what no valve and no engine of this machine can show, whatever it lacks.

A lift beyond both stops, a pressure below zero or far above its supply: the physics of the rig decides, not what stands
beside a sample. So a block of any length is found, where a spike is one or two samples.
"""

from collections.abc import Iterator, Sequence
from math import isnan, sqrt

import numpy as np

from apesim.engine.kinematics import clearance_volume, crank_of, cylinder_volume
from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility import thresholds as limits
from apesim.studies.measured.plausibility.disturbances import (
    find_code_limits,
    find_disturbances,
    find_impossible,
    is_short,
)
from apesim.studies.measured.plausibility.signals import find_levels, find_noise
from apesim.studies.measured.runs import ENGINE, Disturbance, Masked, Measured, MeasuredRun
from apesim.studies.measured.sensors import SENSORS

BESIDE_IMPOSSIBLE = 1
"""Samples beside an impossible block that are masked with it: a contact that opens has flanks, and where a long record
was thinned a mean holds a part of the block."""


def mask_impossible(machine: Machine, measured: Measured) -> Measured:
    """Mask the samples that the machine rules out, where they are few; what is much is left for the checks to refuse.

    The data come back as the same object where nothing is to be masked.
    """
    runs = list(measured.runs)
    masked = [_name_impossible(machine, each, measured.runs[each.run]) for each in measured.masked]
    for number, run in enumerate(measured.runs):
        axis, places = SENSORS[run.bench].axis, run.angles if run.bench == ENGINE else run.times
        found, channels = [], dict(run.channels)
        for channel, flags in find_flags(machine, run):
            values = run.channels[channel]
            beside = np.convolve(flags, np.ones(2 * BESIDE_IMPOSSIBLE + 1), mode="same") > 0.5
            beside &= np.isfinite(values)
            if is_short(places, beside, axis):
                share = float(np.mean(beside))
                found.append(Masked(number, channel, Disturbance.IMPOSSIBLE, places[flags], values[flags], share))
                channels[channel] = np.where(beside, np.nan, values)
        masked += found
        runs[number] = run._replace(channels=channels) if found else run
    if len(masked) == len(measured.masked) and all(a is b for a, b in zip(masked, measured.masked, strict=True)):
        return measured
    return measured._replace(runs=tuple(runs), masked=tuple(masked))


def find_flags(machine: Machine, run: MeasuredRun, *, spares_spikes: bool = False) -> Iterator[tuple[str, np.ndarray]]:
    """Find the samples of each channel of a run that the machine rules out, by flags (n,) that are not all False.

    `spares_spikes`: spikes are left to be called so; else they are where they are too many to be masked.

    >>> times, pressure = np.arange(40) * 1e-4, np.full(40, 0.5e6)
    >>> pressure[[3, 4, 5]] = -1e3
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", times, {"pressure_a": pressure})
    >>> [(channel, flags.nonzero()[0].tolist()) for channel, flags in find_flags(Machine(), run)]
    [('pressure_a', [3, 4, 5])]
    """
    axis, places = SENSORS[run.bench].axis, run.angles if run.bench == ENGINE else run.times
    for channel, values in run.channels.items():
        if np.isfinite(values).sum() < limits.MIN_SAMPLES:
            continue
        flags = find_impossible(values, find_limits(machine, run, channel))
        for disturbance, spikes in find_disturbances(places, values, axis) if flags.any() else ():
            if disturbance == Disturbance.SPIKES and (spares_spikes or not is_short(places, spikes, axis)):
                flags &= ~spikes  # so many are refused as what they are, also where some of them could be
        if flags.any():
            yield channel, flags


def find_spoilt(machine: Machine, run: MeasuredRun, number: int, max_share: float = limits.MAX_SPOILT) -> list[Masked]:
    """Find what the machine rules out in the channels of a run of which it spoils a part alone.

    That part is at most the share `max_share` of a channel's samples; `number` is that of the run in the folder, from
    0.
    """
    places = run.angles if run.bench == ENGINE else run.times
    return [
        Masked(
            number, channel, Disturbance.IMPOSSIBLE, places[flags], run.channels[channel][flags], float(flags.mean())
        )
        for channel, flags in find_flags(machine, run, spares_spikes=True)
        if flags.mean() <= max_share
    ]


def without(run: MeasuredRun, spoilt: Sequence[Masked]) -> MeasuredRun:
    """Take samples for missing; the run comes back as the same object where there are none."""
    if not spoilt:
        return run
    places, channels = run.angles if run.bench == ENGINE else run.times, dict(run.channels)
    for each in spoilt:
        channels[each.channel] = np.where(np.isin(places, each.places), np.nan, channels[each.channel])
    return run._replace(channels=channels)


def find_limits(machine: Machine, run: MeasuredRun, channel: str) -> tuple[float, float]:
    """Find the limits [SI] that a channel of a run cannot reach; infinite where it has none.

    They come from the dimensions of the machine and the run's supply.

    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", np.arange(9), {"lift": np.zeros(9)})
    >>> find_limits(Machine(), run, "lift")
    (-0.00045, 0.00945)
    """
    values = run.channels[channel]
    if "temperature" in channel:
        return limits.MIN_TEMPERATURE, limits.MAX_TEMPERATURE
    if "pressure" in channel:
        return _find_vacuum(values), limits.MAX_OVER_SUPPLY * _find_highest_pressure(machine, run, channel)
    if channel not in ("lift", "velocity"):
        return find_code_limits(channel)
    stroke, noise = machine.valve.stroke, find_noise(values)
    low, high = limits.MAX_BELOW * stroke, limits.MAX_ABOVE * stroke
    if channel == "velocity":
        push = _find_supply(machine, run) * machine.valve.piston_area
        high = limits.MAX_OVER_SPEED * sqrt(2.0 * push * stroke / machine.valve.moving_mass)
        low = -high
    if noise > limits.MAX_NOISE_SHARE * (high - low):
        return find_code_limits(channel)
    return low - limits.MIN_NOISES_BEYOND * noise, high + limits.MIN_NOISES_BEYOND * noise


def _find_vacuum(values: np.ndarray) -> float:
    """Absolute pressure that a trace cannot fall to [Pa]: zero, or less by noise where it comes near to it."""
    above, noise = values[values > 0.0], find_noise(values)
    if len(above) < limits.MIN_SAMPLES:
        return 0.0
    return min(0.0, find_levels(above)[0] - limits.MIN_NOISES_ABOVE_VACUUM * noise)


def _find_supply(machine: Machine, run: MeasuredRun) -> float:
    """Highest pressure that the valve is fed with [Pa abs]: the supply's, or that of the control air."""
    control = machine.supply.control_pressure
    return run.supply if isnan(control) else max(run.supply, control)


def _find_highest_pressure(machine: Machine, run: MeasuredRun, channel: str) -> float:
    """Highest pressure that a volume can come to [Pa abs]: what it is fed with, or what the crank compresses.

    The crank compresses air of the surroundings from where the first exhaust valve begins to close,
    without loss of heat.
    """
    supply = _find_supply(machine, run)
    if channel != "cylinder_pressure":
        return supply
    engine = machine.engine
    trapped = max(cylinder_volume(crank_of(engine), valve.closes - valve.flank)[0] for valve in engine.exhausts)
    ratio = trapped / clearance_volume(engine)
    return max(supply, machine.ambient.pressure * ratio**machine.air.heat_capacity_ratio)


def _name_impossible(machine: Machine, masked: Masked, run: MeasuredRun) -> Masked:
    """What was masked as a held or clipped value, named for what it is where no rig has that value."""
    if masked.disturbance not in (Disturbance.CLIPPED, Disturbance.STUCK):
        return masked
    bounds = find_limits(machine, run, masked.channel)
    is_impossible = bool(find_impossible(np.array([np.median(masked.values)]), bounds)[0])
    return masked._replace(disturbance=Disturbance.IMPOSSIBLE) if is_impossible else masked
