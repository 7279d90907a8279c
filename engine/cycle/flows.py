"""Gas exchange of the engine: flows through groove, exhaust valve, feed of the receiver and intake pipe.

It also holds the regimes of these flows, and the sums of what effects let into the cylinder. The law of a flow is
Eq. 7 of the EPV paper (doi 10.1631/jzus.A0820373), see `apesim.restriction`.
"""

from typing import TypeAlias

import numpy as np

from apesim.effect import add_laws
from apesim.engine.breathing import raised_cosine
from apesim.engine.cycle.state import (
    EXHAUST_FLOW,
    FEED_FLOW,
    GROOVE_FLOW,
    INTAKE_OPEN,
    LIFT,
    LIFT_SLOPE,
    PIPE_FLOW,
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
from apesim.restriction import SHUT, beyond_regime, flow_in, next_regime, regime_between
from apesim.stack_array import zeros
from apesim.valve.actuator import AREA, AREA_SLOPE
from apesim.valve.ledger import valve_states
from apesim.valve.ports import ports_area

Sides: TypeAlias = tuple[float, float, float, float]
"""Pressure [Pa abs] and temperature [K] before a flow, then pressure and temperature behind it."""
FLOWS = PIPE_FLOW - GROOVE_FLOW + 1
"""Number of the flows whose regimes are modes: GROOVE_FLOW, EXHAUST_FLOW, FEED_FLOW, PIPE_FLOW."""


@kernel
def intake_lift(p: Cycle, angle: float, y: np.ndarray, mode: np.ndarray) -> float:
    """Lift of the intake: of the electro-pneumatic valve or of the cam.

    The lift of the valve is its stroke less the position of its piston; that of a cam see `apesim.engine.breathing`.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    angle : float
        Crank angle [rad].
    y : (>= STATES,) float array
        State vector.
    mode : (MODES,) float array
        Modes of the smooth segment.

    Returns
    -------
    float
        Lift of the intake [m].

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> print(intake_lift(cycle, 0.0, y, mode))
    0.0
    """
    if p.engine.intake == EPV:
        return p.actuator.valve.stroke - valve_states(y).position
    if p.has_lift_curve:
        return mode[LIFT] + mode[LIFT_SLOPE] * angle
    cam = p.engine.cam
    return cam.lift * raised_cosine(angle, cam.opens, cam.closes, cam.flank)


@kernel
def intake_area(p: Cycle, angle: float, y: np.ndarray, mode: np.ndarray) -> float:
    """Effective area of the groove.

    On a piece of its table the area is a line over the lift; an ideal valve opens the whole area at once.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    angle : float
        Crank angle [rad].
    y : (>= STATES,) float array
        State vector.
    mode : (MODES,) float array
        Modes of the smooth segment.

    Returns
    -------
    float
        Effective area of the groove [m2].

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> print(intake_area(cycle, 0.0, y, mode))
    0.0
    """
    if p.engine.intake == IDEAL_VALVE:
        return p.full_area * mode[INTAKE_OPEN]
    lift = intake_lift(p, angle, y, mode)
    if p.has_ports and mode[AREA_SLOPE] != 0.0:
        return ports_area(p.ports, lift - p.lap)
    return max(0.0, mode[AREA] + mode[AREA_SLOPE] * lift)


@kernel
def exchange_sides(
    p: Cycle, cylinder: CylinderState, receiver: tuple[float, float], intake: tuple[float, float]
) -> tuple[Sides, Sides, Sides, Sides]:
    """Pressures and temperatures before and behind the flows of the gas exchange.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    cylinder : apesim.engine.cylinder.CylinderState
        State of the cylinder.
    receiver : tuple of float
        Pressure [Pa abs] and temperature [K] in the receiver.
    intake : tuple of float
        Pressure [Pa abs] and temperature [K] before the groove.

    Returns
    -------
    groove, exhaust, feed, pipe : tuple of float
        Pressure [Pa abs] and temperature [K] before each flow, then pressure and temperature behind it.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> cylinder, _ = cylinder_state(cycle, 0.0, y)
    >>> groove, exhaust, feed, pipe = exchange_sides(cycle, cylinder, (1e6, 290.0), (0.9e6, 280.0))
    >>> groove[:2], pipe
    ((900000.0, 280.0), (1000000.0, 290.0, 900000.0, 280.0))
    """
    ambient = p.actuator.ambient
    return (
        (intake[0], intake[1], cylinder.pressure, cylinder.temperature),
        (cylinder.pressure, cylinder.temperature, ambient.pressure, ambient.temperature),
        (p.supply[0], p.supply[1], receiver[0], receiver[1]),
        (receiver[0], receiver[1], intake[0], intake[1]),
    )


@kernel
def exchange_flows(
    p: Cycle,
    y: np.ndarray,
    mode: np.ndarray,
    cylinder: CylinderState,
    receiver: tuple[float, float],
    intake: tuple[float, float],
) -> tuple[float, float, float, float, float, float]:
    """Flows through groove, exhaust valve and feed of the receiver, each with its enthalpy.

    ``mdot = S psi(r) p/sqrt(R T)`` (Eq. 7 of the EPV paper [1]_), in the regime that the mode holds, with the effective
    area S, the flow function psi of the pressure ratio r, the gas constant R, and pressure p and temperature T
    upstream.

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
    receiver : tuple of float
        Pressure [Pa abs] and temperature [K] in the receiver.
    intake : tuple of float
        Pressure [Pa abs] and temperature [K] before the groove.

    Returns
    -------
    groove, groove_enthalpy : float
        Flow into the cylinder through the groove [kg/s], and its enthalpy [W].
    exhaust, exhaust_enthalpy : float
        Flow out of the cylinder through the exhaust valve [kg/s], and its enthalpy [W].
    fed, fed_enthalpy : float
        Flow from the supply into the receiver [kg/s], and its enthalpy [W].

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
    >>> exchange_flows(cycle, y, mode, cylinder, (1e6, 290.0), (1e6, 290.0))
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """
    gas, valve, sides = p.actuator.gas, p.engine.exhaust, exchange_sides(p, cylinder, receiver, intake)
    area = intake_area(p, cylinder.angle, y, mode)
    groove, groove_enthalpy = flow_in(gas, mode[GROOVE_FLOW], area, sides[0])
    area = valve.effective_area * raised_cosine(cylinder.angle, valve.opens, valve.closes, valve.flank)
    exhaust, exhaust_enthalpy = flow_in(gas, mode[EXHAUST_FLOW], area, sides[1])
    fed, fed_enthalpy = flow_in(gas, mode[FEED_FLOW], p.engine.receiver.feed_area, sides[2])
    return groove, groove_enthalpy, exhaust, exhaust_enthalpy, fed, fed_enthalpy


@kernel
def effect_terms(p: Cycle, cylinder: CylinderState) -> tuple[float, float, float, float, float, float, float]:
    """Sum what effects let into the cylinder.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    cylinder : apesim.engine.cylinder.CylinderState
        State of the cylinder.

    Returns
    -------
    mass, energy : float
        Flow of mass [kg/s] and of energy [W] from outside.
    groove_mass, groove_energy : float
        Flow of mass [kg/s] and of energy [W] past the groove.
    heat, wall_exergy : float
        Part of the energy that is heat [W], and its exergy at the wall's temperature [W].
    branches : float
        Branches of the effects' laws, see `apesim.effect.note_branch`.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> effect_terms(cycle, cylinder_state(cycle, 0.0, y)[0])
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """
    if len(p.effects) > 0:
        balance = zeros(TERMS)
        add_laws(p.effects, cylinder, balance)
        return (
            balance[MASS],
            balance[ENERGY],
            balance[GROOVE_MASS],
            balance[GROOVE_ENERGY],
            balance[HEAT],
            balance[WALL_EXERGY],
            balance[BRANCH],
        )
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


@kernel
def pipe_flow(
    p: Cycle,
    mode: np.ndarray,
    receiver: tuple[float, float],
    intake: tuple[float, float],
    groove: float,
    groove_enthalpy: float,
) -> tuple[float, float]:
    """Flow of engine air out of the receiver: into the intake pipe, or where there is none, to the groove.

    Into a pipe it is Eq. 7 of the EPV paper (doi 10.1631/jzus.A0820373), with the area of the pipe's feed.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    mode : (MODES,) float array
        Modes of the smooth segment.
    receiver : tuple of float
        Pressure [Pa abs] and temperature [K] in the receiver.
    intake : tuple of float
        Pressure [Pa abs] and temperature [K] before the groove.
    groove : float
        Flow through and past the groove [kg/s].
    groove_enthalpy : float
        Enthalpy of the flow through and past the groove [W].

    Returns
    -------
    mass_flow : float
        Flow out of the receiver [kg/s].
    enthalpy_flow : float
        Enthalpy of that flow [W].

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> pipe_flow(cycle, mode, (1e6, 290.0), (1e6, 290.0), 0.05, 14e3)
    (0.05, 14000.0)
    """
    if has_pipe(p):
        return flow_in(p.actuator.gas, mode[PIPE_FLOW], p.pipe[1], (*receiver, *intake))
    return groove, groove_enthalpy


@kernel
def exchange_sides_at(p: Cycle, t: float, y: np.ndarray) -> tuple[Sides, Sides, Sides, Sides]:
    """Pressures and temperatures before and behind the flows of the gas exchange, from a state vector.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    t : float
        Time from the start of the cycle [s].
    y : (>= SIZE,) float array
        State vector.

    Returns
    -------
    groove, exhaust, feed, pipe : tuple of float
        Sides of each flow, see `exchange_sides`.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> groove, exhaust, feed, pipe = exchange_sides_at(cycle, 0.0, y)
    >>> print(round(groove[0]), "Pa to", round(groove[2]), "Pa")
    1101325 Pa to 101325 Pa
    """
    cylinder, _ = cylinder_state(p, t, y)
    receiver = receiver_state(p, y)
    return exchange_sides(p, cylinder, receiver, intake_state(p, y, receiver))


@kernel
def exchange_events(p: Cycle, t: float, y: np.ndarray, mode: np.ndarray, g: np.ndarray, first_event: int) -> None:
    """Write by how much each flow of the gas exchange has left its regime.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    t : float
        Time from the start of the cycle [s].
    y : (>= SIZE,) float array
        State vector.
    mode : (MODES,) float array
        Modes of the smooth segment.
    g : (n,) float array
        Values of the events; changed. Above zero: the flow has left its regime.
    first_event : int
        Element of g for the first of the flows.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> g = [0.0] * FLOWS
    >>> exchange_events(cycle, 0.0, y, mode, g, 0)
    >>> g
    [-1.0, -1.0, -1.0, -1.0]
    """
    sides = exchange_sides_at(p, t, y)
    for i in range(FLOWS):
        g[first_event + i] = beyond_regime(p.actuator.gas, mode[GROOVE_FLOW + i], sides[i])


@kernel
def change_exchange_regime(p: Cycle, t: float, y: np.ndarray, i: int, mode: np.ndarray) -> None:
    """Change a flow of the gas exchange over to the regime that follows.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    t : float
        Time from the start of the cycle [s].
    y : (>= SIZE,) float array
        State vector.
    i : int
        Number of the flow, from 0 for the groove.
    mode : (MODES,) float array
        Modes of the smooth segment; changed.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)

    From a pressure ratio below the end of subsonic flow the exhaust goes over to choked flow:

    >>> from apesim.restriction import CHOKED, SUBSONIC
    >>> mode[EXHAUST_FLOW] = SUBSONIC
    >>> y[6:8] *= 5.0
    >>> change_exchange_regime(cycle, 0.0, y, EXHAUST_FLOW - GROOVE_FLOW, mode)
    >>> print(mode[EXHAUST_FLOW] == CHOKED)
    True
    """
    mode[GROOVE_FLOW + i] = next_regime(p.actuator.gas, mode[GROOVE_FLOW + i], exchange_sides_at(p, t, y)[i])


@kernel
def groove_regime(p: Cycle, sides: Sides, mode: np.ndarray) -> int:
    """Find the regime of the flow through the groove; it is shut on a piece of the table without area.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    sides : tuple of float
        Pressure [Pa abs] and temperature [K] before the groove, then behind it.
    mode : (MODES,) float array
        Modes of the smooth segment.

    Returns
    -------
    int
        Regime, see `apesim.restriction.regime_between`.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> from apesim.restriction import CHOKED
    >>> groove_regime(cycle, (1e6, 290.0, 1e5, 290.0), mode) == SHUT
    True
    >>> mode[AREA] = 1e-4
    >>> groove_regime(cycle, (1e6, 290.0, 1e5, 290.0), mode) == CHOKED
    True
    """
    is_open = mode[INTAKE_OPEN] != 0.0 or mode[AREA] != 0.0 or mode[AREA_SLOPE] != 0.0
    return regime_between(p.actuator.gas, sides) if is_open else SHUT


@kernel
def start_groove_segment(p: Cycle, t: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the regime of the flow through the groove on entering a piece of its table; the other flows keep theirs.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    t : float
        Time from the start of the cycle [s].
    y : (>= SIZE,) float array
        State vector.
    mode : (MODES,) float array
        Modes of the smooth segment; changed.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> from apesim.restriction import CHOKED
    >>> mode[AREA] = 1e-4
    >>> start_groove_segment(cycle, 0.0, y, mode)
    >>> print(mode[GROOVE_FLOW] == CHOKED)
    True
    """
    mode[GROOVE_FLOW] = groove_regime(p, exchange_sides_at(p, t, y)[0], mode)


@kernel
def start_exchange_segment(p: Cycle, t: float, t_end: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the regimes of the flows of the gas exchange at the start of a smooth segment.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    t : float
        Time from the start of the cycle [s].
    t_end : float
        Time at the end of the segment [s].
    y : (>= SIZE,) float array
        State vector.
    mode : (MODES,) float array
        Modes of the smooth segment; changed.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)

    Before TDC the exhaust valve is shut, and the full receiver takes no air:

    >>> from apesim.restriction import NEAR
    >>> start_exchange_segment(cycle, 0.0, 1e-3, y, mode)
    >>> print(mode[EXHAUST_FLOW] == SHUT, mode[FEED_FLOW] == NEAR)
    True True
    """
    gas, valve, sides = p.actuator.gas, p.engine.exhaust, exchange_sides_at(p, t, y)
    middle = p.start + p.speed * 0.5 * (t + t_end)
    exhaust_open = raised_cosine(middle, valve.opens, valve.closes, valve.flank) > 0.0
    mode[GROOVE_FLOW] = groove_regime(p, sides[0], mode)
    mode[EXHAUST_FLOW] = regime_between(gas, sides[1]) if exhaust_open else SHUT
    mode[FEED_FLOW] = regime_between(gas, sides[2]) if p.receiver_volume > 0.0 else SHUT
    mode[PIPE_FLOW] = regime_between(gas, sides[3]) if has_pipe(p) else SHUT
