"""Warnings about an operating point: what may be wrong with it, and what to change."""

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

from apesim.air import HOTTEST
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.indicators import valve_travel
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun
from apesim.march.error_bounds import MAX_CLOSURE, MAX_EXERGY_CLOSURE, MAX_QUADRATURE_CHANGE, MAX_TOLERANCE_CHANGE
from apesim.march.periodic import Orbit
from apesim.valve.ledger import logged_motion
from apesim.valve.measures import Travel
from apesim.valve.warnings import closure_text, control_text, quadrature_text, travel_text

TEMPERATURE = TRACE.index("cylinder_temperature [K]")
"""Column of a trace that holds the cylinder's temperature."""


class EngineWarning(IntEnum):
    """Kinds of warning about an operating point."""

    NOT_PERIODIC = 0
    SUBHARMONIC = 1
    NO_BRAKE_WORK = 2
    STAYS_CLOSED = 3
    OPENS_PARTLY = 4
    STAYS_OPEN = 5
    CLOSES_PARTLY = 6
    BETWEEN_STOPS = 7
    CONTROL_BELOW_AMBIENT = 8
    ABOVE_ISENTROPIC = 9
    BEYOND_CP = 10
    CLOSURE = 11
    QUADRATURE = 12
    WORK_TOLERANCE = 13
    AIR_TOLERANCE = 14
    EXERGY_CLOSURE = 15

    @property
    def summary(self) -> str:
        """Short text of the warning."""
        return SUMMARIES[self]

    @property
    def is_incomplete_stroke(self) -> bool:
        """Whether the warning is of a valve that does not open and close fully in every cycle."""
        return self.name in Travel.__members__


SUMMARIES = {
    EngineWarning.NOT_PERIODIC: "the state does not repeat",
    EngineWarning.SUBHARMONIC: "the state repeats only after some cycles",
    EngineWarning.NO_BRAKE_WORK: "brake work is not positive",
    EngineWarning.STAYS_CLOSED: "the valve does not open",
    EngineWarning.OPENS_PARTLY: "the valve does not open fully",
    EngineWarning.STAYS_OPEN: "the valve does not close",
    EngineWarning.CLOSES_PARTLY: "the valve does not close fully",
    EngineWarning.BETWEEN_STOPS: "the valve neither opens nor closes fully",
    EngineWarning.CONTROL_BELOW_AMBIENT: "the control pressure is below that of the vents",
    EngineWarning.ABOVE_ISENTROPIC: "more than isentropic work",
    EngineWarning.BEYOND_CP: "the cylinder is hotter than cp(T) holds",
    EngineWarning.CLOSURE: "mass or energy does not close as promised",
    EngineWarning.QUADRATURE: "indicated work by quadrature is off by more than promised",
    EngineWarning.WORK_TOLERANCE: "indicated work hangs on the tolerance",
    EngineWarning.AIR_TOLERANCE: "engine air hangs on the tolerance",
    EngineWarning.EXERGY_CLOSURE: "exergy does not close as promised",
}
TOLERANCE_TEXT = (
    "{what} changes by {change:.1e} at ten times the tolerance, more than {most:g}: it is near zero, or the valve "
    "hardly opens; do not rely on its digits, or move the operating point a little"
)


def judge_point(machine: Machine, run: SteadyRun, values: dict[str, Any]) -> dict[EngineWarning, str]:
    """Find what a user should know of an operating point whose march did not end early.

    Each text says what is the matter, and what to change. `values` are its indicators, see
    `apesim.engine.indicators.indicators`.
    """
    return judge_cylinders([machine], [run], values)


def judge_cylinders(
    machines: Sequence[Machine], runs: Sequence[SteadyRun], values: dict[str, Any]
) -> dict[EngineWarning, str]:
    """Find what a user should know of cylinders on one shaft, of which `values` are the totals, see `judge_point`.

    A warning that several of them have is told of the first.
    """
    warnings = _judge_orbit(runs[0].orbit)
    if values["brake_torque_Nm"] <= 0.0:
        warnings[EngineWarning.NO_BRAKE_WORK] = "brake work is not positive: what is related to it is null"
    for number, (machine, run) in enumerate(zip(machines, runs, strict=True), start=1):
        if machine.engine.intake == EPV:
            prefix = f"cylinder {number}: " * (len(runs) > 1)
            told = {warning: prefix + text for warning, text in _judge_valve(machine, run).items()}
            warnings = told | warnings
    if values["isentropic_efficiency"] > 1.0:
        warnings[EngineWarning.ABOVE_ISENTROPIC] = (
            "more than isentropic work: heat from the walls, or air from outside, adds to it"
        )
    hottest = max(float(run.trace[:, TEMPERATURE].max()) for run in runs)
    if runs[0].cycle.actuator.gas.perfect and hottest > HOTTEST:
        warnings[EngineWarning.BEYOND_CP] = (
            f"the cylinder comes to {hottest:.0f} K, beyond the {HOTTEST:g} K up to which cp(T) holds"
        )
    return warnings | _judge_accuracy(values)


def _judge_orbit(orbit: Orbit) -> dict[EngineWarning, str]:
    """Find what a user should know of the periodic state."""
    if not orbit.converged:
        text = f"not periodic after {orbit.cycles} cycles: the state still changes by {orbit.change:.1e}"
        return {EngineWarning.NOT_PERIODIC: text}
    if orbit.period > 1:
        text = f"the state repeats only after {orbit.period} cycles: work and air are their mean, angles those of one"
        return {EngineWarning.SUBHARMONIC: text}
    return {}


def _judge_valve(machine: Machine, run: SteadyRun) -> dict[EngineWarning, str]:
    """Find what a user should know of the valve's strokes and of its control air."""
    warnings: dict[EngineWarning, str] = {}
    actuator, travel = run.cycle.actuator, valve_travel(machine, run)
    if travel != Travel.COMPLETE:
        stroke = actuator.valve.stroke
        lifts = stroke - logged_motion(run.log)[0]
        warnings[EngineWarning[travel.name]] = travel_text(travel, stroke, lifts.min(), lifts.max())
    control, _ = run.cycle.supply if run.cycle.control_from_receiver else run.cycle.control
    if control < actuator.vent_pressure:
        warnings[EngineWarning.CONTROL_BELOW_AMBIENT] = control_text(control, actuator.vent_pressure)
    return warnings


def _judge_accuracy(values: dict[str, Any]) -> dict[EngineWarning, str]:
    """Find what a user should know of the closure of the balances and of the tolerance."""
    warnings: dict[EngineWarning, str] = {}
    mass, energy = values["mass_closure"], values["energy_closure"]
    if max(mass, energy) > MAX_CLOSURE:
        warnings[EngineWarning.CLOSURE] = closure_text(mass, energy)
    if values["exergy_closure"] > MAX_EXERGY_CLOSURE:
        warnings[EngineWarning.EXERGY_CLOSURE] = (
            f"exergy closes to {values['exergy_closure']:.1e} of what enters; {MAX_EXERGY_CLOSURE:g} is promised: "
            "trust its table to that much only"
        )
    if values["work_by_quadrature_change"] > MAX_QUADRATURE_CHANGE:
        warnings[EngineWarning.QUADRATURE] = quadrature_text("indicated work", values["work_by_quadrature_change"])
    for warning, name, what in (
        (EngineWarning.WORK_TOLERANCE, "work_tolerance_change", "indicated work"),
        (EngineWarning.AIR_TOLERANCE, "air_tolerance_change", "engine air"),
    ):
        if values[name] > MAX_TOLERANCE_CHANGE:
            warnings[warning] = TOLERANCE_TEXT.format(what=what, change=values[name], most=MAX_TOLERANCE_CHANGE)
    return warnings
