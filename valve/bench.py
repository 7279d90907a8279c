"""The valve alone on its test bench."""

from math import inf
from typing import NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.march.adaptive import LOG_HEAD, LOG_ROWS, TOLERANCE, Accuracy, march
from apesim.march.error_bounds import closure_of
from apesim.march.hybrid_system import events, handle_event, observe, power, rates, start_segment, zero_crossings
from apesim.march.periodic import periodic_orbit
from apesim.valve.actuator import (
    GAS_SCALE,
    MAX_STEP,
    MODES,
    PHASE,
    SCALE,
    STATES,
    Actuator,
    actuator_of,
    actuator_rates,
    closed_at_rest,
    in_domain,
    state_of,
)
from apesim.valve.chamber import filled
from apesim.valve.ledger import (
    CONTROL_ENTRIES,
    ControlLedger,
    control_ledger_at,
    control_rates,
    gas_of_volume,
    update_part,
    valve_states,
)
from apesim.valve.line import (
    LINE_FLOW,
    before_solenoids,
    change_line_regime,
    has_line,
    line_event,
    line_feed,
    start_line_segment,
)
from apesim.valve.measures import Travel, closing_stroke, opening_stroke, travel_of
from apesim.valve.motion import actuator_events, actuator_zero_crossings, handle_actuator_event, start_actuator_segment
from apesim.valve.piston import HELD_CLOSED, is_moving

LINE = STATES
"""Element of the state vector at which the supply line's gas begins; without a line it is not controlled."""
LEDGER = LINE + 2
"""Element at which the ledger of the control air begins."""
SIZE = LEDGER + CONTROL_ENTRIES
TRACE = (
    "lift [m]",
    "velocity [m/s]",
    "pressure_a [Pa abs]",
    "pressure_b [Pa abs]",
    "temperature_a [K]",
    "temperature_b [K]",
)
"""Columns of a trace, after ``time [s]``; the velocity is that of the lift, positive as the valve opens."""


class Bench(NamedTuple):
    """The bench, for the kernels."""

    actuator: Actuator
    supply: tuple[float, float, float]
    """Control air: pressure [Pa abs], temperature [K]; pressure before the groove [Pa abs]."""


class BenchRun(NamedTuple):
    """One run of the bench."""

    opening: object
    """`apesim.valve.measures.Stroke`"""
    closing: object
    control_air: float
    """Through the supply sides of both solenoids [kg]."""
    closure: dict
    """Mass and energy, relative to what was supplied; work on the piston as a ledger against its quadrature."""
    times: np.ndarray
    """[s], shape (n,)"""
    trace: np.ndarray
    """Columns `TRACE`, shape (n, 6)."""
    orbit: object
    """`apesim.march.periodic.Orbit` of a repeated pulse, else None."""
    log: np.ndarray
    """Of the march, see `apesim.march.adaptive.march`; of a repeated pulse, two periods."""
    status: int
    """`apesim.march.adaptive.Status`"""
    steps: int
    travel: Travel
    p: Bench


@kernel
def bench_ledger(y: np.ndarray) -> ControlLedger:
    """Read the ledger of the control air from a state vector of the bench.

    Parameters
    ----------
    y : (SIZE,) float array
        State vector of a bench, or a difference of two.

    Returns
    -------
    apesim.valve.ledger.ControlLedger
        Its entries, by name.

    Examples
    --------
    >>> print(bench_ledger(np.zeros(SIZE)).supplied)
    0.0
    """
    return control_ledger_at(y, LEDGER)


@kernel
def control_air(p, y):
    """Where control air comes from, and what is before the solenoids, both as pressure [Pa abs] and temperature [K]."""
    source = p.supply[0], p.supply[1]
    return source, before_solenoids(p.actuator, y, LINE, source)


@kernel
def supply_of(p, y):
    """What `apesim.valve.actuator.state_of` wants to know."""
    pressure, temperature = control_air(p, y)[1]
    return pressure, temperature, p.supply[2]


@rates.for_type(Bench)
@kernel
def bench_rates(p, t, y, mode, dy):
    """Rates of the bench; see `apesim.march.hybrid_system.rates`."""
    if not in_domain(p.actuator, y):
        return False
    if has_line(p.actuator):
        mass, energy = gas_of_volume(y, LINE)
        if mass <= 0.0 or energy <= 0.0:
            return False
    r = actuator_rates(p.actuator, t, y, mode, supply_of(p, y))
    fed, fed_enthalpy = line_feed(p.actuator, mode, *control_air(p, y), r)
    update_part(dy, 0, r[:STATES])
    update_part(dy, LINE, (fed - r.supplied, fed_enthalpy - r.supplied_enthalpy))
    update_part(dy, LEDGER, control_rates(r, fed, fed_enthalpy, r.other_mass, r.other_energy))
    return True


@events.for_type(Bench)
@kernel
def bench_events(p, t, y, mode, g):
    """Events of the bench."""
    actuator_events(p.actuator, y, mode, supply_of(p, y), g)
    g[LINE_FLOW] = line_event(p.actuator, *control_air(p, y), mode)


@handle_event.for_type(Bench)
@kernel
def handle_bench_event(p, tables, event, t, y, mode):
    """Responses of the bench."""
    if event == LINE_FLOW:
        change_line_regime(p.actuator, *control_air(p, y), mode)
    else:
        handle_actuator_event(p.actuator, tables, event, y, mode, supply_of(p, y))


@zero_crossings.for_type(Bench)
@kernel
def bench_zero_crossings(p, t, y, dy, mode, w):
    """Zero crossings of the bench."""
    actuator_zero_crossings(p.actuator, y, valve_states(dy).speed, mode, w)


@start_segment.for_type(Bench)
@kernel
def start_bench_segment(p, tables, t, t_end, y, mode):
    """Modes of a smooth stretch."""
    start_actuator_segment(p.actuator, tables, t, t_end, y, mode, supply_of(p, y))
    start_line_segment(p.actuator, *control_air(p, y), mode)


@power.for_type(Bench)
@kernel
def bench_power(p, t, y):
    """Power of the chambers on the piston [W]."""
    state = state_of(p.actuator, y, p.supply)
    return (state.pressure_a - state.pressure_b) * p.actuator.valve.piston_area * state.speed


@observe.for_type(Bench)
@kernel
def observe_bench(p, t, y, mode, row):
    """A row of the trace."""
    state = state_of(p.actuator, y, p.supply)
    row[0] = p.actuator.valve.stroke - state.position
    row[1] = -state.speed if is_moving(mode[PHASE]) else 0.0
    row[2], row[3] = state.pressure_a, state.pressure_b
    row[4], row[5] = state.temperature_a, state.temperature_b


def bench_of(machine, edges, period=inf, intake_pressure=None, edges_b=None):
    """The bench with a machine's valve and supply.

    Parameters
    ----------
    machine : NamedTuple
        With the sections ``air``, ``ambient``, ``supply``, ``valve``, ``groove`` and ``effects``.
    edges : (n,) float array
        Energise, release, energise, ... ascending [s].
    period : float
        At which they repeat [s].
    intake_pressure : float, optional
        Before the groove; ambient pressure if left out [Pa abs].
    edges_b : (m,) float array, optional
        Those of solenoid B where they are its own [s].

    Returns
    -------
    Bench, apesim.valve.actuator.ActuatorTables
    """
    actuator, tables = actuator_of(machine, edges, period, edges_b)
    before_groove = machine.ambient.pressure if intake_pressure is None else intake_pressure
    return Bench(actuator, (*machine.supply.control(), before_groove)), tables


def accuracy_of(p, tolerance=TOLERANCE):
    """`apesim.march.adaptive.Accuracy` of a bench; its supply line is among the states where it has one."""
    return Accuracy(tolerance, MAX_STEP, np.array(SCALE + 2 * (GAS_SCALE,) if has_line(p.actuator) else SCALE))


def closed_at_start(p):
    """State and mode of a bench at rest: valve closed, see `apesim.valve.actuator.closed_at_rest`, supply line full.

    Returns
    -------
    y : (SIZE,) float array
    mode : (MODES,) float array
    """
    y, mode = np.zeros(SIZE), np.zeros(MODES)
    update_part(y, 0, closed_at_rest(p.actuator, p.supply))
    update_part(y, LINE, filled(p.actuator.gas, p.actuator.line[0], *p.supply[:2]))
    mode[PHASE] = HELD_CLOSED
    return y, mode


def run_bench(
    machine,
    pulse,
    until=None,
    period=inf,
    sample=1e-4,
    tolerance=TOLERANCE,
    brakes=(),
    intake_pressure=None,
    brakes_b=None,
):
    """One run: from rest with a single pulse, or the periodic state of a repeated one.

    Parameters
    ----------
    machine : NamedTuple
        See `bench_of`.
    pulse : float
        Time for which the solenoids are energised, from t = 0 [s].
    until : float, optional
        End of a single run; twice the pulse if left out [s].
    period : float
        Of a repeated pulse [s]; inf: it is single.
    sample : float or (n,) float array
        Between two rows of the trace, or when to take them, ascending [s].
    tolerance : float
    brakes : sequence of float
        Further edges of the solenoids, which interrupt a stroke: two (or four, ...) between the edges of the pulse, as
        many as wanted after it [s].
    intake_pressure : float, optional
        See `bench_of`.
    brakes_b : sequence of float, optional
        Those of solenoid B where they are its own; then ``brakes`` are those of solenoid A [s].

    Returns
    -------
    BenchRun
    """
    repeated = period < inf
    edges_a, edges_b = (sorted((0.0, pulse, *own)) for own in (brakes, brakes if brakes_b is None else brakes_b))
    p, tables = bench_of(machine, edges_a, period, intake_pressure, edges_b)
    end = period if repeated else 2.0 * pulse if until is None else until
    breakpoints = tables.breakpoints(0.0, end)
    accuracy = accuracy_of(p, tolerance)
    y, mode = closed_at_start(p)
    orbit = None
    if repeated:
        orbit = periodic_orbit(p, tables, y, mode, breakpoints, accuracy)
        y, mode = orbit.y.copy(), orbit.mode.copy()
    start = y.copy()
    log = np.empty((LOG_ROWS, LOG_HEAD + STATES))
    times = np.append(np.arange(0.0, end, sample), end) if np.ndim(sample) == 0 else sample
    trace = np.empty((len(times), len(TRACE)))
    phase = mode[PHASE]
    outcome = march(p, tables, 0.0, y, mode, breakpoints, accuracy, log, times, trace)
    log = log[: outcome.logged].copy()
    if repeated:
        later = log.copy()
        later[:, 0] += period
        log = np.concatenate((log, later))
    horizon = 2.0 * end if repeated else end
    opening = opening_stroke(log, 0.0, horizon)
    closing = closing_stroke(log, pulse, horizon)
    supplied, balance = bench_ledger(y).supplied, closure(start, y, outcome.work)
    travel = travel_of(log, phase, opening, closing)
    return BenchRun(opening, closing, supplied, balance, times, trace, orbit, log, *outcome[:2], travel, p)


def closure(start, y, quadrature):
    """How well mass, energy and work of a run close.

    Parameters
    ----------
    start, y : (SIZE,) float array
        State at the start and at the end.
    quadrature : float
        Work on the piston over the dense output [J].

    Returns
    -------
    dict
        ``mass`` and ``energy`` relative to what was supplied, see `apesim.march.error_bounds.closure_of`; ``work``
        relative to its own size.
    """
    valve, before, ledger = valve_states(y - start), valve_states(start), bench_ledger(y - start)
    (line_mass, line_energy), (mass_before, energy_before) = (gas_of_volume(each, LINE) for each in (y - start, start))
    mass = valve.mass_a + valve.mass_b + line_mass - (ledger.line_fed - ledger.vented + ledger.other_mass)
    energy = valve.energy_a + valve.energy_b + line_energy + ledger.valve_work
    energy -= ledger.line_fed_enthalpy - ledger.vented_enthalpy + ledger.other_energy
    work = quadrature - ledger.valve_work
    return {
        "mass": closure_of(mass, ledger.supplied, before.mass_a + before.mass_b + mass_before),
        "energy": closure_of(energy, ledger.supplied_enthalpy, before.energy_a + before.energy_b + energy_before),
        "work": abs(work / ledger.valve_work) if ledger.valve_work else abs(work),
    }
