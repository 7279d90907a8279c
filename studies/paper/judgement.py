"""Claims: all that the paper says of its valve, judged."""

from collections.abc import Mapping

from apesim.archive import Archive
from apesim.engine.machine import Machine
from apesim.studies.discharge import Discharge
from apesim.studies.paper.claims import design, engine, equations, numerics
from apesim.studies.paper.claims.claim import AREA, Claim, grid_of, range_of, with_range
from apesim.studies.paper.claims.motion import computed, valve_claims
from apesim.studies.paper.friction import friction_map
from apesim.studies.paper.subject import PAPERS, engine_subject_of, subject_of

LONG = (engine.speed_demand, design.working_frequency, engine.correction, numerics.fixed_step)
"""Judges of a machine that take seconds each: the longest first, so that several processes end together."""


def all_claims(
    machine: Machine,
    archive: Archive,
    tests: Discharge,
    by_area: Mapping[float, Mapping[str, Claim]],
    frictions: friction_map.FrictionMap | None,
    judged: Mapping[str, Claim] | None = None,
) -> list[Claim]:
    """Judge every claim; those on the engine take some seconds.

    `archive` is the map over the paper's grid, see `apesim.studies.limit.valve_map.compute_map`, `tests` the result of
    the model's own discharge tests. `by_area` has claims by area and key, see
    `apesim.studies.paper.claims.area.claims_by_area`; empty: not over areas. With `frictions` None the claim on the
    friction is left out. `judged` is what the judges of `LONG` said, by their names, where they were asked already.
    """
    judged = judged or {judge.__name__: judge(machine) for judge in LONG}
    subject, grid = subject_of(machine), grid_of(archive, machine.ambient.pressure)
    motion = valve_claims(machine, grid, subject == PAPERS)
    claims = [
        *motion[:-3],
        judged["working_frequency"],
        design.engine_speed(),
        equations.curves_collapse(tests),
        equations.exponents_of_eq_10(machine),
        equations.gauge_pressures(machine),
        equations.sign_of_outflow(machine),
        judged["fixed_step"],
        numerics.evaluation_function(machine),
        *motion[-3:],
        *([friction_map.viscous_friction(frictions)] if frictions else []),
        design.time_error(),
    ]
    in_engine = engine_subject_of(engine.supplied(machine))
    return [
        *(_over_areas(computed(claim)._replace(judged_on=subject), by_area) for claim in claims),
        computed(judged["correction"])._replace(judged_on=in_engine),
        computed(judged["speed_demand"])._replace(judged_on=in_engine),
    ]


def _over_areas(claim: Claim, by_area: Mapping[float, Mapping[str, Claim]]) -> Claim:
    """A claim with its verdicts over the solenoids' area, where it was judged over that."""
    areas = list(by_area)
    if not areas or claim.key not in by_area[areas[0]]:
        return claim
    tried = [round(area * 1e6, 6) for area in areas]
    judged = [by_area[area][claim.key] for area in areas]
    return with_range(claim, range_of(AREA, "mm^2", tried, judged))
