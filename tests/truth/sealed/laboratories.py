"""Laboratories of the second benchmark: how far their rigs are off, and how far one run differs from the next.

What a rig is off by does not follow the priors that a program may assume: it is twice as wide as
`truth.sealed.nuisances`, with heavier tails, and the geometry is among it. A laboratory that states how far it knows
its rig states the standard deviation, and says nothing of the tails.
"""

import numpy as np

from tests.truth.simulator.effects import Rig

from .library import ENGINE
from .nuisances import NUISANCES, SHARES, Nuisance, nuisances_for, of_engine, of_valve

WIDER = 2.0
"""Times the priors of `truth.sealed.nuisances`."""
FREEDOM = 4
"""Degrees of freedom of Student's t: of a thousand values 13 lie beyond three standard deviations, of normal ones 3."""
FARTHEST = 5.5
"""Largest value of that t; one in two hundred lies beyond, and is not taken."""
SPREAD = 1.2919
"""Standard deviation of that t between these ends."""
SMALLEST_SHARE = -0.5
"""Below which no share is drawn."""
MEASURED_WELL = 0.25
"""Widths of a geometry that nothing is said of, over those of one that is stated: such a laboratory measured it."""
GEOMETRY = (
    Nuisance("valve.piston_area", 0.003, of_valve("piston_area")),
    Nuisance("valve.stroke", 0.0033, of_valve("stroke")),
    Nuisance("valve.clearance_volume", 0.02, of_valve("clearance_volume")),
    Nuisance("valve.moving_mass", 0.005, of_valve("moving_mass")),
    Nuisance("valve.spring_rate", 0.01, of_valve("spring_rate")),
    Nuisance("engine.bore", 0.0006, of_engine("bore"), engine_only=True),
    Nuisance("engine.rod_length", 0.001, of_engine("rod_length"), engine_only=True),
    Nuisance("engine.compression_ratio", 0.005, of_engine("compression_ratio"), engine_only=True),
)
"""Shares that a calliper (0.05 mm of 38 mm, 0.03 mm of 9 mm), a filling with oil, and a scale leave open."""
SCATTER = {
    "supply.pressure": 0.003,
    "supply.temperature": 0.5,
    "valve.viscous_friction": 0.03,
    "valve.solenoid.dead_time": 0.03e-3,
}
"""Standard deviations by which runs differ: a regulator, the room, the grease, and the coil's warmth."""
UNITS = {
    "valve.solenoid.dead_time": ("ms", 1e3),
    "supply.temperature": ("K", 1.0),
    "engine.friction.constant": ("kPa", 1e-3),
    "tdc_error": ("deg", np.degrees(1.0)),
}
"""Units of what is no share, and their factors from SI."""
UNSAID = ("air.heat_capacity_ratio",)
"""What no laboratory states."""
CHANNEL_UNITS = {"lift": ("mm", 1e3)}
PRESSURE = ("kPa", 1e-3)


def rig_nuisances(bench, channels, stated):
    """What a laboratory's rig is off in, with the standard deviations that it is drawn with.

    Parameters
    ----------
    bench : str
    channels : sequence of str
    stated : bool
        The laboratory states how far it knows its rig.

    Returns
    -------
    tuple of truth.sealed.nuisances.Nuisance
    """
    share = 1.0 if stated else MEASURED_WELL
    own = [one for one in GEOMETRY if bench == ENGINE or not one.engine_only]
    geometry = [one._replace(deviation=share * one.deviation) for one in own]
    return (*(one._replace(deviation=WIDER * one.deviation) for one in nuisances_for(bench, channels)), *geometry)


def draw_heavy(rng, nuisance):
    """A value of a distribution with heavy tails, SI or a share."""
    lowest = SMALLEST_SHARE if nuisance.name in SHARES else -np.inf
    while True:
        x = float(rng.standard_t(FREEDOM))
        value = nuisance.deviation * x / SPREAD
        if abs(x) <= FARTHEST and value >= lowest:
            return value


def run_scatter():
    """What runs differ by, as nuisances."""
    by_name = {one.name: one for one in NUISANCES}
    return tuple(by_name[name]._replace(deviation=deviation) for name, deviation in SCATTER.items())


def key_of(name):
    """Key of a nuisance in a machine file."""
    channel, _, error = name.partition(" ")
    if error:
        return f"effects.sensor_{error}.{channel}"
    return f"effects.{name}.angle" if name == "tdc_error" else name


def stated_lines(nuisances):
    """Lines of measured.toml that state how far the rig is known."""
    lines = ["[known_to]"]
    for one in nuisances:
        channel, _, error = one.name.partition(" ")
        if one.name in UNSAID:
            continue
        key = f"sensor.{channel}.{error}" if error else key_of(one.name)
        unit, factor = UNITS.get(one.name, CHANNEL_UNITS.get(channel, PRESSURE) if error == "offset" else ("%", 100.0))
        lines.append(f'"{key}" = "{one.deviation * factor:.4g} {unit}"')
    return lines


def assumed(nuisances, stated):
    """Standard deviations that a program goes by, by the key of the machine file: what is stated, else the usual prior.

    0: the number counts as exact.
    """
    usual = {one.name: one.deviation for one in NUISANCES}
    return {
        key_of(one.name): one.deviation if stated and one.name not in UNSAID else usual.get(one.name, 0.0)
        for one in nuisances
    }


def scattered(rig: Rig, values):
    """A rig as it is in one run."""
    for one in run_scatter():
        rig = one.add(rig, values[one.name])
    return rig
