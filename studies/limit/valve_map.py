"""The valve over pressure and temperature of its control air (Figs. 8-11 of doi 10.1631/jzus.A0820373)."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import column, run_axis, run_text, values_of
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.march.adaptive import Status
from apesim.quantities.arguments import Given
from apesim.quantities.settings import dumps
from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.archives.machines import read_recorded_machine
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, computed, public
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.run.march_status import STATUS_MEANINGS
from apesim.studies.run.operating_conditions import PRESSURE, TEMPERATURE, TIME, with_control_air
from apesim.valve.bench import run_bench

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from apesim.studies.drawing.style import Look

PRESSURES = "0.1:1.9:0.2 MPa gauge"
TEMPERATURES = "250:322:8 K"
"""The paper's grid."""
PULSE = 50e-3
SAMPLE = 0.1e-3
MEASURES = {
    "delay": ("delay_s", "s", "delay time t_d: command edge to 1 % of the stroke"),
    "stroke_time": ("stroke_time_s", "s", "full stroke time t_f: from there to contact"),
    "seating_speed": ("seating_speed_m_s", "m/s", "seating speed v_e: speed just before contact"),
    "fluctuation": ("fluctuation", "1", "(peak speed - lowest later speed before contact)/peak"),
    "reverses": ("reverses", "1", "whether the motion turns back before contact"),
}
"""Field of `apesim.valve.measures.Stroke`: its name in files, unit and what it is."""
TRACES = {
    "lift": (0, "m", "lift"),
    "velocity": (1, "m/s", "velocity of the lift, positive as it opens"),
    "pressure_a": (2, "Pa abs", "pressure of chamber A, which pushes to closed"),
    "pressure_b": (3, "Pa abs", "pressure of chamber B, which pushes to open"),
}


def supply_columns(grid: Sequence[tuple[float, ...]]) -> dict[str, Variable]:
    """Make the axis of runs of an archive, and the pressure [Pa abs] and temperature [K] of each run's control air.

    A tuple of `grid` begins with these two; what stands behind them is passed over.
    """
    pressures, temperatures = [p for p, *_ in grid], [t for _, t, *_ in grid]
    return {
        "run": run_axis(len(grid)),
        "supply_pressure": column(pressures, "Pa abs", "pressure of the control air", coordinate=True),
        "supply_temperature": column(temperatures, "K", "temperature of the control air", coordinate=True),
    }


def compute_map(
    machine: Machine,
    pressures: Sequence[float],
    temperatures: Sequence[float],
    pulse: float = PULSE,
    command: str = "",
    report: Callable[[int, int], Any] | None = None,
) -> Archive:
    """Run the valve on its bench over a grid of pressures [Pa abs] and temperatures [K] of the control air.

    Run ``i len(temperatures) + j`` is pressure i and temperature j; the solenoids are energised for `pulse` [s];
    `report` gets the numbers of runs done and of all.
    """
    grid = list(product(pressures, temperatures))
    runs = []
    for done, (pressure, temperature) in enumerate(grid):
        runs.append(run_bench(with_control_air(machine, pressure, temperature), pulse, sample=SAMPLE))
        if report:
            report(done + 1, len(grid))
    variables = {
        **supply_columns(grid),
        "time": Variable(("time",), runs[0].times, "s", "time after the solenoids are energised"),
        "status": column([run.status for run in runs], "1", "how the march ended", STATUS_MEANINGS),
        "control_air_kg": column([run.control_air for run in runs], "kg", "control air of an opening and a closing"),
    }
    for stroke in ("opening", "closing"):
        for field, (name, unit, description) in MEASURES.items():
            values = [getattr(getattr(run, stroke), field) for run in runs]
            variables[f"{stroke}_{name}"] = column(values, unit, description)
    for name, (number, unit, description) in TRACES.items():
        traces = np.stack([run.trace[:, number] for run in runs])
        variables[name] = Variable(("run", "time"), traces, unit, description)
    provenance = {"kind": "valve map", "command": command, "kernels": sources_hash(), "pulse_s": repr(pulse)}
    return Archive(dumps(machine), provenance, variables)


def faults_of_map(archive: Archive) -> list[str]:
    """Write one line for each run that failed or did not complete both strokes, named by its control air.

    >>> for line in faults_of_map(compute_map(Machine(), [0.12e6, 0.5e6], [287.0])):
    ...     print(line)
    run 0 (0.12 MPa abs, 287 K): a stroke is not completed within the pulse
    """
    v, lines = values_of(archive), []
    for run, status in enumerate(v["status"]):
        where = run_text(archive, run)
        if status != Status.DONE:
            lines.append(f"{where}: failed: {Status(status).remedy}")
        elif np.isnan(v["opening_stroke_time_s"][run] + v["closing_stroke_time_s"][run]):
            lines.append(f"{where}: a stroke is not completed within the pulse")
    return lines


@dataclass(frozen=True, eq=False, repr=False)
class ValveMap(ArchiveResult):
    """Bench runs of the valve over pressure and temperature of its control air."""

    title: ClassVar[str] = "the valve over pressure and temperature"

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each run that failed or did not complete both strokes."""
        return faults_of_map(archive)

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Grid and pulse."""
        return grid_conditions(archive) | {"pulse": f"{1e3 * float(archive.provenance['pulse_s']):g} ms"}

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str = "opening_delay") -> "Axes":
        """Draw a measure over pressure, a line for each temperature.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : str
            Name of a trace, e.g. "closing_seating_speed".

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Examples
        --------
        >>> from apesim.studies.archives.archive_result import variables_of
        >>> delays = column([5.9e-3, 5.5e-3], "s", "delay time of the opening")
        >>> archive = Archive("", {}, supply_columns([(0.5e6, 287.0), (0.9e6, 287.0)]) | {"opening_delay_s": delays})
        >>> result = ValveMap({}, variables_of(archive), archive=archive)
        >>> axes = result.plot()
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('control pressure [MPa gauge]', 'opening delay [ms]')
        """
        return plot_over_pressure(self, what, ax)


def grid_conditions(archive: Archive) -> dict[str, str]:
    """Write the ends of the grid of an archive over pressure and temperature, in words.

    The archive needs the columns of `supply_columns`.

    >>> grid_conditions(Archive("", {}, supply_columns([(0.5e6, 250.0), (0.9e6, 287.0)])))
    {'pressure': '0.5 to 0.9 MPa abs', 'temperature': '250 to 287 K'}
    """
    low, high = (f"{end(archive.variables['supply_pressure'].values) / 1e6:.4g}" for end in (np.min, np.max))
    cold, hot = (f"{end(archive.variables['supply_temperature'].values):g}" for end in (np.min, np.max))
    return {"pressure": f"{low} to {high} MPa abs", "temperature": f"{cold} to {hot} K"}


def plot_over_pressure(
    result: ArchiveResult,
    what: str,
    ax: "Axes | None" = None,
    groups: "Mapping[str, tuple[np.ndarray, Look]] | None" = None,
    name: str = "",
) -> "Axes":
    """Draw a variable, e.g. "opening_delay", over the control pressure, a line for each temperature.

    Without `ax` in a new figure; `groups` has the runs of each line and its look by its label, where the temperature
    alone does not tell them apart. `name` is what the variable is called, if not by its own name.
    """
    from apesim.studies.drawing.panels import add_legend, gauge_in_mpa, label_axes
    from apesim.studies.drawing.style import looks_of

    check_plotted(what, result.traces)
    ax, trace = axes_for(ax), result.traces[what]
    pressures, temperatures = (result.traces[f"supply_{axis}"].values for axis in ("pressure", "temperature"))
    gauge = gauge_in_mpa(pressures, read_recorded_machine(result.archive.machine).ambient.pressure)
    if groups is None:
        kelvins = np.unique(temperatures)
        looks = zip(kelvins, looks_of(len(kelvins)), strict=True)
        groups = {f"{kelvin:g} K": (np.flatnonzero(temperatures == kelvin), look) for kelvin, look in looks}
    factor, unit = (1e3, "ms") if trace.unit == "s" else (1.0, "" if trace.unit == "1" else trace.unit)
    for label, (runs, look) in groups.items():
        runs = runs[np.argsort(pressures[runs], kind="stable")]
        drawn: Look = {"ms": 4} | look
        ax.plot(gauge[runs], factor * trace[runs], label=label, **drawn)
    label_axes(ax, x=("control pressure", "MPa gauge"), y=(name or what.replace("_", " "), unit), title=result.title)
    add_legend(ax)
    return ax


@public
def map_valve(
    machine: Machine,
    *,
    pressure: Given | Iterable[Given] = PRESSURES,
    temperature: Given | Iterable[Given] = TEMPERATURES,
    pulse: Given = "50 ms",
    out: str | PathLike[str] | None = None,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> ValveMap:
    """Run the valve on its bench over pressure and temperature of its control air.

    Parameters
    ----------
    machine : Machine
        Machine with the valve.
    pressure : str, float or sequence of them
        Pressures of the control air, e.g. "0.1:1.9:0.2 MPa gauge", or [Pa abs].
    temperature : str, float or sequence of them
        Temperatures of the control air, e.g. "250:322:8 K", or [K].
    pulse : str or float
        Time for which the solenoids are energised, e.g. "50 ms", or [s].
    out : path, optional
        The archive to write.
    overwrite : bool
        Replace an archive that is there.
    progress : bool or function
        True: a bar on standard error; a function is called with the numbers of runs done and in all.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    ValveMap
        ``failed`` names the runs that do not complete both strokes.

    Raises
    ------
    InputError
        The machine or an argument is out of range.
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> found = apesim.map_valve(apesim.Machine(), pressure="0.4:0.8:0.4 MPa gauge", temperature="287 K")
    >>> (1e3 * found.traces["opening_delay"].values).round(2)
    array([5.6 , 5.77])
    """
    call = call_text(map_valve, locals()) if call is None else call
    arguments, machine = arguments_of("map_valve", machine)
    pressures = arguments.range("pressure", pressure, PRESSURE)
    temperatures = arguments.range("temperature", temperature, TEMPERATURE)
    seconds = arguments.quantity("pulse", pulse, TIME)
    arguments.refuse()

    def compute(**options: Any) -> Archive:
        return compute_map(machine, pressures, temperatures, seconds, command=call, **options)

    first = run_bench, machine, seconds
    with show_progress(progress, "map") as report:
        archive, wall_time = computed(compute, first, out, overwrite=overwrite, report=report)
    return ValveMap.of(archive, wall_time)
