"""Largest deviations from the independent solutions printed in tests/acceptance/reference-valve.csv and -engine.csv."""

import numpy as np

from docs.results import Number, Table
from tests.acceptance import reference_tables as printed

HEADS = ["result", "numbers", "largest deviation", "half of the last printed digit", "beyond that half", "unit"]


def compute():
    """Deviations of each column, and the largest of all, with and without what the print's rounding explains."""
    values = {}
    for name, rows, results in (
        ("valve", printed.VALVE_ROWS, printed.valve_results),
        ("engine", printed.ENGINE_ROWS, printed.engine_results),
    ):
        lines, largest = [], {"": 0.0, "_angle": 0.0}
        for column, deviations, halves in printed.deviations(rows, results):
            kind = "_angle" if "[deg]" in column else ""
            factor, unit = (1e4, "10⁻⁴ °") if kind else (1e6, "10⁻⁶")
            beyond = np.maximum(deviations - halves, 0.0).max()
            cells = [Number(factor * float(part), error=0.05) for part in (deviations.max(), halves.max(), beyond)]
            lines.append([column.split(" [")[0], Number(len(deviations)), *cells, unit])
            largest[kind] = max(largest[kind], float(beyond))
        values[f"{name}_columns"] = Table(HEADS, lines)
        values[f"{name}_rows"] = Number(len(rows))
        values[f"{name}_numbers"] = Number(sum(int(line[1].value) for line in lines))
        values[f"{name}_beyond"] = Number(1e6 * largest[""], "·\u00a010⁻⁶", error=0.05)
        if largest["_angle"]:
            values[f"{name}_beyond_angle"] = Number(1e3 * largest["_angle"], "·\u00a010⁻³ °", error=0.05)
    return values
