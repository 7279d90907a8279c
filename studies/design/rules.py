"""Rules of proportion: what follows from a builder's answers, each with its reason.

Every rule scales a number of the default machine, so that the answers of the default machine give the default machine.
"Heywood" is J. B. Heywood, Internal Combustion Engine Fundamentals, McGraw-Hill, 1988.
"""

from collections.abc import Callable, Iterator
from math import isclose, sqrt
from typing import Any, NamedTuple

from apesim.engine.angles import TURN
from apesim.engine.kinematics import swept_volume
from apesim.engine.machine import Machine
from apesim.engine.receiver import MAX_VOLUME
from apesim.quantities.trees import overruled, schema, with_value
from apesim.studies.design.estimates import Point, lap_to_lap, solenoid_for

RATED_SPEED = 1000.0 * TURN / 60.0
"""Rated speed of the default machine [rad/s]; chosen: there its valve still meets its timing."""
DIGITS = 4
"""Digits of a number that follows from a rule: no rule knows more."""


class Sizes(NamedTuple):
    """Machine in the making, over the default machine: what rules scale by."""

    machine: Machine
    """The machine, with all that is known so far."""
    rated_speed: float
    """Rated speed [rad/s]."""

    @property
    def swept(self) -> float:
        """Swept volume."""
        return swept_volume(self.machine.engine) / swept_volume(Machine().engine)

    @property
    def speed(self) -> float:
        """Rated speed."""
        return self.rated_speed / RATED_SPEED

    @property
    def demand(self) -> float:
        """Volume of air a time over the speed of sound of the supply: what the area of a port is chosen for."""
        return self.swept * self.speed / sqrt(self.machine.supply.temperature / Machine().supply.temperature)

    @property
    def work(self) -> float:
        """Work of a cycle, as gauge pressure of the supply times swept volume."""
        gauge, standard = (each.supply.pressure - each.ambient.pressure for each in (self.machine, Machine()))
        return max(gauge, 0.0) / standard * self.swept

    @property
    def groove(self) -> float:
        """Effective area of the groove."""
        return self.machine.groove.effective_area / Machine().groove.effective_area

    @property
    def piston(self) -> float:
        """Area of the valve's piston."""
        return self.machine.valve.piston_area / Machine().valve.piston_area

    @property
    def lift(self) -> float:
        """Stroke of the valve."""
        return self.machine.valve.stroke / Machine().valve.stroke

    @property
    def solenoid(self) -> float:
        """Effective area of a solenoid that serves the valve in the same crank angle."""
        time = lap_to_lap(Point(Machine(), RATED_SPEED)) / self.speed
        area = solenoid_for(Point(self.machine, self.rated_speed), time)
        return area / Machine().valve.solenoid.effective_area


class Rule(NamedTuple):
    """Rule of proportion."""

    key: str
    """Key of the machine file."""
    factor: Callable[[Sizes], float]
    """The number over the default machine's."""
    text: str
    """What it is proportional to, and why."""
    where: tuple[str, ...] = ()
    """Keys of which one has to be answered for the rule to hold; none: it holds always."""


MACH = "as swept volume x rated speed: the air is as fast (Taylor's Mach index, Heywood ch. 6)"
RULES = (
    Rule("engine.stroke", lambda at: at.machine.engine.bore / Machine().engine.bore, "1.04 bores (chosen)"),
    Rule("engine.rod_length", lambda at: at.machine.engine.stroke / Machine().engine.stroke, "1.70 strokes (chosen)"),
    Rule("groove.effective_area", lambda at: at.demand, MACH),
    Rule("engine.exhaust.effective_area", lambda at: at.demand, MACH),
    Rule(
        "engine.receiver.volume",
        lambda at: min(at.swept, MAX_VOLUME / Machine().engine.receiver.volume),
        "2.00 swept volumes, at most 1 m3 (chosen)",
    ),
    Rule("engine.receiver.feed_area", lambda at: at.demand, MACH),
    Rule(
        "shaft.inertia",
        lambda at: at.work / at.speed**2,
        "as supply pressure x swept volume / rated speed^2: the speed ripples alike (chosen)",
    ),
    Rule("valve.piston_area", lambda at: at.groove, "as the groove's area: a valve of the same shape (chosen)"),
    Rule("valve.stroke", lambda at: sqrt(at.groove), "as the root of the groove's area: the same shape (chosen)"),
    Rule("groove.lap", lambda at: at.lift, "a ninth of the valve's stroke (chosen)"),
    Rule(
        "groove.effective_area",
        lambda at: sqrt(at.piston) * at.lift,
        "as the girth of the answered valve x its stroke: 0.21 of the girth is open (chosen)",
        ("valve.piston_area", "valve.stroke"),
    ),
    Rule("valve.clearance_volume", lambda at: at.piston * at.lift, "1.12 piston area x stroke (chosen)"),
    Rule(
        "valve.moving_mass",
        lambda at: at.piston * at.lift,
        "as piston area x stroke: its length grows with the stroke (chosen)",
    ),
    Rule(
        "valve.spring_rate",
        lambda at: at.piston / at.lift,
        "as piston area / stroke: the springs are worth 15 kPa on the piston at its stops (chosen)",
    ),
    Rule(
        "valve.viscous_friction", lambda at: sqrt(at.piston), "as the piston's girth, which the seal rubs on (chosen)"
    ),
    Rule(
        "valve.solenoid.effective_area",
        lambda at: at.solenoid,
        "lap to lap in 71 deg at rated speed: t = 2 (stroke - lap) (A/(197 m/s S) + beta/(p A)) (chosen)",
    ),
)
"""Rules in the order in which they are applied: each may use what those before it gave."""
KEPT = {
    "command.energise": "an angle has no size; apesim engine timing corrects it",
    "command.release": "an angle has no size; apesim engine timing corrects it",
    "engine.exhaust.opens": "an angle has no size",
    "engine.exhaust.closes": "an angle has no size",
    "engine.friction.constant": "a mean pressure has no size; small engines have more",
}
"""Keys that stay the default machine's, and are said in the file, each with the reason."""


class Derived(NamedTuple):
    """Number that followed from a rule."""

    key: str
    text: str
    """Its value, with its unit."""
    rule: str
    is_clipped: bool
    """Whether the rule leads out of the range of the key, whose end was taken."""


def derive(machine: Machine, rated_speed: float, given: frozenset[str]) -> tuple[Machine, list[Derived]]:
    """Apply all rules whose keys are not `given` to a machine of some rated speed [rad/s].

    >>> derive(Machine(), RATED_SPEED, frozenset())[0] == Machine()
    True
    """
    found: dict[str, Derived] = {}
    for leaf, rule in _rules_with_leaves():
        idle = {key for key, _ in overruled(machine)}
        if rule.key in given | idle or (rule.where and not given.intersection(rule.where)):
            continue
        exact = leaf.default * rule.factor(Sizes(machine, rated_speed))
        low, high = leaf.declaration.ends
        clipped = min(max(exact, low), high)
        # A number of few digits in the unit of its key, and the default machine's own number where nothing changed.
        value = leaf.default if isclose(exact, leaf.default, rel_tol=1e-9) else _rounded(leaf.declaration, clipped)
        machine = with_value(machine, rule.key, value)
        found[rule.key] = Derived(rule.key, leaf.declaration.render(value), rule.text, clipped != exact)
    return machine, list(found.values())


def _rules_with_leaves() -> Iterator[tuple[Any, Rule]]:
    """Rules, each with the declaration and the default of its key."""
    leaves = {leaf.key: leaf for leaf in schema(Machine)}
    yield from ((leaves[rule.key], rule) for rule in RULES)


def _rounded(declaration: Any, value: float) -> float:
    """A value in SI with `DIGITS` digits in the unit of its declaration."""
    number, _, unit = declaration.render(value).partition(" ")
    text = f"{float(f'{float(number):.{DIGITS}g}'):.12f}".rstrip("0").rstrip(".")
    return declaration.read(f"{text} {unit}".strip())
