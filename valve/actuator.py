"""Solenoids, chambers and piston together: the valve as bench and engine march it."""

from typing import NamedTuple

import numpy as np

from apesim.air import Ambient, Gas, gas_of, internal_energy
from apesim.effect import NoEffects, add_laws, adjusted, chosen, volume_of
from apesim.kernel import kernel
from apesim.restriction import flow_in
from apesim.stack_array import zeros
from apesim.valve.chamber import chamber_state
from apesim.valve.effects import VALVE_EFFECTS, ValveLaws, ValveTables
from apesim.valve.groove import area_table
from apesim.valve.piston import (
    Valve,
    dry_friction_force,
    is_moving,
    smooth_force,
    volume_a,
    volume_b,
)
from apesim.valve.solenoid import breakpoints_of, opening_curve
from apesim.valve.solenoid_flow import FLOWS, SUPPLY_A, SUPPLY_B, VENT_A, VENT_B, solenoid_sides
from apesim.valve.terms import DRY, ENERGY_A, ENERGY_B, FLOW_SHARE, FORCE, MASS_A, MASS_B, TERMS, ValveState

STATES = 6
"""Position [m], speed [m/s], mass [kg] and energy [J] of chamber A, the same of chamber B."""
PHASE, PIECE, PIECE_LOW, PIECE_HIGH, AREA, AREA_SLOPE, START, X_A, X_A_SLOPE, X_B, X_B_SLOPE, REGIME = range(12)
BRANCHES, LINE_REGIME, MODES = range(REGIME + FLOWS, REGIME + FLOWS + 3)
"""Modes: phase of the piston; piece of the groove's table, its ends [m], its line as area [m2] at lift 0 and slope [m];
start of the stretch [s], energised fraction of each solenoid there and its slope [1/s]; from REGIME on, those of the
flows through the solenoids, see `apesim.restriction`; branches of the effects' laws; regime of the
flow into the supply line; how many modes there are."""
GAS_SCALE = 1e-30
SCALE = (9e-3, 1.0, GAS_SCALE, GAS_SCALE, GAS_SCALE, GAS_SCALE)
"""Scale of the error of each state beside its own size: the paper's stroke, 1 m/s; gas states are relative."""
MAX_STEP = 0.5e-3
"""Longest step [s]: no contact and start from rest of a valve fit into it unseen."""


class Actuator(NamedTuple):
    """The valve with what surrounds it, as numbers for the kernels."""

    gas: Gas
    ambient: Ambient
    valve: Valve
    """Without its curve, which is in the tables."""
    control_pressure: float
    """Of control air from the regulator [Pa abs]."""
    vent_pressure: float
    """Behind the vents of the solenoids [Pa abs]."""
    stretch: float
    """On the pressure difference over the upstream pressure, in Eq. 8 of the solenoids; 1: they choke as it says."""
    line: tuple[float, float]
    """Supply line before the solenoids, see `apesim.effect.volume_of`."""
    effects: ValveLaws | ValveTables | NoEffects


class ActuatorTables(NamedTuple):
    """The valve's arrays."""

    edges_a: np.ndarray
    """Of solenoid A: energise, release, energise, ... ascending [s], shape (n,)."""
    edges_b: np.ndarray
    period: float
    """At which the edges repeat for ever, in the past too [s]; inf: they happen once."""
    curve_a: np.ndarray
    """How solenoid A follows a switch, see `apesim.valve.solenoid.opening_curve`."""
    curve_b: np.ndarray
    groove: np.ndarray
    """See `apesim.valve.groove.area_table`."""

    def breakpoints(self, start, end):
        """Times at which a switch happens or a solenoid's curve bends, up to end and with it [s]."""
        solenoids = (self.edges_a, self.curve_a), (self.edges_b, self.curve_b)
        breakpoints = [breakpoints_of(edges, self.period, curve[:, 0], start, end) for edges, curve in solenoids]
        return np.unique(np.concatenate(breakpoints))


def actuator_of(machine, edges, period, edges_b=None, kind=0):
    """The kernels' view of a machine's valve, its effects applied.

    Parameters
    ----------
    machine : NamedTuple
        With the sections ``air``, ``ambient``, ``supply``, ``valve``, ``groove`` and ``effects``.
    edges : (n,) float array
        Energise, release, energise, ... ascending [s].
    period : float
        At which the edges repeat [s]; inf: they happen once.
    edges_b : (m,) float array, optional
        Those of solenoid B where they are its own [s].
    kind : int
        See `apesim.effect.chosen`.

    Returns
    -------
    Actuator, ActuatorTables
    """
    valve = machine.valve
    curve = opening_curve(valve.solenoid)
    actuator = Actuator(
        gas_of(machine.air),
        machine.ambient,
        valve._replace(solenoid=valve.solenoid._replace(opening_curve=None)),
        machine.supply.control()[0],
        machine.ambient.pressure,
        1.0,
        volume_of(VALVE_EFFECTS, machine.effects),
        chosen(VALVE_EFFECTS, machine.effects, ValveLaws, ValveTables, kind),
    )
    edges_a, edges_b = (np.asarray(each, dtype=float) for each in (edges, edges if edges_b is None else edges_b))
    tables = ActuatorTables(edges_a, edges_b, float(period), curve, curve, area_table(machine.groove, valve.stroke))
    return adjusted(VALVE_EFFECTS, machine.effects, actuator, tables)


def closed_at_rest(actuator, supply):
    """State of a piston at rest, closed: chamber A at supply pressure, B at the vent's, both at supply temperature.

    Parameters
    ----------
    actuator : Actuator
    supply : tuple of float
        Control air: pressure [Pa abs], temperature [K].

    Returns
    -------
    (6,) float array
    """
    gas, valve = actuator.gas, actuator.valve
    pressure, temperature = supply[:2]
    energy = internal_energy(gas, temperature)
    mass_a = pressure * volume_a(valve, valve.stroke) / (gas.gas_constant * temperature)
    mass_b = actuator.vent_pressure * volume_b(valve, valve.stroke) / (gas.gas_constant * temperature)
    return np.array([valve.stroke, 0.0, mass_a, mass_a * energy, mass_b, mass_b * energy])


class ActuatorRates(NamedTuple):
    """Rates of the states and of the ledger."""

    position: float
    speed: float
    mass_a: float
    energy_a: float
    mass_b: float
    energy_b: float
    supplied: float
    """Control air through the supply sides of both solenoids [kg/s]."""
    supplied_enthalpy: float
    vented: float
    vented_enthalpy: float
    other_mass: float
    """Into the chambers by effects [kg/s]."""
    other_energy: float
    work: float
    """Of both chambers on the piston [W]."""


@kernel
def state_of(actuator, y, supply):
    """The valve's state as the laws see it.

    Parameters
    ----------
    actuator : Actuator
    y : (>= 6,) float array
    supply : tuple of float
        Control air: pressure [Pa abs], temperature [K]; pressure before the groove [Pa abs].

    Returns
    -------
    ValveState
    """
    valve = actuator.valve
    v_a = volume_a(valve, y[0])
    v_b = volume_b(valve, y[0])
    p_a, t_a = chamber_state(actuator.gas, y[2], y[3], v_a)
    p_b, t_b = chamber_state(actuator.gas, y[4], y[5], v_b)
    return ValveState(
        actuator.gas,
        actuator.ambient,
        valve,
        y[0],
        y[1],
        p_a,
        t_a,
        v_a,
        p_b,
        t_b,
        v_b,
        supply[0],
        supply[1],
        supply[2],
        actuator.vent_pressure,
        actuator.stretch,
    )


@kernel
def in_domain(actuator, y):
    """Whether masses, energies and volumes are above zero."""
    valve = actuator.valve
    return (
        y[2] > 0.0
        and y[3] > 0.0
        and y[4] > 0.0
        and y[5] > 0.0
        and volume_a(valve, y[0]) > 0.0
        and volume_b(valve, y[0]) > 0.0
    )


@kernel
def solenoid_flows(actuator, t, mode, state):
    """Flows SUPPLY_A...VENT_B through the solenoids, each with its enthalpy; without the effects' shares [kg/s, W]."""
    gas, area, sides = actuator.gas, actuator.valve.solenoid.effective_area, solenoid_sides(state)
    x_a = mode[X_A] + mode[X_A_SLOPE] * (t - mode[START])
    x_b = mode[X_B] + mode[X_B_SLOPE] * (t - mode[START])
    return (
        flow_in(gas, mode[REGIME + SUPPLY_A], area * (1.0 - x_a), sides[SUPPLY_A]),
        flow_in(gas, mode[REGIME + VENT_A], area * x_a, sides[VENT_A]),
        flow_in(gas, mode[REGIME + SUPPLY_B], area * x_b, sides[SUPPLY_B]),
        flow_in(gas, mode[REGIME + VENT_B], area * (1.0 - x_b), sides[VENT_B]),
    )


@kernel
def _larger(flow, share):
    return (1.0 + share) * flow[0], (1.0 + share) * flow[1]


@kernel
def with_shares(flows, balance):
    """Flows through the solenoids with the shares by which effects make them larger."""
    return (
        _larger(flows[SUPPLY_A], balance[FLOW_SHARE + SUPPLY_A]),
        _larger(flows[VENT_A], balance[FLOW_SHARE + VENT_A]),
        _larger(flows[SUPPLY_B], balance[FLOW_SHARE + SUPPLY_B]),
        _larger(flows[VENT_B], balance[FLOW_SHARE + VENT_B]),
    )


@kernel
def actuator_rates(actuator, t, y, mode, supply):
    """Rates of the valve (Eqs. 1-8).

    Parameters
    ----------
    actuator : Actuator
    t : float
        [s]
    y : (>= 6,) float array
    mode : (>= MODES,) float array
    supply : tuple of float
        See `state_of`.

    Returns
    -------
    ActuatorRates
    """
    valve = actuator.valve
    phase = mode[PHASE]
    state = state_of(actuator, y, supply)
    flows = solenoid_flows(actuator, t, mode, state)
    force = smooth_force(valve, state.position, state.speed, state.pressure_a, state.pressure_b)
    speed = acceleration = mass_a = mass_b = energy_a = energy_b = 0.0
    if len(actuator.effects) > 0:
        balance = zeros(TERMS)
        add_laws(actuator.effects, state, balance)
        flows = with_shares(flows, balance)
        force += balance[FORCE] + dry_friction_force(phase, balance[DRY])
        mass_a, mass_b = balance[MASS_A], balance[MASS_B]
        energy_a, energy_b = balance[ENERGY_A], balance[ENERGY_B]
    if is_moving(phase):
        speed = state.speed
        acceleration = force / valve.moving_mass
    (in_a, in_energy_a), (out_a, out_energy_a), (in_b, in_energy_b), (out_b, out_energy_b) = flows
    work_a = state.pressure_a * valve.piston_area * speed
    work_b = -state.pressure_b * valve.piston_area * speed
    return ActuatorRates(
        speed,
        acceleration,
        in_a - out_a + mass_a,
        in_energy_a - out_energy_a - work_a + energy_a,
        in_b - out_b + mass_b,
        in_energy_b - out_energy_b - work_b + energy_b,
        in_a + in_b,
        in_energy_a + in_energy_b,
        out_a + out_b,
        out_energy_a + out_energy_b,
        mass_a + mass_b,
        energy_a + energy_b,
        work_a + work_b,
    )
