"""Highest speeds at which the intended timing is met, over supply and window, as a result."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.archive import Archive
from apesim.archive.columns import values_of
from apesim.engine.angles import DEGREE, RPM
from apesim.engine.machine import Machine
from apesim.quantities.arguments import Given, WithUnit
from apesim.results import Scalar
from apesim.studies.archives.grid_result import GridResult
from apesim.studies.archives.machines import read_recorded_machine
from apesim.studies.archives.pressure_axes import find_pressure_axis
from apesim.studies.drawing.axes import axes_for, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, computed, public
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.limit.engine_limit import CRITERION, LOWEST, Failure, judged, map_engine_limit
from apesim.studies.limit.points import Point, lowest_run, own_run
from apesim.studies.limit.summary import summary_json
from apesim.studies.run.default_grids import DURATIONS
from apesim.studies.run.operating_conditions import DURATION, JOBS, read_supplies, require_epv, require_one_command

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class EngineLimitMap(GridResult):
    """Highest speeds at which the valve opens and closes at its targets, with complete strokes.

    ``limit_rpm`` and ``limit_hz`` are those of the machine's own supply and targets.
    """

    title: ClassVar[str] = "highest speeds at which the targets are met"

    open_target_deg: float = field(kw_only=True)
    """Target of the opening [deg]."""

    @classmethod
    def _axes_of(cls, archive: Archive) -> tuple[str, ...]:
        """Name the axes of the grid."""
        return find_pressure_axis(archive), "supply_temperature", "duration_deg"

    @classmethod
    def _recorded(cls, archive: Archive) -> dict[str, Any]:
        """Find the target of the opening in the text of the machine, too."""
        open_target = read_recorded_machine(archive.machine).command.open_target
        return super()._recorded(archive) | {"open_target_deg": open_target / DEGREE}

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line on the points at which the criterion is not met even at the lowest speed."""
        missing = int(np.isnan(archive.variables["limit_rpm"].values).sum())
        where = f"{LOWEST / RPM:g} r/min"
        return [f"at {missing} points the criterion is not even met at {where}"] if missing else []

    @classmethod
    def _summary_of(cls, archive: Archive) -> Mapping[str, Scalar]:
        """Limits at the machine's own point, and the lowest of the grid."""
        columns = values_of(archive)
        own, lowest = own_run(columns), lowest_run(columns)
        at_own = "at the machine's own supply and targets"
        found = {
            "limit_rpm": Scalar(float(columns["limit_rpm"][own]), "r/min", f"highest speed {at_own}"),
            "limit_hz": Scalar(float(columns["limit_hz"][own]), "Hz", f"the same as a working rate, {at_own}"),
        }
        if lowest is not None:
            found["min_limit_rpm"] = Scalar(float(columns["limit_rpm"][lowest]), "r/min", "lowest of the grid")
        return found

    def _runs_of_grid(self) -> np.ndarray:
        """Find the runs that are points of the grid; the machine's own may stand beside it."""
        return np.flatnonzero(self.archive.variables["point"].values != Point.OWN)

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine limit --json``.

        Returns
        -------
        dict
            Summary, criterion and the results of each point under ``points``; NaN where JSON says null.

        Examples
        --------
        >>> from apesim.studies.limit.engine_limit import EngineLimit, limit_columns
        >>> limit = EngineLimit(230.0, Failure.FULL_LIFT, np.nan, None, 102)
        >>> columns = limit_columns([(1.1e6, 287.0, 1.3, 1.1e6)], [Point.GRID_AND_OWN], [limit])
        >>> limits = EngineLimitMap.of(Archive("", {}, columns), ambient_pressure=101325.0, open_target_deg=-5.0)
        >>> data = limits.to_dict()
        >>> round(float(data["limit_rpm"])), data["points"][0]["fails"]
        (2196, 'full_lift')
        """
        columns = values_of(self.archive)
        points = []
        for run in columns["run"]:
            point = {name: values[run] for name, values in columns.items() if name != "run"}
            failure = Failure(point["fails"])
            points.append(point | {"fails": failure.name.lower(), "remedy": failure.remedy})
        stated = summary_json(columns, "duration_deg")
        return stated | {"criterion": CRITERION, "open_target_deg": self.open_target_deg, "points": points}

    def _draw(self, folder: str | PathLike[str]) -> list[Path]:
        from apesim.studies.limit.engine_figures import engine_limit_figures

        return engine_limit_figures(self.archive, self.ambient_pressure, folder)

    @in_house_style
    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the highest speed over pressure, for each duration and temperature.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Examples
        --------
        >>> from apesim.studies.limit.engine_limit import EngineLimit, limit_columns
        >>> limit = EngineLimit(230.0, Failure.FULL_LIFT, np.nan, None, 102)
        >>> columns = limit_columns([(1.1e6, 287.0, 1.3, 1.1e6)], [Point.GRID_AND_OWN], [limit])
        >>> limits = EngineLimitMap.of(Archive("", {}, columns), ambient_pressure=101325.0, open_target_deg=-5.0)
        >>> axes = limits.plot()
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('supply pressure [MPa gauge]', 'highest speed [r/min]')
        """
        from apesim.studies.drawing.panels import add_legend
        from apesim.studies.limit.engine_figures import draw_limits

        ax = axes_for(ax)
        draw_limits(ax, self.archive, self.ambient_pressure)
        add_legend(ax)
        return ax


@public
def find_engine_limit(
    machine: Machine,
    *,
    pressure: Given | Sequence[Given] | None = None,
    control_pressure: Given | Sequence[Given] | None = None,
    temperature: Given | Sequence[Given] | None = None,
    duration: WithUnit | Sequence[WithUnit] = DURATIONS,
    out: str | PathLike[str] | None = None,
    jobs: int | None = 1,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> EngineLimitMap:
    """Find the highest speed at which the valve opens and closes at its targets, with complete strokes.

    Parameters
    ----------
    machine : Machine
        With an electro-pneumatic valve as its intake.
    pressure : str, float or sequence, optional
        Of the supply, e.g. "0.6:1.4:0.4 MPa gauge", or [Pa abs]; if left out, 0.6, 1 and 1.4 times the machine's own
        gauge pressure. A control pressure that the machine states stays.
    control_pressure : str, float or sequence, optional
        Of the control air, which is varied instead, at one pressure of the supply, the machine's own if that is left
        out.
    temperature : str, float or sequence, optional
        Of the supply, e.g. "250 K, 287 K", or [K]; 250 K, the machine's own and 322 K if left out.
    duration : str, (array, str) or sequence of them
        From the target opening to the target closing, with the unit: "60 deg, 75 deg" or ``([60, 75], "deg")``.
    out : path, optional
        The archive to write.
    jobs : int or None
        Processes; None: as many as the work is worth. A script that asks for more than one does so below
        ``if __name__ == "__main__":``, as each process imports it.
    overwrite : bool
        Replace an archive that is there.
    progress : bool or function
        True: a bar on standard error; a function is called with the numbers of points done and in all.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    EngineLimitMap
        Its numbers are those at the machine's own supply and targets, its traces those of the grid.

    Raises
    ------
    InputError
        The machine or an argument is out of range.
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> limits = apesim.find_engine_limit(
    ...     apesim.Machine(), pressure="1 MPa gauge", temperature="287 K", duration="75 deg"
    ... )
    >>> limits["runs"], limits.failed
    (1, ())
    """
    call = call_text(find_engine_limit, locals()) if call is None else call
    arguments, machine = arguments_of("find_engine_limit", machine)
    require_epv(arguments, machine)
    require_one_command(arguments, machine)
    supplies = read_supplies(arguments, machine, pressure, control_pressure, temperature)
    durations = arguments.range("duration", duration, DURATION)
    arguments.quantity("jobs", jobs, JOBS)
    arguments.refuse()

    def compute(report: Callable[[int, int], None]) -> Archive:
        return map_engine_limit(machine, supplies, durations, jobs=jobs, command=call, report=report)

    first_march = judged, machine, LOWEST
    with show_progress(progress, "limit") as report:
        archive, wall_time = computed(compute, first_march, out, overwrite=overwrite, report=report)
    open_target = machine.command.open_target / DEGREE
    return EngineLimitMap.of(archive, wall_time, ambient_pressure=machine.ambient.pressure, open_target_deg=open_target)
