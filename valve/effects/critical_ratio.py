"""Solenoids that choke at another pressure ratio than an ideal nozzle."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


OF_AIR = 0.528
"""Critical pressure ratio of Eq. 8 of the EPV paper (doi 10.1631/jzus.A0820373) at k = 1.4, to three digits."""


class CriticalRatio(NamedTuple):
    """The critical pressure ratio b of ISO 6358 for the solenoids; that of Eq. 8 is off."""

    b: Annotated[float, Quantity("", 0.2, OF_AIR, "ISO 6358-1; catalogues of small valves: 0.2 to 0.5")] = OF_AIR


def adjust(
    effect: CriticalRatio, actuator: "Actuator", tables: "ActuatorTables"
) -> tuple["Actuator", "ActuatorTables"]:
    """Stretch the flow function of the solenoids over the pressure ratio.

    ``psi_b(r) = psi(1 - (1 - 0.528)/(1 - b) (1 - r))``: the flow chokes at b, to 3e-4, and falls to none at equal
    pressures. psi is Eq. 8 of the EPV paper [1]_. Choking below b is ISO 6358-1 [2]_; the stretched function in place
    of its quarter ellipse is chosen.

    Parameters
    ----------
    effect : CriticalRatio
        Parameters of the effect.
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    tables : apesim.valve.actuator.ActuatorTables
        Arrays of the valve.

    Returns
    -------
    apesim.valve.actuator.Actuator
        Valve with the effect.
    apesim.valve.actuator.ActuatorTables
        Arrays with the effect.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 8.
    .. [2] ISO 6358-1:2013, "Pneumatic fluid power - Determination of flow-rate characteristics of components using
       compressible fluids - Part 1: General rules and test methods for steady-state flow".

    Examples
    --------
    The pressure difference is stretched by (1 - 0.528)/(1 - 0.292) = 2/3:

    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> round(adjust(CriticalRatio(b=0.292), actuator, tables)[0].stretch, 6)
    0.666667
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
