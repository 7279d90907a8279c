"""Solenoids, chambers and piston together: the valve as bench and engine march it.

Equations: the EPV paper (doi 10.1631/jzus.A0820373), Eqs. 1-8.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.air import Gas, GasContent, GasState, gas_of, internal_energy
from apesim.effect import FedVolume, NoEffects, add_laws, adjusted, chosen, library_for, volume_of
from apesim.kernel import kernel
from apesim.restriction import NO_FLOW, Flow, flow_in
from apesim.stack_array import zeros
from apesim.valve.chamber import chamber_state
from apesim.valve.effects import VALVE_LIBRARY, ValveLaws, ValveTables
from apesim.valve.groove import area_table
from apesim.valve.ledger import ValveStates, valve_states
from apesim.valve.piston import (
    Valve,
    dry_friction_force,
    is_moving,
    smooth_force,
    volume_a,
    volume_b,
)
from apesim.valve.solenoid import SolenoidCurves, breakpoints_of, solenoid_curves
from apesim.valve.solenoid_flow import FLOWS, SUPPLY_A, SUPPLY_B, VENT_A, VENT_B, solenoid_sides
from apesim.valve.supply import ValveSupply
from apesim.valve.terms import DRY, ENERGY_A, ENERGY_B, FLOW_SHARE, FORCE, MASS_A, MASS_B, TERMS, ValveState

STATES = 6
"""Number of states: position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B."""
PHASE, PIECE, PIECE_LOW, PIECE_HIGH, AREA, AREA_SLOPE, START, X_A, X_A_SLOPE, X_B, X_B_SLOPE, REGIME = range(12)
BRANCHES, LINE_REGIME, MODES = range(REGIME + FLOWS, REGIME + FLOWS + 3)
"""Modes: phase of the piston; piece of the groove's table, its ends [m], its line as area [m2] at lift 0 and slope [m];
start of the stretch [s], energised fraction of each solenoid there and its slope [1/s]; from REGIME on, those of the
flows through the solenoids, see `apesim.restriction`; branches of the effects' laws; regime of the
flow into the supply line; how many modes there are."""
GAS_SCALE = 1e-30
"""Scale of the error of a mass or energy beside its own size; so small that the error of gas states is relative."""
SCALE = (9e-3, 1.0, GAS_SCALE, GAS_SCALE, GAS_SCALE, GAS_SCALE)
"""Scale of the error of each state beside its own size: the stroke of the EPV paper, 1 m/s; gas states are relative."""
MAX_STEP = 0.5e-3
"""Longest step [s]; chosen, so that no contact and start from rest of a valve fit into it unseen."""


class Actuator(NamedTuple):
    """Valve with what surrounds it, as numbers for the kernels."""

    gas: Gas
    """Working gas."""
    ambient: GasState
    """State of the surroundings."""
    valve: Valve
    """Dimensions of the valve; the curves of its solenoids are in the tables."""
    control_pressure: float
    """Pressure of control air from the regulator [Pa abs]."""
    vent_pressure: float
    """Pressure behind the vents of the solenoids [Pa abs]."""
    stretch: float
    """Factor on 1 - r in the flow function of the solenoids, with the pressure ratio r; 1: Eq. 8 of the EPV paper."""
    line: FedVolume
    """Supply line before the solenoids, where an effect puts one there."""
    effects: ValveLaws | ValveTables | NoEffects  # type: ignore[valid-type]
    """Parameters of the effects that act within the march."""


class ActuatorTables(NamedTuple):
    """Arrays of the valve."""

    edges_a: np.ndarray
    """Edges of solenoid A: energise, release, energise, ..., ascending [s], shape (n,)."""
    edges_b: np.ndarray
    """Edges of solenoid B [s], shape (m,)."""
    period: float
    """Period at which the edges repeat for ever, in the past too [s]; inf: they happen once."""
    curves_a: SolenoidCurves
    """How solenoid A follows each edge, see `apesim.valve.solenoid.solenoid_curves`."""
    curves_b: SolenoidCurves
    """How solenoid B follows each edge."""
    groove: np.ndarray
    """Effective area of the groove over lift, see `apesim.valve.groove.area_table`."""

    def breakpoints(self, start: float, end: float) -> np.ndarray:
        """Return the times [s] at which a switch happens or an energised fraction has a corner, ascending.

        They lie after `start` and up to `end` [s], `end` itself included.

        The default solenoids have a dead time and a ramp of 1.5 ms:

        >>> import apesim
        >>> _, tables = actuator_of(apesim.Machine(), edges=[0.0, 0.05], period=np.inf)
        >>> (tables.breakpoints(0.0, 0.1) * 1e3).round(6).tolist()
        [1.5, 3.0, 50.0, 51.5, 53.0, 100.0]
        """
        solenoids = [(self.edges_a, self.curves_a), (self.edges_b, self.curves_b)]
        if self.edges_a is self.edges_b and self.curves_a is self.curves_b:
            del solenoids[1]
        breakpoints = [breakpoints_of(edges, self.period, curves, start, end) for edges, curves in solenoids]
        return np.unique(np.concatenate(breakpoints))


def actuator_of(
    machine: Any,
    edges: Sequence[float] | np.ndarray,
    period: float,
    edges_b: Sequence[float] | np.ndarray | None = None,
    kind: int = 0,
) -> tuple[Actuator, ActuatorTables]:
    """Prepare a machine's valve for the kernels, with its effects applied: its numbers and its arrays.

    The edges [s] are those of energise, release, energise, ..., ascending, and repeat at `period` [s] (inf: they happen
    once); `edges_b` [s] are those of solenoid B where they are its own. `kind` says which laws the march needs at
    least, see `apesim.effect.chosen`. The machine has the sections ``air``, ``ambient``, ``supply``, ``valve``,
    ``groove`` and ``effects``.
    """
    valve = machine.valve
    curves = solenoid_curves(valve.solenoid)
    library = library_for(machine.effects, VALVE_LIBRARY, "valve")
    actuator = Actuator(
        gas_of(machine.air),
        GasState(*machine.ambient),
        valve._replace(solenoid=valve.solenoid._replace(opening_curve=None, release_curve=None)),
        machine.supply.control().pressure,
        machine.ambient.pressure,
        1.0,
        volume_of(library.effects, machine.effects),
        chosen(library, machine.effects, kind),
    )
    edges_a = np.asarray(edges, dtype=float)
    edges_b = edges_a if edges_b is None else np.asarray(edges_b, dtype=float)
    tables = ActuatorTables(edges_a, edges_b, float(period), curves, curves, area_table(machine.groove, valve.stroke))
    return adjusted(library.effects, machine.effects, actuator, tables)


def closed_at_rest(actuator: Actuator, control: GasState) -> np.ndarray:
    """Return the state of a piston at rest, closed.

    Chamber A is at the pressure of the control air, chamber B at that of the vents, both at the control air's
    temperature.

    Masses follow from ``p V = m R T``, Eq. 3 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    actuator : Actuator
        Valve as the kernels take it.
    control : apesim.air.GasState
        State of the control air.

    Returns
    -------
    (6,) float array
        Position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B.

    Examples
    --------
    1 MPa * 21 589 mm3/(287.05 J/(kg K) * 300 K) = 0.2507 g in chamber A:

    >>> import apesim
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=np.inf)
    >>> y = closed_at_rest(actuator, GasState(1e6, 300.0))
    >>> round(float(y[2]) * 1e3, 4)
    0.2507
    """
    gas, valve = actuator.gas, actuator.valve
    pressure, temperature = control
    energy = internal_energy(gas, temperature)
    mass_a = pressure * volume_a(valve, valve.stroke) / (gas.gas_constant * temperature)
    mass_b = actuator.vent_pressure * volume_b(valve, valve.stroke) / (gas.gas_constant * temperature)
    return np.array([valve.stroke, 0.0, mass_a, mass_a * energy, mass_b, mass_b * energy])


class ActuatorRates(NamedTuple):
    """Rates of the valve's states and of its ledger."""

    states: ValveStates
    """Rates of the states: speed [m/s] and acceleration [m/s2] of the piston, masses [kg/s] and energies [W]."""
    supplied: Flow
    """Control air through the supply sides of both solenoids."""
    vented: Flow
    """Air through the vents of both solenoids."""
    let_in: Flow
    """Mass and energy that effects let into the chambers."""
    work: float
    """Power of both chambers on the piston [W]."""


AT_REST = ActuatorRates(ValveStates(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), NO_FLOW, NO_FLOW, NO_FLOW, 0.0)
"""Rates of a valve that does nothing."""


@kernel
def state_of(actuator: Actuator, y: np.ndarray, supply: ValveSupply) -> ValveState:
    """Return the valve's state as the laws see it: pressures, temperatures and volumes beside position and speed.

    `y` (>= 6,) is position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B.
    """
    valve = actuator.valve
    states = valve_states(y)
    v_a = volume_a(valve, states.position)
    v_b = volume_b(valve, states.position)
    return ValveState(
        actuator.gas,
        actuator.ambient,
        valve,
        states.position,
        states.speed,
        chamber_state(actuator.gas, GasContent(states.mass_a, states.energy_a), v_a),
        v_a,
        chamber_state(actuator.gas, GasContent(states.mass_b, states.energy_b), v_b),
        v_b,
        supply,
        actuator.vent_pressure,
        actuator.stretch,
    )


@kernel
def in_domain(actuator: Actuator, y: np.ndarray) -> bool:
    """Return whether masses, energies and volumes are above zero, so that the laws hold; `y` is as in `state_of`."""
    valve, states = actuator.valve, valve_states(y)
    return (
        states.mass_a > 0.0
        and states.energy_a > 0.0
        and states.mass_b > 0.0
        and states.energy_b > 0.0
        and volume_a(valve, states.position) > 0.0
        and volume_b(valve, states.position) > 0.0
    )


@kernel
def solenoid_flows(actuator: Actuator, t: float, mode: np.ndarray, state: ValveState) -> tuple[Flow, ...]:
    """Return the flows through the solenoids, without the shares of effects.

    ``mdot = S x psi(r) p/sqrt(R T)``, Eq. 7 of the EPV paper [1]_, with the open share x of each flow.

    Parameters
    ----------
    actuator : Actuator
        Valve as the kernels take it.
    t : float
        Time [s].
    mode : (>= MODES,) float array
        Modes of the valve, see `apesim.valve.actuator`.
    state : ValveState
        State of the valve.

    Returns
    -------
    tuple of apesim.restriction.Flow
        Flows from SUPPLY_A to VENT_B.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 7 and 8.

    Examples
    --------
    9 mm2 * 0.6847 * 1 MPa/sqrt(287.05 J/(kg K) * 300 K) = 21.0 g/s into an energised chamber B:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> from apesim.restriction import CHOKED
    >>> mode = np.zeros(MODES)
    >>> mode[X_B], mode[REGIME + SUPPLY_B] = 1.0, CHOKED
    >>> flows = solenoid_flows(actuator, 0.0, mode, state_of(actuator, y, supply))
    >>> round(float(flows[SUPPLY_B].mass) * 1e3, 2)
    21.0
    """
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
def _larger(flow: Flow, share: float) -> Flow:
    """Return a flow that is larger by a share."""
    return Flow((1.0 + share) * flow.mass, (1.0 + share) * flow.enthalpy)


@kernel
def with_shares(flows: tuple[Flow, ...], balance: np.ndarray) -> tuple[Flow, ...]:
    """Return the flows through the solenoids with the shares by which effects make them larger.

    They are ordered from SUPPLY_A to VENT_B; `balance` (TERMS,) is that of the valve, see `apesim.valve.terms`.

    >>> balance = np.zeros(TERMS)
    >>> balance[FLOW_SHARE + VENT_A] = 0.5
    >>> flows = with_shares((Flow(1.0, 10.0), Flow(2.0, 20.0), Flow(3.0, 30.0), Flow(4.0, 40.0)), balance)
    >>> [float(flow.mass) for flow in flows]
    [1.0, 3.0, 3.0, 4.0]
    """
    return (
        _larger(flows[SUPPLY_A], balance[FLOW_SHARE + SUPPLY_A]),
        _larger(flows[VENT_A], balance[FLOW_SHARE + VENT_A]),
        _larger(flows[SUPPLY_B], balance[FLOW_SHARE + SUPPLY_B]),
        _larger(flows[VENT_B], balance[FLOW_SHARE + VENT_B]),
    )


@kernel
def actuator_rates(actuator: Actuator, t: float, y: np.ndarray, mode: np.ndarray, supply: ValveSupply) -> ActuatorRates:
    """Return the rates of the valve's states and ledger.

    Balances of momentum, mass and energy: Eqs. 1 to 8 of the EPV paper [1]_. The energy balance
    ``dU/dt = sum(h mdot) - p dV/dt`` is Eq. 5 for the internal energy.

    U is the internal energy of a chamber, p its pressure, V its volume, h the specific enthalpy of a flow mdot into it.
    The chambers are adiabatic (Eq. 6), but for heat that effects add.

    Parameters
    ----------
    actuator : Actuator
        Valve as the kernels take it.
    t : float
        Time [s].
    y : (>= 6,) float array
        Position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B.
    mode : (>= MODES,) float array
        Modes of the valve, see `apesim.valve.actuator`.
    supply : apesim.valve.supply.ValveSupply
        Control air before the solenoids, and pressure before the groove.

    Returns
    -------
    ActuatorRates
        Rates.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 1 to 8.

    Examples
    --------
    A free piston, with A at 1 MPa, B at 0.101325 MPa and the springs' 16.45 N to open:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> from apesim.valve.piston import TO_CLOSED
    >>> mode = np.zeros(MODES)
    >>> mode[PHASE] = TO_CLOSED
    >>> round(float(actuator_rates(actuator, 0.0, y, mode, supply).states.speed * actuator.valve.moving_mass), 2)
    1002.74
    >>> round(1134.1e-6 * (1e6 - 101325.0) - 1828.0 * 9e-3, 2)
    1002.74
    """
    valve = actuator.valve
    phase = mode[PHASE]
    state = state_of(actuator, y, supply)
    flows = solenoid_flows(actuator, t, mode, state)
    force = smooth_force(valve, state.position, state.speed, state.chamber_a.pressure, state.chamber_b.pressure)

    # What effects add: to flows, force and chambers.
    speed = acceleration = mass_a = mass_b = energy_a = energy_b = 0.0
    if len(actuator.effects) > 0:
        balance = zeros(TERMS)
        add_laws(actuator.effects, state, balance)
        flows = with_shares(flows, balance)
        force += balance[FORCE] + dry_friction_force(phase, balance[DRY])
        mass_a, mass_b = balance[MASS_A], balance[MASS_B]
        energy_a, energy_b = balance[ENERGY_A], balance[ENERGY_B]

    # A piston that is held stays at rest whatever the force: an event sets it free.
    if is_moving(phase):
        speed = state.speed
        acceleration = force / valve.moving_mass

    # Work of the gas on the piston, which stands between the chambers: where one expands, the other is compressed.
    in_a, out_a, in_b, out_b = flows
    work_a = state.chamber_a.pressure * valve.piston_area * speed
    work_b = -state.chamber_b.pressure * valve.piston_area * speed
    return ActuatorRates(
        ValveStates(
            speed,
            acceleration,
            in_a.mass - out_a.mass + mass_a,
            in_a.enthalpy - out_a.enthalpy - work_a + energy_a,
            in_b.mass - out_b.mass + mass_b,
            in_b.enthalpy - out_b.enthalpy - work_b + energy_b,
        ),
        Flow(in_a.mass + in_b.mass, in_a.enthalpy + in_b.enthalpy),
        Flow(out_a.mass + out_b.mass, out_a.enthalpy + out_b.enthalpy),
        Flow(mass_a + mass_b, energy_a + energy_b),
        work_a + work_b,
    )
