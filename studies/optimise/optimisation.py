"""Command angles for most torque, least specific air, or the best of both, as a result."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from apesim.archive import Archive
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.quantities import Arguments, Choice, InputError
from apesim.quantities.arguments import WithUnit
from apesim.results import Scalar
from apesim.studies.archives.grid_result import GridResult
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, computed, public
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.optimise.landscape import Goal
from apesim.studies.optimise.search import Optimum
from apesim.studies.optimise.summary import point_json
from apesim.studies.optimise.table import NAMES, archive_of, faults_of, optima_of, optima_over_speed
from apesim.studies.run.default_grids import OPTIMUM_SPEEDS
from apesim.studies.run.operating_conditions import JOBS, SPEED, require_epv

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GOALS = ("torque", "air", "both")
FREE_KEY = "supply.pressure"

PLOTS = {
    "brake torque": ("brake_torque_Nm", "brake torque [N m]"),
    "specific air": ("specific_air_kg_per_kWh", "specific air [kg/kWh]"),
}
"""What is drawn: name in the archive, without the kind of command, and label."""


@dataclass(frozen=True, eq=False, repr=False)
class OptimalCommands(GridResult):
    """Command angles that give most torque or least specific air over speed, and the Pareto front between them.

    Attributes
    ----------
    goal : {"torque", "air", "both"}
        What was asked for.
    optima : tuple of Optimum
        Best commands at each speed.
    """

    title: ClassVar[str] = "the best commands"
    axes: ClassVar[tuple[str, ...]] = ("speed_rpm",)

    goal: str = field(kw_only=True)
    optima: tuple[Optimum, ...] = field(kw_only=True)

    @classmethod
    def _recorded(cls, archive: Archive) -> dict[str, Any]:
        """Make the optima of the archive, too, and find what was asked for."""
        optima = optima_of(archive)
        wanted = [goal for goal in Goal if f"{NAMES[goal]}_energise_deg" in archive.variables]
        goal = "both" if len(wanted) > 1 else wanted[0].name.lower()
        found = {"goal": goal, "optima": optima, "failed": faults_of(optima)}
        return super()._recorded(archive) | found

    @classmethod
    def _summary_of(cls, archive: Archive) -> Mapping[str, Scalar]:
        """Count the periodic states that were computed."""
        sketches, runs = (int(archive.variables[name].values.sum()) for name in ("sketches", "runs"))
        return {
            "all_sketches": Scalar(sketches, "1", "states followed roughly, to 1e-3"),
            "all_full_runs": Scalar(runs, "1", "states followed fully"),
        }

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine optimise --json``.

        Returns
        -------
        dict
            Goal, criterion, ranges that were searched, and the results of each speed under ``points``; NaN where JSON
            says null.

        Examples
        --------
        >>> from apesim.studies.optimise.landscape import RECORDED, Point
        >>> point = Point((0.7, 1.0), -1.0, 4.2, 1.1e6, dict.fromkeys(RECORDED, 1.0), (60.0, 57e3), True)
        >>> optimum = Optimum(94.0, point, {Goal.TORQUE: point}, [], 81, 27)
        >>> archive = archive_of(Machine(), [optimum], [Goal.TORQUE])
        >>> best = OptimalCommands.of(archive, ambient_pressure=101325.0, goal="torque", optima=(optimum,))
        >>> data = best.to_dict()
        >>> data["searched_energise"], data["points"][0]["most_torque"]["bounds"]
        ('-240 to 60 deg', {'duration': 'highest'})
        """
        provenance = self.archive.provenance
        stated = {key: text for key, text in provenance.items() if key.startswith(("criterion", "searched_"))}
        points = [point_json(optimum) for optimum in self.optima]
        return {"for": self.goal, **stated, "points": points, "faults": list(self.failed)}

    def _draw(self, folder: str | PathLike[str]) -> list[Path]:
        from apesim.studies.optimise.figures import optimise_figures

        return optimise_figures(self.archive, self.ambient_pressure, folder)

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str = "brake torque") -> "Axes":
        """Draw what the best and the machine's own commands give over speed.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : {"brake torque", "specific air"}
            Torque, or all air over brake work.

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
        >>> from apesim.studies.optimise.landscape import RECORDED, Point
        >>> point = Point((0.7, 1.0), -1.0, 4.2, 1.1e6, dict.fromkeys(RECORDED, 1.0), (60.0, 57e3), True)
        >>> optimum = Optimum(94.0, point, {Goal.TORQUE: point}, [], 81, 27)
        >>> archive = archive_of(Machine(), [optimum], [Goal.TORQUE])
        >>> best = OptimalCommands.of(archive, ambient_pressure=101325.0, goal="torque", optima=(optimum,))
        >>> best.plot().get_ylabel()
        'brake torque [N m]'
        """
        from apesim.studies.drawing.panels import add_legend
        from apesim.studies.optimise.figures import draw_over_speed

        check_plotted(what, PLOTS)
        ax, (name, label) = axes_for(ax), PLOTS[what]
        draw_over_speed(ax, self.archive, name)
        ax.set_ylabel(label)
        add_legend(ax)
        return ax


@public
def optimise_commands(
    machine: Machine,
    *,
    goal: str = "both",
    speed: WithUnit | Sequence[WithUnit] = OPTIMUM_SPEEDS,
    free: str | None = None,
    out: str | PathLike[str] | None = None,
    jobs: int | None = 1,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> OptimalCommands:
    """Find the command angles that give most torque, least specific air, or the best of both.

    Parameters
    ----------
    machine : Machine
        Machine with an electro-pneumatic valve as its intake.
    goal : {"torque", "air", "both"}
        Goal of the search; both: the Pareto front, too.
    speed : str, (array, str) or sequence of them
        Speeds with their unit: a range such as "600:1800:300 rpm", a list, or ``(array, "rpm")``.
    free : str, optional
        "supply.pressure=0.5 MPa gauge:1.5 MPa gauge" sets the supply pressure free, too.
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
    OptimalCommands
        ``failed`` names the speeds at which no commands give brake work.

    Raises
    ------
    InputError
        The machine or an argument is out of range.
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> best = apesim.optimise_commands(apesim.Machine(), goal="torque", speed="900 rpm")
    >>> bool(best.traces["most_torque_brake_torque"][0] > best.traces["fixed_brake_torque"][0])
    True
    """
    call = call_text(optimise_commands, locals()) if call is None else call
    arguments, machine = arguments_of("optimise_commands", machine)
    require_epv(arguments, machine)
    number = arguments.quantity("goal", goal, Choice(GOALS, "command line"))
    speeds = arguments.range("speed", speed, SPEED)
    pressures = _free_pressures(arguments, machine, free)
    arguments.quantity("jobs", jobs, JOBS)
    arguments.refuse()
    goal = GOALS[number]
    goals = tuple(Goal) if goal == "both" else (Goal[goal.upper()],)
    optima: list[Optimum] = []

    def compute(report: Callable[[int, int], None]) -> Archive:
        optima.extend(optima_over_speed(machine, speeds, goals, pressures, jobs, report))
        return archive_of(machine, optima, goals, pressures, call)

    first_march = run_steady, machine, speeds[0]
    with show_progress(progress, "optimise") as report:
        archive, wall_time = computed(compute, first_march, out, overwrite=overwrite, report=report)
    return OptimalCommands.of(
        archive,
        wall_time,
        failed=faults_of(optima),
        ambient_pressure=machine.ambient.pressure,
        goal=goal,
        optima=tuple(optima),
    )


def _free_pressures(arguments: Arguments, machine: Machine, free: str | None) -> tuple[float, float] | None:
    """Both ends of a supply pressure set free, or None [Pa abs]."""
    if free is None:
        return None
    key, equals, _ = free.partition("=")
    if key.strip() != FREE_KEY or not equals:
        wrong = f"{free!r} is not the supply pressure with its bounds"
        arguments.fault("free", wrong, f"write {FREE_KEY}=0.5 MPa gauge:1.5 MPa gauge")
        return None
    from apesim.studies.identify.free import free_parameters  # which takes a second to import

    try:
        (parameter,) = free_parameters(machine, [free])
    except InputError as error:
        for fault in error.faults:
            arguments.fault("free", fault.wrong, fault.right)
        return None
    return parameter.low, parameter.high
