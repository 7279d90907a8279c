"""Claims on the valve's motion: those that may hang on the solenoids' area, which the paper does not print."""

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.paper.claims import delay, design, stroke
from apesim.studies.paper.claims.claim import NOT_COMPUTABLE, Claim, Grid


def valve_claims(machine: Machine, grid: Grid, chosen: bool = False) -> list[Claim]:
    """Judge the claims on the valve's motion, which may hang on the solenoids' area.

    `chosen` tells that this area was chosen by the paper's size of the temperature's effect.
    """
    claims = [
        delay.delay_rises_with_pressure(grid),
        delay.delay_levels_off(grid),
        delay.delay_and_temperature(machine, grid),
        delay.size_of_temperature(grid, chosen),
        delay.delay_is_linear(grid),
        stroke.fluctuation_rises(grid),
        stroke.fluctuation_from_limited_area(machine),
        stroke.pressures_cross(machine),
        stroke.piston_rebounds(grid),
        stroke.not_monotonic(
            grid, "Fig. 10", "stroke_time_over_pressure", "stroke_time_s", "full stroke time", "ms", 1e3
        ),
        stroke.not_monotonic(
            grid, "Fig. 11", "seating_speed_over_pressure", "seating_speed_m_s", "seating speed", "m/s", 1.0
        ),
        stroke.stroke_time_falls_with_temperature(grid),
        stroke.response_over_pressure(grid),
        stroke.pressure_to_be_optimised(grid),
        stroke.strokes_alike(machine, grid),
        design.friction_is_small(machine),
        design.heat_is_small(machine),
        design.springs_soften(machine),
    ]
    return [computed(claim) for claim in claims]


def computed(claim: Claim) -> Claim:
    """A claim as it is; not computable where a stroke that it needs is not completed, as one of its values is NaN."""
    if np.all(np.isfinite([value for value in claim.values.values() if value is not None])):
        return claim
    return claim._replace(ours="a stroke that it needs is not completed", verdict=NOT_COMPUTABLE)
