"""The operating points of a sweep, in the order of their numbers."""

import re
from itertools import product
from typing import NamedTuple

from apesim.engine.angles import TURN
from apesim.engine.cylinder import CAM, EPV, IDEAL_VALVE
from apesim.engine.machine import Machine
from apesim.quantities.units import NUMBER
from apesim.studies.sweep.variation import Variation

TIMINGS = (FIXED, CORRECTED) = (0, 1)
TIMING_NAMES = ("fixed", "corrected")
ACTUATIONS = {
    "epv": (EPV, FIXED),
    "epv corrected": (EPV, CORRECTED),
    "cam": (CAM, FIXED),
    "ideal": (IDEAL_VALVE, FIXED),
}
"""What moves the intake, and whether its commands are the machine's own or corrected."""


class Point(NamedTuple):
    """One operating point of a plan."""

    run: int
    machine: Machine
    speed: float
    """[rad/s]"""
    timing: int
    """`FIXED`: the machine's own command angles; `CORRECTED`: those that meet its targets."""
    combination: int
    """Number of its machine in the variation."""
    trace_start: float
    """Crank angle of the traces' first row [rad]."""


class Plan(NamedTuple):
    """All operating points of a sweep: a full grid."""

    points: list
    """Points, each a `Point`; the last axis runs fastest."""
    axes: dict
    """Texts of the values of each axis by its name, which is that of a variable in the archive."""
    variation: Variation


def actuations_of(intakes, timings):
    """Names in `ACTUATIONS`: only an electro-pneumatic valve has commands to correct.

    Parameters
    ----------
    intakes : sequence of int
        Codes of `apesim.engine.cylinder.INTAKES`.
    timings : sequence of int

    Returns
    -------
    list of str
    """
    pairs = [(intake, timing) for intake in intakes for timing in (timings if intake == EPV else (FIXED,))]
    names = {pair: name for name, pair in ACTUATIONS.items()}
    return [names[pair] for pair in pairs]


def plan(variation, speeds, intakes, timings=(FIXED,)):
    """Operating points: every actuation, every machine, every speed.

    Parameters
    ----------
    variation : apesim.studies.sweep.variation.Variation
    speeds : sequence of float
        [rad/s]
    intakes : sequence of int
        Codes of `apesim.engine.cylinder.INTAKES`.
    timings : sequence of int
        Of the electro-pneumatic valve.

    Returns
    -------
    Plan
    """
    actuations = actuations_of(intakes, timings)
    trace_start = variation.machines[0].command.energise
    points = []
    for name, (number, machine), speed in product(actuations, enumerate(variation.machines), speeds):
        intake, timing = ACTUATIONS[name]
        machine = machine._replace(engine=machine.engine._replace(intake=intake))
        points.append(Point(len(points), machine, speed, timing, number, trace_start))
    axes = {"actuation": actuations}
    axes |= {axis.name: list(axis.texts) for axis in variation.axes}
    axes["speed_rpm"] = [f"{rpm(speed):.12g} r/min" for speed in speeds]
    return Plan(points, axes, variation)


def rpm(speed):
    """A speed [rad/s] in revolutions per minute, without the noise of its conversion."""
    return float(f"{speed / TURN * 60.0:.12g}")


def actuation_of(point):
    """Code of what moves a point's intake: its place in `ACTUATIONS`."""
    return list(ACTUATIONS.values()).index((point.machine.engine.intake, point.timing))


def in_one_unit(texts):
    """Numbers of the texts of an axis, where they have one unit.

    Parameters
    ----------
    texts : list of str

    Returns
    -------
    numbers : list of str
        The texts themselves, if they are no numbers of one unit.
    unit : str
        "" without any.
    """
    found = [re.fullmatch(rf"({NUMBER}|inf)( .*)?", text) for text in texts]
    units = {match and (match[3] or "").strip() for match in found}
    if None in units or len(units) > 1:
        return texts, ""
    return [match[1] for match in found], units.pop()
