"""The operating points of a sweep, in the order of their numbers."""

import re
from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

from apesim.engine.angles import TURN
from apesim.engine.cylinder import CAM, EPV, IDEAL_VALVE
from apesim.engine.machine import Machine
from apesim.quantities.units import NUMBER
from apesim.studies.sweep.variation import Variation

TIMINGS = (FIXED, CORRECTED) = (0, 1)
"""Codes of the timing: command angles of the machine itself, or those by which the valve meets its targets."""
TIMING_NAMES = ("fixed", "corrected")
"""Names of the timings, in the order of their codes."""
ACTUATIONS = {
    "epv": (EPV, FIXED),
    "epv corrected": (EPV, CORRECTED),
    "cam": (CAM, FIXED),
    "ideal": (IDEAL_VALVE, FIXED),
}
"""What moves the intake, and whether its commands are the machine's own or corrected."""


class Point(NamedTuple):
    """One operating point of a sweep: a machine, its speed, and how its valve is timed."""

    run: int
    """Number of the run, from 0."""
    machine: Machine
    speed: float
    """Speed of the crankshaft [rad/s]."""
    timing: int
    """`FIXED`: the machine's own command angles; `CORRECTED`: those that meet its targets."""
    combination: int
    """Number of its machine in the variation."""
    trace_start: float
    """Crank angle of the traces' first row [rad]."""


class Plan(NamedTuple):
    """All operating points of a sweep: a full grid."""

    points: list[Point]
    """Points in the order of their run numbers; the last axis runs fastest."""
    axes: dict[str, list[str]]
    """Texts of the values of each axis by its name, which is that of a variable in the archive."""
    variation: Variation
    """Machines of the sweep, and the keys in which they differ."""


def actuations_of(intakes: Sequence[int], timings: Sequence[int]) -> list[str]:
    """Name the actuations that intakes and timings make: only an electro-pneumatic valve has commands to correct.

    The names of `ACTUATIONS` come in the order of the intakes, whose codes are those of
    `apesim.engine.cylinder.INTAKES`; `timings` has codes of `TIMINGS`.

    >>> actuations_of([EPV, CAM], TIMINGS)
    ['epv', 'epv corrected', 'cam']
    """
    pairs = [(intake, timing) for intake in intakes for timing in (timings if intake == EPV else (FIXED,))]
    names = {pair: name for name, pair in ACTUATIONS.items()}
    return [names[pair] for pair in pairs]


def plan(
    variation: Variation, speeds: Sequence[float], intakes: Sequence[int], timings: Sequence[int] = (FIXED,)
) -> Plan:
    """Plan the operating points of a sweep: every actuation, every machine, every speed [rad/s].

    Points are numbered from 0; speeds vary fastest, then machines, then actuations. `intakes` has codes of
    `apesim.engine.cylinder.INTAKES`; `timings` has codes of `TIMINGS` and counts for the electro-pneumatic valve only.

    >>> variation = Variation((), (Machine(),))
    >>> planned = plan(variation, [TURN * 10.0, TURN * 15.0], [EPV, CAM])
    >>> [(point.run, rpm(point.speed), actuation_of(point)) for point in planned.points]
    [(0, 600.0, 0), (1, 900.0, 0), (2, 600.0, 2), (3, 900.0, 2)]
    >>> planned.axes
    {'actuation': ['epv', 'cam'], 'speed_rpm': ['600 r/min', '900 r/min']}
    """
    actuations = actuations_of(intakes, timings)
    trace_start = variation.machines[0].command.energise
    points: list[Point] = []
    for name, (number, machine) in product(actuations, enumerate(variation.machines)):
        intake, timing = ACTUATIONS[name]
        machine = machine._replace(engine=machine.engine._replace(intake=intake))
        points += [
            Point(len(points) + at, machine, speed, timing, number, trace_start) for at, speed in enumerate(speeds)
        ]
    axes = {"actuation": actuations}
    axes |= {axis.name: list(axis.texts) for axis in variation.axes}
    axes["speed_rpm"] = [f"{rpm(speed):.12g} r/min" for speed in speeds]
    return Plan(points, axes, variation)


def rpm(speed: float) -> float:
    """Convert a speed [rad/s] to [r/min], rounded to 12 digits against the rounding noise of the conversion."""
    return float(f"{speed / TURN * 60.0:.12g}")


def actuation_of(point: Point) -> int:
    """Code the actuation of an operating point, as archives hold it: its place in `ACTUATIONS`, from 0."""
    return list(ACTUATIONS.values()).index((point.machine.engine.intake, point.timing))


def in_one_unit(texts: Sequence[str]) -> tuple[Sequence[str], str]:
    """Split the texts of an axis into numbers and the unit that all of them share ("" if there is none).

    The texts stay unchanged if they are no numbers or their units differ.

    >>> in_one_unit(["600 r/min", "900 r/min"])
    (['600', '900'], 'r/min')
    >>> in_one_unit(["ideal", "thermally_perfect"])
    (['ideal', 'thermally_perfect'], '')
    """
    matches: list[Any] = [re.fullmatch(rf"({NUMBER}|inf)( .*)?", text) for text in texts]
    units = {match and (match[3] or "").strip() for match in matches}
    if None in units or len(units) > 1:
        return texts, ""
    return [match[1] for match in matches], units.pop()


def span_of(texts: Sequence[str]) -> str:
    """Write the values of an axis in words: all of a few, else the ends and their number."""
    if len(texts) <= 4:
        return ", ".join(texts)
    numbers, unit = in_one_unit(texts)
    return " ".join(filter(None, (f"{numbers[0]} to {numbers[-1]}", unit, f"({len(texts)})")))
