"""Kinds of archives: which study's results each holds, and the class that reads, prints and draws them."""

from collections.abc import Iterable, Mapping

KINDS = {
    "engine sweep": "apesim.studies.sweep.study:Sweep",
    "engine limit": "apesim.studies.limit.engine_limit_map:EngineLimitMap",
    "engine timing": "apesim.studies.timing.correction:CorrectedTiming",
    "engine optimise": "apesim.studies.optimise.optimisation:OptimalCommands",
    "engine assess": "apesim.studies.assessment.comparison:ValveAssessment",
    "engine start": "apesim.studies.transient.start:StartRun",
    "engine start map": "apesim.studies.transient.start_map:StartMap",
    "engine transient": "apesim.studies.transient.transient:TransientRun",
    "valve map": "apesim.studies.limit.valve_map:ValveMap",
    "valve limit": "apesim.studies.limit.valve_limit:ValveLimit",
    "valve soft-landing": "apesim.studies.soft_landing.study:SoftLanding",
}
"""Class of the result by the kind of an archive, which is the command that writes it; a new kind is one more entry."""
SIGNS = {
    "engine sweep": {"actuation", "axes"},
    "engine start map": {"starting_share", "axes"},
    "engine start": {"starting_share", "first_motion_s"},
    "engine transient": {"revolution_start_s", "shaft_closure"},
    "valve map": {"pulse_s", "opening_delay_s"},
    "valve limit": {"limit_hz", "duty"},
    "engine limit": {"limit_rpm", "duration_deg", "fails"},
    "engine timing": {"interpolation_error_rad", "advance_deg"},
    "engine optimise": {"searched_energise", "fixed_energise_deg"},
    "engine assess": {"timing", "brake_torque_lost_Nm"},
    "valve soft-landing": {"dwell_s", "cost_s", "spacing_s"},
}
"""Variables and entries of the provenance by which an archive from before kinds is known, the first match counts."""


def kind_of(variables: Iterable[str], provenance: Mapping[str, str]) -> str:
    """Find the kind of an archive from the names of its variables and its provenance; "" where nothing tells.

    Archives from before they held their kind are known by `SIGNS`.
    """
    names = {*variables, *provenance}
    guesses = (kind for kind, signs in SIGNS.items() if signs <= names)
    return provenance.get("kind") or next(guesses, "")
