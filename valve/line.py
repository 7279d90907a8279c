"""The supply line between control air and solenoids, where an effect puts one there: a gas volume and its feed."""

from apesim.kernel import kernel
from apesim.restriction import SHUT, beyond_regime, flow_in, next_regime, regime_between
from apesim.valve.actuator import LINE_REGIME
from apesim.valve.chamber import chamber_state
from apesim.valve.ledger import gas_of_volume
from apesim.valve.motion import BRANCHED

LINE_FLOW = BRANCHED + 1
"""Event: the flow into the line, into another regime."""


@kernel
def has_line(actuator):
    """Whether there is a supply line."""
    return len(actuator.effects) > 0 and actuator.line[1] > 0.0


@kernel
def before_solenoids(actuator, y, first, source):
    """Pressure [Pa abs] and temperature [K] before the solenoids.

    Parameters
    ----------
    actuator : Actuator
    y : float array
        State; without a line it may end before the line's.
    first : int
        Its element that is the mass of the air in the line [kg]; the next one is the energy [J].
    source : tuple of float
        Pressure and temperature of the control air; of this also where there is no line.

    Returns
    -------
    pressure, temperature : float
    """
    if has_line(actuator):
        return chamber_state(actuator.gas, *gas_of_volume(y, first), actuator.line[0])
    return source


@kernel
def line_feed(actuator, mode, source, line, valve):
    """Control air from its source: into the line, or where there is none, to the solenoids [kg/s, W].

    Parameters
    ----------
    actuator : Actuator
    mode : (>= MODES,) float array
    source, line : tuple of float
        Pressure and temperature before and in the line.
    valve : apesim.valve.actuator.ActuatorRates

    Returns
    -------
    mass_flow, enthalpy_flow : float
    """
    if has_line(actuator):
        return flow_in(actuator.gas, mode[LINE_REGIME], actuator.line[1], (*source, *line))
    return valve.supplied, valve.supplied_enthalpy


@kernel
def start_line_segment(actuator, source, line, mode):
    """Regime of the feed at the start of a stretch."""
    mode[LINE_REGIME] = regime_between(actuator.gas, (*source, *line)) if has_line(actuator) else SHUT


@kernel
def line_event(actuator, source, line, mode):
    """By how much the feed has left its regime."""
    return beyond_regime(actuator.gas, mode[LINE_REGIME], (*source, *line)) if has_line(actuator) else -1.0


@kernel
def change_line_regime(actuator, source, line, mode):
    """Take the feed over into the regime that follows."""
    mode[LINE_REGIME] = next_regime(actuator.gas, mode[LINE_REGIME], (*source, *line))
