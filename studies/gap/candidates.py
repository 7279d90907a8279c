"""What the library offers to close a gap: every effect that the machine does not have yet, as parameters to fit."""

from itertools import product
from typing import NamedTuple

from studies.gap.parameters import DECLARED, Parameter

SHAPES = {
    "coulomb_friction": ("breakaway",),
    "stribeck_friction": ("speed",),
    "end_cushion": ("length",),
    "supply_droop": ("volume",),
}
"""Parameters beside the strength that a fit may free."""
APART = {"cylinder_wall_heat": ("h",), "coulomb_friction": ("force",)}
"""Strengths that are searched for, where they are not all."""
NUISANCES = ("sensor_gain", "sensor_offset", "time_zero")
"""Effects of the library that are no physics to be named, but known within a prior."""
ENGINE_SENSORS = ("cylinder_pressure", "receiver_pressure", "torque", "air_flow")


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


class Probe(NamedTuple):
    """One way to switch a candidate on a little."""

    candidate: Candidate
    x: tuple
    """Of the candidate's parameters."""
    strength: int
    """Which of the strengths."""


def candidates_of(machine, bench, effects):
    """The effects that may be missing.

    Parameters
    ----------
    machine : engine.machine.Machine
    bench : {"valve", "engine"}
    effects : sequence of apesim.effect.Effect
        The library.

    Returns
    -------
    list of Candidate
    """
    found = []
    for effect in effects:
        if effect.name in NUISANCES or effect.is_on(getattr(machine.effects, effect.name)):
            continue
        names = effect.strengths or effect.parameters._fields[:1]
        strengths = [n for n in names if n in APART.get(effect.name, names)]
        found.append(
            Candidate(
                effect.name,
                tuple(_strength(effect, name) for name in strengths),
                tuple(_shape(effect, name) for name in SHAPES.get(effect.name, ())),
            )
        )
    return found


def _strength(effect, name):
    key = f"effects.{effect.name}.{name}"
    low, high = DECLARED[key].ends
    away = max(high - effect.off, effect.off - low, key=abs)
    ends = sorted(((low - effect.off) / away, (high - effect.off) / away))
    return Parameter(key, away, *ends, effect.off)


def _shape(effect, name):
    key = f"effects.{effect.name}.{name}"
    low, high = DECLARED[key].ends
    return Parameter(key, high - low, 0.0, 1.0, low)


def probes_of(candidate):
    """How a candidate is probed: each strength by a little and by a quarter of its range, with shapes spread.

    Those whose slope at zero vanishes are seen by the finite step alone.
    """
    for number, strength in enumerate(candidate.strengths):
        for size, *shape in product((0.01, 0.25, -0.25), *((0.1, 0.6) for _ in candidate.shapes)):
            if not strength.low <= size <= strength.high:
                continue
            x = [0.0] * len(candidate.strengths)
            x[number] = size
            yield Probe(candidate, (*x, *shape), number)
