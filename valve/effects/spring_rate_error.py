"""Springs whose rate differs from the machine file's."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect, Misstated, Search, scale
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


class SpringRateError(NamedTuple):
    """An error of the rate of both springs."""

    share: Annotated[float, Quantity("", -0.6, 0.6, "springs are sold to 10 percent; one taken for two")] = 0.0


def adjust(
    effect: SpringRateError, actuator: "Actuator", tables: "ActuatorTables"
) -> tuple["Actuator", "ActuatorTables"]:
    """Change the rate of both springs by a share, ``K = (1 + share) K``.

    K is the rate of Eq. 1 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    effect : SpringRateError
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

    Examples
    --------
    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> round(adjust(SpringRateError(share=0.1), actuator, tables)[0].valve.spring_rate, 6)
    2010.8
    """
    valve = actuator.valve
    valve = valve._replace(spring_rate=(1.0 + effect.share) * valve.spring_rate)
    return actuator._replace(valve=valve), tables


EFFECT = Effect(
    "spring_rate_error",
    SpringRateError,
    equation="K = (1 + share) K",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eq. 1; DIN 2095 (now EN 15800) on tolerances of springs",
    seen_in="mid stroke; confused with Coulomb friction",
    isolated_by="force over travel with both chambers open",
    adjust=adjust,
    search=Search(misstated=(Misstated("valve.spring_rate", scale),)),
)
