"""Gas exchange: the flows through groove, exhaust valve and the receiver's feed, and their regimes."""

from apesim.kernel import kernel
from apesim.restriction import SHUT, beyond_regime, flow_in, next_regime, regime_between
from engine.breathing import raised_cosine
from engine.cycle_state import (
    EXHAUST_FLOW,
    FEED_FLOW,
    GROOVE_FLOW,
    INTAKE_OPEN,
    cylinder_state,
    receiver_state,
)
from engine.cylinder import EPV, IDEAL_VALVE
from valve.actuator import AREA, AREA_SLOPE
from valve.ports import ports_area

FLOWS = FEED_FLOW - GROOVE_FLOW + 1


@kernel
def intake_lift(p, angle, y):
    """Lift of the intake [m]."""
    if p.engine.intake == EPV:
        return p.actuator.valve.stroke - y[0]
    cam = p.engine.cam
    return cam.lift * raised_cosine(angle, cam.opens, cam.closes, cam.flank)


@kernel
def intake_area(p, angle, y, mode):
    """Effective area of the groove [m2]."""
    if p.engine.intake == IDEAL_VALVE:
        return p.full_area * mode[INTAKE_OPEN]
    lift = intake_lift(p, angle, y)
    if p.has_ports and mode[AREA_SLOPE] != 0.0:
        return ports_area(p.ports, lift - p.lap)
    return max(0.0, mode[AREA] + mode[AREA_SLOPE] * lift)


@kernel
def beside(p, cylinder, receiver, flow):
    """Pressures and temperatures on both sides of a flow, GROOVE_FLOW...FEED_FLOW [Pa abs, K, Pa abs, K]."""
    if flow == GROOVE_FLOW:
        return receiver[0], receiver[1], cylinder.pressure, cylinder.temperature
    if flow == EXHAUST_FLOW:
        return cylinder.pressure, cylinder.temperature, p.actuator.ambient.pressure, p.actuator.ambient.temperature
    return p.supply[0], p.supply[1], receiver[0], receiver[1]


@kernel
def breathing(p, y, mode, cylinder, receiver):
    """Flows through groove, exhaust valve and feed, each with its enthalpy [kg/s, W]."""
    gas, valve = p.actuator.gas, p.engine.exhaust
    area = intake_area(p, cylinder.angle, y, mode)
    groove, groove_enthalpy = flow_in(gas, mode[GROOVE_FLOW], area, *beside(p, cylinder, receiver, GROOVE_FLOW))
    area = valve.effective_area * raised_cosine(cylinder.angle, valve.opens, valve.closes, valve.flank)
    exhaust, exhaust_enthalpy = flow_in(gas, mode[EXHAUST_FLOW], area, *beside(p, cylinder, receiver, EXHAUST_FLOW))
    area = p.engine.receiver.feed_area
    fed, fed_enthalpy = flow_in(gas, mode[FEED_FLOW], area, *beside(p, cylinder, receiver, FEED_FLOW))
    return groove, groove_enthalpy, exhaust, exhaust_enthalpy, fed, fed_enthalpy


@kernel
def exchange_events(p, t, y, mode, first, g):
    """By how much each flow has left its regime, into g from its element ``first``."""
    cylinder, _ = cylinder_state(p, t, y)
    receiver = receiver_state(p, y)
    for i in range(FLOWS):
        flow = GROOVE_FLOW + i
        g[first + i] = beyond_regime(p.actuator.gas, mode[flow], *beside(p, cylinder, receiver, flow))


@kernel
def change_regime(p, t, y, mode, flow):
    """Take a flow over into the regime that follows."""
    cylinder, _ = cylinder_state(p, t, y)
    mode[flow] = next_regime(p.actuator.gas, mode[flow], *beside(p, cylinder, receiver_state(p, y), flow))


@kernel
def set_regime(p, t, y, mode, flow, is_open):
    """Regime of a flow from the state."""
    mode[flow] = SHUT
    if is_open:
        cylinder, _ = cylinder_state(p, t, y)
        mode[flow] = regime_between(p.actuator.gas, *beside(p, cylinder, receiver_state(p, y), flow))


@kernel
def set_groove_regime(p, t, y, mode):
    """Regime of the flow through the groove on the piece of its table, or by whether the ideal valve is open."""
    is_open = mode[INTAKE_OPEN] != 0.0 or mode[AREA] != 0.0 or mode[AREA_SLOPE] != 0.0
    set_regime(p, t, y, mode, GROOVE_FLOW, is_open)


@kernel
def exchange_enters(p, t, t_end, y, mode):
    """Regimes of the flows at the start of a stretch."""
    set_groove_regime(p, t, y, mode)
    valve = p.engine.exhaust
    middle = p.start + p.speed * 0.5 * (t + t_end)
    is_open = raised_cosine(middle, valve.opens, valve.closes, valve.flank) > 0.0
    set_regime(p, t, y, mode, EXHAUST_FLOW, is_open)
    set_regime(p, t, y, mode, FEED_FLOW, p.receiver_volume > 0.0)
