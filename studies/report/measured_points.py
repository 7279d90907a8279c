"""Measured points over the curves of a page: what a dynamometer gave at each speed."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isnan

import numpy as np

from apesim.air import ANR_DENSITY
from apesim.engine.angles import RPM
from apesim.engine.indicators import JOULE_PER_KWH
from apesim.quantities import Fault, InputError
from apesim.studies.measured import ENGINE, Measured, MeasuredRun
from apesim.studies.report.figures.curves import Curves, Line
from apesim.studies.report.figures.labels import format_number
from apesim.studies.report.sections import Content, Figure

LOOK = 4
"""Number of colour and marker of the first measured points: behind those of the four actuations."""
SAME_PRESSURE = 0.02
"""Share within which supply pressures are of one curve: the supply of a bench sags as the engine draws more."""


def find_means(run: MeasuredRun) -> dict[str, float]:
    """Numbers of a measured run by the variables that figures draw, in their shown units; those that can be known."""
    torque, air = (run.means.get(name, np.nan) for name in ("torque", "air_flow"))
    power = torque * run.speed
    numbers = {
        "brake_torque_Nm": torque,
        "brake_power_W": 1e-3 * power,
        "air_L_per_min_ANR": 6e4 * air / ANR_DENSITY,
        "specific_air_kg_per_kWh": JOULE_PER_KWH * air / power if power > 0.0 else np.nan,
    }
    return {name: value for name, value in numbers.items() if not isnan(value)}


def add_measured(content: Content, measured: Measured) -> Content:
    """Add measured means to the figures over the speed; raises InputError where there is nothing, or no such figure."""
    groups = group_by_supply(measured)
    if not groups:
        right = 'give a folder of bench = "engine" whose runs have torque or air_flow'
        raise InputError([Fault(measured.folder, "", "holds no means of an engine over its speed", right)])
    names = {name for runs in groups.values() for run in runs for name in find_means(run)}
    if not any(_is_over_speed(figure, names) for section in content.sections for figure in section.figures):
        wrong, right = "has nothing to be drawn over", "give the archive of apesim engine sweep over the speed"
        raise InputError([Fault(measured.folder, "", wrong, right)])
    sections = [
        replace(section, figures=[_add_points(figure, groups, names) for figure in section.figures])
        for section in content.sections
    ]
    return replace(content, sections=sections)


def group_by_supply(measured: Measured) -> dict[str, list[MeasuredRun]]:
    """Runs with means by the label of their points: measured, with the supply pressure where there are several."""
    if measured.bench != ENGINE:
        return {}
    groups: list[list[MeasuredRun]] = []
    for run in sorted((run for run in measured.runs if find_means(run)), key=lambda run: run.supply):
        if groups and run.supply <= (1.0 + SAME_PRESSURE) * groups[-1][0].supply:
            groups[-1].append(run)
        else:
            groups.append([run])
    pressures = [format_number(1e-6 * float(np.mean([run.supply for run in runs])), 3) for runs in groups]
    return {f"measured, {pressure} MPa abs": runs for pressure, runs in zip(pressures, groups, strict=True)}


def _is_over_speed(figure: Figure, names: set[str]) -> bool:
    """Whether a figure draws one of some variables over the speed."""
    return isinstance(figure, Curves) and figure.name in names and figure.x.label == "speed"


def _add_points(figure: Figure, groups: Mapping[str, Sequence[MeasuredRun]], names: set[str]) -> Figure:
    """Add the points of each supply pressure to a figure over the speed."""
    if not (isinstance(figure, Curves) and _is_over_speed(figure, names)):
        return figure
    lines = []
    for look, (label, runs) in enumerate(groups.items(), LOOK):
        points = sorted(
            (run.speed / RPM, value) for run in runs for name, value in find_means(run).items() if name == figure.name
        )
        if points:
            speeds, values = np.array(points).T
            lines.append(Line(label, [values], [separate(speeds)], look, has_line=False))
    return replace(figure, lines=[*figure.lines, *lines])


def separate(places: np.ndarray) -> np.ndarray:
    """Move places that are the same apart by what no one sees, so that each keeps its point; they ascend.

    >>> bool(np.all(np.diff(separate(np.array([600.0, 600.0, 900.0]))) > 0.0))
    True
    """
    apart = places.astype(float)
    for k in range(1, len(apart)):
        apart[k] = max(apart[k], np.nextafter(apart[k - 1], np.inf))
    return apart
