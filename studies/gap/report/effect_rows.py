"""What is said of each parameter that a model adds: its value, and the interval that the data leave it."""

import numpy as np

from apesim.studies.estimation.parameters import DECLARED, corrections, shown
from apesim.studies.estimation.profile_likelihood import End, EndKind
from apesim.studies.gap.search.candidates import SHAPES
from apesim.studies.gap.search.intervals import shaped

NORMAL_95 = 1.959963984540054
LOW, HIGH = SIDES = "low", "high"
"""Sides of an interval."""


def effects_of(model):
    """Parameters of the effects that a model adds, or of the nuisance that it frees, with their intervals.

    Returns
    -------
    list of dict
        ``interval_95`` is None where it was not sought; ``open_ends`` says on which sides the data do not hold the
        parameter: there the interval ends at the end of its range.
    """
    machine, runs, rows = model.residuals.machine, model.residuals.runs, []
    for j, (parameter, x) in enumerate(zip(model.residuals.parameters, model.fitted.x, strict=True)):
        if parameter.prior:
            continue
        ends = ends_of(model, j)
        if not model.identifiable[j] and all(end.is_open for end in ends):
            continue
        said = corrections(machine, parameter, x, runs)
        key, value = next(iter(said.items()))
        declared = parameter.declaration if key == parameter.key else DECLARED[key]
        interval = sorted((corrections(machine, parameter, end.at, runs)[key], end.is_open) for end in ends)
        rows.append(
            {
                "name": parameter.key.split(".")[1] if parameter.key.startswith("effects.") else parameter.key,
                "parameter": key.split(".")[-1],
                "key": key,
                "value": shown(declared, value),
                "unit": declared.unit,
                "interval_95": [shown(declared, end) for end, _ in interval] or None,
                "open_ends": [side for side, (_, is_open) in zip(SIDES, interval, strict=False) if is_open],
                "text": declared.render(value),
            }
        )
    return rows


def ends_of(model, j):
    """Both ends of a parameter's 95 % interval, in x.

    Returns
    -------
    sequence of apesim.studies.estimation.profile_likelihood.End
        By profile likelihood where the effect has a shape, none where that was not sought; else by the curvature, where
        a parameter on which the data do not depend is held on neither side.
    """
    parameter = model.residuals.parameters[j]
    if any(j in numbers for numbers in shaped(model)):
        return (model.profiles or {}).get(parameter.key, ())
    x, half = model.fitted.x, NORMAL_95 * np.sqrt(model.fitted.covariance[j, j])
    if not model.identifiable[j]:
        half = np.inf
    ends = np.clip([x[j] - half, x[j] + half], parameter.low, parameter.high)
    is_inside = parameter.low <= x[j] - half, x[j] + half <= parameter.high
    kinds = [EndKind.FROM_CURVATURE if inside else EndKind.FROM_CURVATURE_OPEN for inside in is_inside]
    return [End(end, kind, x) for end, kind in zip(ends, kinds, strict=True)]


def value_text(row):
    """The value of a row of `effects_of`; of a shape that is held on one side only, that side, on neither, ""."""
    if row["open_ends"] and row["parameter"] in SHAPES.get(row["name"], ()):
        return _held_side(row, 3)
    return _number(row["value"], row["unit"], 3)


def interval_text(row, digits=3):
    """What a row of `effects_of` says of its interval."""
    if row["interval_95"] is None:
        return "interval not sought"
    if row["open_ends"]:
        held = _held_side(row, digits)
        return f"{held} (95 %)" if held else "not held by these data"
    low, high = row["interval_95"]
    return f"95 % interval {low:.{digits}g} to {_number(high, row['unit'], digits)}"


def _held_side(row, digits):
    """The end of an interval that the data hold; "" where there is none."""
    if len(row["open_ends"]) == len(SIDES):
        return ""
    low, high = (_number(end, row["unit"], digits) for end in row["interval_95"])
    return f"at most {high}" if LOW in row["open_ends"] else f"at least {low}"


def _number(value, unit, digits):
    return f"{value:.{digits}g} {unit}".rstrip()
