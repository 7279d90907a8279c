"""What means over the speed can tell and cannot, in words for the page and the terminal."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from apesim.studies.gap.report.comparison import find_display
from apesim.studies.gap.report.rounding import round_to_error
from apesim.studies.gap.report.words import format_name

if TYPE_CHECKING:
    from apesim.studies.gap.report.comparison import ComparedSignal
    from apesim.studies.gap.report.engine_curve import EngineCurve

MAX_NAMED = 4
"""Effects that a sentence names: more would not be read."""


def write_misses(curves: "Sequence[EngineCurve]", added: str) -> str:
    """The largest error of each mean in words: of the machine file as it is, calibrated, and with what was added."""
    by_sensor: dict[str, list[EngineCurve]] = {}
    for curve in curves:
        by_sensor.setdefault(curve.sensor, []).append(curve)
    stated, before, after = [], [], []
    for own in by_sensor.values():
        points = [point for curve in own for point in curve.points]
        at_points = [np.interp(_list_speeds(curve), curve.speeds, curve.stated) for curve in own]
        stated.append(_format_miss(points, np.concatenate(at_points)))
        before.append(_format_miss(points, [point.before[0] for point in points]))
        after.append(_format_miss(points, [np.nan if point.after is None else point.after[0] for point in points]))
    said = f"As the machine file is, the model misses {' and '.join(stated)}; calibrated, {' and '.join(before)}"
    return f"{said}; {added}, {' and '.join(after)}." if added else f"{said}."


def _list_speeds(curve: "EngineCurve") -> list[float]:
    """Speeds of the measured points of a curve [rad/s]."""
    return [point.block.run.speed for point in curve.points]


def _format_miss(points: "Sequence[ComparedSignal]", values: Iterable[float] | np.ndarray) -> str:
    """The largest error of a mean, of values [SI] less what was measured, in words; NaN among them is passed over."""
    shown = find_display(points[0].block)
    errors = [shown.convert(value - point.block.values[0]) for value, point in zip(values, points, strict=True)]
    largest = max((abs(error) for error in errors if np.isfinite(error)), default=np.nan)
    size = round_to_error(float(largest), float(shown.convert(points[0].noise)))
    return f"{shown.name} by up to {size} {shown.unit}"


def write_reach(data: Mapping[str, Any], means: int) -> str:
    """What these data can tell: how well so many `means` that were fitted hold the calibration, and which effects show.

    `data` is the content of ``verdict.json``.

    >>> shown, hidden = {"limit": 2.0, "class": []}, {"limit": None, "class": []}
    >>> alike = {"limit": 2.0, "class": ["friction_torque"]}
    >>> limits = {"blow_by": shown, "exhaust_back_pressure": alike, "bounce": hidden, "engine.bore": hidden}
    >>> print(write_reach({"detection_limits": limits, "nuisances": [{}] * 13}, 8))  # doctest: +NORMALIZE_WHITESPACE
    The calibration fits 13 uncertain numbers to 8 means over the cycle; it may go through nearly all of them, and leave
    less than the noise. What happens within a cycle is in a mean as a sum only: of 3 effects these data would show 2,
    of these 1 distinguishable from all others, and 1 at no size within its range.
    """
    effects = [limit for name, limit in data["detection_limits"].items() if "." not in name]
    seen = [limit for limit in effects if limit["limit"] is not None]
    alone = sum(not limit["class"] for limit in seen)
    numbers = len(data["nuisances"])
    through = "" if numbers < means else "; it may go through nearly all of them, and leave less than the noise"
    return (
        f"The calibration fits {numbers} uncertain numbers to {means} means over the cycle{through}. What happens "
        f"within a cycle is in a mean as a sum only: of {len(effects)} effects these data would show {len(seen)}, "
        f"of these {alone} distinguishable from all others, and {len(effects) - len(seen)} at no size within its range."
    )


def write_trace(data: Mapping[str, Any]) -> list[str]:
    """The one trace that would tell most, and what it would tell; [] where none would, or where there are traces.

    `data` is the content of ``verdict.json``.

    >>> trace = {"text": "the run at 400 r/min again, with lift measured", "settled": 0.756, "shown": [], "hinted": []}
    >>> print(*write_trace({"next_test": {"trace": trace}}))  # doctest: +NORMALIZE_WHITESPACE
    One trace would tell most: the run at 400 r/min again, with lift measured. It is expected to settle 76 % of what is
    open.
    >>> trace |= {"settled": None, "shown": ["bounce", "blow_by"], "hinted": ["blow_by"], "unclear": [*"123"]}
    >>> print(*write_trace({"next_test": {"trace": trace}}))  # doctest: +NORMALIZE_WHITESPACE
    One trace would tell most: the run at 400 r/min again, with lift measured. It would show, and distinguish from
    others, 2 of the 3 effects that these data leave unclear, among them blow by, to which they point.
    """
    trace = data["next_test"].get("trace")
    if not trace:
        return []
    said = f"One trace would tell most: {trace['text']}."
    if trace["settled"] is not None:
        return [f"{said} It is expected to settle {100.0 * trace['settled']:.0f} % of what is open."]
    named = " and ".join(map(format_name, trace["hinted"][:MAX_NAMED]))
    return [
        f"{said} It would show, and distinguish from others, {len(trace['shown'])} of the {len(trace['unclear'])} "
        f"effects that these data leave unclear{f', among them {named}, to which they point' if named else ''}."
    ]
