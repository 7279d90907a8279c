"""What comes out of an operating point: work, air, efficiencies, true valve angles, and how well it closes."""

from functools import partial
from math import nan

import numpy as np

from apesim.air import ANR_DENSITY, enthalpy, temperature_at_enthalpy, temperature_of
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.breathing import cam_angles
from apesim.engine.cycle.state import (
    control_ledger,
    cylinder_gas,
    engine_ledger,
    line_gas,
    pipe_gas,
    receiver_gas,
    receiver_state,
)
from apesim.engine.cylinder import CAM, IDEAL_VALVE
from apesim.engine.exergy import TERMS, exergy_closure, exergy_ledger
from apesim.engine.friction import friction_mean_effective_pressure, mean_piston_speed
from apesim.engine.ideal_work import full_admission_work, isentropic_work, isothermal_work
from apesim.engine.kinematics import cylinder_volume, swept_volume
from apesim.exergy import flow_exergy
from apesim.march.adaptive import LOG_HEAD
from apesim.march.error_bounds import closure_of
from apesim.valve.actuator import PHASE
from apesim.valve.chamber import chamber_state
from apesim.valve.groove import area_table, lap_of
from apesim.valve.ledger import valve_states
from apesim.valve.measures import closing_stroke, lap_times, opening_stroke, travel_of

JOULE_PER_KWH = 3.6e6
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
    "exhaust_back_flow_kg_per_cycle": ("kg", "air that flows in through the exhaust valve in a cycle"),
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
    "lowest_cylinder_temperature_K": ("K", "lowest cylinder temperature"),
    "exhaust_temperature_K": ("K", "temperature of the exhaust air of a cycle, mixed: by its mean enthalpy"),
    **{f"exergy_{name}_J": ("J", f"{text}, in a cycle") for name, text in TERMS.items()},
    "converged": ("1", "whether the state repeats: 1 yes, 0 no"),
    "period_cycles": ("1", "cycles after which the state repeats: 1 or 2; 0: not seen to repeat"),
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
"""Name of each indicator, as in files: its unit and what it is."""
FLAGS = ("converged",)
COUNTS = ("period_cycles", "cycles")


def ratio(numerator, denominator):
    """A quotient, or NaN where the denominator is not positive."""
    return numerator / denominator if denominator > 0.0 else nan


def valve_angles(machine, run):
    """True opening and closing of the intake.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    run : apesim.engine.steady.SteadyRun

    Returns
    -------
    dict
        ``valve_open_deg``, ``valve_close_deg``, ``full_open_deg``, ``closed_deg``, ``peak_lift_m``, seating speeds and
        fluctuations. NaN: it never comes to it.
    """
    p, log = run.p, run.log
    table = area_table(machine.groove, machine.valve.stroke)
    if p.engine.intake == CAM:
        return _angles(*cam_angles(machine.engine.cam, lap_of(table))) | _no_strokes()
    if p.engine.intake == IDEAL_VALVE:
        found = (p.open_target, p.close_target, p.open_target, p.close_target, machine.valve.stroke)
        return _angles(*found) | _no_strokes()
    opening, closing, opened, shut = valve_motion(machine, run)
    lift = np.minimum(machine.valve.stroke - log[:, LOG_HEAD], machine.valve.stroke)
    times = (opened, shut, opening.contact, closing.contact)
    return _angles(*(p.start + p.speed * t for t in times), lift.max()) | {
        "opening_seating_speed_m_s": opening.seating_speed,
        "closing_seating_speed_m_s": closing.seating_speed,
        "fluctuation": opening.fluctuation,
        "closing_fluctuation": closing.fluctuation,
    }


def valve_motion(machine, run):
    """Strokes of the valve (`apesim.valve.measures.Stroke`), and when its lift rises and falls through the lap [s].

    Times are from the energising on, and later than a cycle where the valve moves into the next; NaN: never.
    """
    p, log = run.p, run.log
    table = area_table(machine.groove, machine.valve.stroke)
    period = TURN / p.speed
    doubled = np.concatenate((log, log))
    doubled[len(log) :, 0] += period
    release = (machine.command.release - machine.command.energise) / p.speed
    opening = opening_stroke(doubled, 0.0, 2.0 * period)
    closing = closing_stroke(doubled, release, 2.0 * period)
    return opening, closing, *lap_times(doubled, machine.valve.stroke, lap_of(table))


def valve_travel(machine, run):
    """Which of its stops the piston of the electro-pneumatic valve meets in a cycle.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    run : apesim.engine.steady.SteadyRun

    Returns
    -------
    apesim.valve.measures.Travel
    """
    opening, closing, *_ = valve_motion(machine, run)
    return travel_of(run.log, run.orbit.mode[PHASE], opening, closing)


def _angles(opens, closes, full_open, closed, lift):
    return {
        "valve_open_deg": opens / DEGREE,
        "valve_close_deg": closes / DEGREE,
        "full_open_deg": full_open / DEGREE,
        "closed_deg": closed / DEGREE,
        "peak_lift_m": lift,
    }


def _no_strokes():
    names = ("opening_seating_speed_m_s", "closing_seating_speed_m_s", "fluctuation", "closing_fluctuation")
    return dict.fromkeys(names, nan)


def peak_pressure(run):
    """Highest cylinder pressure, over its extrema and the ends of all smooth stretches [Pa abs]."""
    gas, log = run.p.actuator.gas, run.log
    pressures = []
    for row in log:
        volume, _ = cylinder_volume(run.p.crank, run.p.start + run.p.speed * row[0])
        pressures.append(chamber_state(gas, *cylinder_gas(row[LOG_HEAD:]), volume)[0])
    return max(pressures)


def receiver_range(run):
    """Highest less lowest pressure in the receiver, over its extrema and the ends of all smooth stretches [Pa]."""
    p = run.p
    if p.receiver_volume == 0.0:
        return 0.0
    pressures = [receiver_state(p, row[LOG_HEAD:])[0] for row in (*run.log, *run.extrema)]
    return max(pressures) - min(pressures)


def lowest_temperature(run):
    """Lowest cylinder temperature, over its extrema and the ends of all smooth stretches [K]."""
    gas = run.p.actuator.gas
    gases = [cylinder_gas(row[LOG_HEAD:]) for row in (*run.log, *run.extrema)]
    return temperature_of(gas, min(energy / mass for mass, energy in gases))


def exhaust_temperature(run):
    """Temperature of the mean enthalpy of what flows out through the exhaust valve [K]; NaN where nothing does."""
    gas, air = run.p.actuator.gas, engine_ledger(run.end)
    back = air.exhaust_back
    mass = air.exhausted + back
    energy = air.exhausted_enthalpy + back * enthalpy(gas, run.p.actuator.ambient.temperature)
    return temperature_at_enthalpy(gas, energy / mass) if mass > 0.0 else nan


def friction_pressure(run, peak):
    """Friction mean effective pressure of a run with a highest cylinder pressure [Pa]."""
    engine = run.p.engine
    return friction_mean_effective_pressure(engine.friction, peak, mean_piston_speed(engine.stroke, run.p.speed))


def closure(run):
    """Mass and energy that the cycle's ledger does not account for, relative to what goes through the engine.

    See `apesim.march.error_bounds.closure_of`.

    Returns
    -------
    mass, energy : float
    """
    p, control, engine = run.p, control_ledger(run.end), engine_ledger(run.end)
    mass_in, energy_in = engine.pipe_fed, engine.pipe_fed_enthalpy
    if p.receiver_volume > 0.0:
        mass_in, energy_in = engine.fed, engine.fed_enthalpy
    if not (p.receiver_volume > 0.0 and p.control_from_receiver):
        mass_in, energy_in = mass_in + control.line_fed, energy_in + control.line_fed_enthalpy
    stored, stored_energy = _gas_held(run.end - run.start)
    mass = stored - (mass_in - engine.exhausted - control.vented + control.other_mass)
    energy_in = energy_in - engine.exhausted_enthalpy - control.vented_enthalpy + control.other_energy
    energy = stored_energy - (energy_in - engine.work - control.valve_work)
    through = engine.groove + control.supplied + engine.groove_back + engine.exhaust_back
    back = engine.exhaust_back * enthalpy(p.actuator.gas, p.actuator.ambient.temperature)
    carried = abs(engine.groove_enthalpy) + abs(control.supplied_enthalpy) + back
    held, held_energy = _gas_held(run.start)
    return closure_of(mass, through, held), closure_of(energy, carried, held_energy)


def _gas_held(y: np.ndarray) -> tuple[float, float]:
    """Mass [kg] and internal energy [J] of all gas that a state vector of the engine holds."""
    valve = valve_states(y)
    volumes = (cylinder_gas(y), receiver_gas(y), line_gas(y), pipe_gas(y))
    mass, energy = valve.mass_a + valve.mass_b, valve.energy_a + valve.energy_b
    for volume_mass, volume_energy in volumes:
        mass, energy = mass + volume_mass, energy + volume_energy
    return mass, energy


def indicators(machine, run):
    """All scalar results of an operating point.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    run : apesim.engine.steady.SteadyRun

    Returns
    -------
    dict
        Keys as in `INDICATORS`, SI but for the units that the keys name. NaN: undefined.
    """
    p, orbit = run.p, run.orbit
    ledger, control = engine_ledger(run.end), control_ledger(run.end)
    gas, ambient, supply = p.actuator.gas, machine.ambient, machine.supply
    turns = p.speed / TURN
    work = ledger.work
    swept = swept_volume(p.engine)
    peak = peak_pressure(run)
    fmep = friction_pressure(run, peak)
    brake = work - fmep * swept
    engine_air, control_air = ledger.groove, control.supplied
    air = engine_air + control_air

    drawn = p.supply if p.control_from_receiver else p.control

    def efficiency(law):
        ideal = engine_air * law(supply.pressure, supply.temperature) + control_air * law(*drawn)
        return ratio(brake, ideal) if brake > 0.0 else nan

    def expanded(law):
        return efficiency(lambda pressure, temperature: law(gas, temperature, pressure / ambient.pressure))

    mass_closure, energy_closure = closure(run)
    exergy = exergy_ledger(run, fmep * swept)
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
        "groove_back_flow_kg_per_cycle": ledger.groove_back,
        "exhaust_back_flow_kg_per_cycle": ledger.exhaust_back,
        "specific_air_kg_per_kWh": ratio(air * JOULE_PER_KWH, brake),
        "specific_engine_air_kg_per_kWh": ratio(engine_air * JOULE_PER_KWH, brake),
        "indicated_specific_air_kg_per_kWh": ratio(air * JOULE_PER_KWH, work),
        "air_L_per_min_ANR": air * turns / ANR_DENSITY * 60e3,
        "exergy_efficiency": efficiency(partial(flow_exergy, gas, ambient)),
        "isothermal_efficiency": expanded(isothermal_work),
        "isentropic_efficiency": expanded(isentropic_work),
        "full_admission_efficiency": expanded(full_admission_work),
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
