"""Indicators of an operating point: work, air, efficiencies, true valve angles, and how well the balances close."""

from collections.abc import Callable
from functools import partial
from math import nan
from typing import Any

import numpy as np

from apesim.air import ANR_DENSITY, Gas, GasState, enthalpy, temperature_at_enthalpy, temperature_of
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cam import cam_angles
from apesim.engine.cycle.state import (
    Cycle,
    control_ledger,
    cylinder_gas,
    effects_ledger,
    engine_ledger,
    gas_held,
    has_pipe,
    receiver_state,
)
from apesim.engine.cylinder import CAM, IDEAL_VALVE
from apesim.engine.effects import library_of
from apesim.engine.exergy import TERMS, exergy_closure, exergy_ledger
from apesim.engine.friction import friction_mean_effective_pressure, mean_piston_speed
from apesim.engine.ideal_work import full_admission_work, isentropic_work, isothermal_work
from apesim.engine.kinematics import cylinder_volume, swept_volume
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun
from apesim.exergy import flow_exergy
from apesim.march.adaptive import LOG_HEAD
from apesim.march.error_bounds import closure_of
from apesim.valve.actuator import PHASE
from apesim.valve.chamber import chamber_state
from apesim.valve.groove import area_table, lap_of
from apesim.valve.ledger import logged_motion
from apesim.valve.measures import Stroke, Travel, closing_stroke, lap_times, opening_stroke, travel_of

JOULE_PER_KWH = 3.6e6
"""Joules in a kilowatt-hour."""
ADIABATIC = "adiabatic limit"
"""What a cold temperature is where no wall gives heat to the air: real air does not become so cold."""
COLD_WORDS = f"({ADIABATIC} without wall heat)"
WALL_HEATS = "cylinder_wall_heat", "tabulated_cylinder_heat"
"""Effects that bring heat from the walls to the air of the cylinder."""
INDICATORS = {
    "speed_rpm": ("r/min", "speed, revolutions a minute"),
    "indicated_torque_Nm": ("N m", "mean indicated torque"),
    "brake_torque_Nm": ("N m", "mean brake torque"),
    "indicated_power_W": ("W", "indicated power"),
    "brake_power_W": ("W", "brake power"),
    "imep_Pa": ("Pa", "indicated mean effective pressure"),
    "bmep_Pa": ("Pa", "brake mean effective pressure"),
    "fmep_Pa": ("Pa", "friction mean effective pressure"),
    "engine_air_kg_per_cycle": ("kg", "net air through the groove in a cycle"),
    "control_air_kg_per_cycle": ("kg", "net air through the supply sides of the solenoids in a cycle"),
    "groove_back_flow_kg_per_cycle": ("kg", "air that flows back through the groove in a cycle"),
    "exhaust_back_flow_kg_per_cycle": ("kg", "air that flows in through the exhaust valves in a cycle"),
    "specific_air_kg_per_kWh": ("kg/kWh", "all air over brake work"),
    "specific_engine_air_kg_per_kWh": ("kg/kWh", "engine air over brake work"),
    "indicated_specific_air_kg_per_kWh": ("kg/kWh", "all air over indicated work"),
    "air_L_per_min_ANR": ("L/min", "all air at the standard reference atmosphere ANR (ISO 8778)"),
    "exergy_efficiency": ("1", "brake work over the flow exergy of all air at its supply state"),
    "isothermal_efficiency": ("1", "brake work over isothermal work R T ln r of all air"),
    "isentropic_efficiency": ("1", "brake work over isentropic work of all air"),
    "full_admission_efficiency": ("1", "brake work over full-admission work R T (1 - 1/r) of all air"),
    "valve_open_deg": ("deg", "crank angle at which the lift rises through the lap"),
    "valve_close_deg": ("deg", "crank angle at which the lift falls through the lap"),
    "full_open_deg": ("deg", "crank angle of contact with the open stop"),
    "closed_deg": ("deg", "crank angle of contact with the closed stop"),
    "peak_lift_m": ("m", "highest lift"),
    "opening_seating_speed_m_s": ("m/s", "speed just before contact with the open stop"),
    "closing_seating_speed_m_s": ("m/s", "speed just before contact with the closed stop"),
    "fluctuation": ("1", "(peak speed - lowest later speed before contact)/peak, opening stroke"),
    "closing_fluctuation": ("1", "(peak speed - lowest later speed before contact)/peak, closing stroke"),
    "peak_cylinder_pressure_Pa": ("Pa abs", "highest cylinder pressure"),
    "intake_pressure_fluctuation_Pa": ("Pa", "highest less lowest pressure in the receiver"),
    "lowest_cylinder_temperature_K": ("K", f"lowest cylinder temperature {COLD_WORDS}"),
    "exhaust_temperature_K": ("K", f"mixed temperature of the exhaust air of a cycle {COLD_WORDS}"),
    **{f"exergy_{name}_J": ("J", f"{text}, in a cycle") for name, text in TERMS.items()},
    "converged": ("1", "whether the state repeats: 1 yes, 0 no"),
    "period_cycles": ("1", "cycles after which the state repeats; 0: not seen to repeat"),
    "cycles": ("1", "cycles marched to the periodic state"),
    "periodic_change": ("1", "largest change of a state over the last cycle, relative"),
    "mass_closure": ("1", "mass not accounted for over a cycle, relative to the air through the engine"),
    "energy_closure": ("1", "energy not accounted for over a cycle, relative to the enthalpy through the engine"),
    "exergy_closure": ("1", "exergy not accounted for over a cycle, relative to what enters"),
    "work_by_quadrature_change": ("1", "indicated work by quadrature of the dense output against the ledger, relative"),
    "work_tolerance_change": ("1", "change of the cycle's work at ten times the tolerance, relative"),
    "air_tolerance_change": ("1", "change of the engine air at ten times the tolerance, relative"),
    "tolerance": ("1", "of a step"),
}
"""Unit and meaning of each indicator, by its name in files."""
FLAGS = ("converged",)
"""Names of the indicators that are 1 for yes and 0 for no."""
COUNTS = ("period_cycles", "cycles")
"""Names of the indicators that count cycles."""


def is_adiabatic(machine: Machine) -> bool:
    """Tell whether no effect of a machine can bring heat from the walls to the air of its cylinder.

    Its cold temperatures are an adiabatic limit then. An effect from outside that acts on the engine may bring heat.
    """
    return not any(
        effect.is_on(getattr(machine.effects, effect.name))
        for effect in library_of(machine.effects)
        if effect.name in WALL_HEATS or (effect.is_from_outside and effect.layer == "engine")
    )


def ratio(numerator: float, denominator: float) -> float:
    """Quotient of two numbers, NaN where the denominator is not positive."""
    return numerator / denominator if denominator > 0.0 else nan


def valve_angles(machine: Machine, run: SteadyRun) -> dict[str, float]:
    """Find the true opening and closing of the intake, and how hard the valve lands.

    By name: ``valve_open_deg``, ``valve_close_deg``, ``full_open_deg``, ``closed_deg`` [deg], ``peak_lift_m`` [m], the
    seating speeds [m/s] and fluctuations. NaN where the intake never comes to it.

    The ideal valve opens and closes at the intended angles:

    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> machine = Machine()
    >>> machine = machine._replace(engine=machine.engine._replace(intake=IDEAL_VALVE))
    >>> run = run_steady(machine, 100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> angles = valve_angles(machine, run)
    >>> round(angles["valve_open_deg"], 6), round(angles["valve_close_deg"], 6)
    (-5.0, 70.0)
    """
    p, log = run.cycle, run.log
    table = area_table(machine.groove, machine.valve.stroke)
    if p.engine.intake == CAM:
        cam = machine.engine.cam.resolve_lift(machine.valve.stroke)
        return _angles(*cam_angles(cam, lap_of(table))) | _no_strokes()
    if p.engine.intake == IDEAL_VALVE:
        opens, closes = p.open_target, p.close_target
        return _angles(opens, closes, opens, closes, machine.valve.stroke) | _no_strokes()
    opening, closing, opened, shut = valve_motion(machine, run)
    lift = np.minimum(machine.valve.stroke - logged_motion(log)[0], machine.valve.stroke)
    times = (opened, shut, opening.contact, closing.contact)
    opens, closes, full_open, closed = (p.start + p.speed * t for t in times)
    return _angles(opens, closes, full_open, closed, lift.max()) | {
        "opening_seating_speed_m_s": opening.seating_speed,
        "closing_seating_speed_m_s": closing.seating_speed,
        "fluctuation": opening.fluctuation,
        "closing_fluctuation": closing.fluctuation,
    }


def valve_motion(machine: Machine, run: SteadyRun) -> tuple[Stroke, Stroke, float, float]:
    """Find both strokes of the electro-pneumatic valve, and when its lift rises and falls through the lap [s].

    NaN: never. Times are counted from the energising. They are later than a cycle where the valve moves into the next
    cycle.

    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> opening, closing, opened, shut = valve_motion(Machine(), run)
    >>> print(round(opened * 1e3, 1), "ms,", round(shut * 1e3, 1), "ms")
    6.7 ms, 23.6 ms
    """
    p, log = run.cycle, run.log
    table = area_table(machine.groove, machine.valve.stroke)
    period = TURN / p.speed
    doubled = np.concatenate((log, log))
    doubled[len(log) :, 0] += period
    release = (machine.command.release - machine.command.energise) / p.speed
    opening = opening_stroke(doubled, 0.0, 2.0 * period)
    closing = closing_stroke(doubled, release, 2.0 * period)
    return opening, closing, *lap_times(doubled, machine.valve.stroke, lap_of(table))


def valve_travel(machine: Machine, run: SteadyRun) -> Travel:
    """Find which of its stops the piston of the electro-pneumatic valve meets in a cycle."""
    opening, closing, *_ = valve_motion(machine, run)
    return travel_of(run.log, run.orbit.mode[PHASE], opening, closing)


def _angles(opens: float, closes: float, full_open: float, closed: float, lift: float) -> dict[str, float]:
    """Give angles [rad] and the peak lift [m] the names of their indicators."""
    return {
        "valve_open_deg": opens / DEGREE,
        "valve_close_deg": closes / DEGREE,
        "full_open_deg": full_open / DEGREE,
        "closed_deg": closed / DEGREE,
        "peak_lift_m": lift,
    }


def _no_strokes() -> dict[str, float]:
    """Give the indicators of strokes for an intake without a piston between stops: all NaN."""
    names = ("opening_seating_speed_m_s", "closing_seating_speed_m_s", "fluctuation", "closing_fluctuation")
    return dict.fromkeys(names, nan)


def peak_pressure(run: SteadyRun) -> float:
    """Find the highest cylinder pressure [Pa abs] of a cycle.

    Its located extrema and the ends of all smooth segments are used.
    """
    gas, log = run.cycle.actuator.gas, run.log
    pressures = []
    for time, row in zip(log[:, 0].tolist(), log[:, LOG_HEAD:].tolist(), strict=True):  # plain numbers are quicker
        volume, _ = cylinder_volume(run.cycle.crank, run.cycle.start + run.cycle.speed * time)
        pressures.append(chamber_state(gas, cylinder_gas(row), volume).pressure)
    return max(pressures)


def receiver_range(run: SteadyRun) -> float:
    """Find how far the receiver's pressure swings in a cycle, highest less lowest [Pa].

    Located extrema and the ends of all smooth segments are used; 0 where the receiver is infinite.

    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> print(round(receiver_range(run) / 1e3, 1), "kPa")
    84.3 kPa
    """
    p = run.cycle
    if p.receiver_volume == 0.0:
        return 0.0
    pressures = [receiver_state(p, y).pressure for y in _located_states(run)]
    return max(pressures) - min(pressures)


def _located_states(run: SteadyRun) -> list[Any]:
    """State vectors at the extrema of a cycle and at the ends of all smooth segments; plain numbers are quicker."""
    return [*run.log[:, LOG_HEAD:].tolist(), *run.extrema[:, LOG_HEAD:].tolist()]


def lowest_temperature(run: SteadyRun) -> float:
    """Find the lowest cylinder temperature [K] of a cycle.

    Its located extrema and the ends of all smooth segments are used.

    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> print(round(lowest_temperature(run), 1), "K")
    158.1 K
    """
    gas = run.cycle.actuator.gas
    gases = [cylinder_gas(y) for y in _located_states(run)]
    return temperature_of(gas, min(energy / mass for mass, energy in gases))


def exhaust_temperature(*runs: SteadyRun) -> float:
    """Mixed temperature of the exhaust air: that of the mean enthalpy of what flows out in a cycle.

    ``h(T_mix) = (H_e + m_back h(T_0))/(m_e + m_back)``, with net mass m_e and enthalpy H_e through the exhaust valves,
    and the mass m_back that flowed in through them at ambient temperature T_0.

    It is the balance of energy of streams that mix without heat and work [1]_; h(T) is the specific enthalpy.

    Parameters
    ----------
    *runs : apesim.engine.steady.SteadyRun
        Operating point, of one cylinder or of each of several.

    Returns
    -------
    float
        Mixed temperature of the exhaust air of all [K]; NaN where nothing flows out.

    References
    ----------
    .. [1] M. J. Moran, H. N. Shapiro, D. D. Boettner and M. B. Bailey, "Fundamentals of Engineering Thermodynamics",
       8th ed., Wiley, 2014, ISBN 978-1-118-41293-0, chapter 4.

    Examples
    --------
    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> print(round(exhaust_temperature(run), 1), "K")
    223.2 K
    """
    gas, mass, energy = runs[0].cycle.actuator.gas, 0.0, 0.0
    for run in runs:
        air = engine_ledger(run.end)
        mass += air.exhaust.mass + air.exhaust_back
        energy += air.exhaust.enthalpy + air.exhaust_back * enthalpy(gas, run.cycle.actuator.ambient.temperature)
    return temperature_at_enthalpy(gas, energy / mass) if mass > 0.0 else nan


def friction_pressure(run: SteadyRun, peak: float) -> float:
    """Friction mean effective pressure [Pa] of a run, by the correlation of Chen and Flynn (SAE 650733).

    `peak` is the highest cylinder pressure of the cycle [Pa abs].

    At 10 bar and a mean piston speed of 0.088 m * 100 rad/s/pi = 2.80 m/s:

    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> print(round(friction_pressure(run, 10e5) / 1e3, 1), "kPa")
    68.0 kPa
    """
    engine = run.cycle.engine
    return friction_mean_effective_pressure(engine.friction, peak, mean_piston_speed(engine.stroke, run.cycle.speed))


def closure(run: SteadyRun) -> tuple[float, float]:
    """Relative mass and energy that the balances of a cycle do not account for.

    ``closure = |stored - (in - out)|``, over the air and the enthalpy that go through the engine; how small sums are
    treated, see `apesim.march.error_bounds.closure_of`.

    The measure is defined here: what is stored, less what comes in, plus what goes out.

    Parameters
    ----------
    run : apesim.engine.steady.SteadyRun
        Operating point.

    Returns
    -------
    mass, energy : float
        Relative mass and energy that are not accounted for.

    Examples
    --------
    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> bool(max(closure(run)) < 1e-10)
    True
    """
    p, control, engine, let_in = run.cycle, control_ledger(run.end), engine_ledger(run.end), effects_ledger(run.end)
    mass_in, energy_in = engine.feed if p.receiver_volume > 0.0 else engine.pipe if has_pipe(p) else engine.groove
    if not (p.receiver_volume > 0.0 and p.control_from_receiver):
        mass_in, energy_in = mass_in + control.line_fed.mass, energy_in + control.line_fed.enthalpy
    stored, held = gas_held(run.end - run.start), gas_held(run.start)
    mass = stored.mass - (mass_in - engine.exhaust.mass - control.vented.mass + let_in.mass)
    energy_in = energy_in - engine.exhaust.enthalpy - control.vented.enthalpy + let_in.enthalpy
    energy = stored.energy - (energy_in - engine.work - control.valve_work)
    through = engine.groove.mass + control.supplied.mass + engine.groove_back + engine.exhaust_back
    back = engine.exhaust_back * enthalpy(p.actuator.gas, p.actuator.ambient.temperature)
    carried = abs(engine.groove.enthalpy) + abs(control.supplied.enthalpy) + back
    return closure_of(mass, through, held.mass), closure_of(energy, carried, held.energy)


def performance(
    p: Cycle, turns: float, work: float, fmep: float, swept: float, air: tuple[float, float]
) -> dict[str, float]:
    """Compute what follows from work and air of a cycle, by the names in `INDICATORS`; see `indicators`.

    Takes a cylinder for what all draw and give to, the turns [1/s], the work [J], the friction mean effective pressure
    [Pa], the swept volume [m3], engine air and control air [kg].
    """
    gas, ambient, (engine_air, control_air) = p.actuator.gas, p.actuator.ambient, air
    brake, all_air = work - fmep * swept, engine_air + control_air

    # Ideal work is counted from where the air is drawn: control air may come from the regulator or the receiver.
    drawn = p.supply if p.control_from_receiver else p.control

    def efficiency(law: Callable[[GasState], float]) -> float:
        ideal = engine_air * law(p.supply) + control_air * law(drawn)
        return ratio(brake, ideal) if brake > 0.0 else nan

    def expansion_efficiency(law: Callable[[Gas, float, float], float]) -> float:
        return efficiency(lambda state: law(gas, state.temperature, state.pressure / ambient.pressure))

    return {
        "speed_rpm": float(f"{turns * 60.0:.12g}"),  # so that 1000 rpm is 1000 again
        "indicated_torque_Nm": work / TURN,
        "brake_torque_Nm": brake / TURN,
        "indicated_power_W": work * turns,
        "brake_power_W": brake * turns,
        "imep_Pa": work / swept,
        "bmep_Pa": brake / swept,
        "fmep_Pa": fmep,
        "engine_air_kg_per_cycle": engine_air,
        "control_air_kg_per_cycle": control_air,
        "specific_air_kg_per_kWh": ratio(all_air * JOULE_PER_KWH, brake),
        "specific_engine_air_kg_per_kWh": ratio(engine_air * JOULE_PER_KWH, brake),
        "indicated_specific_air_kg_per_kWh": ratio(all_air * JOULE_PER_KWH, work),
        "air_L_per_min_ANR": all_air * turns / ANR_DENSITY * 60e3,
        "exergy_efficiency": efficiency(partial(flow_exergy, gas, ambient)),
        "isothermal_efficiency": expansion_efficiency(isothermal_work),
        "isentropic_efficiency": expansion_efficiency(isentropic_work),
        "full_admission_efficiency": expansion_efficiency(full_admission_work),
    }


def indicators(machine: Machine, run: SteadyRun) -> dict[str, Any]:
    """Compute all scalar results of an operating point.

    Powers, mean effective pressures (work over swept volume) and specific consumptions (air over work) are defined as
    for other piston engines [1]_, here with one cycle a revolution. Exergy efficiency is brake work over the flow
    exergy of the air [2]_, isentropic efficiency brake work over isentropic work [3]_. Volume flows are at the
    reference atmosphere ANR [4]_.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
        Machine of the run.
    run : apesim.engine.steady.SteadyRun
        Operating point.

    Returns
    -------
    dict of str to float or int
        Keys as in `INDICATORS`; SI but for the units that the keys name. NaN: undefined.

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eqs. 2.13 to 2.22.
    .. [2] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.
    .. [3] M. J. Moran, H. N. Shapiro, D. D. Boettner and M. B. Bailey, "Fundamentals of Engineering Thermodynamics",
       8th ed., Wiley, 2014, ISBN 978-1-118-41293-0, chapter 6.
    .. [4] ISO 8778, "Pneumatic fluid power - Standard reference atmosphere".

    Examples
    --------
    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1, estimate_error=False)
    >>> values = indicators(Machine(), run)
    >>> print(round(values["speed_rpm"], 1), "r/min,", round(values["indicated_torque_Nm"], 1), "N m")
    954.9 r/min, 37.9 N m
    """
    p, orbit = run.cycle, run.orbit
    ledger, control = engine_ledger(run.end), control_ledger(run.end)

    # Work and air of a cycle, which most results are quotients of.
    work, peak = ledger.work, peak_pressure(run)
    fmep, swept = friction_pressure(run, peak), swept_volume(p.engine)
    air = ledger.groove.mass, control.supplied.mass

    # Whether the balances close. The march knows no engine friction: its work is given to the exergy ledger.
    mass_closure, energy_closure = closure(run)
    exergy = exergy_ledger(run, fmep * swept)
    values = {
        **performance(p, p.speed / TURN, work, fmep, swept, air),
        "groove_back_flow_kg_per_cycle": ledger.groove_back,
        "exhaust_back_flow_kg_per_cycle": ledger.exhaust_back,
        **valve_angles(machine, run),
        "peak_cylinder_pressure_Pa": peak,
        "intake_pressure_fluctuation_Pa": receiver_range(run),
        "lowest_cylinder_temperature_K": lowest_temperature(run),
        "exhaust_temperature_K": exhaust_temperature(run),
        **{f"exergy_{name}_J": value for name, value in exergy.items()},
        "converged": int(orbit.converged),
        "period_cycles": orbit.period,
        "cycles": orbit.cycles,
        "periodic_change": orbit.change,
        "mass_closure": mass_closure,
        "energy_closure": energy_closure,
        "exergy_closure": exergy_closure(run, exergy),
        "work_by_quadrature_change": abs(run.work_by_quadrature / work - 1.0) if work else nan,
        "work_tolerance_change": run.work_change,
        "air_tolerance_change": run.air_change,
        "tolerance": run.tolerance,
    }
    return {name: values[name] for name in INDICATORS}
