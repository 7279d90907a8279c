"""Ledger of the control air, and the layout of the state vectors that bench and engine integrate.

A state vector holds the valve's states, then the gas of every other volume as its mass and internal energy, then the
ledger: what has flowed through each border since the start. The ledger is integrated beside the states and acts on
nothing. Code outside reads and writes a vector by the functions here and by those that know where its parts begin.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.march.adaptive import LOG_HEAD
from apesim.restriction import Flow

if TYPE_CHECKING:
    from apesim.valve.actuator import ActuatorRates


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

    line_fed: float
    """Control air from its source [kg]."""
    line_fed_enthalpy: float
    """Enthalpy of the control air from its source [J]."""
    supplied: float
    """Control air through the supply sides of both solenoids [kg]."""
    supplied_enthalpy: float
    """Enthalpy of the supplied control air [J]."""
    vented: float
    """Control air through the vents of both solenoids [kg]."""
    vented_enthalpy: float
    """Enthalpy of the vented control air [J]."""
    other_mass: float
    """Air that effects let in, into chambers, cylinder or elsewhere [kg]."""
    other_energy: float
    """Energy that effects let in, into chambers, cylinder or elsewhere [J]."""
    valve_work: float
    """Work of both chambers on the valve's piston [J]."""


CONTROL_ENTRIES = len(ControlLedger._fields)
"""Entries of the control air's ledger."""


@kernel
def valve_states(y: np.ndarray) -> ValveStates:
    """Read the valve's states from a state vector, from its change or from its rates.

    Parameters
    ----------
    y : (n,) float array
        State vector of a bench or an engine, or a difference or the rates of such vectors.

    Returns
    -------
    ValveStates
        Its first elements, by name.

    Examples
    --------
    >>> print(valve_states(np.array([9e-3, 0.0, 1e-4, 20.0, 2e-5, 4.0])).position)
    0.009
    """
    return ValveStates(y[0], y[1], y[2], y[3], y[4], y[5])


def logged_motion(log: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Read the motion of the valve's piston from the log of a march.

    Parameters
    ----------
    log : (l, 3 + i) float array
        Log of a bench's or an engine's march, see `apesim.march.adaptive.march`.

    Returns
    -------
    positions : (l,) float array
        Positions of the piston, 0 fully open [m].
    speeds : (l,) float array
        Speeds of the piston, positive towards closed [m/s].

    Examples
    --------
    >>> positions, speeds = logged_motion(np.array([[0.0, -1.0, 0.0, 9e-3, 0.0], [1e-3, 4.0, 0.0, 8e-3, -2.0]]))
    >>> positions.tolist(), speeds.tolist()
    ([0.009, 0.008], [0.0, -2.0])
    """
    return log[:, LOG_HEAD], log[:, LOG_HEAD + 1]


@kernel
def update_motion(y: np.ndarray, position: float, speed: float) -> None:
    """Write position and speed of the valve's piston into a state vector.

    Parameters
    ----------
    y : (n,) float array
        State vector of a bench or an engine; changed.
    position : float
        Position of the piston, 0 fully open [m].
    speed : float
        Speed of the piston, positive towards closed [m/s].

    Examples
    --------
    >>> y = np.zeros(6)
    >>> update_motion(y, position=9e-3, speed=-0.5)
    >>> y.tolist()
    [0.009, -0.5, 0.0, 0.0, 0.0, 0.0]
    """
    y[0], y[1] = position, speed


@kernel
def gas_of_volume(y: np.ndarray, first: int) -> tuple[float, float]:
    """Read the gas of a volume from a state vector.

    Parameters
    ----------
    y : (n,) float array
        State vector.
    first : int
        Element that holds the mass; the next one holds the internal energy.

    Returns
    -------
    mass : float
        Mass of the gas [kg].
    energy : float
        Internal energy of the gas [J].

    Examples
    --------
    >>> mass, energy = gas_of_volume(np.array([0.0, 2e-4, 41.0]), 1)
    >>> print(mass, energy)
    0.0002 41.0
    """
    return y[first], y[first + 1]


@kernel
def control_ledger_at(y: np.ndarray, first: int) -> ControlLedger:
    """Read the control air's ledger from a state vector.

    Parameters
    ----------
    y : (n,) float array
        State vector.
    first : int
        Element at which the ledger begins.

    Returns
    -------
    ControlLedger
        Its entries, by name.

    Examples
    --------
    >>> print(control_ledger_at(np.arange(11.0), 2).vented)
    6.0
    """
    return ControlLedger(
        y[first],
        y[first + 1],
        y[first + 2],
        y[first + 3],
        y[first + 4],
        y[first + 5],
        y[first + 6],
        y[first + 7],
        y[first + 8],
    )


@kernel
def control_rates(valve: "ActuatorRates", line_fed: Flow, let_in: Flow) -> ControlLedger:
    """Rates of the control air's ledger.

    Parameters
    ----------
    valve : apesim.valve.actuator.ActuatorRates
        Rates of the valve.
    line_fed : apesim.restriction.Flow
        Flow of control air from its source.
    let_in : apesim.restriction.Flow
        Mass and energy that effects let in, into the chambers and elsewhere.

    Returns
    -------
    ControlLedger
        Rates of its entries [kg/s, W].

    Examples
    --------
    >>> from apesim.valve.actuator import AT_REST
    >>> control_rates(AT_REST, Flow(0.1, 20.0), Flow(0.2, 30.0)).other_mass
    0.2
    """
    return ControlLedger(
        line_fed.mass,
        line_fed.enthalpy,
        valve.supplied.mass,
        valve.supplied.enthalpy,
        valve.vented.mass,
        valve.vented.enthalpy,
        let_in.mass,
        let_in.enthalpy,
        valve.work,
    )


@kernel
def update_part(y: np.ndarray, first: int, values: tuple[float, ...] | np.ndarray) -> None:
    """Write a part of a state vector, or of its rates.

    Parameters
    ----------
    y : (n,) float array
        State vector that is changed.
    first : int
        Element at which the part begins.
    values : tuple of float or (k,) float array
        The part: a `ControlLedger`, `ValveStates`, or mass [kg] and internal energy [J] of a gas.

    Examples
    --------
    >>> y = np.zeros(4)
    >>> update_part(y, 2, (2e-4, 41.0))
    >>> y.tolist()
    [0.0, 0.0, 0.0002, 41.0]
    """
    for i in range(len(values)):
        y[first + i] = values[i]
