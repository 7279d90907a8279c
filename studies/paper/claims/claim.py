"""What a claim of the paper is, how it is judged, and the map of the valve that many claims are about."""

from collections.abc import Sequence
from enum import StrEnum
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Archive

AREA = "valve.solenoid.effective_area"
"""What the paper does not print and many of its claims hang on."""


class Verdict(StrEnum):
    """Verdict on a claim; its text is what readers and ``claims.json`` are given."""

    REPRODUCED = "reproduced"
    CONTRADICTED = "contradicted"
    NOT_COMPUTABLE = "not computable"


REPRODUCED, CONTRADICTED, NOT_COMPUTABLE = Verdict
"""Verdicts, by their names."""


class Claim(NamedTuple):
    """A claim of the paper beside the model's answer."""

    key: str
    """Name in ``claims.json``."""
    where: str
    """Place in the paper."""
    claim: str
    paper: str
    """Its number or trend."""
    ours: str
    """The model's number or trend."""
    values: dict[str, Any]
    """The model's numbers, SI unless the name says otherwise."""
    verdict: Verdict
    """Verdict on the valve of `judged_on`; on another than the paper's it says whether that one does the same."""
    remark: str
    """How it was judged, and what to know of it."""
    judged_on: str = ""
    """Whose valve, see `apesim.studies.paper.subject`."""
    depends_on: tuple[str, ...] = ()
    """Names of what the paper does not print and what turns the verdict within `range`."""
    range: dict[str, Any] | None = None
    """Verdicts over what the paper does not print, see `range_of`; None: they do not hang on it, or were not tried."""


class Grid(NamedTuple):
    """The paper's map, as arrays over gauge pressure and temperature."""

    pressure: np.ndarray
    """[Pa gauge], shape (n,)"""
    temperature: np.ndarray
    """[K], shape (m,)"""
    opening: dict[str, np.ndarray]
    """Measures of the opening by name, shape (n, m)."""
    closing: dict[str, np.ndarray]
    """Measures of the closing by name, shape (n, m)."""


def grid_of(archive: Archive, ambient_pressure: float) -> Grid:
    """Grid of a valve map, see `apesim.studies.limit.valve_map.compute_map`; `ambient_pressure` is in Pa abs."""
    v = {name: variable.values for name, variable in archive.variables.items()}
    pressure, temperature = np.unique(v["supply_pressure"]), np.unique(v["supply_temperature"])
    shape = (len(pressure), len(temperature))
    measures = ("delay_s", "stroke_time_s", "seating_speed_m_s", "fluctuation", "reverses")
    strokes = [{name: v[f"{stroke}_{name}"].reshape(shape) for name in measures} for stroke in ("opening", "closing")]
    return Grid(pressure - ambient_pressure, temperature, *strokes)


def verdict_of(holds: bool | np.bool_) -> Verdict:
    """Verdict of a claim that was computed: `REPRODUCED` where it holds, else `CONTRADICTED`."""
    return REPRODUCED if holds else CONTRADICTED


def range_of(name: str, unit: str, tried: Sequence[float], claims: Sequence[Claim]) -> dict[str, Any]:
    """Collect verdicts and answers of a claim, judged over something that the paper does not print.

    `name` is the key of what is varied, as a machine file names it; `tried` are its values in `unit`, ascending, with
    one of `claims` for each. The dict has ``name``, ``unit``, ``tried``, ``verdicts`` and ``answers``.
    """
    verdicts, answers = ([getattr(claim, field) for claim in claims] for field in ("verdict", "ours"))
    return {"name": name, "unit": unit, "tried": list(tried), "verdicts": verdicts, "answers": answers}


def with_range(claim: Claim, verdicts: dict[str, Any]) -> Claim:
    """A claim with its verdicts over what the paper does not print, see `range_of`.

    >>> claim = Claim("rebound", "Fig. 9", "The piston rebounds.", "rebounds", "in 3 strokes", {}, REPRODUCED, "")
    >>> turned = claim._replace(verdict=CONTRADICTED)
    >>> with_range(claim, range_of(AREA, "mm^2", [4.0, 9.0], [claim, turned])).depends_on
    ('valve.solenoid.effective_area',)
    """
    turns = len(set(verdicts["verdicts"])) > 1
    return claim._replace(
        range=verdicts, depends_on=(*claim.depends_on, verdicts["name"]) if turns else claim.depends_on
    )


def range_in_words(claim: Claim) -> str:
    """Say which verdict holds where: ``3-12.5 mm²``, or ``contradicted: 3-7 mm²; reproduced: 7.5-8 mm²``.

    It is "-" where the claim was not tried over anything.
    """
    if claim.range is None:
        return "-"
    unit = {"mm^2": " mm²", "deg": "° window"}[claim.range["unit"]]
    spans: dict[str, list[str]] = {}
    for verdict, group in groupby(zip(claim.range["verdicts"], claim.range["tried"], strict=True), itemgetter(0)):
        values = [value for _, value in group]
        spans.setdefault(verdict, []).append("-".join(f"{value:g}" for value in dict.fromkeys((values[0], values[-1]))))
    lists = {verdict: f"{', '.join(texts)}{unit}" for verdict, texts in spans.items()}
    return lists.popitem()[1] if len(lists) == 1 else "; ".join(f"{verdict}: {text}" for verdict, text in lists.items())
