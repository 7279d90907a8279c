"""Bench: the valve alone, as it is marched and measured.

Equations: the EPV paper (doi 10.1631/jzus.A0820373), Eqs. 1-8; the measures are those of its Fig. 7.
"""

from collections.abc import Sequence
from math import inf
from typing import Any, NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.march.adaptive import LOG_HEAD, LOG_ROWS, NO_CARRY, TOLERANCE, Accuracy, march
from apesim.march.error_bounds import closure_of
from apesim.march.hybrid_system import events, handle_event, observe, power, rates, start_segment, zero_crossings
from apesim.march.periodic import Orbit, periodic_orbit
from apesim.restriction import Flow, Sides
from apesim.valve.actuator import (
    GAS_SCALE,
    MAX_STEP,
    MODES,
    PHASE,
    SCALE,
    STATES,
    Actuator,
    ActuatorTables,
    actuator_of,
    actuator_rates,
    closed_at_rest,
    in_domain,
    state_of,
)
from apesim.valve.chamber import filled
from apesim.valve.ledger import (
    CONTROL_ENTRIES,
    FLOW_ENTRIES,
    ControlLedger,
    control_ledger_at,
    gas_of_volume,
    ledger_flow,
    update_control_ledger,
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
from apesim.valve.measures import Stroke, Travel, closing_stroke, opening_stroke, travel_of
from apesim.valve.motion import actuator_events, actuator_zero_crossings, handle_actuator_event, start_actuator_segment
from apesim.valve.piston import HELD_CLOSED, is_moving
from apesim.valve.supply import ValveSupply

LINE = STATES
"""Element of the state vector at which the supply line's gas begins; without a line it is not controlled."""
LEDGER = LINE + 2
"""Element at which the ledger of the control air begins."""
EFFECTS_LEDGER = LEDGER + CONTROL_ENTRIES
"""Element at which the ledger of what effects let in begins."""
SIZE = EFFECTS_LEDGER + FLOW_ENTRIES
"""Length of a state vector of the bench."""
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
    """Bench as the kernels take it."""

    actuator: Actuator
    """Valve as the kernels take it."""
    supply: ValveSupply
    """Control air at its source, and pressure before the groove."""


class BenchRun(NamedTuple):
    """One run of the bench."""

    opening: Stroke
    """Measures of the opening, `apesim.valve.measures.Stroke`."""
    closing: Stroke
    """Measures of the closing, `apesim.valve.measures.Stroke`."""
    control_air: float
    """Mass through the supply sides of both solenoids [kg]."""
    closure: dict
    """Closure of mass and energy, relative to what was supplied; work on the piston, ledger against quadrature."""
    times: np.ndarray
    """Times of the trace's rows [s], shape (n,)."""
    trace: np.ndarray
    """Trace with the columns `TRACE`, shape (n, 6)."""
    orbit: Orbit | None
    """Periodic state of a repeated pulse, `apesim.march.periodic.Orbit`, else None."""
    log: np.ndarray
    """Log of the march, see `apesim.march.adaptive.march`; of a repeated pulse, two periods."""
    status: int
    """How the march ended, `apesim.march.adaptive.Status`."""
    steps: int
    """Number of steps of the march."""
    travel: Travel
    """Which of its stops the piston met."""
    p: Bench
    """Bench as the kernels took it."""


@kernel
def bench_ledger(y: np.ndarray) -> ControlLedger:
    """Read the control air's ledger from a state vector (SIZE,) of the bench, or from a difference of two."""
    return control_ledger_at(y, LEDGER)


@kernel
def effects_ledger(y: np.ndarray) -> Flow:
    """Read mass [kg] and energy [J] that effects have let into the chambers from a state vector (SIZE,) of the bench.

    It may be a difference of two such vectors.
    """
    return ledger_flow(y, EFFECTS_LEDGER)


@kernel
def control_air(p: Bench, y: np.ndarray) -> Sides:
    """Return the state of the control air at its source and before the solenoids, from state and ledger `y` (SIZE,).

    These are the two sides of the feed of a supply line; equal where there is none.
    """
    return Sides(p.supply.control, before_solenoids(p.actuator, y, LINE, p.supply.control))


@kernel
def supply_of(p: Bench, y: np.ndarray) -> ValveSupply:
    """Return the air before the solenoids and the pressure before the groove, from state and ledger `y` (SIZE,)."""
    return ValveSupply(control_air(p, y).behind, p.supply.intake_pressure)


@rates.for_type(Bench)
@kernel
def bench_rates(p: Bench, t: float, y: np.ndarray, mode: np.ndarray, dy: np.ndarray) -> bool:
    """Write the rates of the bench, see `apesim.march.hybrid_system.rates`.

    Balances of momentum, mass and energy: Eqs. 1 to 8 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    p : Bench
        Bench as the kernels take it.
    t : float
        Time [s].
    y : (SIZE,) float array
        State and ledger of the bench.
    mode : (MODES,) float array
        Modes of the valve, see `apesim.valve.actuator`.
    dy : (SIZE,) float array
        Rates; filled.

    Returns
    -------
    bool
        Whether the state lies in the domain of the laws.

    Examples
    --------
    A piston at rest does not move, whatever presses on it:

    >>> import apesim
    >>> p, tables = bench_of(apesim.Machine(), edges=[0.0])
    >>> y, mode = closed_at_start(p)
    >>> dy = np.ones(SIZE)
    >>> bool(bench_rates(p, 0.0, y, mode, dy)), float(dy[0])
    (True, 0.0)
    """
    if not in_domain(p.actuator, y):
        return False
    if has_line(p.actuator):
        mass, energy = gas_of_volume(y, LINE)
        if mass <= 0.0 or energy <= 0.0:
            return False
    r = actuator_rates(p.actuator, t, y, mode, supply_of(p, y))
    fed = line_feed(p.actuator, mode, control_air(p, y), r)
    update_part(dy, 0, r.states)
    update_part(dy, LINE, (fed.mass - r.supplied.mass, fed.enthalpy - r.supplied.enthalpy))
    update_control_ledger(dy, LEDGER, ControlLedger(fed, r.supplied, r.vented, r.work))
    update_part(dy, EFFECTS_LEDGER, r.let_in)
    return True


@events.for_type(Bench)
@kernel
def bench_events(p: Bench, t: float, y: np.ndarray, mode: np.ndarray, g: np.ndarray) -> None:
    """Write the values of the bench's events into `g` (EVENTS,), see `apesim.march.hybrid_system.events`.

    Takes the time [s], state and ledger `y` (SIZE,), and the valve's modes (MODES,).
    """
    actuator_events(p.actuator, y, mode, supply_of(p, y), g)
    g[LINE_FLOW] = line_event(p.actuator, control_air(p, y), mode)


@handle_event.for_type(Bench)
@kernel
def handle_bench_event(p: Bench, tables: ActuatorTables, event: int, t: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Change state and modes at an event at `t` [s], see `apesim.march.hybrid_system.handle_event`.

    Changes `y` (SIZE,), state and ledger, and `mode` (MODES,), the valve's modes; for events see `apesim.valve.motion`.
    """
    if event == LINE_FLOW:
        change_line_regime(p.actuator, control_air(p, y), mode)
    else:
        handle_actuator_event(p.actuator, tables, event, y, mode, supply_of(p, y))


@zero_crossings.for_type(Bench)
@kernel
def bench_zero_crossings(p: Bench, t: float, y: np.ndarray, dy: np.ndarray, mode: np.ndarray, w: np.ndarray) -> None:
    """Write into `w` (EVENTS,) the values whose zero crossings are located.

    See `apesim.march.hybrid_system.zero_crossings`. Takes the time [s], state and ledger `y` and their rates `dy`, both
    (SIZE,), and the valve's modes (MODES,).
    """
    actuator_zero_crossings(p.actuator, y, valve_states(dy).speed, mode, w)


@start_segment.for_type(Bench)
@kernel
def start_bench_segment(
    p: Bench, tables: ActuatorTables, t: float, t_end: float, y: np.ndarray, mode: np.ndarray
) -> None:
    """Write what is constant over a smooth stretch from `t` to `t_end` [s] into the modes (MODES,).

    See `apesim.march.hybrid_system.start_segment`; `y` (SIZE,) is state and ledger.
    """
    start_actuator_segment(p.actuator, tables, t, t_end, y, mode, supply_of(p, y))
    start_line_segment(p.actuator, control_air(p, y), mode)


@power.for_type(Bench)
@kernel
def bench_power(p: Bench, t: float, y: np.ndarray) -> float:
    """Return the power of the chambers on the piston, ``(p_A - p_B) A dL/dt``.

    It is the work p dV/dt of Eq. 5 of the EPV paper (doi 10.1631/jzus.A0820373), of both chambers.

    Parameters
    ----------
    p : Bench
        Bench as the kernels take it.
    t : float
        Time [s].
    y : (SIZE,) float array
        State and ledger of the bench.

    Returns
    -------
    float
        Power [W].

    Examples
    --------
    >>> import apesim
    >>> p, tables = bench_of(apesim.Machine(), edges=[0.0])
    >>> y, mode = closed_at_start(p)
    >>> float(bench_power(p, 0.0, y))
    0.0
    """
    state = state_of(p.actuator, y, p.supply)
    return (state.chamber_a.pressure - state.chamber_b.pressure) * p.actuator.valve.piston_area * state.speed


@observe.for_type(Bench)
@kernel
def observe_bench(p: Bench, t: float, y: np.ndarray, mode: np.ndarray, row: np.ndarray) -> None:
    """Write a row (6,) of the trace at time `t` [s], see `TRACE`; changes `row`.

    `y` (SIZE,) is the state and ledger of the bench, `mode` (MODES,) the modes of the valve, see
    `apesim.valve.actuator`.
    """
    state = state_of(p.actuator, y, p.supply)
    row[0] = p.actuator.valve.stroke - state.position
    row[1] = -state.speed if is_moving(mode[PHASE]) else 0.0
    row[2], row[3] = state.chamber_a.pressure, state.chamber_b.pressure
    row[4], row[5] = state.chamber_a.temperature, state.chamber_b.temperature


def bench_of(
    machine: Any,
    edges: Sequence[float] | np.ndarray,
    period: float = inf,
    intake_pressure: float | None = None,
    edges_b: Sequence[float] | np.ndarray | None = None,
) -> tuple[Bench, ActuatorTables]:
    """Prepare the bench with a machine's valve and supply: its numbers, and the valve's arrays.

    For edges, period and `edges_b` see `apesim.valve.actuator.actuator_of`. The pressure before the groove is
    `intake_pressure` [Pa abs], ambient pressure if left out.
    """
    actuator, tables = actuator_of(machine, edges, period, edges_b)
    before_groove = machine.ambient.pressure if intake_pressure is None else intake_pressure
    return Bench(actuator, ValveSupply(machine.supply.control(), before_groove)), tables


def accuracy_of(p: Bench, tolerance: float = TOLERANCE) -> Accuracy:
    """Return what the march of a bench holds to; its supply line is among the states where it has one.

    The tolerance is the relative error of a step.
    """
    return Accuracy(tolerance, MAX_STEP, np.array(SCALE + 2 * (GAS_SCALE,) if has_line(p.actuator) else SCALE))


def closed_at_start(p: Bench) -> tuple[np.ndarray, np.ndarray]:
    """Return state (SIZE,) and modes (MODES,) of a bench at rest: valve closed, supply line full, ledger zero."""
    y, mode = np.zeros(SIZE), np.zeros(MODES)
    update_part(y, 0, closed_at_rest(p.actuator, p.supply.control))
    update_part(y, LINE, filled(p.actuator.gas, p.actuator.line.volume, p.supply.control))
    mode[PHASE] = HELD_CLOSED
    return y, mode


def run_bench(
    machine: Any,
    pulse: float,
    until: float | None = None,
    period: float = inf,
    sample: float | np.ndarray = 1e-4,
    tolerance: float = TOLERANCE,
    brakes: Sequence[float] = (),
    intake_pressure: float | None = None,
    brakes_b: Sequence[float] | None = None,
) -> BenchRun:
    """Run the bench once: from rest with a single pulse, or the periodic state of a repeated one.

    The solenoids are energised from t = 0 for `pulse` [s]; `until` ends a single run [s], twice the pulse if left out;
    `period` is that of a repeated pulse [s], inf for a single one. `sample` is the time between two rows of the trace,
    or when to take them [s]; the tolerance is the relative error of a step. `brakes` are further edges of the solenoids
    [s], which interrupt a stroke: two (or four, ...) between the edges of the pulse, as many as wanted after it; with
    `brakes_b`, those of solenoid B alone, they are of solenoid A alone. For machine and `intake_pressure` [Pa abs] see
    `bench_of`.

    The default valve passes 1 % of its stroke 5.8 ms after the command:

    >>> import apesim
    >>> run = run_bench(apesim.Machine(), pulse=10e-3, until=8e-3)
    >>> round(run.opening.delay * 1e3, 2)
    5.8
    """
    repeated = period < inf
    edges_a, edges_b = (sorted((0.0, pulse, *own)) for own in (brakes, brakes if brakes_b is None else brakes_b))
    p, tables = bench_of(machine, edges_a, period, intake_pressure, edges_b)
    end = period if repeated else 2.0 * pulse if until is None else until
    breakpoints = tables.breakpoints(0.0, end)
    accuracy = accuracy_of(p, tolerance)

    # The start: at rest, or the periodic state of a repeated pulse, to which the bench marches from rest.
    y, mode = closed_at_start(p)
    orbit = None
    if repeated:
        orbit = periodic_orbit(p, tables, y, mode, breakpoints, accuracy)
        y, mode = orbit.y.copy(), orbit.mode.copy()

    # The run that is measured. Its start and phase are kept, as the march writes over state and modes.
    start = y.copy()
    log = np.empty((LOG_ROWS, LOG_HEAD + STATES))
    times = np.asarray(sample) if np.ndim(sample) else np.append(np.arange(0.0, end, float(sample)), end)
    trace = np.empty((len(times), len(TRACE)))
    phase = mode[PHASE]
    outcome = march(p, tables, 0.0, y, mode, breakpoints, accuracy, log, times, trace, NO_CARRY)
    log = log[: outcome.logged].copy()

    # Strokes are measured over two periods: what opens late in one closes in the next.
    if repeated:
        later = log.copy()
        later[:, 0] += period
        log = np.concatenate((log, later))
    horizon = 2.0 * end if repeated else end
    opening = opening_stroke(log, 0.0, horizon)
    closing = closing_stroke(log, pulse, horizon)
    supplied, balance = bench_ledger(y).supplied.mass, closure(start, y, outcome.work)
    travel = travel_of(log, phase, opening, closing)
    return BenchRun(
        opening, closing, supplied, balance, times, trace, orbit, log, outcome.status, outcome.steps, travel, p
    )


def trace_bench(machine: Any, pulse: float, times: np.ndarray, tolerance: float = TOLERANCE) -> tuple[np.ndarray, int]:
    """Take the trace (n, 6) of a single pulse [s] from rest, without what `run_bench` measures beside it.

    It has the columns `TRACE`, and rows at `times` (n,) [s], ascending, which end the run; the second value is the
    `apesim.march.adaptive.Status` at the end. The trace is that of `run_bench` to the bit, and comes sooner, as nothing
    is located but what ends a step.

    >>> import apesim
    >>> trace, status = trace_bench(apesim.Machine(), 10e-3, np.array([0.0, 8e-3]))
    >>> run = run_bench(apesim.Machine(), 10e-3, 8e-3, sample=np.array([0.0, 8e-3]))
    >>> bool((trace == run.trace).all()), status == run.status
    (True, True)
    """
    p, tables = bench_of(machine, sorted((0.0, pulse)))
    y, mode = closed_at_start(p)
    log, trace = np.empty((0, LOG_HEAD + STATES)), np.empty((len(times), len(TRACE)))
    breakpoints = tables.breakpoints(0.0, float(times[-1]))
    outcome = march(p, tables, 0.0, y, mode, breakpoints, accuracy_of(p, tolerance), log, times, trace, NO_CARRY)
    return trace, outcome.status


def closure(start: np.ndarray, y: np.ndarray, quadrature: float) -> dict[str, float]:
    """Return how well mass, energy and work of a run close.

    ``mass`` and ``energy`` are relative to what was supplied, see `apesim.march.error_bounds.closure_of`, ``work`` to
    its own size. `start` and `y` (SIZE,) are the states at the start and at the end, `quadrature` the work on the
    piston over the dense output [J].
    """
    valve, before, ledger = valve_states(y - start), valve_states(start), bench_ledger(y - start)
    let_in = effects_ledger(y - start)
    (line_mass, line_energy), (mass_before, energy_before) = (gas_of_volume(each, LINE) for each in (y - start, start))
    mass = valve.mass_a + valve.mass_b + line_mass - (ledger.line_fed.mass - ledger.vented.mass + let_in.mass)
    energy = valve.energy_a + valve.energy_b + line_energy + ledger.valve_work
    energy -= ledger.line_fed.enthalpy - ledger.vented.enthalpy + let_in.enthalpy
    work = quadrature - ledger.valve_work
    return {
        "mass": closure_of(mass, ledger.supplied.mass, before.mass_a + before.mass_b + mass_before),
        "energy": closure_of(energy, ledger.supplied.enthalpy, before.energy_a + before.energy_b + energy_before),
        "work": abs(work / ledger.valve_work) if ledger.valve_work else abs(work),
    }
