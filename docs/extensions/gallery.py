"""The gallery: order of the examples, and what has to be quiet while they run."""

import os
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


def prepare(_conf: dict, _file: str) -> None:
    """Make every example start as a fresh process does: figures as Matplotlib has them, no output in colours."""
    import matplotlib

    matplotlib.rcdefaults()
    matplotlib.use("Agg", force=True)
    matplotlib.rcParams.update({"figure.dpi": 110, "savefig.dpi": 110})
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
