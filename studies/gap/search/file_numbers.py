"""Numbers of the machine file that count as exact, as candidates beside the effects of the library.

A stroke, an area or an angle that was taken off the wrong drawing is what users err in most, and no effect of the
library stands for it. Each such number is tried as one candidate; what is found is no physics that is missing.
"""

from collections.abc import Iterator, Sequence
from math import isfinite, radians
from typing import NamedTuple

from apesim.effect import Effect, Misstated
from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.studies.estimation.parameters import DECLARED, Parameter, value_of
from apesim.studies.estimation.priors import find_idle, has_number, priors_of
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.measured import CYLINDER, ENGINE, VALVE, Bench, Measured

MAX_SIZES = 6.0
"""Sizes up to which a number may be wrong: a length by 60 %, an angle by 60 deg."""


class Suspect(NamedTuple):
    """A number of the machine file that may be wrong."""

    key: str
    size: float
    """Size of an error that a search begins with: a share of the number where it is relative, else SI; negative: the
    file says too much."""
    relative: bool = True
    """Whether the size is a share of the number."""
    lowest: float = -MAX_SIZES
    """Sizes up to which it may be wrong in the other way; 0: in this way alone."""


SUSPECTS = {
    VALVE: (
        Suspect("valve.stroke", 0.1),
        Suspect("valve.piston_area", 0.1),
        Suspect("valve.moving_mass", 0.1),
        Suspect("valve.spring_rate", 0.1),
        # A volume that the file leaves out is the effect dead_volume; one that it counts twice is not.
        Suspect("valve.clearance_volume", -0.1, lowest=0.0),
        Suspect("valve.solenoid.ramp_time", 0.1),
    ),
    ENGINE: (
        Suspect("engine.bore", 0.1),
        Suspect("engine.stroke", 0.1),
        Suspect("engine.rod_length", 0.1),
        Suspect("engine.compression_ratio", 0.1),
        Suspect("engine.exhaust.opens", radians(10.0), relative=False),
        Suspect("engine.exhaust.closes", radians(10.0), relative=False),
        Suspect("engine.exhaust_2.opens", radians(10.0), relative=False),
        Suspect("engine.exhaust_2.closes", radians(10.0), relative=False),
        Suspect("engine.receiver.volume", 0.25),
        Suspect("groove.lap", 0.5e-3, relative=False),
    ),
    CYLINDER: (),
}
"""Numbers without a prior of their own, by bench; those of the valve matter on an engine's, too."""


def list_suspects(bench: Bench) -> tuple[Suspect, ...]:
    """The numbers of the machine file that may be wrong on a bench."""
    return SUSPECTS[VALVE] * (bench == ENGINE) + SUSPECTS[bench]


def find_file_numbers(
    machine: Machine, measured: Measured, candidates: Sequence[Candidate], without: Sequence[str] = ()
) -> list[Candidate]:
    """The numbers of a machine that may be wrong: those that count as exact, and that no candidate stands for.

    Left out is what is stated in ``[known_to]``, as it is fitted within that or said to be exact, and what does nothing
    in this machine. `candidates` are the effects that are searched for, `without` keys that are not to be considered.

    >>> found = find_file_numbers(Machine(), Measured("", {}, (), VALVE), [])
    >>> [candidate.name for candidate in found][:3]
    ['valve.stroke', 'valve.piston_area', 'valve.moving_mass']
    """
    known = {*without, *(prior.key for prior in priors_of(machine, measured)), *_list_stood_for(machine, candidates)}
    return [
        Candidate(suspect.key, (_make_error(machine, suspect),), ())
        for suspect in list_suspects(measured.bench)
        if suspect.key not in known and _is_tried(machine, suspect)
    ]


def _is_tried(machine: Machine, suspect: Suspect) -> bool:
    """Whether a machine has a number that does something, and of which such an error can be taken."""
    number = value_of(machine, suspect.key)
    return isfinite(number) and not (suspect.relative and not number) and not find_idle(machine, suspect.key)


def list_misstated(machine: Machine, effect: Effect) -> list[Misstated]:
    """The numbers of a machine whose errors together do the same as an effect; none where one of them is overruled.

    >>> from apesim.valve.effects import slow_ramp
    >>> [each.key for each in list_misstated(Machine(), slow_ramp.EFFECT)]  # both edges have this ramp
    ['valve.solenoid.ramp_time']
    """
    there = [each for each in effect.search.misstated if has_number(machine, each.key)]
    return [] if any(find_idle(machine, each.key) for each in there) else there


def _list_stood_for(machine: Machine, candidates: Sequence[Candidate]) -> Iterator[str]:
    """Keys of the numbers that an effect among candidates stands for, on both sides of what the file says."""
    searched = {candidate.name: candidate for candidate in candidates}
    for effect in ALL_EFFECTS:
        misstated = list_misstated(machine, effect) if effect.name in searched else []
        if len(misstated) == 1 and searched[effect.name].strengths[0].low < 0.0:
            yield misstated[0].key


def _make_error(machine: Machine, suspect: Suspect) -> Parameter:
    """An error of a number as a scaled parameter that is off at x = 0."""
    number = value_of(machine, suspect.key)
    unit = suspect.size * (number if suspect.relative else 1.0)
    low, high = sorted((end - number) / unit for end in DECLARED[suspect.key].ends)
    ends = max(low, suspect.lowest), min(high, MAX_SIZES)
    return Parameter(suspect.key, suspect.size, *ends, number, shifts=True, relative=suspect.relative)
