"""Moving mass that differs from the machine file's."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity


class MovingMassError(NamedTuple):
    """An error of the moving mass, oil and a share of the springs among it."""

    share: Annotated[float, Quantity("", -0.15, 0.15, "a third of the springs, oil, fasteners")] = 0.0


def adjust(effect, actuator, tables):
    """Change the moving mass by a share.

    Parameters
    ----------
    effect : MovingMassError
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    valve = actuator.valve
    valve = valve._replace(moving_mass=(1.0 + effect.share) * valve.moving_mass)
    return actuator._replace(valve=valve), tables


EFFECT = Effect(
    "moving_mass_error",
    MovingMassError,
    equation="M = (1 + share) M",
    source="paper, Eq. 1; Rayleigh: a third of a spring moves along",
    seen_in="acceleration; confused with the pressures' gain",
    isolated_by="weighing the piston, or a free oscillation on its springs",
    adjust=adjust,
)
