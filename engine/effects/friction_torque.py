"""Mechanical friction that differs from Chen and Flynn's correlation."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.engine.cycle.state import Cycle, CycleTables


class FrictionTorque(NamedTuple):
    """Constant friction mean effective pressure, beside that of the correlation."""

    fmep: Annotated[float, Quantity("kPa", -50, 50, "as large as that of a small engine")] = 0.0


def adjust(effect: FrictionTorque, cycle: "Cycle", tables: "CycleTables") -> tuple["Cycle", "CycleTables"]:
    """Add to the constant of the friction mean effective pressure, ``A' = A + fmep``.

    A is the constant of Chen and Flynn's correlation [1]_.

    Parameters
    ----------
    effect : FrictionTorque
        Parameters of the effect.
    cycle : apesim.engine.cycle.state.Cycle
        Machine at a speed, as numbers for the kernels.
    tables : apesim.engine.cycle.state.CycleTables
        Arrays of the machine.

    Returns
    -------
    cycle : apesim.engine.cycle.state.Cycle
        Machine with the effect.
    tables : apesim.engine.cycle.state.CycleTables
        Arrays of the machine with the effect.

    References
    ----------
    .. [1] S. K. Chen and P. F. Flynn, "Development of a single cylinder compression ignition research engine",
       SAE 650733, 1965, doi 10.4271/650733.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), speed=100.0)
    >>> rubbing, _ = adjust(FrictionTorque(fmep=10e3), cycle, tables)
    >>> round(rubbing.engine.friction.constant - cycle.engine.friction.constant, 6)
    10000.0
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
