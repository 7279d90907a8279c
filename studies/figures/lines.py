"""Lines that several figures have."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.studies.limit.points import own_run


def over_pressure(axis, v, column, parameter, label, ambient_pressure, brightest):
    """Draw a column over gauge pressure, a colour for each value of a parameter, a style for each temperature.

    Parameters
    ----------
    axis : matplotlib.axes.Axes
    v : dict of array
        Columns over runs, among them ``supply_pressure`` and ``supply_temperature``.
    column, parameter : str
    label : str
        With a place for the value of the parameter.
    ambient_pressure : float
        [Pa abs]
    brightest : float
        Of the colours, 0...1.
    """
    pressure = (v["supply_pressure"] - ambient_pressure) / 1e6
    temperatures, values = np.unique(v["supply_temperature"]), np.unique(v[parameter])
    colours = plt.get_cmap("viridis")(np.linspace(0.0, brightest, len(values)))
    styles = ["-", "--", ":", "-."]
    for value, colour in zip(values, colours, strict=True):
        for number, temperature in enumerate(temperatures):
            chosen = (v[parameter] == value) & (v["supply_temperature"] == temperature)
            look = {"color": colour, "ls": styles[number % len(styles)], "marker": "o", "ms": 3}
            axis.plot(pressure[chosen], v[column][chosen], label=f"{label.format(value)}, {temperature:g} K", **look)


def draw_own_point(axis, v, column, ambient_pressure, more=""):
    """Draw the machine's own point of a map of limits as a star; what more is said of it follows in the legend."""
    own = own_run(v)
    pressure = (v["supply_pressure"][own] - ambient_pressure) / 1e6
    axis.plot(pressure, v[column][own], "*", color="#c1440e", ms=11, label=f"the machine's own point{more}")
