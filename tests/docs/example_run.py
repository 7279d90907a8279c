"""Run an example as a fresh process does, and say which figures it makes: ``python example_run.py SCRIPT REPORT``."""

import json
import runpy
import sys

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.category import UnitData
from matplotlib.ticker import FixedFormatter, NullFormatter

COLOURBAR = "<colorbar>"
"""Label that matplotlib gives the axes of a colour bar."""


def has_categories(axis: Axis) -> bool:
    """Tell whether the ticks of an axis say what they stand for: names, or none at all."""
    named = isinstance(axis.get_major_formatter(), FixedFormatter | NullFormatter)
    return named or isinstance(axis.get_units(), UnitData) or not len(axis.get_ticklocs())


def label_of(axes: Axes, name: str) -> str | None:
    """Label of an axis, "x" or "y", or of one that shares its scale; None where the axis needs none."""
    axis = getattr(axes, f"{name}axis")
    if not axes.axison or not axis.get_visible() or has_categories(axis):
        return None
    alike = [axis] + [
        getattr(other, f"{name}axis") for other in getattr(axes, f"get_shared_{name}_axes")().get_siblings(axes)
    ]
    return next((each.label.get_text() for each in alike if each.label.get_text()), "")


def labels_of(axes: Axes) -> list[str]:
    """Labels of both axes that need one; a colour bar has one in all."""
    labels = [label for name in "xy" if (label := label_of(axes, name)) is not None]
    if axes.get_label() == COLOURBAR or axes not in axes.figure.axes:
        return [next(filter(None, labels), "")]
    return labels


def main(script: str, report: str) -> None:
    """Run a script, and write the labels of all axes of each of its figures as JSON."""
    sys.path[0], sys.argv = ".", [script]
    runpy.run_path(script, run_name="__main__")
    figures = []
    for number in plt.get_fignums():
        figure = plt.figure(number)
        figure.canvas.draw()
        everything = [axes for parent in figure.axes for axes in (parent, *parent.child_axes)]
        figures.append([label for axes in everything for label in labels_of(axes)])
    with open(report, "w", encoding="utf-8") as file:
        json.dump(figures, file)


if __name__ == "__main__":
    main(*sys.argv[1:])
