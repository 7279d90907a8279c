"""The exergy ledger of a cycle beside an independent solution: 1000 r/min, 1.0 MPa gauge, receiver of 1 L."""

from docs.results import Number, Table
from tests.acceptance.exergy_table import COLUMNS, EXPECTED, exergy_terms

HEADS = {
    "engine_air": "engine air",
    "indicated_work": "indicated work",
    "feed": "feed",
    "groove": "groove",
    "exhaust": "exhaust",
    "mixing": "mixing",
    "control_air": "control air",
}
CASES = {"fixed": "EPV, fixed", "corrected": "EPV, corrected", "cam": "cam", "ideal": "ideal valve"}


def compute():
    """Terms of each intake, ours and theirs, and the largest difference."""
    rows, largest = [], 0.0
    for case, expected in EXPECTED.items():
        found = exergy_terms(case)
        differences = [found[name] - number for name, number in zip(COLUMNS, expected, strict=True)]
        largest = max(largest, *map(abs, differences))
        rows.append([CASES[case], "independent", *(f"{number:.1f}" for number in expected)])
        rows.append(["", "apesim", *(Number(found[name], error=0.05) for name in COLUMNS)])
    return {
        "terms": Table(["intake", "", *(f"{HEADS[name]} [J]" for name in COLUMNS)], rows),
        "largest": Number(largest, "J", error=0.005),
    }
