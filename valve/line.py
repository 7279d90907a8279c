"""Supply line between control air and solenoids, where an effect puts one there: a gas volume and its feed.

Its balances are those of a chamber, its flow that of a restriction: the EPV paper (doi 10.1631/jzus.A0820373), Eqs.
3-8.
"""

import numpy as np

from apesim.air import GasState
from apesim.kernel import kernel
from apesim.restriction import SHUT, Flow, Sides, beyond_regime, flow_in, next_regime, regime_between
from apesim.valve.actuator import LINE_REGIME, Actuator, ActuatorRates
from apesim.valve.chamber import chamber_state
from apesim.valve.ledger import gas_of_volume
from apesim.valve.motion import BRANCHED

LINE_FLOW = BRANCHED + 1
"""Event: the flow into the line goes over into another regime."""


@kernel
def has_line(actuator: Actuator) -> bool:
    """Return whether there is a supply line: an effect then feeds the solenoids through it."""
    return len(actuator.effects) > 0 and actuator.line.feed_area > 0.0


@kernel
def before_solenoids(actuator: Actuator, y: np.ndarray, first: int, source: GasState) -> GasState:
    """Return the state of the control air before the solenoids: of that in the line; `source` where there is none.

    `first` is the element of the state `y` (n,) that is the mass of the air in the line [kg]; the next one is its
    energy [J]. Without a line `y` may end before these.
    """
    if has_line(actuator):
        return chamber_state(actuator.gas, gas_of_volume(y, first), actuator.line.volume)
    return source


@kernel
def line_feed(actuator: Actuator, mode: np.ndarray, control: Sides, valve: ActuatorRates) -> Flow:
    """Return the control air from its source: into the line, or to the solenoids where there is none.

    ``mdot = S psi(r) p/sqrt(R T)``, Eq. 7 of the EPV paper (doi 10.1631/jzus.A0820373), with the area of the feed.

    Parameters
    ----------
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    mode : (>= MODES,) float array
        Modes of the valve, see `apesim.valve.actuator`.
    control : apesim.restriction.Sides
        State of the control air at its source and before the solenoids.
    valve : apesim.valve.actuator.ActuatorRates
        Rates of the valve.

    Returns
    -------
    apesim.restriction.Flow
        Flow of control air from its source.

    Examples
    --------
    >>> import apesim
    >>> import numpy as np
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> from apesim.valve.actuator import MODES, actuator_rates
    >>> mode = np.zeros(MODES)
    >>> rates = actuator_rates(actuator, 0.0, y, mode, supply)
    >>> line_feed(actuator, mode, Sides(supply.control, supply.control), rates)
    Flow(mass=0.0, enthalpy=0.0)
    """
    if has_line(actuator):
        return flow_in(actuator.gas, mode[LINE_REGIME], actuator.line.feed_area, control)
    return valve.supplied


@kernel
def start_line_segment(actuator: Actuator, control: Sides, mode: np.ndarray) -> None:
    """Write the regime of the feed at the start of a smooth stretch into `mode` (>= MODES,): shut without a line.

    `control` has the states of the control air at its source and before the solenoids.
    """
    mode[LINE_REGIME] = regime_between(actuator.gas, control) if has_line(actuator) else SHUT


@kernel
def line_event(actuator: Actuator, control: Sides, mode: np.ndarray) -> float:
    """Return by how much the pressure ratio of the feed has left its regime; above zero it has; -1 without a line.

    `control` has the states of the control air at its source and before the solenoids. `mode` (>= MODES,) holds the
    regime.
    """
    return beyond_regime(actuator.gas, mode[LINE_REGIME], control) if has_line(actuator) else -1.0


@kernel
def change_line_regime(actuator: Actuator, control: Sides, mode: np.ndarray) -> None:
    """Take the feed over into the regime that follows, in `mode` (>= MODES,).

    `control` has the states of the control air at its source and before the solenoids.

    A line at 0.8 of the pressure of the source is not filled by a choked flow:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> from apesim.restriction import CHOKED, SUBSONIC
    >>> from apesim.valve.actuator import MODES
    >>> mode = np.full(MODES, float(CHOKED))
    >>> change_line_regime(actuator, Sides(supply.control, GasState(8e5, 300.0)), mode)
    >>> bool(mode[LINE_REGIME] == SUBSONIC)
    True
    """
    mode[LINE_REGIME] = next_regime(actuator.gas, mode[LINE_REGIME], control)
