"""What the valve's faults cost over speed, as a result."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from apesim.archive import Archive
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.quantities.arguments import WithUnit
from apesim.studies.archives.grid_result import GridResult
from apesim.studies.assessment.grid import FIXED, TIMINGS, assess_speeds, faults_of_assessment, undefined_ratios
from apesim.studies.assessment.summary import points_of
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, computed, public
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.run.default_grids import SPEEDS
from apesim.studies.run.operating_conditions import SPEED, require_epv

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PLOTS = {
    "brake torque lost": ("brake_torque_lost_Nm", "brake torque lost [N m]"),
    "air added": ("specific_air_added_kg_per_kWh", "air over brake work added [kg/kWh]"),
}
"""What is drawn: name in the archive, and label."""


@dataclass(frozen=True, eq=False, repr=False)
class ValveAssessment(GridResult):
    """What the valve's lateness, finite speed, fluctuation and control air cost in torque and air.

    Traces over speed, valve, order and cause, e.g. ``to_xarray()["brake_torque_lost"]``.
    """

    title: ClassVar[str] = "what the valve's faults cost"
    axes: ClassVar[tuple[str, ...]] = ("speed_rpm",)

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each speed at which not all valves could be compared."""
        return faults_of_assessment(archive)

    @classmethod
    def _warnings_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each valve that does no work, whose air over work is undefined."""
        return undefined_ratios(archive)

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Write the speeds, and whether the commands of the real valve are fixed or corrected."""
        return {**super()._conditions_of(archive), "timing": archive.provenance["timing"]}

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine assess --json``.

        Returns
        -------
        dict
            Results of each speed under ``points``, see `apesim.studies.assessment.summary.points_of`; NaN where
            JSON says null.

        Examples
        --------
        >>> import apesim
        >>> data = apesim.assess_valve(apesim.Machine(), speed="900 rpm").to_dict()
        >>> data["points"][0]["outcome"], data["faults"]
        ('complete', [])
        """
        return {"points": points_of(self.archive), "faults": list(self.failed), "warnings": list(self.warnings)}

    def _draw(self, folder: str | PathLike[str]) -> list[Path]:
        from apesim.studies.assessment.figures import assessment_figures

        return assessment_figures(self.archive, folder)

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str = "brake torque lost") -> "Axes":
        """Draw what each cause costs over speed.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : {"brake torque lost", "air added"}
            Cost against the ideal valve: torque, or air over brake work.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Raises
        ------
        InputError
            There is no such plot.

        Examples
        --------
        >>> import apesim
        >>> axes = apesim.assess_valve(apesim.Machine(), speed="900 rpm").plot()
        >>> axes.get_ylabel()
        'brake torque lost [N m]'
        """
        from apesim.studies.assessment.figures import MARKS, draw_losses
        from apesim.studies.drawing.panels import add_legend

        check_plotted(what, PLOTS)
        ax, (name, label) = axes_for(ax), PLOTS[what]
        draw_losses(ax, self.archive, name, title=MARKS)
        ax.set_ylabel(label)
        add_legend(ax)
        return ax


@public
def assess_valve(
    machine: Machine,
    *,
    speed: WithUnit | Sequence[WithUnit] = SPEEDS,
    timing: str = FIXED,
    out: str | PathLike[str] | None = None,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> ValveAssessment:
    """Find what the valve's lateness, finite speed, fluctuation and control air cost in torque and air.

    Parameters
    ----------
    machine : Machine
        Machine with an electro-pneumatic valve as its intake.
    speed : str, (array, str) or sequence of them
        Speeds with their unit: a range such as "300:2400:100 rpm", a list, or ``(array, "rpm")``.
    timing : {"fixed", "corrected"}
        Commands of the real valve: the machine's own, or those that meet its targets.
    out : path, optional
        The archive to write.
    overwrite : bool
        Replace an archive that is there.
    progress : bool or function
        True: a bar on standard error; a function is called with the numbers of points done and in all.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    ValveAssessment
        ``failed`` names the speeds at which not all valves could be compared.

    Raises
    ------
    InputError
        The machine or an argument is out of range.
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> assessment = apesim.assess_valve(apesim.Machine(), speed="900 rpm")
    >>> lost = assessment.to_xarray()["brake_torque_lost"].sel(order="mean").squeeze()
    >>> round(float(lost.sel(cause="control_air")), 6)
    0.0
    """
    call = call_text(assess_valve, locals()) if call is None else call
    arguments, machine = arguments_of("assess_valve", machine)
    require_epv(arguments, machine)
    speeds = arguments.range("speed", speed, SPEED)
    if timing not in TIMINGS:
        arguments.fault("timing", f"{timing!r} is no timing", f"write {' or '.join(TIMINGS)}")
    arguments.refuse()

    def compute(report: Callable[[int, int], None]) -> Archive:
        return assess_speeds(machine, speeds, timing, command=call, report=report)

    first_march = run_steady, machine, speeds[0]
    with show_progress(progress, "assessment") as report:
        archive, wall_time = computed(compute, first_march, out, overwrite=overwrite, report=report)
    return ValveAssessment.of(archive, wall_time, ambient_pressure=machine.ambient.pressure)
