"""The chain of valves at an operating point, each link in its own periodic state."""

from enum import IntEnum
from math import nan
from typing import NamedTuple

import numpy as np

from apesim.march import Status
from apesim.periodic import Drive
from engine.breathing import DEGREE, TURN
from engine.cycle_state import WORK
from engine.cylinder import CAM, EPV, IDEAL_VALVE
from engine.indicators import JOULE_PER_KWH, indicators, ratio
from engine.operating_point import accuracy_at, cycle_of
from engine.steady import run_steady
from studies.assessment.lift import LIFT, constant_speed_lift, lift_curve_of
from valve.groove import area_table, lap_of

LINKS = {
    "ideal": "full groove area at once, from one intended angle to the other",
    "true_timing": "full groove area at once, while the real lift is above the lap",
    "constant_speed": "crosses the lap, reaches its peak and leaves it where the real lift does, at constant speeds",
    "real_lift": "the real lift, its control air not counted",
    "real": "the real lift with its control air",
}
"""Each valve of the chain, and what it does."""
CAUSES = {
    "delay": "it opens and closes late: from ideal to true_timing",
    "finite_speed": "it takes its time, and may not lift fully: from true_timing to constant_speed",
    "fluctuation": "it starts from rest and its speed varies: from constant_speed to real_lift",
    "control_air": "it has to be driven: from real_lift to real",
}
"""What each step of the chain costs, and between which links."""
MEASURES = {
    "indicated_torque_Nm": ("N m", "indicated torque"),
    "brake_torque_Nm": ("N m", "brake torque"),
    "air_kg_per_cycle": ("kg", "all air in a cycle"),
    "specific_air_kg_per_kWh": ("kg/kWh", "all air over brake work"),
    "indicated_specific_air_kg_per_kWh": ("kg/kWh", "all air over indicated work"),
}
"""Name of each measure of a link: its unit and what it is."""
LOSSES = {
    "indicated_torque_lost_Nm": -1.0,
    "brake_torque_lost_Nm": -1.0,
    "air_added_kg_per_cycle": 1.0,
    "specific_air_added_kg_per_kWh": 1.0,
    "indicated_specific_air_added_kg_per_kWh": 1.0,
}
"""Name of each measure's loss, in the order of `MEASURES`, and its sign: a loss is positive, a gain negative."""
REAL = (
    *("valve_open_deg", "valve_close_deg", "full_open_deg", "closed_deg", "peak_lift_m"),
    *("fluctuation", "closing_fluctuation", "intake_pressure_fluctuation_Pa", "period_cycles", "periodic_change"),
)
"""Indicators of the real valve that stand beside the chain."""
CYCLES = 8
"""Over which the change from cycle to cycle is looked for."""
LIFT_STEP = 0.25 * DEGREE


class Outcome(IntEnum):
    """Whether a chain has all its links, and if not, why."""

    COMPLETE = 0
    NEVER_OPENS = 1
    NEVER_CLOSES = 2
    NOT_PERIODIC = 3
    LINK_NOT_PERIODIC = 4
    FAILED = 5
    OUT_OF_REACH = 6

    @property
    def remedy(self):
        """What is the matter, and what to change."""
        return REMEDIES[self]


REMEDIES = {
    Outcome.COMPLETE: "complete",
    Outcome.NEVER_OPENS: "the real lift never rises through the lap, so it has no true angles; lower the speed or "
    "raise the pressure",
    Outcome.NEVER_CLOSES: "the real lift never falls through the lap, so it has no true angles; lower the speed or "
    "raise the pressure",
    Outcome.NOT_PERIODIC: "the real valve's cycles do not repeat one by one, so its true angles change from cycle to "
    "cycle; lower the speed",
    Outcome.LINK_NOT_PERIODIC: "a link was not brought to its periodic state; see `apesim engine run` at this point",
    Outcome.FAILED: "a march ended early; see `apesim engine run` at this point",
    Outcome.OUT_OF_REACH: "no commands make the real valve meet its targets; see `apesim engine timing`",
}
OUTCOMES = ", ".join(f"{int(outcome)} {outcome.name.lower().replace('_', ' ')}" for outcome in Outcome)


class Assessment(NamedTuple):
    """The chain at an operating point."""

    speed: float
    """[rad/s]"""
    energise: float
    """Crank angle [rad]; NaN where there are no corrected ones."""
    release: float
    outcome: Outcome
    links: np.ndarray
    """`MEASURES` of `LINKS`, (5, 5); NaN: undefined."""
    real: dict
    """Those of `REAL`."""
    cycle_to_cycle: float
    """See `cycle_to_cycle`."""


def with_ideal(machine, opens, closes):
    """A machine with an ideal valve that opens and closes at two angles [rad]."""
    command = machine.command._replace(open_target=opens, close_target=closes)
    return machine._replace(command=command, engine=machine.engine._replace(intake=IDEAL_VALVE))


def with_lift(machine, curve):
    """A machine with a cam that lifts by a curve, (n, 2) [rad, m]."""
    engine = machine.engine
    return machine._replace(engine=engine._replace(intake=CAM, cam=engine.cam._replace(lift_curve=curve)))


def assess(machine, speed):
    """Run the chain of valves, each link to its own periodic state.

    Where the real lift crosses the lap several times in a cycle, its true angles are those of the first rise and of the
    fall after it; what comes later is fluctuation.

    Parameters
    ----------
    machine : engine.machine.Machine
        Its intake is the electro-pneumatic valve, whatever it says.
    speed : float
        [rad/s]

    Returns
    -------
    Assessment
    """
    machine = machine._replace(engine=machine.engine._replace(intake=EPV))
    run = run_steady(machine, speed, angle_step=LIFT_STEP)
    energise, release, *_ = machine.command
    if run.status != Status.DONE:
        return without_links(speed, energise, release, Outcome.FAILED)
    values = indicators(machine, run)
    outcome = outcome_of(machine, run, values)
    links = dict.fromkeys(LINKS, np.full(len(MEASURES), nan))
    if run.orbit.converged:
        links["real"] = measures(values)
        if not acts_on_intake(run):
            links["real_lift"] = measures(values | {"control_air_kg_per_cycle": 0.0})
    for name, other in others_of(machine, run, values, outcome).items():
        other_run = run_steady(other, speed)
        if other_run.status == Status.DONE and other_run.orbit.converged:
            links[name] = measures(indicators(other, other_run))
        else:
            outcome = outcome or Outcome.LINK_NOT_PERIODIC
    real = {name: values[name] for name in REAL}
    return Assessment(
        speed, energise, release, outcome, np.stack(list(links.values())), real, cycle_to_cycle(machine, run)
    )


def without_links(speed, energise, release, outcome):
    """An assessment that came to nothing."""
    links = np.full((len(LINKS), len(MEASURES)), nan)
    return Assessment(speed, energise, release, outcome, links, dict.fromkeys(REAL, nan) | {"period_cycles": 0}, nan)


def acts_on_intake(run):
    """Whether the control air is drawn from a receiver, and so lowers the pressure before the groove."""
    return run.p.control_from_receiver and run.p.receiver_volume > 0.0


def outcome_of(machine, run, values):
    """Whether a real valve has one pair of true angles, and if not, why."""
    if run.orbit.period != 1:
        return Outcome.NOT_PERIODIC
    if np.isnan(values["valve_open_deg"] + values["valve_close_deg"]):
        always = run.trace[:, LIFT].min() > lap_of(area_table(machine.groove, machine.valve.stroke))
        return Outcome.NEVER_CLOSES if always else Outcome.NEVER_OPENS
    return Outcome.COMPLETE


def others_of(machine, run, values, outcome):
    """The machines of the links that have to be run, beside the real one, by name.

    The real lift is among them only where its control air acts on the intake, so that not counting it is not enough.
    """
    others = {"ideal": with_ideal(machine, machine.command.open_target, machine.command.close_target)}
    if outcome == Outcome.COMPLETE:
        opens, closes = values["valve_open_deg"] * DEGREE, values["valve_close_deg"] * DEGREE
        others["true_timing"] = with_ideal(machine, opens, closes)
        others["constant_speed"] = with_lift(machine, constant_speed_lift(machine, run, opens, closes))
    if outcome != Outcome.NOT_PERIODIC and acts_on_intake(run):
        others["real_lift"] = with_lift(machine, lift_curve_of(machine, run))
    return others


def measures(values):
    """`MEASURES` of an operating point from its indicators, (5,)."""
    air = values["engine_air_kg_per_cycle"] + values["control_air_kg_per_cycle"]
    torques = values["indicated_torque_Nm"], values["brake_torque_Nm"]
    indicated, brake = (ratio(air * JOULE_PER_KWH, TURN * torque) for torque in torques)
    return np.array([*torques, air, brake, indicated])


def cycle_to_cycle(machine, run):
    """Largest change of the indicated torque from a cycle to the next, over `CYCLES` that follow a run [N m].

    In a periodic state it is the solver's error.
    """
    drive = Drive(*cycle_of(machine, run.p.speed), accuracy_at(run.p, run.tolerance))
    y, mode = run.orbit.y, run.orbit.mode
    torques = []
    for _ in range(CYCLES):
        y, mode, status = drive.march(y, mode)
        torques.append(y[WORK] / TURN if status == Status.DONE else nan)
    return float(np.abs(np.diff(torques)).max())


def losses(links):
    """What each of `CAUSES` costs.

    Parameters
    ----------
    links : (..., 5, 5) float array
        `MEASURES` of `LINKS`.

    Returns
    -------
    (..., 4, 5) float array
        `LOSSES` of `CAUSES`; over the causes they sum up to the difference between the first and the last link.
    """
    return np.diff(links, axis=-2) * np.array(list(LOSSES.values())) + 0.0  # no -0.0
