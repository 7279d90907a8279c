"""Exergy ledger of a cycle: what enters with the air, where it is destroyed or carried off, and what becomes work.

The dead state is the ambient's pressure p_0 and temperature T_0. A restriction keeps the enthalpy and destroys
mdot T_0 (s_down - s_up); mixing, heat through a wall and friction destroy theirs. Every term is integrated beside the
states of a cycle, or an impact of its log; none is what is left over.
"""

from apesim.engine.cycle.flows import breathing, effects_of, exchange_sides, piped
from apesim.engine.cycle.state import (
    EXHAUST_FLOW,
    FEED_FLOW,
    GROOVE_FLOW,
    PIPE_FLOW,
    SIZE,
    control_air,
    cylinder_gas,
    cylinder_state,
    engine_ledger,
    has_pipe,
    intake_state,
    line_gas,
    pipe_gas,
    receiver_gas,
    receiver_state,
    supply_of,
)
from apesim.engine.cylinder import EPV
from apesim.exergy import (
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

ENGINE_AIR, FEED, RECEIVER_MIXING, GROOVE, CYLINDER_MIXING, EXHAUST_VALVE, EXHAUST_AIR, RATES = range(
    VALVE_RATES, VALVE_RATES + 8
)
"""Rates of the ledger that belong to the engine; how many there are with the valve's."""
ENTERS = {
    "engine_air": (ENGINE_AIR, "exergy that engine air brings from its supply, net of what flows back"),
    "control_air": (CONTROL_AIR, "exergy that control air brings from its supply, net of what flows back"),
    "wall_heat": (
        WALL_HEAT,
        "exergy of the heat from the walls, Q (1 - T_0/T_wall); a tabulated heat counts at the air's temperature",
    ),
}
"""Terms of exergy that enters: name, rate and what it is."""
LEAVES = {
    "feed": (FEED, "exergy destroyed by throttling in the feed of receiver and intake pipe"),
    "receiver_mixing": (RECEIVER_MIXING, "exergy destroyed by mixing in receiver and intake pipe"),
    "groove": (GROOVE, "exergy destroyed by throttling in the groove, and in leaks past it"),
    "cylinder_mixing": (CYLINDER_MIXING, "exergy destroyed by mixing in the cylinder"),
    "exhaust_valve": (EXHAUST_VALVE, "exergy destroyed by throttling in the exhaust valve"),
    "exhaust_air": (EXHAUST_AIR, "thermal exergy that exhaust air carries off at ambient pressure"),
    "solenoids": (SOLENOIDS, "exergy destroyed by throttling before the chambers: solenoids, supply line"),
    "chamber_mixing": (CHAMBER_MIXING, "exergy destroyed by mixing in the valve's chambers and supply line"),
    "vents": (VENTS, "exergy destroyed by throttling in the vents of the solenoids"),
    "vented_air": (VENTED_AIR, "exergy that vented control air carries off"),
    "valve_friction": (VALVE_FRICTION, "work of the valve's piston against friction and the forces of effects"),
    "valve_impacts": (VALVE_IMPACTS, "kinetic energy that the valve's piston loses at its stops"),
    "leaks": (LEAKS, "exergy that leaks of effects between chambers and to ambient destroy or carry off"),
    "heat_transfer": (HEAT_TRANSFER, "exergy destroyed by heat transfer between walls and air"),
}
"""Terms of exergy that is destroyed or carried off."""
WORKS = {
    "stored": "rise of the exergy stored in air, springs and motion over the cycle",
    "indicated_work": "indicated work, of the march with this ledger",
    "engine_friction": "work of the engine's friction",
    "brake_work": "brake work",
}
"""Terms that are no rate. What enters is what leaves, stored and indicated work; that is friction and brake work."""
TERMS = {name: text for name, (_, text) in (ENTERS | LEAVES).items()} | WORKS
"""Terms of the ledger in the order of flow: name and what it is, J in a cycle."""


@kernel(inline=False)
def add_exergy_rates(p, t, y, mode, cylinder, dy):
    """Write the rates of the exergy ledger into dy, behind those of a cycle [W].

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
    t : float
        [s]
    y, mode : float array
    cylinder : apesim.engine.cylinder.CylinderState
    dy : (SIZE + RATES,) float array
    """
    r = zeros(RATES)
    gas, ambient = p.actuator.gas, p.actuator.ambient
    p_c, t_c = cylinder.pressure, cylinder.temperature
    receiver = receiver_state(p, y)
    intake = intake_state(p, y, receiver)
    sides = exchange_sides(p, cylinder, receiver, intake)
    groove, groove_enthalpy, exhaust, _, fed, _ = breathing(p, y, mode, cylinder, receiver, intake)
    mass, energy, past_groove, past_groove_enthalpy, heat, wall_exergy, _ = effects_of(p, cylinder)
    through = stream_through(mode[GROOVE_FLOW], sides[0], groove)
    past = stream_through(past_groove, sides[0], past_groove)
    out = stream_through(mode[EXHAUST_FLOW], sides[1], exhaust)
    r[GROOVE] += throttling_loss(gas, ambient, through, intake[0], p_c)
    r[GROOVE] += throttling_loss(gas, ambient, past, intake[0], p_c)
    r[CYLINDER_MIXING] += mixing_loss(gas, ambient, through, t_c) + mixing_loss(gas, ambient, past, t_c)
    r[CYLINDER_MIXING] -= mixing_loss(gas, ambient, out, t_c)
    r[EXHAUST_VALVE] += throttling_loss(gas, ambient, out, p_c, ambient.pressure)
    r[EXHAUST_AIR] += stream_exergy(gas, ambient, out, ambient.pressure)
    r[LEAKS] -= exergy_brought(gas, ambient, mass, energy - heat, p_c, t_c)
    r[WALL_HEAT] += wall_exergy
    r[HEAT_TRANSFER] += wall_exergy - heat_exergy(ambient, heat, t_c)
    control, mixing = 0.0, 0.0
    if p.engine.intake == EPV:
        control, mixing = add_valve_rates(p.actuator, t, y, mode, control_air(p, y)[0], supply_of(p, y), r)
    if has_pipe(p):
        pipe, _ = piped(p, mode, receiver, intake, groove + past_groove, groove_enthalpy + past_groove_enthalpy)
        drawn = stream_through(mode[PIPE_FLOW], sides[3], pipe)
        r[FEED] += throttling_loss(gas, ambient, drawn, receiver[0], intake[0])
        r[RECEIVER_MIXING] += mixing_loss(gas, ambient, drawn, intake[1])
        r[RECEIVER_MIXING] -= mixing_loss(gas, ambient, through, intake[1]) + mixing_loss(gas, ambient, past, intake[1])
        brought, back = stream_exergy(gas, ambient, drawn, receiver[0]), -mixing_loss(gas, ambient, drawn, receiver[1])
    else:
        brought = stream_exergy(gas, ambient, through, intake[0]) + stream_exergy(gas, ambient, past, intake[0])
        back = -mixing_loss(gas, ambient, through, intake[1]) - mixing_loss(gas, ambient, past, intake[1])
    if p.receiver_volume > 0.0:
        feed = stream_through(mode[FEED_FLOW], sides[2], fed)
        r[FEED] += throttling_loss(gas, ambient, feed, p.supply[0], receiver[0])
        r[RECEIVER_MIXING] += mixing_loss(gas, ambient, feed, receiver[1]) + back
        brought = stream_exergy(gas, ambient, feed, p.supply[0])
        if p.control_from_receiver:
            r[RECEIVER_MIXING] += mixing
            r[CONTROL_AIR] = control * flow_exergy(gas, ambient, p.supply[0], p.supply[1])
            brought -= r[CONTROL_AIR]
    r[ENGINE_AIR] += brought
    for i in range(RATES):
        dy[SIZE + i] = r[i]


def stored(p, t, y):
    """Exergy of all the air between supply and exhaust, and of the valve's springs and motion [J].

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
    t : float
        [s]
    y : (SIZE,) float array

    Returns
    -------
    float
    """
    gas, ambient = p.actuator.gas, p.actuator.ambient
    cylinder, _ = cylinder_state(p, t, y)
    receiver = receiver_state(p, y)
    gases = [(*cylinder_gas(y), cylinder.pressure, cylinder.temperature, cylinder.volume)]
    if p.receiver_volume > 0.0:
        gases.append((*receiver_gas(y), *receiver, p.receiver_volume))
    if has_pipe(p):
        gases.append((*pipe_gas(y), *intake_state(p, y, receiver), p.pipe[0]))
    if has_line(p.actuator):
        gases.append((*line_gas(y), *control_air(p, y)[1], p.actuator.line[0]))
    total = sum(exergy_stored(gas, ambient, *content) for content in gases)
    return total + (valve_stored(p.actuator, y, supply_of(p, y)) if p.engine.intake == EPV else 0.0)


def exergy_ledger(run, friction_work):
    """Exergy ledger of a cycle.

    Parameters
    ----------
    run : apesim.engine.steady.SteadyRun
    friction_work : float
        Of the engine's friction [J].

    Returns
    -------
    dict
        `TERMS` by name [J].
    """
    terms = {name: float(run.exergy_end[SIZE + number]) for name, (number, _) in (ENTERS | LEAVES).items()}
    work = float(engine_ledger(run.exergy_end).work)
    works = (
        stored(run.p, 0.0, run.exergy_end) - stored(run.p, 0.0, run.start),
        work,
        friction_work,
        work - friction_work,
    )
    return terms | dict(zip(WORKS, map(float, works), strict=True))


def exergy_entering(terms):
    """Exergy that enters by a ledger [J]; the work that drives an engine which compresses is part of it."""
    return sum(max(0.0, term) for term in (*(terms[name] for name in ENTERS), -terms["indicated_work"]))


def exergy_closure(run, terms):
    """Exergy that the ledger of a run does not account for, see `apesim.march.error_bounds.closure_of`."""
    enters, leaves = (sum(terms[name] for name in names) for names in (ENTERS, LEAVES))
    left = enters - leaves - terms["stored"] - terms["indicated_work"]
    return closure_of(left, exergy_entering(terms), stored(run.p, 0.0, run.start))
