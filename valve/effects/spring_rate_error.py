"""Springs whose rate differs from the machine file's."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity


class SpringRateError(NamedTuple):
    """An error of the rate of both springs."""

    share: Annotated[float, Quantity("", -0.3, 0.3, "springs are sold to 10 percent; an end coil that binds")] = 0.0


def adjust(effect, actuator, tables):
    """Change the spring rate by a share.

    Parameters
    ----------
    effect : SpringRateError
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    valve = actuator.valve
    valve = valve._replace(spring_rate=(1.0 + effect.share) * valve.spring_rate)
    return actuator._replace(valve=valve), tables


EFFECT = Effect(
    "spring_rate_error",
    SpringRateError,
    equation="K = (1 + share) K",
    source="paper, Eq. 1; DIN 2095 (now EN 15800) on tolerances of springs",
    seen_in="mid stroke; confused with Coulomb friction",
    isolated_by="force over travel with both chambers open",
    adjust=adjust,
)
