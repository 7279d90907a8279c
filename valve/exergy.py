"""Exergy of the control air: what it brings, and what becomes of it in solenoids, chambers and piston.

Equations: Bejan, Advanced Engineering Thermodynamics, 4th ed., chapters 3 and 5; see `apesim.exergy`.
"""

import numpy as np

from apesim.air import GasContent, GasState
from apesim.effect import add_laws, restitution
from apesim.exergy import (
    exergy_brought,
    exergy_stored,
    heat_exergy,
    mixing_loss,
    stream_exergy,
    stream_through,
    throttling_loss,
)
from apesim.kernel import kernel
from apesim.march.adaptive import LOG_HEAD
from apesim.restriction import Sides, flow_in
from apesim.stack_array import zeros
from apesim.valve.actuator import LINE_REGIME, PHASE, REGIME, Actuator, solenoid_flows, state_of, with_shares
from apesim.valve.ledger import valve_states
from apesim.valve.line import has_line
from apesim.valve.motion import MET_CLOSED, MET_OPEN
from apesim.valve.piston import HELD_CLOSED, HELD_OPEN, dry_friction_force, is_moving, land
from apesim.valve.solenoid_flow import SUPPLY_A, SUPPLY_B, VENT_A, VENT_B, solenoid_sides
from apesim.valve.supply import ValveSupply
from apesim.valve.terms import (
    DRY,
    ENERGY_A,
    ENERGY_B,
    FORCE,
    HEAT_A,
    HEAT_B,
    MASS_A,
    MASS_B,
    TERMS,
    WALL_EXERGY,
)

(
    CONTROL_AIR,
    WALL_HEAT,
    SOLENOIDS,
    VENTS,
    VENTED_AIR,
    CHAMBER_MIXING,
    VALVE_FRICTION,
    VALVE_IMPACTS,
    LEAKS,
    HEAT_TRANSFER,
    VALVE_RATES,
) = range(11)
"""Rates of the exergy ledger that the valve adds to, see `apesim.engine.exergy.TERMS`; how many there are."""


@kernel
def add_valve_rates(
    actuator: Actuator,
    t: float,
    y: np.ndarray,
    mode: np.ndarray,
    source: GasState,
    supply: ValveSupply,
    r: np.ndarray,
) -> tuple[float, float]:
    """Add the valve's part of the exergy ledger.

    Every loss is T_0 times the entropy made, every stream counts with its flow exergy [1]_; see `apesim.exergy`.

    Parameters
    ----------
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    t : float
        Time [s].
    y : (>= 6,) float array
        Position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B.
    mode : (>= MODES,) float array
        Modes of the valve, see `apesim.valve.actuator`.
    source : apesim.air.GasState
        State of the control air before its line.
    supply : apesim.valve.supply.ValveSupply
        Control air before the solenoids, and pressure before the groove.
    r : (>= VALVE_RATES,) float array
        Ledger that is added to [W].

    Returns
    -------
    control_air : float
        Mass flow from the source [kg/s].
    mixing : float
        Exergy destroyed in the source where control air flows back and mixes with what is there [W].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapters 3
       and 5.

    Examples
    --------
    Nothing flows while all flows are shut:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> from apesim.valve.actuator import MODES
    >>> r = np.zeros(VALVE_RATES)
    >>> control_air, mixing = add_valve_rates(actuator, 0.0, y, np.zeros(MODES), supply.control, supply, r)
    >>> control_air
    0.0
    """
    gas, ambient, valve = actuator.gas, actuator.ambient, actuator.valve
    state = state_of(actuator, y, supply)
    flows, sides = solenoid_flows(actuator, t, mode, state), solenoid_sides(state)

    # Flows as the rates have them: with what effects add.
    balance = zeros(TERMS)
    if len(actuator.effects) > 0:
        add_laws(actuator.effects, state, balance)
        flows = with_shares(flows, balance)

    # Streams through the solenoids: throttled on the way in and out, mixed in the chamber that they enter.
    in_a = stream_through(mode[REGIME + SUPPLY_A], sides[SUPPLY_A], flows[SUPPLY_A].mass)
    out_a = stream_through(mode[REGIME + VENT_A], sides[VENT_A], flows[VENT_A].mass)
    in_b = stream_through(mode[REGIME + SUPPLY_B], sides[SUPPLY_B], flows[SUPPLY_B].mass)
    out_b = stream_through(mode[REGIME + VENT_B], sides[VENT_B], flows[VENT_B].mass)
    (p_a, t_a), (p_b, t_b), line = state.chamber_a, state.chamber_b, supply.control
    before, vent = line.pressure, actuator.vent_pressure
    r[SOLENOIDS] += throttling_loss(gas, ambient, in_a, before, p_a) + throttling_loss(gas, ambient, in_b, before, p_b)
    r[VENTS] += throttling_loss(gas, ambient, out_a, p_a, vent) + throttling_loss(gas, ambient, out_b, p_b, vent)
    r[VENTED_AIR] += stream_exergy(gas, ambient, out_a, vent) + stream_exergy(gas, ambient, out_b, vent)
    r[CHAMBER_MIXING] += mixing_loss(gas, ambient, in_a, t_a) - mixing_loss(gas, ambient, out_a, t_a)
    r[CHAMBER_MIXING] += mixing_loss(gas, ambient, in_b, t_b) - mixing_loss(gas, ambient, out_b, t_b)

    # Friction, and the forces of effects: on a piston that is held they do no work.
    if is_moving(mode[PHASE]):
        force = balance[FORCE] + dry_friction_force(mode[PHASE], balance[DRY])
        r[VALVE_FRICTION] += state.speed * (valve.viscous_friction * state.speed - force)

    # What effects let into the chambers: heat apart from air, as its exergy is taken at the temperature of its wall.
    heat_a, heat_b = balance[HEAT_A], balance[HEAT_B]
    r[LEAKS] -= exergy_brought(gas, ambient, balance[MASS_A], balance[ENERGY_A] - heat_a, state.chamber_a)
    r[LEAKS] -= exergy_brought(gas, ambient, balance[MASS_B], balance[ENERGY_B] - heat_b, state.chamber_b)
    r[WALL_HEAT] += balance[WALL_EXERGY]
    r[HEAT_TRANSFER] += balance[WALL_EXERGY] - heat_exergy(ambient, heat_a, t_a) - heat_exergy(ambient, heat_b, t_b)

    # What the source gives, to the line where there is one, else to the chambers. Where control air flows back, it
    # mixes in the source, whose balance is the caller's.
    if has_line(actuator):
        feed = Sides(source, line)
        mass = flow_in(gas, mode[LINE_REGIME], actuator.line.feed_area, feed).mass
        drawn = stream_through(mode[LINE_REGIME], feed, mass)
        r[SOLENOIDS] += throttling_loss(gas, ambient, drawn, source.pressure, before)
        r[CHAMBER_MIXING] += mixing_loss(gas, ambient, drawn, line.temperature)
        r[CHAMBER_MIXING] -= mixing_loss(gas, ambient, in_a, line.temperature) + mixing_loss(
            gas, ambient, in_b, line.temperature
        )
        r[CONTROL_AIR] += stream_exergy(gas, ambient, drawn, source.pressure)
        return mass, -mixing_loss(gas, ambient, drawn, source.temperature)
    r[CONTROL_AIR] += stream_exergy(gas, ambient, in_a, source.pressure) + stream_exergy(
        gas, ambient, in_b, source.pressure
    )
    mixing = -mixing_loss(gas, ambient, in_a, source.temperature) - mixing_loss(gas, ambient, in_b, source.temperature)
    return in_a.mass + in_b.mass, mixing


def valve_stored(actuator: Actuator, y: np.ndarray, supply: ValveSupply) -> float:
    """Return the exergy that the valve holds: air of both chambers, springs and motion.

    The springs hold ``K L (L - L_max)``, their energy but for a constant; the motion holds ``M v^2/2``.

    The springs' energy is the integral of their force K (L_max - 2 L), Eq. 1 of the EPV paper [1]_; the air counts with
    its exergy [2]_.

    Parameters
    ----------
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    y : (>= 6,) float array
        Position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B.
    supply : apesim.valve.supply.ValveSupply
        Control air before the solenoids, and pressure before the groove.

    Returns
    -------
    float
        Exergy [J].

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 1.
    .. [2] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.

    Examples
    --------
    1 m/s adds 0.1145 kg/2 times 1 m2/s2:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> moving = y.copy()
    >>> moving[1] = 1.0
    >>> round(float(valve_stored(actuator, moving, supply) - valve_stored(actuator, y, supply)), 5)
    0.05725
    """
    gas, ambient, valve = actuator.gas, actuator.ambient, actuator.valve
    state = state_of(actuator, y, supply)
    springs = valve.spring_rate * state.position * (state.position - valve.stroke)
    motion = 0.5 * valve.moving_mass * state.speed**2
    states = valve_states(y)
    a = exergy_stored(gas, ambient, GasContent(states.mass_a, states.energy_a), state.chamber_a, state.volume_a)
    b = exergy_stored(gas, ambient, GasContent(states.mass_b, states.energy_b), state.chamber_b, state.volume_b)
    return a + b + springs + motion


def impact_loss(actuator: Actuator, log: np.ndarray) -> float:
    """Return the kinetic energy that the piston loses at its stops, the sum of ``M (v-^2 - v+^2)/2``.

    v- and v+ are the speeds before and after a contact, by Newton's law of restitution [1]_; M is the moving mass.

    Parameters
    ----------
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    log : (l, 3 + i) float array
        Log of a march, see `apesim.march.adaptive.march`.

    Returns
    -------
    float
        Energy [J].

    References
    ----------
    .. [1] W. J. Stronge, "Impact Mechanics", Cambridge University Press, 2000, doi 10.1017/CBO9780511626432.

    Examples
    --------
    A contact at 2 m/s of 0.1145 kg:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> round(float(impact_loss(actuator, np.array([[0.0, MET_OPEN, 0.0, 0.0, -2.0, *y[2:]]]))), 6)
    0.229
    """
    lost = 0.0
    for row in log[(log[:, 1] == MET_CLOSED) | (log[:, 1] == MET_OPEN)]:
        speed = valve_states(row[LOG_HEAD:]).speed
        stop = HELD_CLOSED if row[1] == MET_CLOSED else HELD_OPEN
        after, _ = land(stop, speed, restitution(actuator.effects, abs(speed)))
        lost += 0.5 * actuator.valve.moving_mass * (speed**2 - after**2)
    return lost
