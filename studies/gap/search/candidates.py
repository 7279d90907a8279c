"""What the library offers to close a gap: every effect that the machine does not have yet, as parameters to fit."""

from collections.abc import Iterable, Iterator
from itertools import product
from typing import Any, NamedTuple

from apesim.effect import Effect
from apesim.engine.machine import Machine
from apesim.quantities.trees import fields
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.measured import CYLINDER

SAME_IN_RECORD = {"valve.solenoid.dead_time": "time_zero"}
"""Numbers of the machine that do the same to every signal of a valve's bench as an error of the record: both edges come
later, whether the solenoids or the recorder are late."""
SIZES, INVERSE_SIZES = (0.01, 0.25, -0.25), (0.1, 0.5)
"""Sizes of probes, in units of a strength's x."""
MAX_REACH = 1.3
"""How far beyond its range a strength may be fitted: an effect that ends there by its interval is not the one."""


class Candidate(NamedTuple):
    """An effect of the library that the machine does not have yet, with the parameters that a fit may free."""

    name: str
    """Name of the effect."""
    strengths: tuple[Parameter, ...]
    """Parameters that are off at x = 0; one or several."""
    shapes: tuple[Parameter, ...]
    """Further parameters that a fit may free, without effect while the strengths are off."""
    file: str = ""
    """File that it is a fault of, see `apesim.studies.gap.search.run_faults`; "": it is an effect of the library."""
    kind: str = ""
    """Kind of the fault; "": it is an effect of the library."""
    sizes: tuple[float, ...] = ()
    """Sizes of its probes in units of a strength's x; (): the usual."""

    @property
    def is_file_number(self) -> bool:
        """Whether it is a number of the machine file that may be wrong."""
        return any(strength.is_file_number for strength in self.strengths)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters that a fit frees: the strengths, then the shapes."""
        return self.strengths + self.shapes

    def switch_on(self, number: int, size: float, shapes: Iterable[float]) -> tuple[float, ...]:
        """Values x of the parameters, in their order, with one strength at a size, the others off, and given shapes.

        `number` is the place of the strength among `strengths`, `size` its value x.
        """
        return (*(size if k == number else 0.0 for k in range(len(self.strengths))), *shapes)


class Probe(NamedTuple):
    """A candidate switched on by a given size, to see what it does to the data."""

    candidate: Candidate
    x: tuple[float, ...]
    """Values x of the candidate's parameters."""
    strength: int
    """Place of the strength that is on among the candidate's strengths."""

    @property
    def parameter(self) -> Parameter:
        """The strength that the probe switches on."""
        return self.candidate.strengths[self.strength]

    @property
    def one_sided(self) -> bool:
        """Whether the strength that the probe switches on cannot be negative."""
        return self.parameter.low >= 0.0

    def scale(self, factor: float) -> tuple[float, ...]:
        """Values x of the candidate's parameters with the probe's strength times a factor, shapes as they are.

        The strength is clipped to the range that a fit may take.
        """
        x = list(self.x)
        size = x[self.strength] * factor
        x[self.strength] = float(min(max(size, self.parameter.low), self.parameter.high))
        return tuple(x)


def find_candidates(machine: Machine, bench: str, effects: Iterable[Effect]) -> list[Candidate]:
    """The effects that may be missing: those of the library that are off in the machine, in its order.

    Tables are left out, and so are errors of the record that are known within a prior, as a sensor's gain. `effects`
    are those of `select_effects`, chosen by `bench` ("valve", "engine" or "cylinder") already.
    """
    candidates = []
    for effect in effects:
        search = effect.search
        if search.is_nuisance or effect.tabulated or effect.is_on(getattr(machine.effects, effect.name)):
            continue
        names = effect.strengths or effect.parameters._fields[:1]  # type: ignore[attr-defined]
        shapes = [name for name in search.shapes if bench != CYLINDER or name not in search.unseen_on_rig]
        strengths = [name for name in names if name in (search.strengths or names)]
        candidates.append(
            Candidate(
                effect.name,
                tuple(make_strength(effect, name) for name in strengths),
                tuple(_make_shape(effect, name) for name in shapes),
                sizes=search.sizes,
            )
        )
    return candidates


def make_strength(effect: Effect, name: str) -> Parameter:
    """A strength of an effect, by its `name`, as a scaled parameter that is off at x = 0.

    Its value is ``off + scale x``, where the scale reaches to the end of the declared range that is farther from off; a
    fit may go `MAX_REACH` times as far. An effect with a `min_area` has the value ``scale / x`` with the scale at the
    least area, as it does the less the larger it is.

    >>> from apesim.valve.effects import coulomb_friction
    >>> force = make_strength(coulomb_friction.EFFECT, "force")
    >>> force.key, force.value(0.0), force.value(0.5)
    ('effects.coulomb_friction.force', 0.0, 6.0)
    """
    key = f"effects.{effect.name}.{name}"
    declared = fields(effect.parameters)[name]
    low, high = declared.ends
    if min_area := effect.search.min_area:
        return Parameter(key, min_area, min_area / high, 1.0, effect.off, inverse=True)
    away = max(high - effect.off, effect.off - low, key=abs)
    first, last = sorted((MAX_REACH * (low - effect.off) / away, MAX_REACH * (high - effect.off) / away))
    return Parameter(key, away, first, last, effect.off, reach=MAX_REACH, **_from_outside(effect, name))


def _make_shape(effect: Effect, name: str) -> Parameter:
    """A shape of an effect as a parameter: x = 0 and 1 are the ends of its declared range."""
    key = f"effects.{effect.name}.{name}"
    low, high = fields(effect.parameters)[name].ends
    return Parameter(key, high - low, 0.0, 1.0, low, **_from_outside(effect, name))


def _from_outside(effect: Effect, name: str) -> dict[str, Any]:
    """What a parameter of an effect from outside brings along; of ours, the machine's class knows it."""
    if not effect.is_from_outside:
        return {}
    return {"outside": fields(effect.parameters)[name], "is_sensed": effect.slots == ("sensor",)}


def list_probes(candidate: Candidate) -> Iterator[Probe]:
    """The probes of a candidate: each strength by a little and by a quarter of its range, with shapes spread.

    An effect whose slope at zero vanishes is seen by the large probes alone.

    >>> from apesim.valve.effects import side_force
    >>> (force,) = find_candidates(Machine(), "valve", [side_force.EFFECT])
    >>> [probe.x for probe in list_probes(force)]
    [(0.01,), (0.25,), (-0.25,)]
    """
    for number, strength in enumerate(candidate.strengths):
        sizes = INVERSE_SIZES if strength.inverse else candidate.sizes or SIZES
        for size, *shapes in product(sizes, *((0.1, 0.6) for _ in candidate.shapes)):
            if strength.low <= size <= strength.high:
                yield Probe(candidate, candidate.switch_on(number, size, shapes), number)
