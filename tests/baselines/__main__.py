"""``python -m tests.baselines rms|aic|bic|sindy gap explain CASE --machine FILE --out OUT [--without NAME]...``

Writes a ``verdict.json`` as `apesim gap explain` does, so that the blind benchmark scores it alike.
"""

import argparse
import json
from math import exp
from pathlib import Path
from time import perf_counter

from apesim.engine.machine import Machine
from apesim.studies.gap.search.library import select_effects
from apesim.studies.measured import read_measured

from .fits import one_parameter_fits
from .selection import select_by_bic
from .sparse import missing_force

NORMAL_95 = 1.959963984540054


def by_fit(machine, measured, effects, akaike):
    """Verdict of the best one-parameter fit."""
    base, rows = one_parameter_fits(machine, measured, effects)
    cost, name, parameter, x, deviation = rows[0]
    criteria = [base, *(row[0] + 2.0 for row in rows)]
    if akaike and base < cost + 2.0:
        return {
            "verdict": "NO_GAP",
            "alarm": False,
            "effects": [],
            "probability": weight(base, criteria),
        }
    value, half = (parameter.shown(size) for size in (parameter.value(x), parameter.scale * NORMAL_95 * deviation))
    named = {
        "name": name,
        "parameter": parameter.key.split(".")[-1],
        "value": value,
        "unit": parameter.declaration.unit,
        "interval_95": [value - half, value + half],
    }
    probability = weight(cost + 2.0, criteria) if akaike else None
    return {"verdict": "NAMED", "alarm": True, "effects": [named], "probability": probability}


def by_selection(machine, measured, effects):
    """Verdict of a forward selection by BIC, all nuisances free."""
    best, tried, nuisances = select_by_bic(machine, measured, effects)
    rows = []
    for number, one in enumerate(best.effects, len(nuisances)):
        parameter, half = one.strengths[0], NORMAL_95 * best.deviation[number]
        ends = (parameter.shown(parameter.value(best.x[number] + way * half)) for way in (-1.0, 0.0, 1.0))
        low, value, high = ends
        row = {"name": one.name, "parameter": parameter.key.split(".")[-1], "value": value}
        rows.append(row | {"unit": parameter.declaration.unit, "interval_95": sorted([low, high])})
    return {
        "verdict": ("NO_GAP", "NAMED", "TWO_EFFECTS", "SEVERAL")[len(rows)],
        "alarm": bool(rows),
        "effects": rows,
        "probability": weight(best.bic, [model.bic for model in tried]),
    }


def weight(own, all_of_them):
    """Akaike's weight, which the method takes for the probability of a model."""
    return 1.0 / sum(exp(min(0.5 * (own - other), 700.0)) for other in all_of_them)


def by_sparse_regression(machine, measured):
    """Verdict of the largest missing force."""
    found = missing_force(machine, measured)
    if not found:
        return {"verdict": "REFUSED", "alarm": False, "effects": [], "probability": None}
    named = [{"name": found[0][0], "parameter": "", "value": found[0][1], "unit": "N", "interval_95": [0.0, 0.0]}]
    return {"verdict": "NAMED", "alarm": True, "effects": named, "probability": None}


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.baselines")
    parser.add_argument("method", choices=["rms", "aic", "bic", "sindy"])
    parser.add_argument("words", nargs=2, help="gap explain")
    parser.add_argument("case")
    parser.add_argument("--machine", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--without", action="append", default=[])
    given = parser.parse_args()
    started = perf_counter()
    machine = Machine.load(given.machine, ())
    measured = read_measured(given.case, machine.ambient.pressure)
    effects = select_effects(measured.bench, given.without)
    if given.method == "sindy":
        verdict = by_sparse_regression(machine, measured)
    elif given.method == "bic":
        verdict = by_selection(machine, measured, effects)
    else:
        verdict = by_fit(machine, measured, effects, given.method == "aic")
    verdict |= {"wall_time_s": perf_counter() - started}
    out = Path(given.out)
    out.mkdir(parents=True, exist_ok=True)
    (out / "verdict.json").write_text(json.dumps(verdict))


if __name__ == "__main__":
    main()
