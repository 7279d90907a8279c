"""Warnings: what a user should know of a run of the valve's bench."""

from enum import IntEnum
from typing import TYPE_CHECKING

from apesim.march.error_bounds import MAX_CLOSURE, MAX_QUADRATURE_CHANGE
from apesim.valve.ledger import logged_motion
from apesim.valve.measures import Travel

if TYPE_CHECKING:
    from apesim.valve.bench import BenchRun


class BenchWarning(IntEnum):
    """Kinds of what may be wrong with a run of the bench."""

    NOT_PERIODIC = 0
    SUBHARMONIC = 1
    STAYS_CLOSED = 2
    OPENS_PARTLY = 3
    STAYS_OPEN = 4
    CLOSES_PARTLY = 5
    BETWEEN_STOPS = 6
    CONTROL_BELOW_AMBIENT = 7
    CLOSURE = 8
    QUADRATURE = 9


TRAVEL_TEXTS = {
    Travel.STAYS_CLOSED: "does not open: its piston stays on the closed stop; energise it for longer",
    Travel.OPENS_PARTLY: "does not open fully: its lift reaches {highest:.3g} of {stroke:.3g} mm; "
    "energise it for longer",
    Travel.STAYS_OPEN: "does not close: its piston stays on the open stop; release it for longer",
    Travel.CLOSES_PARTLY: "does not close fully: its lift falls to {lowest:.3g} of {stroke:.3g} mm; "
    "release it for longer",
    Travel.BETWEEN_STOPS: "neither opens nor closes fully: its lift goes from {lowest:.3g} to {highest:.3g} of "
    "{stroke:.3g} mm; give both strokes more time",
}
"""Texts of travels that are not complete, for lifts in millimetres."""
UNDER_WAY = (
    "the valve does not open fully: its lift reaches {highest:.3g} of {stroke:.3g} mm, and is {end:.3g} mm where the "
    "run ends; energise it for longer, or raise the control pressure, and end the run later"
)
"""Text of a single run that ends under way between the stops, for lifts in millimetres."""
CONTROL_BELOW_AMBIENT = (
    "the control pressure, {control:.4g} MPa abs, is below that of the vents, {vent:.4g} MPa abs: control air flows "
    "back into its supply, and counts negative; raise it"
)
"""Text for control air below the pressure of the vents, both in MPa abs."""


def travel_text(travel: Travel, stroke: float, lowest: float, highest: float) -> str:
    """Return the text of a travel that is not complete: what happened, and what to change.

    `stroke` of the piston, its `lowest` and its `highest` lift in [m].

    >>> print(travel_text(Travel.OPENS_PARTLY, 9e-3, 0.0, 5e-3))
    the valve does not open fully: its lift reaches 5 of 9 mm; energise it for longer, or raise the control pressure
    """
    lowest, highest = (1e3 * min(max(lift, 0.0), stroke) for lift in (lowest, highest))
    text = TRAVEL_TEXTS[travel].format(lowest=lowest, highest=highest, stroke=1e3 * stroke)
    return f"the valve {text}, or raise the control pressure"


def control_text(control: float, vent: float) -> str:
    """Return the text for control air below the pressure of the vents, both [Pa abs]; it says what to change."""
    return CONTROL_BELOW_AMBIENT.format(control=control * 1e-6, vent=vent * 1e-6)


def closure_text(mass: float, energy: float) -> str:
    """Return the text for a run whose mass or energy do not close, with the relative closures and what is promised."""
    return f"mass closes to {mass:.1e}, energy to {energy:.1e}; {MAX_CLOSURE:g} is promised: please report this run"


def quadrature_text(work: str, change: float) -> str:
    """Return the text for a work that differs between ledger and quadrature, by the relative `change`."""
    return f"{work} by quadrature is off by {change:.1e}; {MAX_QUADRATURE_CHANGE:g} is promised: please report this run"


def judge_bench(run: "BenchRun") -> dict[BenchWarning, str]:
    """Find what a user should know of a run of the bench that did not end early: what was found, and what to change."""
    told, orbit, closure, actuator = {}, run.orbit, run.closure, run.p.actuator
    if orbit and not orbit.converged:
        told[BenchWarning.NOT_PERIODIC] = (
            f"not periodic after {orbit.cycles} cycles; the numbers are those of one cycle"
        )
    if orbit and orbit.period > 1:
        told[BenchWarning.SUBHARMONIC] = (
            f"the motion repeats only after {orbit.period} cycles; the numbers are those of one"
        )
    if run.travel != Travel.COMPLETE:
        stroke = actuator.valve.stroke
        lifts = stroke - logged_motion(run.log)[0]
        text = travel_text(run.travel, stroke, lifts.min() if orbit else lifts[-1], lifts.max())
        if run.travel == Travel.BETWEEN_STOPS and not orbit:  # it starts closed: it does not swing between two lifts
            text = UNDER_WAY.format(highest=1e3 * lifts.max(), stroke=1e3 * stroke, end=1e3 * max(lifts[-1], 0.0))
        told[BenchWarning[run.travel.name]] = text
    if run.p.supply.control.pressure < actuator.vent_pressure:
        told[BenchWarning.CONTROL_BELOW_AMBIENT] = control_text(run.p.supply.control.pressure, actuator.vent_pressure)
    if max(closure["mass"], closure["energy"]) > MAX_CLOSURE:
        told[BenchWarning.CLOSURE] = closure_text(closure["mass"], closure["energy"])
    if closure["work"] > MAX_QUADRATURE_CHANGE:
        told[BenchWarning.QUADRATURE] = quadrature_text("the piston's work", closure["work"])
    return told
