"""Thresholds of the search for a missing effect, as the code has them."""

import ast
from math import exp
from pathlib import Path

from apesim.studies.estimation import calibration, model, scatter_sizes
from apesim.studies.estimation.heavy_tails import find_pull
from apesim.studies.gap import thresholds
from apesim.studies.gap.decide.reliability import FEATURES, load_reliability
from apesim.studies.gap.search import gap_test, model_selection, run_faults
from docs.results import Number, Table

LIVE = True

PERCENT = ("ALARM", "MIN_REMOVED", "MAX_LEFT", "TERM_CHANCE", "DOUBTFUL")


def compute():
    """Each threshold by its name in lower case, further numbers of the search, and all of them as a table."""
    values = {"all": list_thresholds()}
    for name, value in vars(thresholds).items():
        if name.isupper() and isinstance(value, float):
            shown = Number(100.0 * value, "%") if name in PERCENT else Number(round(value, 1 if value > 1.0 else 3))
            values[name.lower()] = shown
    values["odds"] = Number(round(exp(0.5 * thresholds.AMBIGUOUS_COST)))
    values["table_odds"] = Number(round(exp(0.5 * thresholds.TABLE_MARGIN)))
    for name, value in {
        "draws": gap_test.DRAWS,
        "singles": model_selection.MAX_SINGLES,
        "large": model_selection.MAX_LARGE,
        "min_sets": model_selection.MIN_SETS,
        "max_sets": model_selection.MAX_SETS,
        "faults": model_selection.MAX_FAULTS,
        "files": run_faults.MIN_FILES,
        "most_corrected": thresholds.MAX_CORRECTED,
        "max_pull": model.MAX_PULL,
        "negligible": model_selection.NEGLIGIBLE,
        "starts": calibration.STARTS,
        "windows": thresholds.WINDOWS,
    }.items():
        values[name] = Number(value)
    values["min_foreseen"] = Number(100.0 * model_selection.MIN_FORESEEN, "%")
    values["cost_of_six"] = Number(round(float(find_pull(6.0)) ** 2, 1))
    told = load_reliability()
    values["sealed_cases"] = Number(told["cases"].get("number", 0))
    values["reliability"] = list_reliability(told["kinds"])
    values["odd_chance"] = Number(100.0 * scatter_sizes.ODD_CHANCE, "%")
    return values


def list_thresholds():
    """The file of thresholds: name, value and reason."""
    tree = ast.parse(Path(thresholds.__file__).read_text())
    rows = []
    for node, reason in zip(tree.body, tree.body[1:], strict=False):
        if isinstance(node, ast.Assign):
            target = node.targets[0]
            names = [name.id for name in (target.elts if isinstance(target, ast.Tuple) else [target])]
            shown = ", ".join(f"{getattr(thresholds, name):.3g}" for name in names)
            text = " ".join(ast.literal_eval(reason.value).split()).split(", see `")[0].rstrip(".")
            rows.append([", ".join(f"`{name}`" for name in names), shown, f"{text}."])
    return Table(["threshold", "value", "what it is, and why it has this value"], rows)


def list_reliability(kinds):
    """What sealed cases tell of each kind of statement, and by what its log odds grow."""
    rows = [
        [kind, Number(counted["statements"]), Number(counted["right"]), *list_slopes(counted["slopes"])]
        for kind, counted in kinds.items()
    ]
    return Table(["statement", "made", "right", *(f"`{name}`" for name in FEATURES)], rows)


def list_slopes(slopes):
    """Slopes of a kind of statement, in the order of the features; 0 where one says nothing of it."""
    return [Number(round(slopes[name], 2)) for name in FEATURES]
