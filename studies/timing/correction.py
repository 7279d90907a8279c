"""The function `correct_timing` for Python, which checks its arguments, and its result `CorrectedTiming`."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from apesim.archive import Archive
from apesim.engine.angles import DEGREE
from apesim.engine.machine import Machine
from apesim.quantities import Arguments
from apesim.quantities.arguments import Given, WithUnit
from apesim.studies.archives.grid_result import GridResult
from apesim.studies.archives.machines import read_recorded_machine
from apesim.studies.archives.pressure_axes import find_pressure_axis
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, computed, public
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.run.default_grids import TIMING_SPEEDS
from apesim.studies.run.operating_conditions import ANGLE, JOBS, SPEED, read_supplies, require_epv, require_one_command
from apesim.studies.timing.export import as_json, export, refuse_exports
from apesim.studies.timing.grid import TimingMap, faults_of_timing, map_timing, timing_map_of
from apesim.studies.timing.solve import corrected

if TYPE_CHECKING:
    from matplotlib.axes import Axes as PlotAxes


@dataclass(frozen=True, eq=False, repr=False)
class CorrectedTiming(GridResult):
    """Result of `correct_timing`: commands that make the valve open and close at its targets.

    It also holds what they win back in torque and air, and how their delays depend on the temperature.

    Attributes
    ----------
    map : TimingMap
        Tables over the axes, laws of the delays, and error of interpolation.
    """

    title: ClassVar[str] = "commands that open and close the valve at its targets"
    map: TimingMap = field(kw_only=True)

    @classmethod
    def _axes_of(cls, archive: Archive) -> tuple[str, ...]:
        """Name the axes of the grid."""
        return "speed_rpm", find_pressure_axis(archive), "supply_temperature"

    @classmethod
    def _recorded(cls, archive: Archive) -> dict[str, Any]:
        """Make the tables and laws of the archive, too."""
        machine = read_recorded_machine(archive.machine)
        return super()._recorded(archive) | {"map": timing_map_of(archive, machine.command)}

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each point whose targets are out of reach."""
        return faults_of_timing(archive)

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine timing --json``.

        Returns
        -------
        dict
            Targets, axes, tables, laws, error of interpolation, and the results of each point; None for NaN.

        Examples
        --------
        >>> import apesim
        >>> timing = apesim.correct_timing(
        ...     apesim.Machine(), speed="900 rpm", pressure="1 MPa gauge", temperature="287 K"
        ... )
        >>> data = timing.to_dict()
        >>> data["points"][0]["reason"], round(data["advance_deg"][0][0][0], 1)
        ('reached', 36.2)
        """
        return as_json(self.map)

    def write(self, path: str | PathLike[str], *, overwrite: bool = False) -> Path:
        """Write the archive, and beside it the table as CSV, JSON and C header.

        Parameters
        ----------
        path : path
            The archive; the other files have its name with the endings ``.csv``, ``.json`` and ``.h``.
        overwrite : bool
            Replace files that are there.

        Returns
        -------
        Path
            Path of the archive.

        Raises
        ------
        ArchiveError
            A file exists, or cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> import apesim
        >>> timing = apesim.correct_timing(
        ...     apesim.Machine(), speed="900 rpm", pressure="1 MPa gauge", temperature="287 K"
        ... )
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = timing.write(f"{folder}/timing.h5")
        ...     sorted(file.name for file in path.parent.iterdir())
        ['timing.csv', 'timing.h', 'timing.h5', 'timing.json']
        """
        refuse_exports(Path(path), overwrite=overwrite)
        written = super().write(path, overwrite=overwrite)
        export(self.map, written)
        return written

    def _draw(self, folder: str | PathLike[str]) -> list[Path]:
        from apesim.studies.timing.figures import timing_figures

        return timing_figures(self.map, self.ambient_pressure, folder)

    @in_house_style
    def plot(self, ax: "PlotAxes | None" = None, what: str = "energise", *, edge: str = "") -> "PlotAxes":
        """Draw the advance of a command edge over speed, a line for each pressure, at the middle of the temperatures.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : {"energise", "release"}
            Edge of the command.
        edge : str, optional
            Another name of `what`, which counts where it is given.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Examples
        --------
        >>> import apesim
        >>> timing = apesim.correct_timing(
        ...     apesim.Machine(), speed="900 rpm", pressure="1 MPa gauge", temperature="287 K"
        ... )
        >>> axes = timing.plot(what="release")
        >>> axes.get_ylabel()
        'target less command angle [deg]'
        """
        from apesim.studies.drawing.panels import add_legend, add_legend_entry
        from apesim.studies.timing.figures import BY_BENCH, DASHED, draw_advance

        what = edge or what
        check_plotted(what, ("energise", "release"))
        ax = axes_for(ax)
        draw_advance(ax, self.map, self.ambient_pressure, edge=what)
        if (number := len(self.map.axes.temperatures)) > 1:
            ax.set_title(f"{ax.get_title()}, 1 of {number} temperatures")
        ax.set_ylabel("target less command angle [deg]")
        add_legend_entry(ax, BY_BENCH, **DASHED)
        add_legend(ax)
        return ax


@public
def correct_timing(
    machine: Machine,
    *,
    target: WithUnit | Sequence[WithUnit] | None = None,
    speed: WithUnit | Sequence[WithUnit] = TIMING_SPEEDS,
    pressure: Given | Sequence[Given] | None = None,
    control_pressure: Given | Sequence[Given] | None = None,
    temperature: Given | Sequence[Given] | None = None,
    out: str | PathLike[str] | None = None,
    jobs: int | None = 1,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> CorrectedTiming:
    """Find the command angles that make the valve really open and close at its targets.

    Parameters
    ----------
    machine : Machine
        Machine with an electro-pneumatic valve as its intake.
    target : str, (pair of float, str) or pair of str, optional
        Crank angles of opening and closing with their unit, "-5 deg, 70 deg" or ``((-5, 70), "deg")``; the machine's
        own if left out.
    speed : str, (array, str) or sequence of them
        Speeds with their unit: a range such as "300:2400:150 rpm", a list, or ``(array, "rpm")``.
    pressure : str, float or sequence, optional
        Pressures of the supply, e.g. "0.6:1.4:0.4 MPa gauge", or [Pa abs]; if left out, 0.6, 1 and 1.4 times the
        machine's own gauge pressure. A control pressure that the machine states stays.
    control_pressure : str, float or sequence, optional
        Pressures of the control air, which are varied instead, at one pressure of the supply, the machine's own if
        that is left out.
    temperature : str, float or sequence, optional
        Temperatures of the supply, e.g. "250 K, 287 K", or [K]; 250 K, the machine's own and 322 K if left out.
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
    CorrectedTiming
        ``failed`` names the points out of reach, which are NaN.

    Raises
    ------
    InputError
        The machine or an argument is out of range.
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> machine = apesim.Machine()
    >>> timing = apesim.correct_timing(
    ...     machine, target="-5 deg, 70 deg", speed="900 rpm", pressure="1 MPa gauge", temperature="287 K"
    ... )
    >>> timing["runs"], timing.failed
    (1, ())
    >>> timing.traces["advance_deg"].unit
    'deg'
    """
    call = call_text(correct_timing, locals()) if call is None else call
    arguments, machine = arguments_of("correct_timing", machine)
    require_epv(arguments, machine)
    require_one_command(arguments, machine)
    machine = _with_targets(arguments, machine, target)
    speeds = arguments.range("speed", speed, SPEED)
    supplies = read_supplies(arguments, machine, pressure, control_pressure, temperature)
    arguments.quantity("jobs", jobs, JOBS)
    arguments.refuse()
    if out is not None:
        refuse_exports(Path(out), overwrite=overwrite)
    maps: list[TimingMap] = []

    def compute(report: Callable[[int, int], None]) -> Archive:
        maps.append(map_timing(supplies, speeds, jobs, command=call, report=report))
        return maps[0].archive

    first_march = corrected, machine, speeds[0]
    with show_progress(progress, "timing") as report:
        archive, wall_time = computed(compute, first_march, out, overwrite=overwrite, report=report)
    (timing_map,) = maps
    if out is not None:
        export(timing_map, Path(out))
    return CorrectedTiming.of(archive, wall_time, ambient_pressure=machine.ambient.pressure, map=timing_map)


def _with_targets(arguments: Arguments, machine: Machine, target: WithUnit | Sequence[WithUnit] | None) -> Machine:
    """Give a machine other targets, two angles with their unit; wrong ones are noted and change nothing."""
    if target is None:
        return machine
    noted = len(arguments.faults)
    angles = arguments.range("target", target, ANGLE)
    if len(arguments.faults) > noted:
        return machine
    form = 'write two angles, opening and closing, less than a turn apart, e.g. "-5 deg, 70 deg"'
    if len(angles) != 2:
        arguments.fault("target", f"{target!r} is not an opening and a closing", form)
        return machine
    machine = machine._replace(command=machine.command._replace(open_target=angles[0], close_target=angles[1]))
    for _, wrong, _ in machine.command.faults():
        arguments.fault("target", wrong, form)
    if angles[0] > 360.0 * DEGREE:
        arguments.fault("target", "opens after more than a turn", form)
    return machine
