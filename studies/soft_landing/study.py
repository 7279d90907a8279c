"""Pulse patterns that lower the seating speed, over pressure, as a result."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from apesim.archive import Archive
from apesim.engine.machine import Machine
from apesim.quantities import Choice
from apesim.quantities.arguments import Given
from apesim.studies.archives.grid_result import GridResult
from apesim.studies.archives.machines import read_recorded_machine
from apesim.studies.drawing.axes import axes_for, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, computed, public
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.run.default_grids import LANDING_SHARES, PULSE, pressures_around
from apesim.studies.run.operating_conditions import JOBS, PRESSURE, SHORT_TIME, TEMPERATURE, TIME
from apesim.studies.soft_landing.landing import SOLENOIDS
from apesim.studies.soft_landing.results import archive_of, strokes_of
from apesim.studies.soft_landing.strokes import SPACING, Result, faults_of, soft_landings
from apesim.studies.soft_landing.summary import stroke_json
from apesim.valve.bench import run_bench

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ANY = "any"


@dataclass(frozen=True, eq=False, repr=False)
class SoftLanding(GridResult):
    """Brakes that lower the seating speed, of both strokes over pressure.

    Attributes
    ----------
    spacing : float
        Shortest time between two edges of a solenoid [s].
    cost : float
        Longest time that a brake may add to a stroke [s].
    solenoids : {"both", "a", "b", "any"}
        Solenoids that a brake may switch.
    strokes : tuple of Result
        Opening and closing for each pressure.
    """

    title: ClassVar[str] = "brakes that lower the seating speed"
    axes: ClassVar[tuple[str, ...]] = ("supply_pressure",)

    spacing: float = field(kw_only=True)
    cost: float = field(kw_only=True)
    solenoids: str = field(kw_only=True)
    strokes: tuple[Result, ...] = field(kw_only=True)

    @classmethod
    def _recorded(cls, archive: Archive) -> dict[str, Any]:
        """Make the strokes of the archive, too, and find what was asked for."""
        strokes = strokes_of(archive, read_recorded_machine(archive.machine))
        spacing, cost = (float(archive.provenance[name]) for name in ("spacing_s", "cost_s"))
        ways = archive.provenance["solenoids"].split(", ")
        solenoids = ANY if len(ways) > 1 else ways[0]
        found = {"spacing": spacing, "cost": cost, "solenoids": solenoids, "strokes": strokes}
        return super()._recorded(archive) | found | {"failed": faults_of(strokes, spacing, cost, ways)}

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim valve soft-landing --json``.

        Returns
        -------
        dict
            Spacing, cost, and the brakes of each stroke under ``points``; NaN where JSON says null.

        Examples
        --------
        >>> results = soft_landings(Machine(), [0.12e6], 287.0, dwell=50e-3)  # too little pressure to move the piston
        >>> landings = SoftLanding.of(
        ...     archive_of(Machine(), results, SPACING, 1e-3),
        ...     ambient_pressure=101325.0,
        ...     spacing=SPACING,
        ...     cost=1e-3,
        ...     solenoids=ANY,
        ...     strokes=tuple(results),
        ... )
        >>> data = landings.to_dict()
        >>> round(data["spacing_ms"], 2), [point["reachable"] for point in data["points"]]
        (4.17, [False, False])
        """
        from apesim.studies.terminal.console import to_builtins

        spacing, cost = self.spacing, self.cost
        data = {
            "spacing_ms": 1e3 * spacing,
            "cost_ms": 1e3 * cost,
            "solenoids": self.solenoids,
            "reachable": not self.failed,
            "points": [stroke_json(stroke, spacing, cost) for stroke in self.strokes],
            "faults": list(self.failed),
        }
        return to_builtins(data)

    def _draw(self, folder: str | PathLike[str]) -> list[Path]:
        from apesim.studies.soft_landing.figures import soft_landing_figures

        return soft_landing_figures(self.archive, self.ambient_pressure, folder)

    @in_house_style
    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the softest landing over the time between edges that the solenoids need.

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
        >>> results = soft_landings(Machine(), [0.12e6], 287.0, dwell=50e-3)  # too little pressure to move the piston
        >>> landings = SoftLanding.of(
        ...     archive_of(Machine(), results, SPACING, 1e-3),
        ...     ambient_pressure=101325.0,
        ...     spacing=SPACING,
        ...     cost=1e-3,
        ...     solenoids=ANY,
        ...     strokes=tuple(results),
        ... )
        >>> landings.plot().get_xlabel()
        'shortest time between two edges [ms]'
        """
        from apesim.studies.drawing.panels import add_legend
        from apesim.studies.soft_landing.figures import draw_over_spacing, shown_of

        ax = axes_for(ax)
        columns, titles, *rest = shown_of(self.archive, self.ambient_pressure)
        draw_over_spacing(ax, columns, titles, *rest)
        if len(titles) < len(self.archive.runs):
            ax.set_title(f"{ax.get_title()}; {len(titles)} of {len(self.archive.runs)} pressures are drawn")
        add_legend(ax)
        return ax


@public
def find_soft_landing(
    machine: Machine,
    *,
    pressure: Given | Sequence[Given] | None = None,
    temperature: Given | None = None,
    cost: Given = "1 ms",
    spacing: Given | None = None,
    solenoids: str = ANY,
    pulse: Given = PULSE,
    out: str | PathLike[str] | None = None,
    jobs: int | None = 1,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> SoftLanding:
    """Find pulse patterns that lower the seating speed: a braking re-switch in each stroke.

    Soft landing by control is the further study that the EPV paper (doi 10.1631/jzus.A0820373) ends with; the patterns
    are ours.

    Parameters
    ----------
    machine : Machine
        Machine with the valve.
    pressure : str, float or sequence, optional
        Control pressures, e.g. "0.4:1.6:0.6 MPa gauge", or [Pa abs]; if left out, 0.4, 1 and 1.6 times the machine's
        own gauge pressure of control air.
    temperature : str or float, optional
        Of the control air, e.g. "287 K", or [K]; the machine's own if left out.
    cost : str or float
        Time added to a stroke, command edge to contact, at most, or [s].
    spacing : str or float, optional
        Time between two edges of a solenoid, at least, or [s]; 4.17 ms (120 Hz) if left out.
    solenoids : {"both", "a", "b", "any"}
        Switched by a brake: both at once, A or B alone, the best of these.
    pulse : str or float
        Time from each command edge to the next, or [s].
    out : path, optional
        The archive to write.
    jobs : int or None
        Processes; None: as many as the work is worth. A script that asks for more than one does so below
        ``if __name__ == "__main__":``, as each process imports it.
    overwrite : bool
        Replace an archive that is there.
    progress : bool or function
        True: a bar on standard error; a function is called with how much is done and how much there is in all.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    SoftLanding
        ``failed`` names the strokes that no brake softens at that cost.

    Raises
    ------
    InputError
        The machine or an argument is out of range.
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> landings = apesim.find_soft_landing(apesim.Machine(), pressure="1 MPa gauge", solenoids="b")
    >>> [stroke.task.stroke for stroke in landings.strokes]
    ['opening', 'closing']
    """
    call = call_text(find_soft_landing, locals()) if call is None else call
    arguments, machine = arguments_of("find_soft_landing", machine)
    choice = Choice((*SOLENOIDS, ANY), "command line")

    # What is left out is the machine's own, or the default.
    around = pressures_around(machine, machine.supply.control().pressure, LANDING_SHARES)
    pressures = around if pressure is None else arguments.range("pressure", pressure, PRESSURE)
    own = machine.supply.temperature
    kelvin = own if temperature is None else arguments.quantity("temperature", temperature, TEMPERATURE)
    max_added = arguments.quantity("cost", cost, SHORT_TIME)
    min_spacing = SPACING if spacing is None else arguments.quantity("spacing", spacing, SHORT_TIME)
    number = arguments.quantity("solenoids", solenoids, choice)
    dwell = arguments.quantity("pulse", pulse, TIME)
    arguments.quantity("jobs", jobs, JOBS)
    arguments.refuse()

    # The strokes are kept beside the archive, which holds only some of the brakes that were tried.
    ways = SOLENOIDS if choice.options[number] == ANY else (choice.options[number],)
    strokes: list[Result] = []

    def compute(report: Callable[[int, int], None]) -> Archive:
        strokes.extend(soft_landings(machine, pressures, kelvin, dwell, min_spacing, max_added, report, ways, jobs))
        return archive_of(machine, strokes, min_spacing, max_added, call, ways)

    # One march compiles first, so that the time is that of computing.
    first_march = run_bench, machine, dwell
    with show_progress(progress, "soft landing") as report:
        archive, wall_time = computed(compute, first_march, out, overwrite=overwrite, report=report)
    return SoftLanding.of(
        archive,
        wall_time,
        failed=faults_of(strokes, min_spacing, max_added, ways),
        ambient_pressure=machine.ambient.pressure,
        spacing=min_spacing,
        cost=max_added,
        solenoids=choice.options[number],
        strokes=tuple(strokes),
    )
