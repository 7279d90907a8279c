"""Lines of a map of limits: over pressure, and the machine's own point."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from apesim.studies.drawing.panels import gauge_in_mpa
from apesim.studies.drawing.style import RED, STYLES, Look, looks_of
from apesim.studies.limit.points import own_run

OWN_POINT: Look = {"marker": "*", "ls": "", "color": RED, "ms": 11}
"""Look of the machine's own point."""


def draw_over_pressure(
    axis: Axes,
    v: Mapping[str, np.ndarray],
    column: str,
    *,
    parameter: str,
    label: str,
    ambient_pressure: float,
) -> None:
    """Draw a column over gauge pressure, a colour for each value of a parameter, a style for each temperature.

    `v` holds columns over runs, (n,), among them ``supply_pressure`` [Pa abs] and ``supply_temperature`` [K];
    `parameter` names the one that chooses the colour. `label` has a place for its value, e.g. "duty {:g}";
    `ambient_pressure` is in [Pa abs].

    >>> from apesim.studies.drawing.panels import open_one
    >>> v = {"supply_pressure": np.array([0.6e6, 1.1e6]), "supply_temperature": np.array([287.0, 287.0])}
    >>> v |= {"duty": np.array([0.5, 0.5]), "limit_hz": np.array([22.0, 30.0])}
    >>> _, axis = open_one()
    >>> draw_over_pressure(axis, v, "limit_hz", parameter="duty", label="duty {:g}", ambient_pressure=0.1e6)
    >>> axis.lines[0].get_label(), axis.lines[0].get_xdata().tolist()
    ('duty 0.5, 287 K', [0.5, 1.0])
    """
    pressure = gauge_in_mpa(v["supply_pressure"], ambient_pressure)
    temperatures, values = np.unique(v["supply_temperature"]), np.unique(v[parameter])
    for value, own in zip(values, looks_of(len(values)), strict=True):
        for number, temperature in enumerate(temperatures):
            chosen = (v[parameter] == value) & (v["supply_temperature"] == temperature)
            look: Look = own | {"ls": STYLES[number % len(STYLES)], "ms": 3.5}
            axis.plot(pressure[chosen], v[column][chosen], label=f"{label.format(value)}, {temperature:g} K", **look)


def draw_own_point(axis: Axes, v: Mapping[str, np.ndarray], column: str, *, ambient_pressure: float, more: str) -> None:
    """Draw the machine's own point of a map of limits as a star; `more` is its window or duty in the legend.

    `v` holds columns over runs, (n,); `ambient_pressure` is in [Pa abs].

    >>> from apesim.studies.drawing.panels import open_one
    >>> from apesim.studies.limit.points import Point
    >>> v = {"point": np.array([Point.GRID, Point.OWN]), "supply_pressure": np.array([0.6e6, 1.1e6])}
    >>> v |= {"supply_temperature": np.array([250.0, 287.0]), "limit_hz": np.array([22.0, 30.0])}
    >>> _, axis = open_one()
    >>> draw_own_point(axis, v, "limit_hz", ambient_pressure=0.1e6, more="duty 0.2")
    >>> axis.lines[0].get_xydata().tolist()
    [[1.0, 30.0]]
    """
    own = own_run(v)
    pressure = gauge_in_mpa(v["supply_pressure"][own], ambient_pressure)
    label = f"the machine's own: {more}, {v['supply_temperature'][own]:g} K"
    axis.plot(pressure, v[column][own], label=label, **OWN_POINT)
