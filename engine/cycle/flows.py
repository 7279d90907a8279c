"""Gas exchange: the flows through groove, exhaust valve, the receiver's feed and intake pipe, and their regimes; what
effects let into the cylinder."""

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
)
from apesim.kernel import kernel
from apesim.restriction import SHUT, beyond_regime, flow_in, next_regime, regime_between
from apesim.stack_array import zeros
from apesim.valve.actuator import AREA, AREA_SLOPE
from apesim.valve.ledger import valve_states
from apesim.valve.ports import ports_area

FLOWS = PIPE_FLOW - GROOVE_FLOW + 1


@kernel
def intake_lift(p, angle, y, mode):
    """Lift of the intake [m]."""
    if p.engine.intake == EPV:
        return p.actuator.valve.stroke - valve_states(y).position
    if p.has_lift_curve:
        return mode[LIFT] + mode[LIFT_SLOPE] * angle
    cam = p.engine.cam
    return cam.lift * raised_cosine(angle, cam.opens, cam.closes, cam.flank)


@kernel
def intake_area(p, angle, y, mode):
    """Effective area of the groove [m2]."""
    if p.engine.intake == IDEAL_VALVE:
        return p.full_area * mode[INTAKE_OPEN]
    lift = intake_lift(p, angle, y, mode)
    if p.has_ports and mode[AREA_SLOPE] != 0.0:
        return ports_area(p.ports, lift - p.lap)
    return max(0.0, mode[AREA] + mode[AREA_SLOPE] * lift)


@kernel
def exchange_sides(p, cylinder, receiver, intake):
    """Pressures and temperatures before and behind the flows GROOVE_FLOW...PIPE_FLOW [Pa abs, K, Pa abs, K]."""
    ambient = p.actuator.ambient
    return (
        (intake[0], intake[1], cylinder.pressure, cylinder.temperature),
        (cylinder.pressure, cylinder.temperature, ambient.pressure, ambient.temperature),
        (p.supply[0], p.supply[1], receiver[0], receiver[1]),
        (receiver[0], receiver[1], intake[0], intake[1]),
    )


@kernel
def breathing(p, y, mode, cylinder, receiver, intake):
    """Flows through groove, exhaust valve and feed, each with its enthalpy [kg/s, W]."""
    gas, valve, sides = p.actuator.gas, p.engine.exhaust, exchange_sides(p, cylinder, receiver, intake)
    area = intake_area(p, cylinder.angle, y, mode)
    groove, groove_enthalpy = flow_in(gas, mode[GROOVE_FLOW], area, sides[0])
    area = valve.effective_area * raised_cosine(cylinder.angle, valve.opens, valve.closes, valve.flank)
    exhaust, exhaust_enthalpy = flow_in(gas, mode[EXHAUST_FLOW], area, sides[1])
    fed, fed_enthalpy = flow_in(gas, mode[FEED_FLOW], p.engine.receiver.feed_area, sides[2])
    return groove, groove_enthalpy, exhaust, exhaust_enthalpy, fed, fed_enthalpy


@kernel
def effects_of(p, cylinder):
    """What effects let into the cylinder: mass [kg/s] and energy [W] from outside, and past the groove; heat and its
    exergy at the wall [W]; branches."""
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
def piped(p, mode, receiver, intake, groove, groove_enthalpy):
    """Engine air from the receiver: into the intake pipe, or where there is none, to the groove [kg/s, W]."""
    if has_pipe(p):
        return flow_in(p.actuator.gas, mode[PIPE_FLOW], p.pipe[1], (*receiver, *intake))
    return groove, groove_enthalpy


@kernel
def sides_at(p, t, y):
    """`exchange_sides` of a state."""
    cylinder, _ = cylinder_state(p, t, y)
    receiver = receiver_state(p, y)
    return exchange_sides(p, cylinder, receiver, intake_state(p, y, receiver))


@kernel
def exchange_events(p, t, y, mode, g, first_event):
    """By how much each flow has left its regime, into g from its element ``first_event``."""
    sides = sides_at(p, t, y)
    for i in range(FLOWS):
        g[first_event + i] = beyond_regime(p.actuator.gas, mode[GROOVE_FLOW + i], sides[i])


@kernel
def exchange_changes(p, t, y, i, mode):
    """Take a flow, the i-th, over into the regime that follows."""
    mode[GROOVE_FLOW + i] = next_regime(p.actuator.gas, mode[GROOVE_FLOW + i], sides_at(p, t, y)[i])


@kernel
def groove_regime(p, sides, mode):
    """Regime of the flow through the groove between two sides; shut on a piece of its table without area."""
    is_open = mode[INTAKE_OPEN] != 0.0 or mode[AREA] != 0.0 or mode[AREA_SLOPE] != 0.0
    return regime_between(p.actuator.gas, sides) if is_open else SHUT


@kernel
def start_groove_segment(p, t, y, mode):
    """Regime of the flow through the groove on entering a piece of its table; the other flows keep theirs."""
    mode[GROOVE_FLOW] = groove_regime(p, sides_at(p, t, y)[0], mode)


@kernel
def start_exchange_segment(p, t, t_end, y, mode):
    """Regimes of the flows at the start of a stretch."""
    gas, valve, sides = p.actuator.gas, p.engine.exhaust, sides_at(p, t, y)
    middle = p.start + p.speed * 0.5 * (t + t_end)
    exhaust_open = raised_cosine(middle, valve.opens, valve.closes, valve.flank) > 0.0
    mode[GROOVE_FLOW] = groove_regime(p, sides[0], mode)
    mode[EXHAUST_FLOW] = regime_between(gas, sides[1]) if exhaust_open else SHUT
    mode[FEED_FLOW] = regime_between(gas, sides[2]) if p.receiver_volume > 0.0 else SHUT
    mode[PIPE_FLOW] = regime_between(gas, sides[3]) if has_pipe(p) else SHUT
