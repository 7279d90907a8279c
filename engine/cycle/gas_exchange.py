"""Gas exchange of the engine: the ports through which air flows between its volumes, and the regimes of these flows.

`ports_at` is their list: regimes, events and balances pass over its entries; ledger and exergy name some. The law of a
flow is Eq. 7 of the EPV paper (doi 10.1631/jzus.A0820373), see `apesim.restriction`. What effects let into the cylinder
is summed here, too.
"""

from typing import NamedTuple

import numpy as np

from apesim.air import GasState
from apesim.effect import add_laws
from apesim.engine.cam import raised_cosine
from apesim.engine.cycle.state import (
    EXCHANGE,
    FEED,
    GROOVE,
    INTAKE_OPEN,
    LIFT,
    LIFT_SLOPE,
    PORTS,
    Cycle,
    Instant,
    cylinder_state,
    has_pipe,
    intake_state,
)
from apesim.engine.cylinder import (
    BRANCH,
    ENERGY,
    EPV,
    GROOVE_ENERGY,
    GROOVE_MASS,
    HEAT,
    IDEAL_VALVE,
    MASS,
    TERMS,
    WALL_EXERGY,
    CylinderState,
)
from apesim.engine.exhaust import exhaust_area
from apesim.kernel import kernel
from apesim.restriction import NO_FLOW, SHUT, Flow, Sides, beyond_regime, flow_in, next_regime, regime_between
from apesim.stack_array import zeros
from apesim.valve.actuator import AREA, AREA_SLOPE
from apesim.valve.ledger import FLOW_ENTRIES, valve_states
from apesim.valve.ports import ports_area

SUPPLY_AIR, RECEIVER_AIR, INTAKE_AIR, CYLINDER_AIR, OUTSIDE_AIR = range(5)
"""Airs that a port leads from or to: INTAKE_AIR is before the groove, OUTSIDE_AIR behind the exhaust valves."""
AIRS = 5
"""Number of these airs."""


class Port(NamedTuple):
    """Port of the gas exchange at an instant: a way for air, with what is before and behind it."""

    area: float
    """Effective area [m2]; 0 where the machine has no such port, or it is shut."""
    before: int
    """Number of the air on side 1; a flow from there to side 2 is positive."""
    behind: int
    """Number of the air on side 2."""


class EffectTerms(NamedTuple):
    """What effects let into the cylinder at an instant."""

    let_in: Flow
    """Mass and energy from outside; out of the cylinder below zero."""
    past_groove: Flow
    """Air that passes beside the groove into the cylinder."""
    heat: float
    """Part of the energy from outside that is heat [W]."""
    wall_exergy: float
    """Exergy of that heat at the temperature of its wall [W]."""
    branches: float
    """Branches of the effects' laws, see `apesim.effect.note_branch`."""


NO_EFFECTS = EffectTerms(NO_FLOW, NO_FLOW, 0.0, 0.0, 0.0)
"""Terms of a cylinder without effects."""


@kernel
def intake_lift(p: Cycle, angle: float, y: np.ndarray, mode: np.ndarray) -> float:
    """Lift of the intake [m], at a crank angle [rad]: of the electro-pneumatic valve or of the cam.

    That of the valve is its stroke less the position of its piston; for a cam see `apesim.engine.cam`. `y` (>=
    STATES,) is the state vector, `mode` (MODES,) are the modes.
    """
    if p.engine.intake == EPV:
        return p.actuator.valve.stroke - valve_states(y).position
    if p.has_lift_curve:
        return mode[LIFT] + mode[LIFT_SLOPE] * angle
    cam = p.engine.cam
    return cam.lift * raised_cosine(angle, cam.opens, cam.closes, cam.flank)


@kernel
def intake_area(p: Cycle, angle: float, y: np.ndarray, mode: np.ndarray) -> float:
    """Effective area of the groove [m2], at a crank angle [rad].

    On a piece of its table it is a line over the lift; an ideal valve opens the whole area at once. `y` (>= STATES,) is
    the state vector, `mode` (MODES,) are the modes.
    """
    if p.engine.intake == IDEAL_VALVE:
        return p.full_area * mode[INTAKE_OPEN]
    lift = intake_lift(p, angle, y, mode)
    if p.has_ports and mode[AREA_SLOPE] != 0.0:
        return ports_area(p.ports, lift - p.lap)
    return max(0.0, mode[AREA] + mode[AREA_SLOPE] * lift)


@kernel
def ports_at(p: Cycle, angle: float, y: np.ndarray, mode: np.ndarray) -> tuple[Port, ...]:
    """List the ports of the gas exchange at a crank angle [rad]: the one place that names them, in their order.

    `y` (>= STATES,) is the state vector, `mode` (MODES,) are the modes. Without an intake pipe the groove draws from
    the receiver.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> [round(port.area * 1e6, 6) for port in ports_at(cycle, 4.0, y, mode)]
    [0.0, 500.0, 0.0, 200.0, 0.0]
    """
    engine, piped = p.engine, has_pipe(p)
    return (
        Port(intake_area(p, angle, y, mode), INTAKE_AIR if piped else RECEIVER_AIR, CYLINDER_AIR),
        Port(exhaust_area(p.exhausts[0], angle), CYLINDER_AIR, OUTSIDE_AIR),
        Port(exhaust_area(p.exhausts[-1], angle) if len(p.exhausts) > 1 else 0.0, CYLINDER_AIR, OUTSIDE_AIR),
        Port(engine.receiver.feed_area if p.receiver_volume > 0.0 else 0.0, SUPPLY_AIR, RECEIVER_AIR),
        Port(p.pipe.feed_area if piped else 0.0, RECEIVER_AIR, INTAKE_AIR),
    )


@kernel
def effect_terms(p: Cycle, cylinder: CylinderState) -> EffectTerms:
    """Sum what effects let into the cylinder, over all effects."""
    if len(p.effects) > 0:
        balance = zeros(TERMS)
        add_laws(p.effects, cylinder, balance)
        return EffectTerms(
            let_in=Flow(balance[MASS], balance[ENERGY]),
            past_groove=Flow(balance[GROOVE_MASS], balance[GROOVE_ENERGY]),
            heat=balance[HEAT],
            wall_exergy=balance[WALL_EXERGY],
            branches=balance[BRANCH],
        )
    return NO_EFFECTS


@kernel
def is_groove_open(mode: np.ndarray) -> bool:
    """Check by the modes (MODES,) whether the groove has an area: not on a piece of its table without one."""
    return mode[INTAKE_OPEN] != 0.0 or mode[AREA] != 0.0 or mode[AREA_SLOPE] != 0.0


@kernel
def airs_at(p: Cycle, cylinder: CylinderState, receiver: GasState, intake: GasState) -> tuple[GasState, ...]:
    """List the states of the airs that ports lead from and to, in the order of their numbers.

    `intake` is the state of the air before the groove.
    """
    return p.supply, receiver, intake, cylinder.air, cylinder.behind_exhaust


@kernel
def airs_from(p: Cycle, now: Instant, y: np.ndarray) -> tuple[GasState, ...]:
    """List the states of these airs from a state vector `y` (>= SIZE,)."""
    cylinder, _ = cylinder_state(p, now, y)
    return airs_at(p, cylinder, now.receiver, intake_state(p, y, now.receiver))


@kernel
def sides_of(port: Port, airs: tuple[GasState, ...]) -> Sides:
    """States of the air before and behind a port."""
    return Sides(airs[port.before], airs[port.behind])


@kernel
def port_flow(p: Cycle, mode: np.ndarray, ports: tuple[Port, ...], airs: tuple[GasState, ...], i: int) -> Flow:
    """Flow through port `i` in the regime that the modes (MODES,) hold, without what effects let past the groove.

    ``mdot = S psi(r) p/sqrt(R T)`` (Eq. 7 of the EPV paper [1]_), with the effective area S, the flow function psi of
    the pressure ratio r, the gas constant R, and pressure p and temperature T upstream. The paper has it for its
    solenoids and groove; it is that of any restriction without inertia, and so of the exhaust valves and of the feed of
    the receiver, too.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    mode : (MODES,) float array
        Modes of the smooth segment.
    ports : tuple of Port
        Ports at the instant, see `ports_at`.
    airs : tuple of apesim.air.GasState
        Airs before and behind them, see `airs_at`.
    i : int
        Number of the port.

    Returns
    -------
    apesim.restriction.Flow
        From the air before the port to that behind it.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 7 and 8.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)

    With all ports shut nothing flows:

    >>> from apesim.engine.cycle.state import instant_at
    >>> port_flow(cycle, mode, ports_at(cycle, 4.0, y, mode), airs_from(cycle, instant_at(cycle, 0.0, y), y), 1)
    Flow(mass=0.0, enthalpy=0.0)
    """
    flow = flow_in(p.actuator.gas, mode[EXCHANGE + i], ports[i].area, sides_of(ports[i], airs))
    if i == FEED and p.engine.receiver.check_valve and flow.mass < 0.0:
        return NO_FLOW
    return flow


@kernel
def port_flows(p: Cycle, mode: np.ndarray, ports: tuple[Port, ...], airs: tuple[GasState, ...]) -> tuple[Flow, ...]:
    """Flow through each port, see `port_flow`; written out, as a loop over a tuple takes longer in a kernel."""
    return (
        port_flow(p, mode, ports, airs, 0),
        port_flow(p, mode, ports, airs, 1),
        port_flow(p, mode, ports, airs, 2),
        port_flow(p, mode, ports, airs, 3),
        port_flow(p, mode, ports, airs, 4),
    )


@kernel
def update_exchange(
    ports: tuple[Port, ...], flows: tuple[Flow, ...], entering: np.ndarray, leaving: np.ndarray
) -> None:
    """Add the flow through each port to what enters and what leaves each air, (FLOW_ENTRIES * AIRS,) both."""
    for i in range(PORTS):
        add_flow(entering, ports[i].behind, flows[i])
        add_flow(leaving, ports[i].before, flows[i])


@kernel
def add_flow(flows: np.ndarray, air: int, flow: Flow) -> None:
    """Add a flow to what enters, or to what leaves each air (FLOW_ENTRIES * AIRS,)."""
    flows[FLOW_ENTRIES * air] += flow.mass
    flows[FLOW_ENTRIES * air + 1] += flow.enthalpy


@kernel
def exchange_events(p: Cycle, now: Instant, y: np.ndarray, mode: np.ndarray, g: np.ndarray, first_event: int) -> None:
    """Write by how much the flow through each port has left its regime into `g` (n,), from `first_event` on.

    Above zero it has left it. `y` (>= SIZE,) is the state vector, `mode` (MODES,) are the modes.
    """
    airs, ports = airs_from(p, now, y), ports_at(p, now.angle, y, mode)
    for i in range(PORTS):
        g[first_event + i] = beyond_regime(p.actuator.gas, mode[EXCHANGE + i], sides_of(ports[i], airs))


@kernel
def change_exchange_regime(p: Cycle, now: Instant, y: np.ndarray, i: int, mode: np.ndarray) -> None:
    """Change the flow through port `i` over to the regime that follows, in `mode` (MODES,).

    `y` (>= SIZE,) is the state vector.
    """
    port = ports_at(p, now.angle, y, mode)[i]
    mode[EXCHANGE + i] = next_regime(p.actuator.gas, mode[EXCHANGE + i], sides_of(port, airs_from(p, now, y)))


@kernel
def start_port_segment(p: Cycle, ports: tuple[Port, ...], airs: tuple[GasState, ...], i: int, mode: np.ndarray) -> None:
    """Set the regime of the flow through port `i` for a smooth segment, in `mode` (MODES,).

    `airs` are those at its start, `ports` those at a crank angle within it: a port without area there is shut; the
    groove is judged by the piece of its table.
    """
    is_open = is_groove_open(mode) if i == GROOVE else ports[i].area > 0.0
    mode[EXCHANGE + i] = regime_between(p.actuator.gas, sides_of(ports[i], airs)) if is_open else SHUT


@kernel
def start_groove_segment(p: Cycle, now: Instant, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the regime of the flow through the groove on entering a piece of its table; the other flows keep theirs.

    `y` (>= SIZE,) is the state vector; `mode` (MODES,) is changed.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> from apesim.restriction import CHOKED
    >>> mode[AREA] = 1e-4
    >>> from apesim.engine.cycle.state import instant_at
    >>> start_groove_segment(cycle, instant_at(cycle, 0.0, y), y, mode)
    >>> print(mode[EXCHANGE + GROOVE] == CHOKED)
    True
    """
    start_port_segment(p, ports_at(p, now.angle, y, mode), airs_from(p, now, y), GROOVE, mode)


@kernel
def start_exchange_segment(p: Cycle, now: Instant, middle: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the regimes of the flows of the gas exchange at the start of a smooth segment, in `mode` (MODES,).

    `middle` is a crank angle within it [rad], at which a port has an area if it has one in the segment; `y` (>= SIZE,)
    is the state vector.
    """
    airs, ports = airs_from(p, now, y), ports_at(p, middle, y, mode)
    for i in range(PORTS):
        start_port_segment(p, ports, airs, i, mode)
