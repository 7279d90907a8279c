"""Valves between the ideal and the real one at an operating point, each in its own periodic state."""

from enum import IntEnum
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.operating_point import accuracy_at, cycle_of
from apesim.engine.cycle.state import engine_ledger
from apesim.engine.cylinder import CAM, EPV, IDEAL_VALVE
from apesim.engine.indicators import JOULE_PER_KWH, indicators, ratio, valve_motion
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun, run_steady
from apesim.march.adaptive import Status
from apesim.march.periodic import Drive
from apesim.studies.assessment.causes import EXERGY, LATENESS, MEASURES, REAL, VALVES
from apesim.studies.assessment.lift import LIFT, constant_speed_lift, lift_curve_of, shift_flanks, single_opening
from apesim.valve.groove import area_table, lap_of

CYCLES = 8
"""Number of cycles over which the change from cycle to cycle is looked for."""
LIFT_STEP = 0.25 * DEGREE


class Outcome(IntEnum):
    """Whether all valves could be compared, and if not, why."""

    COMPLETE = 0
    NEVER_OPENS = 1
    NEVER_CLOSES = 2
    NOT_PERIODIC = 3
    VALVE_NOT_PERIODIC = 4
    FAILED = 5
    OUT_OF_REACH = 6

    @property
    def remedy(self) -> str:
        """What is the matter, and what to change, in words."""
        return REMEDIES[self]


REMEDIES = {
    Outcome.COMPLETE: "complete",
    Outcome.NEVER_OPENS: "the real lift never rises through the lap, so it has no true angles; lower the speed or "
    "raise the pressure",
    Outcome.NEVER_CLOSES: "the real lift never falls through the lap, so it has no true angles; lower the speed or "
    "raise the pressure",
    Outcome.NOT_PERIODIC: "the real valve's cycles do not repeat one by one, so its true angles change from cycle to "
    "cycle; lower the speed",
    Outcome.VALVE_NOT_PERIODIC: "a valve was not brought to its periodic state; see `apesim engine run` at this point",
    Outcome.FAILED: "a march ended early; see `apesim engine run` at this point",
    Outcome.OUT_OF_REACH: "no commands make the real valve meet its targets; see `apesim engine timing`",
}
OUTCOMES = ", ".join(f"{int(outcome)} {outcome.name.lower().replace('_', ' ')}" for outcome in Outcome)


class Assessment(NamedTuple):
    """The valves at an operating point."""

    speed: float
    """Speed of the crankshaft [rad/s]."""
    energise: float
    """Command angle of the energising [rad]; NaN where there are no corrected ones."""
    release: float
    """Command angle of the release [rad]; NaN where there are no corrected ones."""
    outcome: Outcome
    """Whether all valves could be compared."""
    valves: np.ndarray
    """`MEASURES` of `VALVES`, (7, 5); NaN: undefined."""
    exergy: np.ndarray
    """`EXERGY` of `VALVES`, (7, 8) [J]; NaN: undefined, and for late_real_lift where it is the real valve's run."""
    real: dict[str, float]
    """Indicators `REAL` of the real valve."""
    lateness: dict[str, float]
    """`LATENESS` of the opening and of the closing, by names that begin with ``opening_`` and ``closing_``."""
    cycle_to_cycle: float
    """Largest change of the indicated torque from a cycle to the next [N m], see `cycle_to_cycle`."""


def _with_ideal(machine: Machine, opens: float, closes: float) -> Machine:
    """Give a machine an ideal valve that opens and closes at two crank angles [rad]."""
    command = machine.command._replace(open_target=opens, close_target=closes)
    return machine._replace(command=command, engine=machine.engine._replace(intake=IDEAL_VALVE))


def with_lift(machine: Machine, curve: np.ndarray) -> Machine:
    """Give a machine a cam that lifts by a curve of crank angle [rad] and lift [m], (n, 2)."""
    engine = machine.engine
    return machine._replace(engine=engine._replace(intake=CAM, cam=engine.cam._replace(lift_curve=curve)))


def assess(machine: Machine, speed: float) -> Assessment:
    """Run the valves that are compared at a speed [rad/s], each to its own periodic state.

    The intake is taken for the electro-pneumatic valve, whatever the machine says. Where the real lift crosses the lap
    several times in a cycle, its true angles are those of the first rise and of the fall after it; what comes later is
    fluctuation.
    """
    machine = machine._replace(engine=machine.engine._replace(intake=EPV))

    # The real valve first: the others are made from its true angles and its lift.
    run = run_steady(machine, speed, angle_step=LIFT_STEP)
    energise, release, *_ = machine.command
    if run.status != Status.DONE:
        return without_valves(speed, energise, release, Outcome.FAILED)
    values = indicators(machine, run)
    outcome = outcome_of(machine, run, values)

    # What cannot be compared stays NaN. Control air that does not act on the intake changes nothing in the cylinder:
    # the real valve's own run is that of the real lift, too, with this air not counted.
    valves = dict.fromkeys(VALVES, np.full(len(MEASURES), nan))
    ledgers = dict.fromkeys(VALVES, np.full(len(EXERGY), nan))
    if run.orbit.converged:
        valves["real"], ledgers["real"] = _measures(values), _exergy_of(values)
        if not _acts_on_intake(run):
            valves["late_real_lift"] = _measures(values | {"control_air_kg_per_cycle": 0.0})

    # The others, each to its own periodic state. A reason that was found at the real valve is kept as the outcome.
    for name, other in _others_of(machine, run, values, outcome).items():
        other_run = run_steady(other, speed)
        if other_run.status == Status.DONE and other_run.orbit.converged:
            other_values = indicators(other, other_run)
            valves[name], ledgers[name] = _measures(other_values), _exergy_of(other_values)
        else:
            outcome = outcome or Outcome.VALVE_NOT_PERIODIC
    return Assessment(
        speed,
        energise,
        release,
        outcome,
        np.stack(list(valves.values())),
        np.stack(list(ledgers.values())),
        {name: values[name] for name in REAL},
        _lateness_of(machine, run, values),
        cycle_to_cycle(machine, run),
    )


def without_valves(speed: float, energise: float, release: float, outcome: Outcome) -> Assessment:
    """Make the assessment of an operating point at which nothing could be compared: its results are NaN.

    The speed is in rad/s; `energise` and `release` are command angles [rad], NaN where there are none.
    """
    valves, exergy = np.full((len(VALVES), len(MEASURES)), nan), np.full((len(VALVES), len(EXERGY)), nan)
    real = dict.fromkeys(REAL, nan) | {"period_cycles": 0}
    lateness = {f"{stroke}_{name}": nan for stroke in ("opening", "closing") for name in LATENESS}
    return Assessment(speed, energise, release, outcome, valves, exergy, real, lateness, nan)


def _lateness_of(machine: Machine, run: SteadyRun, values: dict[str, Any]) -> dict[str, float]:
    """Find what the lateness of both strokes is made of, see `LATENESS`; NaN where a stroke has no delay time."""
    command = machine.command
    opening, closing, *_ = valve_motion(machine, run)
    parts_by_name: dict[str, float] = {}
    for stroke, measured, true_angle, target, edge in (
        ("opening", opening, values["valve_open_deg"], command.open_target, command.energise),
        ("closing", closing, values["valve_close_deg"], command.close_target, command.release),
    ):
        delay, advance = measured.delay * run.cycle.speed / DEGREE, (target - edge) / DEGREE
        lateness = true_angle - target / DEGREE
        parts = (lateness, delay, lateness + advance - delay, advance, measured.delay)
        parts_by_name |= {f"{stroke}_{name}": part for name, part in zip(LATENESS, parts, strict=True)}
    return parts_by_name


def _acts_on_intake(run: SteadyRun) -> bool:
    """Judge whether the control air is drawn from a receiver, and so lowers the pressure before the groove."""
    return bool(run.cycle.control_from_receiver and run.cycle.receiver_volume > 0.0)


def outcome_of(machine: Machine, run: SteadyRun, values: dict[str, Any]) -> Outcome:
    """Judge whether a real valve has one pair of true angles, and if not, why.

    The result is COMPLETE, NOT_PERIODIC, NEVER_OPENS or NEVER_CLOSES; `values` are the run's indicators,
    ``valve_open_deg`` and ``valve_close_deg`` among them.
    """
    if run.orbit.period != 1:
        return Outcome.NOT_PERIODIC
    if np.isnan(values["valve_open_deg"] + values["valve_close_deg"]):
        always = run.trace[:, LIFT].min() > lap_of(area_table(machine.groove, machine.valve.stroke))
        return Outcome.NEVER_CLOSES if always else Outcome.NEVER_OPENS
    return Outcome.COMPLETE


def _others_of(machine: Machine, run: SteadyRun, values: dict[str, Any], outcome: Outcome) -> dict[str, Machine]:
    """Make the machines of the valves that have to be run, beside the real one, by name.

    The real lift is among them only where its control air acts on the intake, so that not counting it is not enough.
    """
    targets = machine.command.open_target, machine.command.close_target
    others = {"ideal": _with_ideal(machine, *targets)}
    if outcome == Outcome.COMPLETE:
        true = values["valve_open_deg"] * DEGREE, values["valve_close_deg"] * DEGREE
        constant_speed = constant_speed_lift(machine, run, *true)
        opening = single_opening(lift_curve_of(machine, run), *true)
        others["on_time_constant_speed"] = with_lift(machine, shift_flanks(constant_speed, true, targets))
        others["on_time_real_lift"] = with_lift(machine, shift_flanks(opening, true, targets))
        others["late_at_once"] = _with_ideal(machine, *true)
        others["late_constant_speed"] = with_lift(machine, constant_speed)
    if outcome != Outcome.NOT_PERIODIC and _acts_on_intake(run):
        others["late_real_lift"] = with_lift(machine, lift_curve_of(machine, run))
    return others


def _measures(values: dict[str, Any]) -> np.ndarray:
    """Compute `MEASURES` of an operating point from its indicators, (5,)."""
    air = values["engine_air_kg_per_cycle"] + values["control_air_kg_per_cycle"]
    torques = values["indicated_torque_Nm"], values["brake_torque_Nm"]
    indicated, brake = (ratio(air * JOULE_PER_KWH, TURN * torque) for torque in torques)
    return np.array([*torques, air, brake, indicated])


def _exergy_of(values: dict[str, Any]) -> np.ndarray:
    """Collect `EXERGY` of an operating point from its indicators [J], (8,)."""
    # Heat from the walls is the only one of the terms under `other` that brings exergy.
    return np.array(
        [
            sum(-values[f"exergy_{term}_J"] if term == "wall_heat" else values[f"exergy_{term}_J"] for term in terms)
            for _, terms in EXERGY.values()
        ]
    )


def cycle_to_cycle(machine: Machine, run: SteadyRun) -> float:
    """Find the largest change [N m] of the indicated torque from a cycle to the next, over `CYCLES` that follow a run.

    In a periodic state it is the solver's error.
    """
    drive = Drive(*cycle_of(machine, run.cycle.speed), accuracy_at(run.cycle, run.tolerance))
    y, mode = run.orbit.y, run.orbit.mode
    torques = []
    for _ in range(CYCLES):
        y, mode, status = drive.march(y, mode)
        torques.append(engine_ledger(y).work / TURN if status == Status.DONE else nan)
    return float(np.abs(np.diff(torques)).max())
