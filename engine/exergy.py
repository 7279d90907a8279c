"""Exergy ledger of a cycle: what enters with the air, where it is destroyed or carried off, and what becomes work.

The dead state is the ambient's pressure p_0 and temperature T_0. A restriction keeps the enthalpy of a stream and
destroys ``mdot T_0 (s_down - s_up)``; mixing, heat through a wall and friction destroy theirs (Bejan, Advanced
Engineering Thermodynamics, 4th ed., chapters 3 and 5). Every term is integrated beside the states of a cycle, or
taken from an impact in its log; none is what is left over.
"""

from typing import TYPE_CHECKING

import numpy as np

from apesim.air import GasState
from apesim.engine.cycle import state
from apesim.engine.cycle.gas_exchange import EffectTerms, Port, airs_at, ports_at, sides_of
from apesim.engine.cycle.state import (
    EXCHANGE,
    SIZE,
    Cycle,
    control_air,
    cylinder_gas,
    cylinder_state,
    engine_ledger,
    has_pipe,
    instant_at,
    intake_state,
    line_gas,
    pipe_gas,
    receiver_gas,
    supply_of,
)
from apesim.engine.cylinder import EPV, CylinderState
from apesim.exergy import (
    Stream,
    exergy_brought,
    exergy_stored,
    flow_exergy,
    heat_exergy,
    mixing_loss,
    stream_exergy,
    stream_through,
    throttling_loss,
)
from apesim.kernel import kernel
from apesim.march.error_bounds import closure_of
from apesim.restriction import Flow, Sides
from apesim.stack_array import zeros
from apesim.valve.exergy import (
    CHAMBER_MIXING,
    CONTROL_AIR,
    HEAT_TRANSFER,
    LEAKS,
    SOLENOIDS,
    VALVE_FRICTION,
    VALVE_IMPACTS,
    VALVE_RATES,
    VENTED_AIR,
    VENTS,
    WALL_HEAT,
    add_valve_rates,
    valve_stored,
)
from apesim.valve.line import has_line

if TYPE_CHECKING:
    from apesim.engine.steady import SteadyRun

ENGINE_AIR, FEED, RECEIVER_MIXING, GROOVE, CYLINDER_MIXING, EXHAUST_VALVE, EXHAUST_AIR, RATES = range(
    VALVE_RATES, VALVE_RATES + 8
)
"""Rates of the ledger that belong to the engine; RATES is how many there are with the valve's."""
ENTERS = {
    "engine_air": (ENGINE_AIR, "exergy that engine air brings from its supply, net of what flows back"),
    "control_air": (CONTROL_AIR, "exergy that control air brings from its supply, net of what flows back"),
    "wall_heat": (
        WALL_HEAT,
        "exergy of the heat from the walls, Q (1 - T_0/T_wall); a tabulated heat counts at the air's temperature",
    ),
}
"""Terms of exergy that enters: rate and meaning by name."""
LEAVES = {
    "feed": (FEED, "exergy destroyed by throttling in the feed of receiver and intake pipe"),
    "receiver_mixing": (RECEIVER_MIXING, "exergy destroyed by mixing in receiver and intake pipe"),
    "groove": (GROOVE, "exergy destroyed by throttling in the groove, and in leaks past it"),
    "cylinder_mixing": (CYLINDER_MIXING, "exergy destroyed by mixing in the cylinder"),
    "exhaust_valve": (EXHAUST_VALVE, "exergy destroyed by throttling in the exhaust valves"),
    "exhaust_air": (EXHAUST_AIR, "exergy that exhaust air carries off"),
    "solenoids": (SOLENOIDS, "exergy destroyed by throttling before the chambers: solenoids, supply line"),
    "chamber_mixing": (CHAMBER_MIXING, "exergy destroyed by mixing in the valve's chambers and supply line"),
    "vents": (VENTS, "exergy destroyed by throttling in the vents of the solenoids"),
    "vented_air": (VENTED_AIR, "exergy that vented control air carries off"),
    "valve_friction": (VALVE_FRICTION, "work of the valve's piston against friction and the forces of effects"),
    "valve_impacts": (VALVE_IMPACTS, "kinetic energy that the valve's piston loses at its stops"),
    "leaks": (LEAKS, "exergy that leaks of effects between chambers and to ambient destroy or carry off"),
    "heat_transfer": (HEAT_TRANSFER, "exergy destroyed by heat transfer between walls and air"),
}
"""Terms of exergy that is destroyed or carried off: rate and meaning by name."""
WORKS = {
    "stored": "rise of the exergy stored in air, springs and motion over the cycle",
    "indicated_work": "indicated work, of the march with this ledger",
    "engine_friction": "work of the engine's friction",
    "brake_work": "brake work",
}
"""Terms that are no rate: meaning by name. What enters leaves, is stored or becomes indicated work."""
TERMS = {name: text for name, (_, text) in (ENTERS | LEAVES).items()} | WORKS
"""Meaning of every term of the ledger by name, in the order of flow; J in a cycle."""


@kernel
def port_stream(
    i: int, mode: np.ndarray, ports: tuple[Port, ...], airs: tuple[GasState, ...], flows: tuple[Flow, ...]
) -> Stream:
    """Stream through port `i`, from the flows through all ports and the modes (MODES,)."""
    return stream_through(mode[EXCHANGE + i], sides_of(ports[i], airs), flows[i].mass)


@kernel(inline=False)
def add_exergy_rates(
    p: Cycle,
    t: float,
    y: np.ndarray,
    mode: np.ndarray,
    cylinder: CylinderState,
    receiver: GasState,
    intake: GasState,
    flows: tuple[Flow, ...],
    terms: EffectTerms,
    dy: np.ndarray,
) -> None:
    """Write the rates of the exergy ledger into the rates of a cycle's state vector, behind them.

    Every loss is T_0 times the entropy made, every stream counts with its flow exergy [1]_; see `apesim.exergy`.

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
    cylinder : apesim.engine.cylinder.CylinderState
        State of the cylinder at that time.
    receiver, intake : apesim.air.GasState
        State of the air in the receiver and before the groove.
    flows : tuple of apesim.restriction.Flow
        Flow through each port, without what passes beside the groove.
    terms : apesim.engine.cycle.gas_exchange.EffectTerms
        What effects let into the cylinder.
    dy : (SIZE + RATES,) float array
        Rates of the state vector; its last elements are changed [W].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapters 3
       and 5.

    Examples
    --------
    With all at rest before the first cycle, nothing is destroyed by friction of the valve's piston:

    >>> from apesim.engine.cycle.gas_exchange import effect_terms
    >>> from apesim.engine.cycle.state import PORTS, instant_at
    >>> from apesim.restriction import NO_FLOW
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), 100.0)
    >>> (y, mode), dy = charged_at_rest(cycle), np.full(SIZE + RATES, np.nan)
    >>> now = instant_at(cycle, 0.0, y)
    >>> (cylinder, _), receiver = cylinder_state(cycle, now, y), now.receiver
    >>> flows, terms = (NO_FLOW,) * PORTS, effect_terms(cycle, cylinder)
    >>> add_exergy_rates(cycle, 0.0, y, mode, cylinder, receiver, receiver, flows, terms, dy)
    >>> print(abs(dy[SIZE + VALVE_FRICTION]))
    0.0
    """
    r: np.ndarray = zeros(RATES)  # type: ignore[call-arg]
    gas, ambient = p.actuator.gas, p.actuator.ambient
    p_c, t_c = cylinder.air
    # Found again: handed over, they would be kept in memory in every march, with this ledger or without.
    ports, airs = ports_at(p, cylinder.angle, y, mode), airs_at(p, cylinder, receiver, intake)
    let_in, heat, past_groove = terms.let_in, terms.heat, terms.past_groove.mass

    # Streams into the cylinder. What passes beside the groove has no regime but the sign of its flow.
    through = port_stream(state.GROOVE, mode, ports, airs, flows)
    past = stream_through(past_groove, Sides(intake, cylinder.air), past_groove)

    # From groove to exhaust. A stream that leaves a volume mixes with nothing, unless it flows back.
    r[GROOVE] += throttling_loss(gas, ambient, through, intake.pressure, p_c)
    r[GROOVE] += throttling_loss(gas, ambient, past, intake.pressure, p_c)
    r[CYLINDER_MIXING] += mixing_loss(gas, ambient, through, t_c) + mixing_loss(gas, ambient, past, t_c)
    for i in state.EXHAUSTS:
        out = port_stream(i, mode, ports, airs, flows)
        r[CYLINDER_MIXING] -= mixing_loss(gas, ambient, out, t_c)
        r[EXHAUST_VALVE] += throttling_loss(gas, ambient, out, p_c, p.exhaust_pressure)
        r[EXHAUST_AIR] += stream_exergy(gas, ambient, out, p.exhaust_pressure)

    # What effects let in: heat apart from air, as its exergy is taken at the temperature of its wall.
    r[LEAKS] -= exergy_brought(gas, ambient, let_in.mass, let_in.enthalpy - heat, cylinder.air)
    r[WALL_HEAT] += terms.wall_exergy
    r[HEAT_TRANSFER] += terms.wall_exergy - heat_exergy(ambient, heat, t_c)

    # The valve. What it draws and destroys at its source counts for the receiver below, where that is the source.
    control, mixing = 0.0, 0.0
    if p.engine.intake == EPV:
        source = control_air(p, y, receiver).before
        control, mixing = add_valve_rates(p.actuator, t, y, mode, source, supply_of(p, y, receiver), r)

    # From the groove up to the supply: `brought` is what enters at the outermost volume there is, and `back` what air
    # that flows back into the receiver destroys there by mixing.
    if has_pipe(p):
        drawn = port_stream(state.PIPE_FEED, mode, ports, airs, flows)
        r[FEED] += throttling_loss(gas, ambient, drawn, receiver.pressure, intake.pressure)
        r[RECEIVER_MIXING] += mixing_loss(gas, ambient, drawn, intake.temperature)
        r[RECEIVER_MIXING] -= mixing_loss(gas, ambient, through, intake.temperature) + mixing_loss(
            gas, ambient, past, intake.temperature
        )
        brought, back = (
            stream_exergy(gas, ambient, drawn, receiver.pressure),
            -mixing_loss(gas, ambient, drawn, receiver.temperature),
        )
    else:
        brought = stream_exergy(gas, ambient, through, intake.pressure) + stream_exergy(
            gas, ambient, past, intake.pressure
        )
        back = -mixing_loss(gas, ambient, through, intake.temperature) - mixing_loss(
            gas, ambient, past, intake.temperature
        )
    if p.receiver_volume > 0.0:
        feed = port_stream(state.FEED, mode, ports, airs, flows)
        r[FEED] += throttling_loss(gas, ambient, feed, p.supply.pressure, receiver.pressure)
        r[RECEIVER_MIXING] += mixing_loss(gas, ambient, feed, receiver.temperature) + back
        brought = stream_exergy(gas, ambient, feed, p.supply.pressure)
        if p.control_from_receiver:
            r[RECEIVER_MIXING] += mixing
            r[CONTROL_AIR] = control * flow_exergy(gas, ambient, p.supply)
            brought -= r[CONTROL_AIR]
    r[ENGINE_AIR] += brought
    for i in range(RATES):
        dy[SIZE + i] = r[i]


def stored_exergy(p: Cycle, t: float, y: np.ndarray) -> float:
    """Sum the exergy of all the air between supply and exhaust, and of the valve's springs and motion.

    Air counts with the exergy of a closed system [1]_.

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
    float
        Stored exergy [J].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), 100.0)
    >>> print(round(stored_exergy(cycle, 0.0, charged_at_rest(cycle)[0])), "J")
    1721 J
    """
    gas, ambient = p.actuator.gas, p.actuator.ambient
    now = instant_at(p, t, y)
    cylinder, _ = cylinder_state(p, now, y)
    receiver = now.receiver
    gases = [(cylinder_gas(y), cylinder.air, cylinder.volume)]
    if p.receiver_volume > 0.0:
        gases.append((receiver_gas(y), receiver, p.receiver_volume))
    if has_pipe(p):
        gases.append((pipe_gas(y), intake_state(p, y, receiver), p.pipe.volume))
    if has_line(p.actuator):
        gases.append((line_gas(y), control_air(p, y, receiver).behind, p.actuator.line.volume))
    total = sum(exergy_stored(gas, ambient, *content) for content in gases)
    return total + (valve_stored(p.actuator, y, supply_of(p, y, receiver)) if p.engine.intake == EPV else 0.0)


def exergy_ledger(run: "SteadyRun", friction_work: float) -> dict[str, float]:
    """Compute the exergy ledger of a cycle.

    Terms are those of the balance of exergy [1]_: what enters leaves, is stored, is destroyed or becomes work.

    Parameters
    ----------
    run : apesim.engine.steady.SteadyRun
        Operating point, with an estimate of its error.
    friction_work : float
        Work of the engine's friction in a cycle [J].

    Returns
    -------
    dict of str to float
        `TERMS` by name [J].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.

    Examples
    --------
    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1)
    >>> terms = exergy_ledger(run, friction_work=30.0)
    >>> round(terms["indicated_work"] - terms["brake_work"], 6)
    30.0
    """
    terms = {name: float(run.exergy_end[SIZE + number]) for name, (number, _) in (ENTERS | LEAVES).items()}
    work = float(engine_ledger(run.exergy_end).work)
    works = (
        stored_exergy(run.cycle, 0.0, run.exergy_end) - stored_exergy(run.cycle, 0.0, run.start),
        work,
        friction_work,
        work - friction_work,
    )
    return terms | dict(zip(WORKS, map(float, works), strict=True))


def exergy_entering(terms: dict[str, float]) -> float:
    """Sum the exergy [J] that enters by a ledger, with the work that drives an engine which compresses.

    `terms` are the `TERMS` by name [J].

    >>> terms = {"engine_air": 700.0, "control_air": 80.0, "wall_heat": -5.0, "indicated_work": 200.0}
    >>> exergy_entering(terms)
    780.0
    """
    return sum(max(0.0, term) for term in (*(terms[name] for name in ENTERS), -terms["indicated_work"]))


def exergy_closure(run: "SteadyRun", terms: dict[str, float]) -> float:
    """Relative exergy that the ledger of a run does not account for.

    ``closure = |in - destroyed - carried off - stored - work|/in``; how small sums are treated, see
    `apesim.march.error_bounds.closure_of`.

    The balance is that of exergy [1]_.

    Parameters
    ----------
    run : apesim.engine.steady.SteadyRun
        Operating point, with an estimate of its error.
    terms : dict of str to float
        Its ledger, `TERMS` by name [J].

    Returns
    -------
    float
        Relative exergy that is not accounted for.

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.

    Examples
    --------
    >>> from apesim.engine.machine import Machine
    >>> from apesim.engine.steady import run_steady
    >>> run = run_steady(Machine(), 100.0, tolerance=1e-4, max_cycles=1)
    >>> bool(exergy_closure(run, exergy_ledger(run, friction_work=30.0)) < 1e-3)
    True
    """
    enters, leaves = (sum(terms[name] for name in names) for names in (ENTERS, LEAVES))
    unaccounted = enters - leaves - terms["stored"] - terms["indicated_work"]
    return closure_of(unaccounted, exergy_entering(terms), stored_exergy(run.cycle, 0.0, run.start))
