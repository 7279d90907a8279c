"""Rates, events and traces of the coupled cycle: valve, receiver and cylinder in one march."""

import numpy as np

from apesim.engine.cycle.cylinder_laws import (
    cylinder_events,
    cylinder_rates,
    cylinder_zero_crossings,
    handle_cylinder_event,
    observe_cylinder,
    start_cylinder_segment,
)
from apesim.engine.cycle.operating_point import MAX_TURN
from apesim.engine.cycle.state import (
    Cycle,
    CycleTables,
    cylinder_state,
    instant_at,
)
from apesim.engine.cylinder import EPV
from apesim.kernel import kernel
from apesim.march.hybrid_system import (
    events,
    handle_event,
    observe,
    power,
    rates,
    start_segment,
    step_share,
    zero_crossings,
)
from apesim.valve.actuator import MAX_STEP, PHASE
from apesim.valve.ledger import valve_states
from apesim.valve.piston import is_moving

MAX_PATH = 0.01
"""Share of the stroke up to which a valve that creeps may move in a longer step than that; chosen."""


@rates.for_type(Cycle)
@kernel
def cycle_rates(p: Cycle, t: float, y: np.ndarray, mode: np.ndarray, dy: np.ndarray) -> bool:
    """Write the rates of an engine's state vector, and where there is room behind it, those of its exergy ledger.

    ``dm/dt = sum of mdot`` and ``dU/dt = sum of mdot h - p dV/dt + Q`` for every gas volume (Eqs. 4 and 5 of the EPV
    paper [1]_ for the valve's chambers; here also for cylinder, receiver, line and pipe). m is the mass, U the internal
    energy, p the pressure and V the volume, h the specific enthalpy of a flow mdot, Q the heat that effects add.

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
    dy : (>= SIZE,) float array
        Rates of the state vector; changed.

    Returns
    -------
    bool
        Whether the state is in its domain; if not, nothing is written.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 4 and 5.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)

    Shut in, the gas of the cylinder changes its energy by the piston's work alone:

    >>> dy = np.zeros_like(y)
    >>> cycle_rates(cycle, 0.0, y, mode, dy)
    True
    >>> from apesim.engine.cycle.state import cylinder_gas
    >>> mass_rate, energy_rate = cylinder_gas(dy)
    >>> print(mass_rate, energy_rate == -cycle_power(cycle, 0.0, y))
    0.0 True
    """
    return cylinder_rates(p, t, instant_at(p, t, y), y, mode, dy, dy).in_domain


@step_share.for_type(Cycle)
@kernel
def cycle_step_share(p: Cycle, y: np.ndarray, mode: np.ndarray) -> float:
    """Return the longest step as a share of `MAX_TURN`: less than 1 while our valve moves, and the crank is slow.

    `y` (>= SIZE,) is the state vector, `mode` (MODES,) are the modes.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> from apesim.valve.piston import TO_OPEN
    >>> cycle, tables, _ = cycle_of(Machine(), speed=10.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> held = cycle_step_share(cycle, y, mode)
    >>> mode[PHASE], y[1] = TO_OPEN, -1.0

    At 10 rad/s the crank turns by 0.286 degrees in the 0.5 ms of a step:

    >>> held, round(cycle_step_share(cycle, y, mode), 4)
    (1.0, 0.1432)
    """
    if p.engine.intake == EPV and is_moving(mode[PHASE]):
        path = abs(valve_states(y).speed) * MAX_TURN / p.speed
        return min(1.0, max(MAX_STEP * p.speed / MAX_TURN, MAX_PATH * p.actuator.valve.stroke / max(path, 1e-300)))
    return 1.0


@events.for_type(Cycle)
@kernel
def cycle_events(p: Cycle, t: float, y: np.ndarray, mode: np.ndarray, g: np.ndarray) -> None:
    """Write the values of an engine's events into `g` (n,): those of its valve, and flows into another regime.

    Above zero the event has happened. `t` is the time from the start of the cycle [s], `y` (>= SIZE,) the state vector,
    `mode` (MODES,) are the modes.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)

    At rest and shut, nothing happens by itself:

    >>> from apesim.march.adaptive import EVENTS
    >>> g = np.full(EVENTS, -1.0)
    >>> cycle_events(cycle, 0.0, y, mode, g)
    >>> bool(g.max() < 0.0)
    True
    """
    cylinder_events(p, instant_at(p, t, y), y, mode, g)


@handle_event.for_type(Cycle)
@kernel
def handle_cycle_event(p: Cycle, tables: CycleTables, event: int, t: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Change state and modes at an event of the engine: one of its valve, or a flow into another regime.

    `event` is its number, `t` the time from the start of the cycle [s]; `y` (>= SIZE,) and `mode` (MODES,) are changed.
    """
    handle_cylinder_event(p, tables, event, instant_at(p, t, y), y, mode)


@zero_crossings.for_type(Cycle)
@kernel
def cycle_zero_crossings(p: Cycle, t: float, y: np.ndarray, dy: np.ndarray, mode: np.ndarray, w: np.ndarray) -> None:
    """Write what is located where it crosses zero, see `cylinder_zero_crossings`."""
    cylinder_zero_crossings(p, instant_at(p, t, y), y, dy, mode, w)


@start_segment.for_type(Cycle)
@kernel
def start_cycle_segment(p: Cycle, tables: CycleTables, t: float, t_end: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the modes of a smooth segment of the cycle, from `t` to `t_end` [s]: changes `mode` (MODES,).

    These are the valve's modes; or the line of a cam's curve and its piece of the groove's table; or whether the ideal
    valve is open; then the regimes of the flows, and the branches of the effects. `y` (>= SIZE,) is the state vector,
    changed where the valve's piston rests.
    """
    middle = p.start + p.speed * 0.5 * (t + t_end)
    start_cylinder_segment(p, tables, t, t_end, instant_at(p, t, y), middle, y, mode)


@power.for_type(Cycle)
@kernel
def cycle_power(p: Cycle, t: float, y: np.ndarray) -> float:
    """Power of the gas on the engine's piston, ``P = p dV/dphi omega``.

    Its integral over a cycle is the indicated work [1]_; p is the pressure, V the volume, phi the crank angle and omega
    the speed.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    t : float
        Time from the start of the cycle [s].
    y : (>= STATES,) float array
        State vector.

    Returns
    -------
    float
        Power [W]; the ambient's pressure on the other side is not taken off.

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eq. 2.14.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)

    At the energising, 5 degrees before TDC, the piston still compresses:

    >>> bool(cycle_power(cycle, 0.0, y) < 0.0)
    True
    """
    cylinder, slope = cylinder_state(p, instant_at(p, t, y), y)
    return cylinder.air.pressure * slope * p.speed


@observe.for_type(Cycle)
@kernel
def observe_cycle(p: Cycle, t: float, y: np.ndarray, mode: np.ndarray, row: np.ndarray) -> None:
    """Write the columns `TRACE` of a row of the trace into `row` (11,).

    `t` is the time from the start of the cycle [s], `y` (>= SIZE,) the state vector, `mode` (MODES,) are the modes.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> from apesim.engine.cycle.cylinder_laws import TRACE
    >>> row = np.zeros(len(TRACE))
    >>> observe_cycle(cycle, 0.0, y, mode, row)
    >>> print(round(row[TRACE.index("cylinder_pressure [Pa abs]")]), "Pa")
    101325 Pa
    """
    observe_cylinder(p, instant_at(p, t, y), y, mode, row)
