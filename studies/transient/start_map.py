"""Starts from rest over keys of the machine, such as the number of cylinders: which of the machines start, and how."""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import nan
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.archive import Archive
from apesim.archive.columns import column, run_axis
from apesim.archive.grid import axes_of, words_of
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps
from apesim.results import Scalar
from apesim.studies.archives.grid_result import GridResult
from apesim.studies.archives.run_result import CONDITIONS
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import computed
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.run.compiling import compile_drivetrain
from apesim.studies.sweep.plan import span_of
from apesim.studies.sweep.variation import Variation, varied_columns
from apesim.studies.transient.start_archive import (
    NUMBERS,
    Intervals,
    Starting,
    interval_variables,
    intervals_of,
    names_of,
    start_machine,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SECONDS_OF_ALL, SECONDS_OF_ONE = 2.5, 0.01
"""Estimated computing time of the starts of a machine from all angles, and of one [s]."""
MAX_RINGS = 12
"""Rings of a circle: with more none would be told from the next."""


@dataclass(frozen=True, eq=False, repr=False)
class StartMap(GridResult):
    """Starts from rest over keys of the machine: from one angle of the crank, or from which of all."""

    title: ClassVar[str] = "starts from rest"

    @classmethod
    def _axes_of(cls, archive: Archive) -> tuple[str, ...]:
        """Name the keys that were varied."""
        return tuple(axes_of(archive))

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Write the values of each axis in words, and what was held."""
        axes = {name.replace("_", " "): span_of(texts) for name, texts in axes_of(archive).items()}
        return axes | json.loads(archive.provenance[CONDITIONS])

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write a line for each machine whose worker died."""
        dead = np.isnan(archive.variables["starting_share"].values)
        return [f"{name}: its worker process died; free memory, or try --jobs 1" for name in names_of(archive, dead)]

    @classmethod
    def _warnings_of(cls, archive: Archive) -> Iterable[str]:
        """Write a line on the machines that do not start, where one angle was asked for."""
        if "interval" in archive.variables:
            return
        never = archive.variables["starting_share"].values == 0.0
        if never.any():
            which = list(names_of(archive, never))
            more = f" and {len(which) - 1} more" if len(which) > 1 else ""
            yield f"{len(which)} of {len(never)} machines do not start: {which[0]}{more}"

    @classmethod
    def _summary_of(cls, archive: Archive) -> Mapping[str, Scalar]:
        """Count the machines that start."""
        count = int((archive.variables["starts"].values == 1).sum())
        return {"starting_machines": Scalar(count, "1", "machines that start")}

    @property
    def is_of_all_angles(self) -> bool:
        """Whether it says from which angles the engines start, and not how they do from one."""
        return "interval" in self.archive.variables

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine start --vary KEY=RANGE --json``.

        Returns
        -------
        dict
            What was varied, in words, and of each machine its values in SI units and degrees, its numbers and its
            intervals; NaN where JSON says null.

        Examples
        --------
        >>> import apesim
        >>> starts = apesim.start_engine(apesim.Machine(), vary={"engine.cylinders": "1, 2"})
        >>> [(point["engine_cylinders"], point["starts"]) for point in starts.to_dict()["points"]]
        [(1.0, True), (2.0, True)]
        """
        axes, v = axes_of(self.archive), self.archive.variables
        varied = {name: words_of(v[name]).tolist() for name in axes}
        points = []
        for run in range(len(self.archive.runs)):
            where = {name: values[run] for name, values in varied.items()}
            numbers = {key: v[key].values[run].item() for key in NUMBERS} | {"starts": bool(v["starts"].values[run])}
            intervals = [list(interval) for interval in intervals_of(self.archive, run)]
            points.append(where | numbers | {"intervals_deg": intervals})
        return {"axes": axes, "points": points, "faults": list(self.failed), "warnings": list(self.warnings)}

    def _draw(self, folder: str | PathLike[str]) -> list[Path]:
        from apesim.studies.transient.figures import draw_start_map

        return draw_start_map(self, folder)

    def plots(self) -> tuple[str, ...]:
        """Name what can be drawn.

        Returns
        -------
        tuple of str
            Values of `what` of `plot`.

        Examples
        --------
        >>> import apesim
        >>> apesim.start_engine(apesim.Machine(), vary={"engine.cylinders": "1, 2"}).plots()
        ('time', 'engine_air', 'control_air')
        """
        if self.is_of_all_angles:
            return "angles", "share"
        has_target = "until" in self.conditions  # without one all make three turns
        return ("time", *(["turns"] * has_target), "engine_air", "control_air")

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str | None = None) -> "Axes":
        """Draw the angles that the engines start from around a circle, or a number over what was varied.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on, polar ones for the angles; those of a new figure if left out.
        what : {"angles", "share", "time", "turns", "engine_air", "control_air"}, optional
            A ring for each engine, or a number over a varied key; the first of `plots` if left out.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Raises
        ------
        InputError
            There is no such plot of this result.

        Examples
        --------
        >>> import apesim
        >>> starts = apesim.start_engine(apesim.Machine(), vary={"load.constant": "0, 5, 10 N m"})
        >>> axes = starts.plot(what="engine_air")
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('load constant [N m]', 'engine air to start [g]')
        """
        from apesim.studies.transient.circle import draw_circle, open_circle
        from apesim.studies.transient.start_curves import draw_over_keys

        plots = self.plots()
        what = what or plots[0]
        check_plotted(what, plots)
        if what != "angles":
            ax = axes_for(ax)
            draw_over_keys(ax, self.archive, what)
            return ax
        runs, labels = self.rings()
        ax = ax or open_circle(labels)
        draw_circle(ax, [intervals_of(self.archive, run) for run in runs], labels)
        if len(runs) < len(self.archive.runs):
            ax.set_title(f"{len(runs)} of {len(self.archive.runs)} machines")
        return ax

    def rings(self) -> tuple[list[int], list[str]]:
        """Choose the machines that have a ring, `MAX_RINGS` at most, and name them with their share of all angles.

        Returns
        -------
        runs : list of int
            Numbers of the machines, from the inside out.
        names : list of str
            Name of each.

        Examples
        --------
        >>> import apesim
        >>> starts = apesim.start_engine(apesim.Machine(), angle="all", vary={"engine.cylinders": "1, 2"})
        >>> starts.rings()
        ([0, 1], ['1 cylinder, 19 %', '2 cylinders, 38 %'])
        """
        from apesim.studies.drawing.spread import spread_out

        runs = spread_out(len(self.archive.runs), MAX_RINGS).tolist()
        shares, names = self.archive.variables["starting_share"].values, list(names_of(self.archive))
        return runs, [f"{names[run]}, {100.0 * shares[run]:.0f} %" for run in runs]


def map_starts(
    machine: Machine,
    variation: Variation,
    starting: Starting,
    conditions: Mapping[str, str],
    provenance: Mapping[str, str],
    *,
    jobs: int | None,
    out: str | PathLike[str] | None,
    overwrite: bool,
    report: Callable[[int, int], object],
) -> StartMap:
    """Start each machine of a variation, and write the archive where it was asked for.

    `machine` is the one that is varied; `conditions` hold for all, and `provenance` has what else is noted.
    """
    seconds = SECONDS_OF_ALL if starting.angle is None else SECONDS_OF_ONE

    def compute(report: Callable[[int, int], object]) -> Archive:
        total = len(variation.machines)
        items = [(number, each, starting) for number, each in enumerate(variation.machines)]
        found: list[tuple[dict[str, Any], Intervals]] = [(dict.fromkeys(NUMBERS, nan) | {"starts": False}, ())] * total
        tasks = run_tasks(_start, items, workers_for(seconds * total, jobs))
        for done, ((number, *_), result) in enumerate(tasks, 1):
            found[number] = result or found[number]
            report(done, total)
        values, intervals = zip(*found, strict=True)
        variables = {"run": run_axis(total)} | varied_columns(variation, range(total))
        for key, declared in NUMBERS.items():
            variables[key] = column([each[key] for each in values], *declared)
        if starting.angle is None:
            variables |= interval_variables(intervals)
        about = {
            "kind": "engine start map",
            "axes": json.dumps({axis.name: list(axis.texts) for axis in variation.axes}),
            CONDITIONS: json.dumps(dict(conditions)),
        }
        return Archive(dumps(machine), {**provenance, **about}, variables)

    archive, wall_time = computed(compute, (_compile, variation), out, overwrite=overwrite, report=report)
    return StartMap.of(archive, wall_time, ambient_pressure=machine.ambient.pressure)


def _compile(variation: Variation) -> None:
    """Compile what any of the machines needs."""
    for machine in variation.machines:
        compile_drivetrain(machine)


def _start(item: tuple[int, Machine, Starting]) -> tuple[dict[str, Any], Intervals]:
    """Numbers and intervals of one machine."""
    _, machine, starting = item
    started = start_machine(machine, starting)
    return started.values, started.intervals
