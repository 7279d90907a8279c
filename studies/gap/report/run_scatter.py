"""Scatter between runs, as data and in words."""

from collections.abc import Mapping
from typing import Any

from apesim.engine.stated_uncertainties import format_known_to, name_key
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.estimation.residuals import WhitenedResiduals

MIN_SIGMAS = 0.01
"""Prior standard deviations from which a scatter is worth a mention."""


def describe_scatter(residuals: WhitenedResiduals) -> list[dict[str, Any]]:
    """Describe what differs from run to run, as the user states it or as repeats show it; [] where nothing does.

    ``key`` is as ``[known_to]`` has it, ``deviation`` is a text; ``differences``, how many of repeats tell it, is None
    where the user states it. `residuals` are those of the calibrated machine.
    """
    scatter, known = residuals.scatter, {p.key: p for p in residuals.parameters}
    if scatter is None:
        return []
    return [
        {
            "key": name_key(key),
            "deviation": format_known_to(
                key, Uncertainty(float(f"{size * known[key].scale:.2g}"), known[key].relative)
            ),
            "differences": None if key in scatter.stated else scatter.contrasts,
        }
        for key, size in zip(scatter.keys, scatter.sizes, strict=True)
        if size > MIN_SIGMAS
    ]


def write_scatter(data: Mapping[str, Any]) -> list[str]:
    """Write what differs from run to run, by ``verdict.json``, as sentences; [] where runs do not scatter.

    >>> rows = [{"key": "valve.viscous_friction", "deviation": "3 %", "differences": 4}]
    >>> write_scatter({"scatter": rows})
    ['Repeats differ by more than noise, counted as scatter: valve.viscous_friction 3 %, by 4 differences.']
    >>> write_scatter({"scatter": [rows[0] | {"differences": None}]})
    ['Runs scatter, as is stated: valve.viscous_friction 3 %.']
    """
    stated, told = ([row for row in data["scatter"] if (row["differences"] is None) is way] for way in (True, False))
    found = [f"Runs scatter, as is stated: {_list(stated)}."] if stated else []
    if told:
        number = told[0]["differences"]
        by = f"by {number} difference{'s' * (number > 1)}"
        found.append(f"Repeats differ by more than noise, counted as scatter: {_list(told)}, {by}.")
    return found


def _list(rows: list[dict[str, Any]]) -> str:
    return ", ".join(f"{row['key']} {row['deviation']}" for row in rows)
