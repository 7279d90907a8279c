"""Moving mass that differs from the machine file's."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect, Misstated, Search, scale
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


class MovingMassError(NamedTuple):
    """An error of the moving mass, oil and a share of the springs among it."""

    share: Annotated[float, Quantity("", -0.5, 0.5, "a third of the springs, oil, parts left out")] = 0.0


def adjust(
    effect: MovingMassError, actuator: "Actuator", tables: "ActuatorTables"
) -> tuple["Actuator", "ActuatorTables"]:
    """Change the moving mass by a share, ``M = (1 + share) M``.

    M is the mass of Eq. 1 of the EPV paper [1]_, which leaves the springs out; a third of a spring's mass moves along
    [2]_.

    Parameters
    ----------
    effect : MovingMassError
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
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 1.
    .. [2] Lord Rayleigh, "The Theory of Sound", 1877.

    Examples
    --------
    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> round(adjust(MovingMassError(share=0.1), actuator, tables)[0].valve.moving_mass, 6)
    0.12595
    """
    valve = actuator.valve
    valve = valve._replace(moving_mass=(1.0 + effect.share) * valve.moving_mass)
    return actuator._replace(valve=valve), tables


EFFECT = Effect(
    "moving_mass_error",
    MovingMassError,
    equation="M = (1 + share) M",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eq. 1; Rayleigh: a third of a spring moves along",
    seen_in="acceleration; confused with the pressures' gain",
    isolated_by="weighing the piston, or a free oscillation on its springs",
    adjust=adjust,
    search=Search(misstated=(Misstated("valve.moving_mass", scale),)),
)
