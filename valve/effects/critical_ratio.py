"""Solenoids that choke at another pressure ratio than an ideal nozzle."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

OF_AIR = 0.528
"""Critical pressure ratio of Eq. 8 at k = 1.4, to three digits."""


class CriticalRatio(NamedTuple):
    """The critical pressure ratio b of ISO 6358 for the solenoids; that of Eq. 8 is off."""

    b: Annotated[float, Quantity("", 0.2, OF_AIR, "ISO 6358-1; catalogues of small valves: 0.2 to 0.5")] = OF_AIR


def adjust(effect, actuator, tables):
    """Stretch Eq. 8 over the pressure ratio: psi_b(r) = psi(1 - (1 - 0.528)/(1 - b) (1 - r)).

    The flow chokes at b, to 3e-4, and falls to none at equal pressures.

    Parameters
    ----------
    effect : CriticalRatio
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    return actuator._replace(stretch=(1.0 - OF_AIR) / (1.0 - effect.b)), tables


EFFECT = Effect(
    "critical_ratio",
    CriticalRatio,
    equation="psi_b(r) = psi(1 - (1 - 0.528)/(1 - b) (1 - r))",
    source="ISO 6358-1: choked below b; the paper's Eq. 8 stretched in place of the standard's quarter ellipse",
    seen_in="shape of the chamber pressure after unchoking; confused with the discharge coefficient",
    isolated_by="discharge test of a solenoid down to ambient pressure, or a steady flow test to ISO 6358-1",
    adjust=adjust,
    off=OF_AIR,
)
