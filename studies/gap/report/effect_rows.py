"""What is said of each parameter that a model adds: its value, and the interval that the data leave it."""

from collections.abc import Iterator, Sequence
from enum import StrEnum
from typing import Any

import numpy as np

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.parameters import DECLARED, Parameter, corrections, shown, value_of
from apesim.studies.estimation.profile_likelihood import End, EndKind
from apesim.studies.gap.decide.standard_errors import WIDENING, find_standard_errors
from apesim.studies.gap.report.rounding import NORMAL_95, find_error, round_to_error
from apesim.studies.gap.search.file_numbers import list_misstated
from apesim.studies.gap.search.intervals import find_shapes


class Side(StrEnum):
    """A side of an interval."""

    LOW = "low"
    HIGH = "high"


SIDES = tuple(Side)
"""Both sides of an interval, the lower one first."""


def describe_effects(model: Model) -> list[dict[str, Any]]:
    """Parameters of the effects that a model adds, or where there are none of the numbers that it corrects.

    ``interval_95`` is None where it was not sought; ``open_ends`` are the sides on which the data do not hold the
    parameter: there the interval ends at the end of its range. ``file`` is the file of a fault of measurement, None of
    an effect; ``before`` is what the machine file says, None of what it does not; ``misstated`` are numbers of the
    machine file that do the same where they are wrong.
    """
    return _describe(model, _list_added(model) or _list_corrected(model))


def describe_numbers(model: Model) -> list[dict[str, Any]]:
    """Numbers of the machine that a model corrects beside the effects that it adds, with their intervals.

    Rows as `describe_effects` has them: numbers that count as exact first, then those of `Model.corrected`.
    """
    return _describe(model, _list_corrected(model)) if _list_added(model) else []


def describe_pulled(model: Model) -> list[dict[str, Any]]:
    """Numbers of the machine, and readings, that a model pulls beyond `MAX_PULL`, the farthest first.

    Rows as `describe_effects` has them, with what the machine file says as ``before``.
    """
    rows, machine = _describe(model, model.pulled), model.residuals.machine
    declared: list[Any] = [DECLARED[row["key"]] for row in rows]
    said = [each.render(value_of(machine, row["key"])) for each, row in zip(declared, rows, strict=True)]
    return [row | {"before": text} for row, text in zip(rows, said, strict=True)]


def _list_added(model: Model) -> list[int]:
    """Places of the parameters of effects and of faults of files."""
    return [j for j, p in enumerate(model.residuals.parameters) if not p.prior and not p.is_file_number]


def _list_corrected(model: Model) -> list[int]:
    """Places of the numbers of the machine that are wrong: those that count as exact, then those pulled far."""
    return [j for j, p in enumerate(model.residuals.parameters) if p.is_file_number] + model.pulled


def _describe(model: Model, places: Sequence[int]) -> list[dict[str, Any]]:
    """Rows of the parameters at some places, see `describe_effects`."""
    machine, runs, rows = model.residuals.machine, model.residuals.runs, []
    errors = find_standard_errors(model) if places else np.zeros(0)
    for j in places:
        parameter, x = model.residuals.parameters[j], model.fitted.x[j]
        ends = find_ends(model, j, float(errors[j]))
        if not model.identifiable[j] and all(end.is_open for end in ends):
            continue
        key, value = next(iter(corrections(machine, parameter, x, runs).items()))
        declared = parameter.declaration if key == parameter.key else DECLARED[key]
        fault = next((c for c in model.candidates if c.file and parameter in c.parameters), None)
        interval = sorted((corrections(machine, parameter, end.at, runs)[key], end.is_open) for end in ends)
        rows.append(
            {
                "name": str(fault.kind) if fault else name_effect(parameter.key),
                "file": parameter.file or None,
                "parameter": key.split(".")[-1],
                "key": key,
                "value": shown(declared, value),
                "unit": declared.unit,  # type: ignore[union-attr]
                "interval_95": [shown(declared, end) for end, _ in interval] or None,
                "open_ends": [str(side) for side, (_, is_open) in zip(SIDES, interval, strict=False) if is_open],
                "text": declared.render(value),  # type: ignore[union-attr]
                "before": declared.render(parameter.origin) if parameter.is_file_number else None,  # type: ignore[union-attr]
                "misstated": [] if fault else list(_describe_misstated(machine, parameter.key, value)),
            }
        )
    return rows


def _describe_misstated(machine: Machine, key: str, strength: float) -> Iterator[dict[str, str]]:
    """Numbers of the machine file that do the same as an effect where they are wrong, with what they would be."""
    for misstated in list_misstated(machine, MISSTATING[key]) if key in MISSTATING else ():
        number = value_of(machine, misstated.key)
        declared: Any = DECLARED[misstated.key]
        right = float(np.clip(misstated.correct(number, strength), *declared.ends))
        yield {"key": misstated.key, "before": declared.render(number), "text": _render_rounded(declared, right)}


def _render_rounded(declared: Any, value: float) -> str:
    """A value as the machine file would have it, with four digits."""
    return f"{shown(declared, value):.4g} {declared.unit}".strip()


def name_effect(key: str) -> str:
    """The name under which a parameter is reported: that of its effect, or the key of a number of the machine.

    >>> name_effect("effects.side_force.force"), name_effect("valve.stroke")
    ('side_force', 'valve.stroke')
    """
    return key.split(".")[1] if key.startswith("effects.") else key


def find_ends(model: Model, j: int, error: float) -> Sequence[End]:
    """Both ends, in x, of the 95 % interval of a model's j-th parameter; none where they were not sought.

    `error` is its standard deviation in x, of `find_standard_errors`. Where the effect has a shape, the ends come from
    profile likelihood, and what the variance is above that by the curvature comes to their distance in quadrature. A
    parameter on which the data do not depend is held on neither side.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> model = explain_example().best
    >>> low, high = find_ends(model, len(model.fitted.x) - 1, 0.01)
    >>> bool(low.at < model.fitted.x[-1] < high.at), low.is_open
    (True, False)
    """
    parameter, x = model.residuals.parameters[j], model.fitted.x
    if any(j in numbers for numbers in find_shapes(model)):
        above = max(0.0, (error / WIDENING) ** 2 - model.fitted.covariance[j, j]) if model.identifiable[j] else 0.0
        ends = (model.profiles or {}).get(parameter.key, ())
        return [_move_away(end, float(x[j]), NORMAL_95 * np.sqrt(above), parameter) for end in ends]
    half = NORMAL_95 * error if model.identifiable[j] else np.inf
    bounds = np.clip([x[j] - half, x[j] + half], parameter.low, parameter.high)
    is_inside = parameter.low <= x[j] - half, x[j] + half <= parameter.high
    kinds = [EndKind.FROM_CURVATURE if inside else EndKind.FROM_CURVATURE_OPEN for inside in is_inside]
    return [End(bound, kind, x) for bound, kind in zip(bounds, kinds, strict=True)]


def _move_away(end: End, best: float, added: float, parameter: Parameter) -> End:
    """An end of an interval farther from the best value by what is added in quadrature, up to the end of the range."""
    at = best + np.sign(end.at - best) * WIDENING * np.hypot(end.at - best, added)
    kind = end.kind if parameter.low <= at <= parameter.high else EndKind.OPEN
    return end._replace(at=float(np.clip(at, parameter.low, parameter.high)), kind=kind)


MISSTATING = {
    f"effects.{effect.name}.{(effect.strengths or effect.parameters._fields)[0]}": effect  # type: ignore[attr-defined]
    for effect in ALL_EFFECTS
    if effect.search.misstated
}
"""Effects that are errors of numbers of the machine file, by the key of their strength."""
SHAPES = {effect.name: effect.search.shapes for effect in ALL_EFFECTS}
"""Parameters beside the strengths that a fit frees, by name of effect."""


def format_value(row: dict[str, Any]) -> str:
    """The value of a parameter as text, with the digits that its interval leaves; see `describe_effects` for the row.

    A shape that the data hold on one side only is given as that side; "" where they hold neither.
    """
    if row["open_ends"] and row["parameter"] in SHAPES.get(row["name"], ()):
        return _format_held_side(row)
    return _format_number(row, row["value"])


def format_interval(row: dict[str, Any], digits: int | None = None) -> str:
    """The interval of a parameter as text, with the digits that it leaves the value if `digits` is None.

    The row is one of `describe_effects`.

    >>> row = {"value": 3.1, "interval_95": [2.54, 3.75], "unit": "N", "open_ends": []}
    >>> format_interval(row), format_interval(row | {"open_ends": ["low"]})
    ('95 % interval 2.5 to 3.8 N', 'at most 3.8 N (95 %)')
    """
    if row["interval_95"] is None:
        return "interval not sought"
    if row["open_ends"]:
        held = _format_held_side(row, digits)
        return f"{held} (95 %)" if held else "not held by these data"
    low, high = (_format_number(row, end, digits) for end in row["interval_95"])
    return f"95 % interval {low.removesuffix(row['unit']).rstrip()} to {high}"


def _format_held_side(row: dict[str, Any], digits: int | None = None) -> str:
    """The end of an interval that the data hold; "" where there is none."""
    if len(row["open_ends"]) == len(SIDES):
        return ""
    low, high = (_format_number(row, end, digits) for end in row["interval_95"])
    return f"at most {high}" if Side.LOW in row["open_ends"] else f"at least {low}"


def _format_number(row: dict[str, Any], number: float, digits: int | None = None) -> str:
    """A value of a parameter, or an end of its interval, with its unit as text."""
    if len(row["open_ends"]) == len(SIDES):
        digits = 2  # the data hold it on neither side, so that it has no error
    error = find_error(row["value"], row["interval_95"], row["open_ends"])
    text = round_to_error(number, error) if digits is None else f"{number:.{digits}g}"
    return f"{text} {row['unit']}".rstrip()
