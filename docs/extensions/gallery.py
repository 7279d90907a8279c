"""Order of the examples in the gallery."""

from pathlib import Path

ORDER = [
    "first_run",
    "own_machine",
    "sweep_over_pressure",
    "cam_against_epv",
    "what_limits_30_hz",
    "timing_map_to_header",
    "soft_landing",
    "optimum",
    "real_air",
    "own_valve_from_discharge_test",
    "laboratory_data",
    "missing_effect_found",
    "own_effect",
    "sweep_on_a_cluster",
    "archives_elsewhere",
    "paper_in_one_page",
]


def order(file: str) -> int:
    """The place of an example in the gallery; one that is not named in ORDER is an error."""
    return ORDER.index(Path(file).stem)
