"""What a user should know of a run of the valve's bench."""

from enum import IntEnum

from apesim.march.adaptive import LOG_HEAD
from apesim.march.error_bounds import MAX_CLOSURE, MAX_QUADRATURE_CHANGE
from apesim.valve.measures import Travel


class BenchWarning(IntEnum):
    """What may be wrong with a run of the bench."""

    NOT_PERIODIC = 0
    EVERY_SECOND_CYCLE = 1
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
"""Of travels that are not complete, for lifts in millimetres."""
CONTROL_BELOW_AMBIENT = (
    "the control pressure, {control:.4g} MPa abs, is below that of the vents, {vent:.4g} MPa abs: control air flows "
    "back into its supply, and counts negative; raise it"
)


def travel_text(travel, stroke, lowest, highest):
    """What is told of a travel that is not complete.

    Parameters
    ----------
    travel : apesim.valve.measures.Travel
    stroke, lowest, highest : float
        Of the piston, and its lifts [m].

    Returns
    -------
    str
    """
    lowest, highest = (1e3 * min(max(lift, 0.0), stroke) for lift in (lowest, highest))
    text = TRAVEL_TEXTS[travel].format(lowest=lowest, highest=highest, stroke=1e3 * stroke)
    return f"the valve {text}, or raise the control pressure"


def control_text(control, vent):
    """What is told of control air below the pressure of the vents, both [Pa abs]."""
    return CONTROL_BELOW_AMBIENT.format(control=control * 1e-6, vent=vent * 1e-6)


def closure_text(mass, energy):
    """What is told where mass or energy do not close as they should."""
    return f"mass closes to {mass:.1e}, energy to {energy:.1e}; {MAX_CLOSURE:g} is promised: please report this run"


def quadrature_text(work, change):
    """What is told where a work, by name, is another by quadrature than by the ledger."""
    return f"{work} by quadrature is off by {change:.1e}; {MAX_QUADRATURE_CHANGE:g} is promised: please report this run"


def judge_bench(run):
    """What a user should know of a run of the bench.

    Parameters
    ----------
    run : apesim.valve.bench.BenchRun
        One that did not end early.

    Returns
    -------
    dict of BenchWarning to str
        Each with what was found and what to change.
    """
    told, orbit, closure, actuator = {}, run.orbit, run.closure, run.p.actuator
    if orbit and not orbit.converged:
        told[BenchWarning.NOT_PERIODIC] = (
            f"not periodic after {orbit.cycles} cycles; the numbers are those of one cycle"
        )
    if orbit and orbit.period == 2:
        told[BenchWarning.EVERY_SECOND_CYCLE] = (
            "the motion repeats only every second cycle; the numbers are those of one"
        )
    if run.travel != Travel.COMPLETE:
        stroke = actuator.valve.stroke
        lifts = stroke - run.log[:, LOG_HEAD]
        lowest = lifts.min() if orbit else lifts[-1]  # a single run starts closed
        told[BenchWarning[run.travel.name]] = travel_text(run.travel, stroke, lowest, lifts.max())
    if run.p.supply[0] < actuator.vent_pressure:
        told[BenchWarning.CONTROL_BELOW_AMBIENT] = control_text(run.p.supply[0], actuator.vent_pressure)
    if max(closure["mass"], closure["energy"]) > MAX_CLOSURE:
        told[BenchWarning.CLOSURE] = closure_text(closure["mass"], closure["energy"])
    if closure["work"] > MAX_QUADRATURE_CHANGE:
        told[BenchWarning.QUADRATURE] = quadrature_text("the piston's work", closure["work"])
    return told
