"""What a claim of the paper is, how it is judged, and the map of the valve that many claims are about."""

from typing import NamedTuple

import numpy as np

REPRODUCED, CONTRADICTED, CALIBRATED, NOT_COMPUTABLE = "reproduced", "contradicted", "calibrated", "not computable"


class Claim(NamedTuple):
    """A claim of the paper beside the model's answer."""

    key: str
    where: str
    """In the paper."""
    claim: str
    paper: str
    """Its number or trend."""
    ours: str
    """The model's."""
    values: dict
    """The model's numbers, SI unless the name says otherwise."""
    verdict: str
    """On `judged_on`: of another valve than the paper's, it says whether that one does the same."""
    remark: str
    judged_on: str = ""
    """Whose valve, see `studies.paper.subject`."""


class Grid(NamedTuple):
    """The paper's map, as arrays over gauge pressure and temperature."""

    pressure: np.ndarray
    """[Pa gauge], shape (n,)"""
    temperature: np.ndarray
    """[K], shape (m,)"""
    opening: dict
    """By measure, shape (n, m)."""
    closing: dict


def grid_of(archive, ambient_pressure):
    """The grid of a valve map.

    Parameters
    ----------
    archive : Archive
        See `studies.valve_map.map_valve`.
    ambient_pressure : float
        [Pa abs]

    Returns
    -------
    Grid
    """
    v = {name: variable.values for name, variable in archive.variables.items()}
    pressure, temperature = np.unique(v["supply_pressure"]), np.unique(v["supply_temperature"])
    shape = (len(pressure), len(temperature))
    measures = ("delay_s", "stroke_time_s", "seating_speed_m_s", "fluctuation", "reverses")
    strokes = [{name: v[f"{stroke}_{name}"].reshape(shape) for name in measures} for stroke in ("opening", "closing")]
    return Grid(pressure - ambient_pressure, temperature, *strokes)


def verdict_of(holds):
    """Reproduced or contradicted."""
    return REPRODUCED if holds else CONTRADICTED
