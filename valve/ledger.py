"""Ledger of the control air, and the layout of the state vectors that bench and engine integrate.

A state vector holds the valve's states, then the gas of every other volume as its mass and internal energy, then the
ledger: what has flowed through each border since the start. The ledger is integrated beside the states and acts on
nothing. Code outside reads and writes a vector by the functions here and by those that know where its parts begin.
"""

from typing import NamedTuple

import numpy as np

from apesim.air import GasContent
from apesim.kernel import kernel
from apesim.march.adaptive import LOG_HEAD
from apesim.restriction import Flow


class ValveStates(NamedTuple):
    """States of the valve, the first elements of every state vector; or what they gain, or their rates."""

    position: float
    """Position of the piston, 0 fully open [m]."""
    speed: float
    """Speed of the piston, positive towards closed [m/s]."""
    mass_a: float
    """Mass of the gas in chamber A [kg]."""
    energy_a: float
    """Internal energy of the gas in chamber A [J]."""
    mass_b: float
    """Mass of the gas in chamber B [kg]."""
    energy_b: float
    """Internal energy of the gas in chamber B [J]."""


class ControlLedger(NamedTuple):
    """Ledger of the control air: sums since the start, or their rates."""

    line_fed: Flow
    """Control air from its source."""
    supplied: Flow
    """Control air through the supply sides of both solenoids."""
    vented: Flow
    """Control air through the vents of both solenoids."""
    valve_work: float
    """Work of both chambers on the valve's piston [J]."""


FLOW_ENTRIES = len(Flow._fields)
"""Entries that a flow takes in a ledger: mass [kg] and enthalpy [J]."""
CONTROL_ENTRIES = sum(FLOW_ENTRIES if kind is Flow else 1 for kind in ControlLedger.__annotations__.values())
"""Entries of the control air's ledger."""


@kernel
def valve_states(y: np.ndarray) -> ValveStates:
    """Read the valve's states from a state vector (n,) of a bench or an engine, from its change or from its rates."""
    return ValveStates(y[0], y[1], y[2], y[3], y[4], y[5])


def logged_motion(log: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Read positions [m], 0 fully open, and speeds [m/s] to closed, of the valve's piston from the log of a march.

    The log (l, 3 + i) is a bench's or an engine's, see `apesim.march.adaptive.march`.
    """
    return log[:, LOG_HEAD], log[:, LOG_HEAD + 1]


@kernel
def update_motion(y: np.ndarray, position: float, speed: float) -> None:
    """Write position [m] and speed [m/s] of the valve's piston into a state vector `y` (n,), which is changed.

    The position is 0 fully open, and the speed positive towards closed.
    """
    y[0], y[1] = position, speed


@kernel
def gas_of_volume(y: np.ndarray, first: int) -> GasContent:
    """Read the gas of a volume from a state vector (n,): mass [kg] at element `first`, internal energy [J] after it."""
    return GasContent(y[first], y[first + 1])


@kernel
def ledger_flow(y: np.ndarray, first: int) -> Flow:
    """Read what has flowed through a border since the start from a state vector (n,).

    Element `first` is the mass [kg], the next one the enthalpy [J].
    """
    return Flow(y[first], y[first + 1])


@kernel
def control_ledger_at(y: np.ndarray, first: int) -> ControlLedger:
    """Read the control air's ledger, which begins at element `first`, from a state vector."""
    line_fed, supplied = ledger_flow(y, first), ledger_flow(y, first + FLOW_ENTRIES)
    vented = ledger_flow(y, first + 2 * FLOW_ENTRIES)
    return ControlLedger(line_fed, supplied, vented, y[first + 3 * FLOW_ENTRIES])


@kernel
def update_part(y: np.ndarray, first: int, values: tuple[float, ...] | np.ndarray) -> None:
    """Write a part of a state vector, or of its rates, from element `first` on; changes `y`.

    The part is `ValveStates`, a gas, or a flow of a ledger.
    """
    for i in range(len(values)):
        y[first + i] = values[i]


@kernel
def update_flows(y: np.ndarray, first: int, flows: tuple[Flow, ...]) -> None:
    """Write what has flowed through several borders, or the flows, one behind the other into `y` from `first` on."""
    for i in range(len(flows)):
        update_part(y, first + FLOW_ENTRIES * i, flows[i])


@kernel
def update_control_ledger(y: np.ndarray, first: int, ledger: ControlLedger) -> None:
    """Write the control air's ledger, or its rates, into a state vector (n,) from element `first` on; changes `y`."""
    flows = ledger.line_fed, ledger.supplied, ledger.vented
    update_flows(y, first, flows)
    y[first + FLOW_ENTRIES * len(flows)] = ledger.valve_work
