"""Questions that a builder can answer from a drawing, a data sheet or a test, in the order in which they are asked."""

from difflib import get_close_matches
from functools import cache
from typing import Any, NamedTuple

from apesim.engine.machine import Machine
from apesim.quantities import Quantity
from apesim.quantities.trees import schema, spellings
from apesim.studies.run.operating_conditions import SPEED, VOLUME

CONDUCTANCE = Quantity("dm^3/(s bar)", 0.001, 100, "ISO 6358", typical="1.8 dm^3/(s bar)")
CRITICAL_RATIO = Quantity("", 0.05, 0.6, "ISO 6358", typical="0.3")
"""What is asked and is no key of a machine file, besides a speed and a volume."""


class Question(NamedTuple):
    """Question to a builder."""

    name: str
    """Name of the answer, on the command line and from Python."""
    text: str
    """What is asked, as it stands before the unit."""
    key: str = ""
    """Key of the machine file that is answered; "" where the answer is no key."""


QUESTIONS = (
    Question("ambient_pressure", "pressure of the surroundings", "ambient.pressure"),
    Question("ambient_temperature", "temperature of the surroundings", "ambient.temperature"),
    Question("supply_pressure", "pressure of the supply, behind its regulator", "supply.pressure"),
    Question("supply_temperature", "temperature of the supply", "supply.temperature"),
    Question("control_pressure", "pressure of the valve's control air", "supply.control_pressure"),
    Question("bore", "bore of the cylinder", "engine.bore"),
    Question("stroke", "stroke of the engine", "engine.stroke"),
    Question("compression_ratio", "compression ratio, (swept + clearance)/clearance", "engine.compression_ratio"),
    Question("rated_speed", "rated speed"),
    Question("piston_diameter", "diameter of the intake valve's piston", "valve.piston_area"),
    Question("valve_stroke", "stroke of the intake valve", "valve.stroke"),
    Question("conductance", "sonic conductance C of a solenoid valve (ISO 6358)", "valve.solenoid.effective_area"),
    Question("critical_ratio", "its critical pressure ratio b (ISO 6358)"),
    Question(
        "dead_time", "dead time of a solenoid, from the signal until it begins to open", "valve.solenoid.dead_time"
    ),
    Question("ramp_time", "ramp time of a solenoid, from there until it is open", "valve.solenoid.ramp_time"),
)
"""What a builder is asked."""
DISCHARGE = (
    Question("discharge_test", "CSV of a discharge test of the solenoid valve, in place of C, b and times"),
    Question("vessel_volume", "volume of the vessel that was discharged"),
)
"""What stands in place of the last four questions, where it is answered."""
REPLACED = frozenset(question.name for question in QUESTIONS[-4:])
"""Questions that a discharge test answers."""


@cache
def declarations() -> dict[str, Any]:
    """Return what each answer may be, by the name of its question; the text of a path has none."""
    by_key = {leaf.key: leaf.declaration for leaf in schema(Machine)}
    found = {question.name: by_key[question.key] for question in QUESTIONS if question.key}
    found["piston_diameter"] = spellings(Machine)["valve.piston_diameter"].declaration
    return found | {
        "rated_speed": SPEED,
        "conductance": CONDUCTANCE,
        "critical_ratio": CRITICAL_RATIO,
        "vessel_volume": VOLUME,
    }


def find_wrong_name(name: str) -> tuple[str, str] | None:
    """Find what is wrong with the name of an answer: wrong, right; None where it is one.

    >>> find_wrong_name("bor")
    ('is no question', 'did you mean bore?')
    """
    names = [question.name for question in (*QUESTIONS, *DISCHARGE)]
    if name in names:
        return None
    near = get_close_matches(name, names, n=1)
    return "is no question", f"did you mean {near[0]}?" if near else f"give one of {', '.join(names)}"
