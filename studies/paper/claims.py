"""What the paper says, and what its equations give."""

import numpy as np

from studies.paper import delay, design, equations, stroke
from studies.paper.claim import NOT_COMPUTABLE, grid_of
from studies.paper.subject import PAPERS, subject_of


def all_claims(machine, archive, found):
    """Every claim, judged.

    Parameters
    ----------
    machine : engine.machine.Machine
    archive : Archive
        The map over the paper's grid, see `studies.valve_map.map_valve`.
    found : studies.discharge.Discharge
        Of the model's own discharge tests.

    Returns
    -------
    list of Claim
    """
    subject, grid = subject_of(machine), grid_of(archive, machine.ambient.pressure)
    claims = [
        delay.delay_rises_with_pressure(grid),
        delay.delay_levels_off(grid),
        delay.delay_and_temperature(grid),
        delay.temperature_scaling(machine),
        delay.size_of_temperature(grid, subject == PAPERS),
        delay.delay_is_linear(grid),
        stroke.fluctuation_rises(grid),
        stroke.fluctuation_from_limited_area(machine),
        stroke.pressures_cross(machine),
        stroke.piston_rebounds(grid),
        stroke.not_monotonic(grid, "stroke_time_over_pressure", "stroke_time_s", "full stroke time", "ms", 1e3),
        stroke.not_monotonic(grid, "seating_speed_over_pressure", "seating_speed_m_s", "seating speed", "m/s", 1.0),
        stroke.stroke_time_falls_with_temperature(grid),
        stroke.response_over_pressure(grid),
        stroke.strokes_alike(machine, grid),
        *design.working_frequency(machine),
        design.engine_speed(),
        equations.curves_collapse(found),
        equations.exponents_of_eq_10(machine),
        equations.gauge_pressures(machine),
        equations.sign_of_outflow(machine),
        design.friction_is_small(machine),
        design.heat_is_small(machine),
        design.springs_soften(machine),
        *design.not_computable(),
    ]
    return [_judged(claim, subject) for claim in claims]


def _judged(claim, subject):
    """A claim with whom it was judged on; not computable where a stroke that it needs is not completed."""
    if np.all(np.isfinite(list(claim.values.values()))):
        return claim._replace(judged_on=subject)
    missing = "a stroke that it needs is not completed"
    return claim._replace(judged_on=subject, ours=missing, verdict=NOT_COMPUTABLE)
