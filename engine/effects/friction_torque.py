"""Mechanical friction that differs from Chen and Flynn's."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity


class FrictionTorque(NamedTuple):
    """A constant friction mean effective pressure more."""

    fmep: Annotated[float, Quantity("kPa", -50, 50, "as large as that of a small engine")] = 0.0


def adjust(effect, cycle, tables):
    """Add to the constant of the friction mean effective pressure.

    Parameters
    ----------
    effect : FrictionTorque
    cycle : apesim.engine.cycle.state.Cycle
    tables : apesim.engine.cycle.state.CycleTables

    Returns
    -------
    apesim.engine.cycle.state.Cycle, apesim.engine.cycle.state.CycleTables
    """
    engine = cycle.engine
    friction = engine.friction._replace(constant=engine.friction.constant + effect.fmep)
    return cycle._replace(engine=engine._replace(friction=friction)), tables


EFFECT = Effect(
    "friction_torque",
    FrictionTorque,
    equation="fmep = fmep + constant",
    source="Chen and Flynn 1965, whose constant varies from engine to engine",
    seen_in="mean brake torque only, at all speeds alike",
    isolated_by="motoring the engine without air, both valves open",
    adjust=adjust,
)
