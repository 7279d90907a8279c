"""What the paper says, and what its equations give."""

from studies.paper import delay, design, equations, stroke
from studies.paper.claim import grid_of


def all_claims(machine, archive):
    """Every claim, judged.

    Parameters
    ----------
    machine : engine.machine.Machine
    archive : Archive
        The map over the paper's grid, see `studies.valve_map.map_valve`.

    Returns
    -------
    list of Claim
    """
    grid = grid_of(archive, machine.ambient.pressure)
    return [
        delay.delay_rises_with_pressure(grid),
        delay.delay_levels_off(grid),
        delay.delay_and_temperature(grid),
        delay.temperature_scaling(machine),
        delay.size_of_temperature(grid),
        delay.delay_is_linear(grid),
        stroke.fluctuation_rises(grid),
        stroke.piston_rebounds(grid),
        stroke.not_monotonic(grid, "stroke_time_over_pressure", "stroke_time_s", "full stroke time", "ms", 1e3),
        stroke.not_monotonic(grid, "seating_speed_over_pressure", "seating_speed_m_s", "seating speed", "m/s", 1.0),
        stroke.stroke_time_falls_with_temperature(grid),
        stroke.strokes_alike(grid),
        design.working_frequency(machine),
        design.engine_speed(),
        equations.gauge_pressures(machine),
        equations.sign_of_outflow(machine),
        design.friction_is_small(machine),
        design.springs_soften(machine),
        *design.not_computable(),
    ]
