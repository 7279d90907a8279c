"""Gas exchange of the engine: flows through groove, exhaust valve, feed of the receiver and intake pipe.

It also holds the regimes of these flows, and the sums of what effects let into the cylinder. The law of a flow is
Eq. 7 of the EPV paper (doi 10.1631/jzus.A0820373), see `apesim.restriction`.
"""

from typing import NamedTuple

import numpy as np

from apesim.air import GasState
from apesim.effect import add_laws
from apesim.engine.breathing import exhaust_area, raised_cosine
from apesim.engine.cycle.exchange import EXHAUST, FEED, FLOWS, GROOVE, PIPE, Exchange
from apesim.engine.cycle.state import (
    EXCHANGE,
    INTAKE_OPEN,
    LIFT,
    LIFT_SLOPE,
    Cycle,
    cylinder_state,
    has_pipe,
    intake_state,
    receiver_state,
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
from apesim.kernel import kernel
from apesim.restriction import NO_FLOW, SHUT, Flow, Sides, beyond_regime, flow_in, next_regime, regime_between
from apesim.stack_array import zeros
from apesim.valve.actuator import AREA, AREA_SLOPE
from apesim.valve.ledger import valve_states
from apesim.valve.ports import ports_area


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

    That of the valve is its stroke less the position of its piston; for a cam see `apesim.engine.breathing`. `y` (>=
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
def exchange_sides(p: Cycle, cylinder: CylinderState, receiver: GasState, intake: GasState) -> Exchange[Sides]:
    """States of the air before and behind the flows of the gas exchange; `intake` is the air before the groove."""
    return Exchange(
        groove=Sides(intake, cylinder.air),
        exhaust=Sides(cylinder.air, cylinder.behind_exhaust),
        feed=Sides(p.supply, receiver),
        pipe=Sides(receiver, intake),
    )


@kernel
def exchange_areas(p: Cycle, angle: float, y: np.ndarray, mode: np.ndarray) -> Exchange[float]:
    """Effective areas [m2] of the flows of the gas exchange, at a crank angle [rad].

    `y` (>= STATES,) is the state vector, `mode` (MODES,) are the modes.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> areas = exchange_areas(cycle, 4.0, y, mode)
    >>> round(areas.exhaust * 1e6, 6), areas.pipe
    (500.0, 0.0)
    """
    return Exchange(
        groove=intake_area(p, angle, y, mode),
        exhaust=exhaust_area(p.engine.exhaust, angle),
        feed=p.engine.receiver.feed_area,
        pipe=p.pipe.feed_area,
    )


@kernel
def exchange_flows(
    p: Cycle, y: np.ndarray, mode: np.ndarray, cylinder: CylinderState, sides: Exchange[Sides]
) -> Exchange[Flow]:
    """Flows of the gas exchange through their restrictions, without what effects let past the groove.

    ``mdot = S psi(r) p/sqrt(R T)`` (Eq. 7 of the EPV paper [1]_), in the regime that the mode holds, with the effective
    area S, the flow function psi of the pressure ratio r, the gas constant R, and pressure p and temperature T
    upstream. The paper has it for its solenoids and groove; it is that of any restriction without inertia, and so of
    the exhaust valve and of the feed of the receiver, too.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    y : (>= STATES,) float array
        State vector.
    mode : (MODES,) float array
        Modes of the smooth segment.
    cylinder : apesim.engine.cylinder.CylinderState
        State of the cylinder.
    sides : apesim.engine.cycle.exchange.Exchange
        Sides of each flow, see `exchange_sides`.

    Returns
    -------
    apesim.engine.cycle.exchange.Exchange
        Each flow; that of the pipe is zero where there is none.

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

    With all flows shut nothing flows:

    >>> cylinder, _ = cylinder_state(cycle, 0.0, y)
    >>> exchange_flows(cycle, y, mode, cylinder, exchange_sides_at(cycle, 0.0, y)).exhaust
    Flow(mass=0.0, enthalpy=0.0)
    """
    gas, areas = p.actuator.gas, exchange_areas(p, cylinder.angle, y, mode)
    return Exchange(
        groove=flow_in(gas, mode[EXCHANGE + GROOVE], areas.groove, sides.groove),
        exhaust=flow_in(gas, mode[EXCHANGE + EXHAUST], areas.exhaust, sides.exhaust),
        feed=flow_in(gas, mode[EXCHANGE + FEED], areas.feed, sides.feed),
        pipe=flow_in(gas, mode[EXCHANGE + PIPE], areas.pipe, sides.pipe) if has_pipe(p) else NO_FLOW,
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
def with_past_groove(p: Cycle, flows: Exchange[Flow], past: Flow) -> Exchange[Flow]:
    """Flows of the gas exchange with what effects let past the groove.

    Into a pipe it is Eq. 7 of the EPV paper (doi 10.1631/jzus.A0820373), with the area of the pipe's feed.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    flows : apesim.engine.cycle.exchange.Exchange
        Flows through the restrictions alone, see `exchange_flows`.
    past : apesim.restriction.Flow
        Flow past the groove, see `effect_terms`.

    Returns
    -------
    apesim.engine.cycle.exchange.Exchange
        Each flow; out of the receiver, where there is no intake pipe, flows what goes through and past the groove.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), 100.0)
    >>> flows = Exchange(Flow(0.5, 14e3), NO_FLOW, NO_FLOW, NO_FLOW)
    >>> with_past_groove(cycle, flows, Flow(0.25, 3e3)).pipe
    Flow(mass=0.75, enthalpy=17000.0)
    """
    groove = Flow(flows.groove.mass + past.mass, flows.groove.enthalpy + past.enthalpy)
    return Exchange(groove, flows.exhaust, flows.feed, flows.pipe if has_pipe(p) else groove)


@kernel
def exchange_sides_at(p: Cycle, t: float, y: np.ndarray) -> Exchange[Sides]:
    """States of the air before and behind the flows of the gas exchange, from a state vector `y` (>= SIZE,).

    See `exchange_sides`; `t` is the time from the start of the cycle [s].

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> groove = exchange_sides_at(cycle, 0.0, y).groove
    >>> print(round(groove.before.pressure), "Pa to", round(groove.behind.pressure), "Pa")
    1101325 Pa to 101325 Pa
    """
    cylinder, _ = cylinder_state(p, t, y)
    receiver = receiver_state(p, y)
    return exchange_sides(p, cylinder, receiver, intake_state(p, y, receiver))


@kernel
def exchange_events(p: Cycle, t: float, y: np.ndarray, mode: np.ndarray, g: np.ndarray, first_event: int) -> None:
    """Write by how much each flow of the gas exchange has left its regime into `g` (n,), from `first_event` on.

    Above zero it has left it. `t` is the time from the start of the cycle [s], `y` (>= SIZE,) the state vector, `mode`
    (MODES,) are the modes.
    """
    sides = exchange_sides_at(p, t, y)
    for i in range(FLOWS):
        g[first_event + i] = beyond_regime(p.actuator.gas, mode[EXCHANGE + i], sides[i])


@kernel
def change_exchange_regime(p: Cycle, t: float, y: np.ndarray, i: int, mode: np.ndarray) -> None:
    """Change a flow of the gas exchange over to the regime that follows, in `mode` (MODES,).

    `t` is the time from the start of the cycle [s], `y` (>= SIZE,) the state vector, `i` the number of the flow, see
    `apesim.engine.cycle.exchange`.
    """
    mode[EXCHANGE + i] = next_regime(p.actuator.gas, mode[EXCHANGE + i], exchange_sides_at(p, t, y)[i])


@kernel
def is_groove_open(mode: np.ndarray) -> bool:
    """Check by the modes (MODES,) whether the groove has an area: not on a piece of its table without one."""
    return mode[INTAKE_OPEN] != 0.0 or mode[AREA] != 0.0 or mode[AREA_SLOPE] != 0.0


@kernel
def start_groove_segment(p: Cycle, t: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the regime of the flow through the groove on entering a piece of its table; the other flows keep theirs.

    `t` is the time from the start of the cycle [s], `y` (>= SIZE,) the state vector; `mode` (MODES,) is changed.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> from apesim.restriction import CHOKED
    >>> mode[AREA] = 1e-4
    >>> start_groove_segment(cycle, 0.0, y, mode)
    >>> print(mode[EXCHANGE + GROOVE] == CHOKED)
    True
    """
    sides = exchange_sides_at(p, t, y).groove
    mode[EXCHANGE + GROOVE] = regime_between(p.actuator.gas, sides) if is_groove_open(mode) else SHUT


@kernel
def open_flows(p: Cycle, angle: float, mode: np.ndarray) -> Exchange[bool]:
    """Check which flows of the gas exchange are open, have an area, in a smooth segment.

    `angle` is the crank angle in the middle of the segment [rad], `mode` (MODES,) are the modes.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> [bool(is_open) for is_open in open_flows(cycle, 0.0, mode)]
    [False, False, True, False]
    """
    return Exchange(
        groove=is_groove_open(mode),
        exhaust=exhaust_area(p.engine.exhaust, angle) > 0.0,
        feed=p.receiver_volume > 0.0,
        pipe=has_pipe(p),
    )


@kernel
def start_exchange_segment(p: Cycle, t: float, t_end: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the regimes of the flows of the gas exchange at the start of a smooth segment, in `mode` (MODES,).

    It lasts from `t` to `t_end` [s], from the start of the cycle; `y` (>= SIZE,) is the state vector.
    """
    sides, is_open = exchange_sides_at(p, t, y), open_flows(p, p.start + p.speed * 0.5 * (t + t_end), mode)
    for i in range(FLOWS):
        mode[EXCHANGE + i] = regime_between(p.actuator.gas, sides[i]) if is_open[i] else SHUT
