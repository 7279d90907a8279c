"""Effective areas of the solenoids, which the paper does not print, over which a judgement of its valve holds."""

from collections.abc import Callable, Sequence

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.execution.pool import Team
from apesim.studies.limit.valve_map import compute_map
from apesim.studies.paper.claims.claim import Claim, grid_of
from apesim.studies.paper.claims.design import works_at_30_hz
from apesim.studies.paper.claims.motion import computed, valve_claims

AREAS = tuple(np.arange(3.0, 12.51, 0.5) * 1e-6)
"""Areas from a quarter of the solenoids' 4 mm bore to all of it, beyond which no effective area lies [m2]."""


def with_area(machine: Machine, area: float) -> Machine:
    """A machine whose solenoids have another effective area [m2]."""
    solenoid = machine.valve.solenoid._replace(effective_area=float(area))
    return machine._replace(valve=machine.valve._replace(solenoid=solenoid))


def claims_by_area(
    machine: Machine,
    pressures: Sequence[float],
    temperatures: Sequence[float],
    areas: Sequence[float] = AREAS,
    report: Callable[[int, int], object] | None = None,
    team: Team | None = None,
) -> dict[float, dict[str, Claim]]:
    """Judge the claims on the valve's motion over effective areas of its solenoids [m2], the machine's own among them.

    `pressures` are in Pa abs, `temperatures` in K. `report` is called with the numbers of areas done and in all;
    without a `team` this process alone computes. Returns the claims by area [m2], ascending, and key.
    """
    tried = sorted({*areas, machine.valve.solenoid.effective_area})
    calls = [(with_area(machine, area), pressures, temperatures) for area in tried]
    return dict(zip(tried, (team or Team()).map(_claims_of, calls, report), strict=True))


def _claims_of(machine: Machine, pressures: Sequence[float], temperatures: Sequence[float]) -> dict[str, Claim]:
    """Judge the claims on the motion of a machine's valve, by their keys."""
    grid = grid_of(compute_map(machine, pressures, temperatures), machine.ambient.pressure)
    return {claim.key: claim for claim in (*valve_claims(machine, grid), computed(works_at_30_hz(machine)))}
