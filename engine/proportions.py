"""Proportions: which numbers of a machine belong to the same dimension, so that one is not changed without the others.

Every key that is left out is the default machine's, which is of one size. A valve of another stroke with the default
valve's mass, clearance and groove is a machine that nobody meant.
"""

from collections.abc import Iterator
from math import isinf
from typing import Any, NamedTuple

from apesim.engine.cylinder import EPV
from apesim.quantities.settings import differences
from apesim.quantities.trees import Leaf, overruled, schema


class Proportion(NamedTuple):
    """A key of the machine file, and the dimensions that its number belongs to."""

    key: str
    belongs_to: tuple[str, ...]
    reason: str
    """Why it changes with them."""


class Unscaled(NamedTuple):
    """A number that is still the default machine's, though a dimension that it belongs to is not."""

    key: str
    value: str
    """The default machine's, with its unit."""
    changed: tuple[str, ...]
    """Keys of the dimensions that were changed."""
    reason: str
    """Why it changes with them."""


VALVE = "valve.stroke", "valve.piston_area"
"""Dimensions of the valve's piston."""
CYLINDER = "engine.bore", "engine.stroke"
"""Dimensions of the engine's cylinder."""
PROPORTIONS = (
    Proportion("valve.moving_mass", VALVE, "a piston of another size has another mass"),
    Proportion("valve.clearance_volume", VALVE, "the dead volume of a chamber grows with its piston"),
    Proportion("valve.spring_rate", VALVE, "springs are chosen for the mass and the stroke"),
    Proportion("valve.viscous_friction", VALVE[1:], "it was identified on the default valve's piston"),
    Proportion("valve.solenoid.effective_area", VALVE, "it fills the chambers: their volume sets the time of a stroke"),
    Proportion(
        "groove.effective_area", (*VALVE, *CYLINDER), "the groove is as long as the lift and fills the cylinder"
    ),
    Proportion("groove.lap", VALVE[:1], "it is a part of the stroke"),
    Proportion("groove.ports.diameter", VALVE, "the ports stand round the piston and open within its stroke"),
    Proportion("groove.ports.groove_width", VALVE[:1], "the groove passes over the ports within the stroke"),
    Proportion("groove.ports.passage_area", VALVE, "the passage is in the piston"),
    Proportion("engine.cam.lift", VALVE[:1], "left out, it is the valve's stroke"),
    Proportion("engine.cam.opens", ("command.open_target",), "cam and valve are compared over one window"),
    Proportion("engine.cam.closes", ("command.close_target",), "cam and valve are compared over one window"),
    Proportion("engine.rod_length", CYLINDER[1:], "rods are some 1.5 to 2 strokes long"),
    Proportion("engine.exhaust.effective_area", CYLINDER, "an exhaust valve grows with its cylinder"),
    Proportion("engine.receiver.volume", CYLINDER, "the default's is two swept volumes of its engine"),
    Proportion("shaft.inertia", CYLINDER, "a flywheel is chosen for the work of a cycle"),
    Proportion("engine.receiver.feed_area", CYLINDER, "it passes the air of an engine of that size"),
)
"""Numbers that belong together, each with the reason: the one place that says so."""
LIFT_OF_CAM, STROKE_OF_VALVE = "engine.cam.lift", "valve.stroke"
"""A cam's lift that is given, and is the default valve's stroke: as files have it that were printed whole."""


def find_unscaled(machine: Any) -> Iterator[Unscaled]:
    """Find the numbers that are still the default machine's, though a dimension that they belong to is not.

    See `PROPORTIONS`. Keys that have no effect are left out, and those of the valve where another intake is at work.

    >>> from apesim.engine.machine import Machine
    >>> [row.key for row in find_unscaled(Machine().with_(engine_stroke="60 mm"))][:2]
    ['groove.effective_area', 'engine.rod_length']
    """
    leaves = {leaf.key: leaf for leaf in schema(type(machine), machine)}
    standard = {leaf.key: leaf.default for leaf in schema(type(machine))}
    changed = {key for key, _ in differences(machine)}
    idle = {key for key, _ in overruled(machine)}
    if leaves[LIFT_OF_CAM].default == standard[STROKE_OF_VALVE]:
        changed -= {LIFT_OF_CAM}
    elif LIFT_OF_CAM not in changed:
        idle |= {LIFT_OF_CAM}  # it follows
    if isinf(machine.engine.receiver.volume):
        idle |= {"engine.receiver.feed_area"}
    if machine.engine.intake != EPV:
        idle |= {key for key in leaves if key.startswith("valve.") and key != STROKE_OF_VALVE}
    for key, belongs_to, reason in PROPORTIONS:
        moved = tuple(each for each in belongs_to if each in changed - idle)
        if moved and key not in changed | idle:
            yield Unscaled(key, _shown(leaves[key]), moved, reason)


def _shown(leaf: Leaf) -> str:
    return leaf.declaration.render(leaf.default)
