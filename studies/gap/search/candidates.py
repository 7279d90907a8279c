"""What the library offers to close a gap: every effect that the machine does not have yet, as parameters to fit."""

from itertools import product
from typing import NamedTuple

from apesim.engine.effects import intake_pipe_loss
from apesim.quantities.trees import fields
from apesim.studies.estimation.parameters import Parameter
from apesim.valve.effects import supply_droop

SHAPES = {
    "coulomb_friction": ("breakaway",),
    "stribeck_friction": ("speed",),
    "end_cushion": ("length",),
    "supply_droop": ("volume",),
}
"""Parameters beside the strength that a fit may free."""
INVERSE = {"supply_droop": supply_droop.MIN_AREA, "intake_pipe_loss": intake_pipe_loss.MIN_AREA}
"""Effects whose strength is an area that does the less the larger it is; the least of it [m2]."""
APART = {"cylinder_wall_heat": ("h",), "coulomb_friction": ("force",)}
"""Strengths that are searched for, where they are not all."""
NUISANCES = ("sensor_gain", "sensor_offset", "time_zero")
"""Effects of the library that are no physics to be named, but known within a prior."""
TWINS = {
    "groove.effective_area": "groove_area_error",
    "engine.exhaust.effective_area": "exhaust_restriction",
    "engine.friction.constant": "friction_torque",
    "effects.tdc_error.angle": "tdc_error",
}
"""Nuisances that, far from their prior, are an effect of the library by another name."""
SIZES, INVERSE_SIZES = (0.01, 0.25, -0.25), (0.1, 0.5)
"""Sizes of probes, in units of a strength's x."""
LARGE_SIZES = {"bounce": (0.25, 0.5, 0.75, 1.0)}
"""Sizes of probes of effects whose slope at zero vanishes, and that look otherwise at each size."""
REACH = 1.3
"""How far beyond its range a strength may be fitted: an effect that ends there by its interval is not the one."""


class Candidate(NamedTuple):
    """An effect of the library, switched off."""

    name: str
    strengths: tuple
    """Parameters, x = 0: off; one or several."""
    shapes: tuple
    """Further parameters that a fit may free."""

    @property
    def parameters(self):
        """All that a fit frees."""
        return self.strengths + self.shapes

    def switched_on(self, number, size, shapes):
        """Its x with one of the strengths at a size, and with given shapes."""
        return (*(size if k == number else 0.0 for k in range(len(self.strengths))), *shapes)


class Probe(NamedTuple):
    """One way to switch a candidate on a little."""

    candidate: Candidate
    x: tuple
    """Values x of the candidate's parameters."""
    strength: int
    """Which of the strengths."""

    @property
    def parameter(self):
        """The strength that it switches on."""
        return self.candidate.strengths[self.strength]

    @property
    def one_sided(self):
        """Whether its strength has one sign only."""
        return self.parameter.low >= 0.0

    def scaled(self, factor):
        """Its x with so many times the strength, within the range that a fit may take."""
        x = list(self.x)
        size = x[self.strength] * factor
        x[self.strength] = float(min(max(size, self.parameter.low), self.parameter.high))
        return tuple(x)


def candidates_of(machine, bench, effects):
    """The effects that may be missing.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    bench : {"valve", "engine"}
    effects : sequence of apesim.effect.Effect
        The library.

    Returns
    -------
    list of Candidate
    """
    found = []
    for effect in effects:
        if effect.name in NUISANCES or effect.tabulated or effect.is_on(getattr(machine.effects, effect.name)):
            continue
        names = effect.strengths or effect.parameters._fields[:1]
        strengths = [n for n in names if n in APART.get(effect.name, names)]
        found.append(
            Candidate(
                effect.name,
                tuple(strength(effect, name) for name in strengths),
                tuple(_shape(effect, name) for name in SHAPES.get(effect.name, ())),
            )
        )
    return found


def strength(effect, name):
    """A strength of an effect as a parameter, x = 0: off."""
    key = f"effects.{effect.name}.{name}"
    declared = fields(effect.parameters)[name]
    low, high = declared.ends
    if effect.name in INVERSE:
        least = INVERSE[effect.name]
        return Parameter(key, least, least / high, 1.0, effect.off, inverse=True)
    away = max(high - effect.off, effect.off - low, key=abs)
    ends = sorted((REACH * (low - effect.off) / away, REACH * (high - effect.off) / away))
    outside = {"outside": declared, "is_sensed": effect.slots == ("sensor",)} if effect.is_from_outside else {}
    return Parameter(key, away, *ends, effect.off, reach=REACH, **outside)


def _shape(effect, name):
    key = f"effects.{effect.name}.{name}"
    low, high = fields(effect.parameters)[name].ends
    return Parameter(key, high - low, 0.0, 1.0, low)


def probes_of(candidate):
    """How a candidate is probed: each strength by a little and by a quarter of its range, with shapes spread.

    Those whose slope at zero vanishes are seen by the finite steps alone.
    """
    for number, strength in enumerate(candidate.strengths):
        sizes = INVERSE_SIZES if strength.inverse else LARGE_SIZES.get(candidate.name, SIZES)
        for size, *shapes in product(sizes, *((0.1, 0.6) for _ in candidate.shapes)):
            if strength.low <= size <= strength.high:
                yield Probe(candidate, candidate.switched_on(number, size, shapes), number)
